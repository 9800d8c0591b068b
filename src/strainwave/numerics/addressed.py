"""Systems and laws as kernels see them: by the addresses of their words and functions.

To a kernel run as Python they are themselves; the functions below do the same with both. States are arrays.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..compile.address import VECTOR, ByAddress, answer, at, call, pointer, put_at, value
from ..compile.jit import entry, kernel_as
from ..law import breakpoints_of, has
from ..law import torsion as torsion_of
from ..results import Floats


class SystemAt(NamedTuple):
    """A system by the addresses of its words and of its functions; 0 where it has none."""

    words: int
    rates_at: int
    torsion_at: int
    watched_at: int


class Tupled(NamedTuple):
    """A system by its address with states that are tuples, as the steps of integration methods take them."""

    words: int
    rates_at: int

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the states."""
        return answer(self.rates_at, self.words, phase, y)


def system_by_address(system: Any, states: int, *, torsion: bool = False) -> ByAddress:
    """A system of so many states for kernels; with its `torsion`, where these look for switches."""

    def addressed(words: Callable[[Any], int]) -> SystemAt:
        seen = len(system.watched(0.0, (0.0,) * states)) if has(system, "watched") else 0
        return SystemAt(
            words(system),
            entry(_rates, system, float, states, states),
            entry(_torsion, system, float, states) if torsion else 0,
            entry(_watched, system, float, states, seen) if seen else 0,
        )

    return ByAddress(system, addressed)


def _rates(model: Any, phase: Any, y: Any, out: Any) -> None:
    put_at(out, at(model).rhs(phase, at(y)))


def _torsion(model: Any, phase: Any, y: Any) -> Any:
    return 1.0 * torsion_of(at(model), phase, at(y))


def _watched(model: Any, phase: Any, y: Any, out: Any) -> None:
    put_at(out, at(model).watched(phase, at(y)))


def _rates_loops(system: Any, phase: Any, y: Any, out: Any) -> None:
    call(system.rates_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_rates_loops, inline=True)
def rates(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write the time derivatives of the states y (states,) at a base angle [rad]."""
    out[:] = system.rhs(phase, tuple(y.tolist()))


def _torsion_loops(system: Any, phase: Any, y: Any) -> Any:
    return value(system.torsion_at, system.words, (phase, pointer(y)))


@kernel_as(_torsion_loops, inline=True)
def torsion(system: Any, phase: float, y: Floats) -> float:
    """Torsion [rad] of a system in the states y (states,)."""
    return float(torsion_of(system, phase, tuple(y.tolist())))


def _watched_loops(system: Any, phase: Any, y: Any, out: Any) -> None:
    if system.watched_at != 0:
        call(system.watched_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_watched_loops, inline=True)
def watched(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write what a system has watched in the states y (states,), if anything."""
    if has(system, "watched"):
        out[:] = system.watched(phase, tuple(y.tolist()))


class LawAt(NamedTuple):
    """A torsion law torque(x) by the addresses of its words and of its functions, with `kinks` breakpoints."""

    words: int
    torques_at: int
    stiffnesses_at: int
    breakpoints_at: int
    kinks: int


def law_at(law: Any, place: int) -> LawAt:
    """The law whose words are at an address."""
    kinks = len(breakpoints_of(law))
    return LawAt(
        place,
        entry(_torques, law, VECTOR, VECTOR),
        entry(_stiffnesses, law, VECTOR, VECTOR),
        entry(_breakpoints, law, kinks) if kinks else 0,
        kinks,
    )


def _torques(law: Any, u: Any, out: Any) -> None:
    known = at(law)
    for i in range(len(u)):
        out[i] = known.torque(u[i])


def _stiffnesses(law: Any, u: Any, out: Any) -> None:
    known = at(law)
    for i in range(len(u)):
        out[i] = known.stiffness(u[i])


def _breakpoints(law: Any, out: Any) -> None:
    put_at(out, at(law).breakpoints())


def _torques_loops(law: Any, u: Any, out: Any) -> None:
    call(law.torques_at, law.words, (u, out))


@kernel_as(_torques_loops)
def torques(law: Any, u: Floats, out: Floats) -> None:
    """Write the torques [N*m] of a law at torsions (n,) [rad]."""
    out[:] = law.torque(u)


def _stiffnesses_loops(law: Any, u: Any, out: Any) -> None:
    call(law.stiffnesses_at, law.words, (u, out))


@kernel_as(_stiffnesses_loops)
def stiffnesses(law: Any, u: Floats, out: Floats) -> None:
    """Write the stiffnesses [N*m/rad] of a law at torsions (n,) [rad]."""
    out[:] = law.stiffness(u)


def _kinks_loops(law: Any, out: Any) -> int:
    if law.kinks > 0:
        call(law.breakpoints_at, law.words, (pointer(out),))
    return law.kinks


@kernel_as(_kinks_loops)
def kinks(law: Any, out: Floats) -> int:
    """Write the breakpoints [rad] of a law; returns their number."""
    known = breakpoints_of(law)
    out[: len(known)] = known
    return len(known)
