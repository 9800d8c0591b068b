"""Systems and laws as kernels see them: by the addresses of their words and functions.

To a kernel run as Python they are themselves; the functions below do the same with both. States are arrays.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..base.law import breakpoints_of, has
from ..base.law import torsion as torsion_of
from ..base.protocols import Law, System
from ..base.quantities import Reals, States
from ..base.results import Floats
from ..compile import address
from ..compile.calls import MATRIX, VECTOR, answer, at, beyond, call, pointer, put_at, value
from ..compile.jit import entries, entry, kernel_as, routine
from ..compile.tree import count, with_leaf


class SystemAt(NamedTuple):
    """A system by the addresses of its words and of its functions; 0 where it has none."""

    words: int
    rates_at: int
    torsion_at: int
    watched_at: int
    guards_at: int


class SeveralAt(NamedTuple):
    """A system by the addresses of its words, of its rates in several states at a time and of its kinks, 0 if none."""

    words: int
    rates_at: int
    kinks_at: int


class Tupled(NamedTuple):
    """A system by its address with states that are tuples, as the steps of integration methods take them."""

    words: int
    rates_at: int

    def rhs(self, phase: Reals, y: States) -> Any:
        """Time derivatives of the states."""
        return answer(self.rates_at, self.words, phase, y)


def system_by_address(system: Any, states: int, *, torsion: bool = False, guards: int = 0) -> address.ByAddress:
    """A system of so many states for kernels; with its `torsion` and its guards, where these look for switches."""

    def addressed(words: Callable[[Any], int]) -> SystemAt:
        seen = len(system.watched(0.0, (0.0,) * states)) if has(system, "watched") else 0
        return SystemAt(
            words(system),
            rates_entry(system, states),
            entry(_torsion, system, float, states) if torsion else 0,
            entry(_watched, system, float, states, seen) if seen else 0,
            entry(_guards, system, float, states, guards) if guards else 0,
        )

    return address.ByAddress(system, addressed)


def several_at(system: System, words: int, states: int, kinks: int) -> SeveralAt:
    """A system of so many states and kinks whose words are at an address."""
    corners = entry(_corners, system, float, states, kinks) if kinks else 0
    return SeveralAt(words, entry(_several, system, float, int, states, states), corners)


def rates_entry(system: System, states: int) -> int:
    """Address of the rates of a system of so many states."""
    return entry(_rates, system, float, states, states)


def _rates(model: Any, phase: float, y: States, out: Any) -> None:
    put_at(out, at(model).rhs(phase, at(y)))


def _several(model: Any, phase: float, number: int, y: States, out: Any) -> None:
    system = at(model)
    for i in range(number):
        put_at(beyond(out, i), system.rhs(phase, at(beyond(y, i))))


def _torsion(model: Any, phase: float, y: States) -> Any:
    return 1.0 * torsion_of(at(model), phase, at(y))


def _watched(model: Any, phase: float, y: States, out: Any) -> None:
    put_at(out, at(model).watched(phase, at(y)))


def _guards(model: Any, phase: float, y: States, out: Any) -> None:
    put_at(out, at(model).guards(phase, at(y)))


def _corners(model: Any, phase: float, y: States, out: Any) -> None:
    put_at(out, at(model).kinks(phase, at(y)))


def _rates_loops(system: Any, phase: float, y: Floats, out: Floats) -> None:
    call(system.rates_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_rates_loops, inline=True)
def rates(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write the time derivatives of the states y (states,) at a base angle [rad]."""
    out[:] = system.rhs(phase, tuple(y.tolist()))


def _rates_of_loops(system: Any, phase: float, y: Floats, out: Floats) -> None:
    call(system.rates_at, system.words, (phase, y.shape[0], pointer(y), pointer(out)))


@kernel_as(_rates_of_loops, inline=True)
def rates_of(system: System, phase: float, y: Floats, out: Floats) -> None:
    """Write the time derivatives of several states y (n, states) at a base angle [rad]."""
    for state, rate in zip(y, out, strict=True):
        rate[:] = system.rhs(phase, tuple(state.tolist()))


def _torsion_loops(system: Any, phase: float, y: Floats) -> Any:
    return value(system.torsion_at, system.words, (phase, pointer(y)))


@kernel_as(_torsion_loops, inline=True)
def torsion(system: System, phase: float, y: Floats) -> float:
    """Torsion [rad] of a system in the states y (states,)."""
    return float(torsion_of(system, phase, tuple(y.tolist())))


