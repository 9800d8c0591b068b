"""Which balance serves a system."""

from ...base.protocols import Balance, System, lacking
from .condensed.build import condensed
from .first_order import first_order
from .rates import SAME, is_second_order
from .second_order import second_order


def balance_of(
    system: System, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, folded: bool = True
) -> Balance:  # fmt: skip
    """Balance problem of a system at its own parameters, in as few unknowns as it takes.

    That is the torsion alone where it is J x'' + B u' + T(u) = tau, what the laws see where all else is linear, and all
    states of any other. `folded`: its orbits may be taken to repeat as often in a turn as what drives them.

    Raises
    ------
    TypeError
        If the system has neither those fields nor a method rhs(phase, y).
    """
    if is_second_order(system):
        return second_order(system, leaf, omega_leaf, harmonics, turns)
    if lacking(system, "rhs"):
        raise TypeError(f"{type(system).__name__} has no rhs(phase, y), nor the fields {', '.join(SAME)}")
    found = condensed(system, leaf, omega_leaf, harmonics, turns, folded)
    return first_order(system, leaf, omega_leaf, harmonics, turns) if found is None else found
