"""Terms that a law may lack: what each would change in the outputs of an identified system."""

from typing import Any, NamedTuple

import numpy as np

from ...model.laws.friction import QuadraticDamping
from ...model.laws.hysteresis import Parallel
from ...numerics.driven.march import lanes_of
from ...quantities import Ratio
from ...results import Floats
from .windows import EFFECT, LeastSquares, Point

SHARP = 0.02  # of the rate's size: over which the dry friction that is looked for changes its sign


class TwistPower(NamedTuple):
    """Torque c x^power."""

    c: Ratio
    power: int

    def torque(self, x: Any) -> Any:
        """Torque at torsion x."""
        total = self.c * x
        for _ in range(self.power - 1):
            total = total * x
        return total

    def stiffness(self, x: Any) -> Any:
        """Its derivative."""
        total = self.power * self.c + 0.0 * x
        for _ in range(self.power - 1):
            total = total * x
        return total


class RateTerm(NamedTuple):
    """Torque c v^3 or, with a width, c v/sqrt(v^2 + width^2)."""

    c: Ratio
    cube: Ratio
    width: Ratio

    def torque(self, _x: Any, v: Any) -> Any:
        """Torque at the rate v."""
        return self.c * v / (v * v + self.width * self.width) ** 0.5 + self.cube * v * v * v

    def stiffness(self, x: Any) -> Any:
        """No stiffness: 0."""
        return 0.0 * x


NAMES = ("x^2", "x^3", "x^5", "|v| v", "v^3", "sign v")


def candidate_columns(problem: LeastSquares, point: Point) -> dict[str, Floats]:
    """What a little of each term adds to the residuals (n,), the starts taken out; none without a law on top."""
    system = problem.of.driven
    if not hasattr(system, "law"):
        return {}
    first = problem.windows[0].record
    sizes = problem.sizes(first)
    x, v = float(sizes[0]), float(sizes[min(1, len(sizes) - 1)])
    torque = _torque(system, x)
    width = SHARP * v
    amounts = [
        torque / x**2, torque / x**3, torque / x**5, torque / (v * v), torque / v**3, torque,
    ]  # fmt: skip
    model = problem.of.model(point.values, first.step, problem.parts, problem.of.delays(point.values))

    def with_terms(on: int) -> Any:
        c = [EFFECT * amount * (i == on) for i, amount in enumerate(amounts)]
        springs = Parallel(TwistPower(c[0], 2), Parallel(TwistPower(c[1], 3), TwistPower(c[2], 5)))
        terms = Parallel(springs, Parallel(QuadraticDamping(c[3]), RateTerm(c[5], c[4], width)))
        return model._replace(law=Parallel(model.law, terms))

    lanes = lanes_of([with_terms(i) for i in (-1, *range(len(amounts)))])
    columns: list[list[Floats]] = [[] for _ in NAMES]
    for w, start, by_start in zip(problem.windows, point.starts, point.by_start, strict=True):
        for i, column in enumerate(problem.differences(w, point.values, lanes, start, by_start).T):
            columns[i].append(column / EFFECT)
    found = {name: np.concatenate(parts) for name, parts in zip(NAMES, columns, strict=True)}
    return {name: column for name, column in found.items() if np.all(np.isfinite(column)) and np.any(column)}


def _torque(system: Any, x: float) -> float:
    """Size of the law's torque at a torsion of that size."""
    stiffness = system.law.stiffness(x) if hasattr(system.law, "stiffness") else 0.0
    return abs(float(stiffness)) * x or 1.0