def _watched_loops(system: Any, phase: float, y: Floats, out: Floats) -> None:
    if system.watched_at != 0:
        call(system.watched_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_watched_loops, inline=True)
def watched(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write what a system has watched in the states y (states,), if anything."""
    if has(system, "watched"):
        out[:] = system.watched(phase, tuple(y.tolist()))


def _guards_loops(system: Any, phase: float, y: Floats, out: Floats) -> None:
    call(system.guards_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_guards_loops, inline=True)
def guards(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write the `guards` of a system in the states y (states,)."""
    out[:] = system.guards(phase, tuple(y.tolist()))


def _corner_distances_loops(system: Any, phase: float, y: Floats, out: Floats) -> None:
    call(system.kinks_at, system.words, (phase, pointer(y), pointer(out)))


@kernel_as(_corner_distances_loops, inline=True)
def corner_distances(system: Any, phase: float, y: Floats, out: Floats) -> None:
    """Write the `kinks` of a system in the states y (states,)."""
    out[:] = system.kinks(phase, tuple(y.tolist()))


class LawAt(NamedTuple):
    """A torsion law torque(x) by the addresses of its words and of its functions, with `kinks` breakpoints."""

    words: int
    torques_at: int
    stiffnesses_at: int
    breakpoints_at: int
    kinks: int


def law_by_address(law: Law) -> address.ByAddress:
    """A law torque(x) for kernels."""
    return address.ByAddress(law, lambda words: law_at(law, words(law)), "law")


def law_at(law: Law, words: int) -> LawAt:
    """The law whose words are at an address."""
    kinks = len(breakpoints_of(law))
    two = (VECTOR, VECTOR)
    functions = (_torques, two), (_stiffnesses, two), (_breakpoints if kinks else None, (kinks,))
    torque, stiffness, breakpoints = entries(law, *functions)
    return LawAt(words, torque, stiffness, breakpoints, kinks)


def _torques(law: Law, u: Floats, out: Floats) -> None:
    spring = at(law)
    for i in range(len(u)):
        out[i] = spring.torque(u[i])


def _stiffnesses(law: Law, u: Floats, out: Floats) -> None:
    spring = at(law)
    for i in range(len(u)):
        out[i] = spring.stiffness(u[i])


def _breakpoints(law: Law, out: Any) -> None:
    put_at(out, at(law).breakpoints())


def _torques_loops(law: Any, u: Floats, out: Floats) -> None:
    call(law.torques_at, law.words, (u, out))


@kernel_as(_torques_loops)
def torques(law: Law, u: Floats, out: Floats) -> None:
    """Write the torques [N*m] of a law at torsions (n,) [rad]."""
    out[:] = law.torque(u)


def _stiffnesses_loops(law: Any, u: Floats, out: Floats) -> None:
    call(law.stiffnesses_at, law.words, (u, out))


@kernel_as(_stiffnesses_loops)
def stiffnesses(law: Law, u: Floats, out: Floats) -> None:
    """Write the stiffnesses [N*m/rad] of a law at torsions (n,) [rad]."""
    out[:] = law.stiffness(u)


def _kinks_loops(law: Any, out: Floats) -> int:
    if law.kinks > 0:
        call(law.breakpoints_at, law.words, (pointer(out),))
    return int(law.kinks)


@kernel_as(_kinks_loops)
def kinks(law: Law, out: Floats) -> int:
    """Write the breakpoints [rad] of a law; returns their number."""
    breakpoints = breakpoints_of(law)
    out[: len(breakpoints)] = breakpoints
    return len(breakpoints)


class FunctionAt(NamedTuple):
    """A torque or a kinematic error of the base angle by the addresses of its words and of its values."""

    words: int
    values_at: int


def _values_of_error(error: Any, angles: Floats, out: Floats) -> None:
    function = at(error)
    for i in range(len(angles)):
        out[i] = function.value(angles[i])


def _values_loops(function: Any, angles: Floats, out: Floats) -> None:
    call(function.values_at, function.words, (angles, out))


@kernel_as(_values_loops)
def excitation_torques(excitation: Any, angles: Floats, out: Floats) -> None:
    """Write the torques [N*m] of an excitation at base angles (n,) [rad]."""
    out[:] = excitation.torque(angles)


@kernel_as(_values_loops)
def error_values(error: Any, angles: Floats, out: Floats) -> None:
    """Write the kinematic errors [rad] at base angles (n,) [rad]."""
    out[:] = error.value(angles)


class OscillatorAt(NamedTuple):
    """Oscillator for a balance; `slot` holds a parameter that is none of the numbers."""

    J: float
    B: float
    omega: float
    law: int
    excitation: FunctionAt
    error: FunctionAt
    slot: Floats


IN_SLOT = 3  # leaf of an `OscillatorAt` whose value goes to its slot


def oscillator_at(system: Any, leaf: int, words: Callable[[Any], int]) -> tuple[OscillatorAt, int, int]:
    """An oscillator by address, the index of its leaf among what it has then, and the address of its law's words."""
    first, places, slot, index = 0, {}, np.zeros(1), leaf
    for name, item in zip(system._fields, system, strict=True):
        inside = 0 <= leaf - first < count(item)
        if isinstance(item, tuple):
            memory = address.words_of(item)
            places[name] = words(memory)
            if inside:
                at_word = address.word_of_leaf(item, leaf - first)
                slot, index = memory.view(np.float64)[at_word : at_word + 1], IN_SLOT
        elif inside:
            index = OscillatorAt._fields.index(name)
        first += count(item)
    torque = FunctionAt(places["excitation"], entry(_torques, system.excitation, VECTOR, VECTOR))
    error = FunctionAt(places["error"], entry(_values_of_error, system.error, VECTOR, VECTOR))
    scalars = float(system.J), float(system.B), float(system.omega)
    return OscillatorAt(*scalars, places["law"], torque, error, slot), index, places["law"]


def _varied_loops(system: Any, leaf: int, value: float) -> Any:
    if leaf == IN_SLOT:
        system.slot[0] = value
    return with_leaf(system, leaf, value)


@kernel_as(_varied_loops, inline=True)
def varied(system: System, leaf: int, value: float) -> Any:
    """The oscillator at a value of its leaf."""
    return with_leaf(system, leaf, value)


class EquationsAt(NamedTuple):
    """A balance problem by the addresses of its words and functions.

    `prepare_at` is 0 where nothing is to be prepared, `slope_at` where the derivative by the parameter is a difference;
    `error` has the coefficients (blocks) of x less what is solved for, and `spare` is a buffer.
    """

    words: int
    prepare_at: int
    equations_at: int
    stiffness_at: int
    slope_at: int
    error: Floats
    spare: Floats

    def residual(self, z: Floats, r: Floats) -> None:
        """Write what the equations lack at z."""
        if self.prepare_at != 0:
            call(self.prepare_at, self.words, (z,))
        call(self.equations_at, self.words, (z, r))

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Write its derivatives by the coefficients and by the parameter; follows `residual` at the same z."""
        call(self.stiffness_at, self.words, (z, jacobian))
        if self.slope_at != 0:
            call(self.slope_at, self.words, (z, slope))
        else:
            difference(self, z, slope, self.spare)

    def harmonics(self) -> int:
        """Number of harmonics of a block."""
        return len(self.error) // 2

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficient of the first state's k-th harmonic."""
        h = len(self.error) // 2
        return z[k] + self.error[k], z[h + k] + self.error[h + k]


def equations_at(native: Any, words: Callable[[Any], int], prepare: Any, slope: Any, error: Floats) -> EquationsAt:
    """A problem of arrays and addresses by its own address; see `EquationsAt`."""
    one, lacks, jacobian = (VECTOR,), (VECTOR, VECTOR), (VECTOR, MATRIX)
    kind = type(native)
    functions = (prepare, one), (kind.equations, lacks), (kind.stiffness, jacobian), (slope, lacks)
    places = entries(native, *functions)
    return EquationsAt(words(native), places[0], places[1], places[2], places[3], error, np.empty(native.size()))


@routine
def difference(problem: Any, z: Floats, slope: Floats, spare: Floats) -> None:
    """Write the derivative of a problem's residual by its parameter, the last entry of z: a central difference."""
    n = len(slope)
    value = z[n]
    d = 1e-6 * max(abs(value), 1e-3)
    z[n] = value - d
    problem.residual(z, slope)
    z[n] = value + d
    problem.residual(z, spare)
    z[n] = value
    for i in range(n):
        slope[i] = (spare[i] - slope[i]) / (2.0 * d)
