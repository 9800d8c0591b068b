"""Balance problems without the classes of their torque and kinematic error, for compiled code.

Where only the frequency varies, both are in the problem's series. Without their classes the type of the problem is
decided by the law alone, and what was compiled once (10 to 20 s for a curve) serves every excitation of that law:
another line of the kinematic error compiles nothing.
"""

from typing import Any, NamedTuple

from ...tree import count
from .linear_part import STRENGTH


class Quiet(NamedTuple):
    """In the place of a torque and of a kinematic error: none."""

    def torque(self, angle: Any) -> Any:
        """No torque [N*m]."""
        return 0.0 * angle

    def value(self, angle: Any) -> Any:
        """No error [rad]."""
        return 0.0 * angle


QUIET = Quiet()
PARTS = ("excitation", "error")


def quiet(problem: Any) -> Any:
    """Return an oscillator's problem without the classes that it asks for nothing; itself where it does ask."""
    system = problem.system
    fields = getattr(system, "_fields", ())
    asks = problem.leaf > STRENGTH and problem.leaf != problem.omega_leaf
    if asks or not {*PARTS, "omega"} <= set(fields):
        return problem
    before = sum(count(getattr(system, part)) for part in PARTS if fields.index(part) < fields.index("omega"))
    omega_leaf = problem.omega_leaf - before
    leaf = problem.leaf if problem.leaf <= STRENGTH else omega_leaf
    return problem._replace(system=system._replace(**dict.fromkeys(PARTS, QUIET)), leaf=leaf, omega_leaf=omega_leaf)
