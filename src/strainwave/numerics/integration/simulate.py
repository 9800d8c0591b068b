"""`simulate`: integration in time of any system with `rhs(phase, y)`.

All methods (see `methods`) end a step at the `corners()` of profiles, and keep the largest values between samples.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import corners_of
from ...base.protocols import System, names_of, omega_of, with_parts
from ...base.quantities import reals, shown
from ...base.results import Floats, Trajectory
from .addressed_steps import BOUND
from .methods import Dopri5, Method, checked, slipping

METHOD = Dopri5()
NEXT = 16.0  # distance to a corner on either side, in units of the rounding of times
MOST_ANGLE = 2.0**33  # of the base angle [rad]: beyond it floats are 2e-6 rad apart


def simulate(system: System, y0: ArrayLike, t: float | ArrayLike, *, method: Method = METHOD) -> Trajectory:
    """Integrate a system in time.

    Parameters
    ----------
    system : NamedTuple
        Anything with `rhs(phase, y)`; its `omega` [rad/s] turns time into phase (1 where it has none). Switches are
        located where it has `breakpoints()`.
    y0 : (states,) array_like
        State at the first time; for an `Oscillator` x [rad], x' [rad/s] and the internal states of its law, if any; for
        a train under gravity or load see `operating_state`.
    t : float or array_like
        End time [s] (from 0), or (start, end): every step is recorded, at a corner of a profile once just before and
        once just after it. More than two increasing times: the solution is recorded there, by dense output, with the
        largest values in between.
    method : Dopri5, Rk4 or Dop8
        Integration method and its tolerances or steps.

    Returns
    -------
    Trajectory
        States `y` (states, n), x [rad] and x' [rad/s] of an oscillator, over `t` (n,) [s]. `status` tells whether the
        end was reached; every value in it is finite. An interrupt (Ctrl-C) ends the run with what is finished and the
        status INTERRUPTED.

    Raises
    ------
    ValueError
        If y0 or t are not finite, of the wrong shape, or t does not increase; if y0 does not have the system's number
        of states; if a parameter of the system is out of range.
    TypeError
        If the system has no rhs, or holds something that is not a number or a model.

    References
    ----------
    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., secs. II.4-II.6.
    """
    system = with_parts("simulate", system, "rhs")
    method, times, omega = checked(method), _times(t), float(omega_of(system))
    if not abs(omega) * max(-times[0], times[-1]) < MOST_ANGLE:
        raise ValueError(
            f"t = {times[0]:g} .. {times[-1]:g} s turns the base angle by more than {MOST_ANGLE:.2g} rad at omega = "
            f"{omega:g} rad/s, where floats no longer resolve it; stay within {MOST_ANGLE / abs(omega):.3g} s of 0"
        )
    spans = stretches(system, omega, float(times[0]), float(times[-1]))
    y, rate = _start(system, spans[0][0], y0)
    system, y, rate = slipping(system, omega * spans[0][0], y)
    with np.errstate(all="ignore"):  # the status tells of an overflow, also where nothing is compiled
        return method.trajectory(system, y, rate, times, spans)


def stretches(system: System, omega: float, start: float, end: float) -> list[tuple[float, float]]:
    """Spans of time [s] from start to end in which the system has no corner, each just inside its corners.

    A step ends just before a corner, where the function still is what it was; the next begins just after it.
    """
    corners = np.array(corners_of(system), float)
    if omega == 0.0 or not len(corners):
        return [(start, end)]
    margin = NEXT * float(np.spacing(max(abs(start), abs(end))))
    times = np.sort(corners / omega)
    times = times[(times > start - margin) & (times < end + margin)]
    spans: list[tuple[float, float]] = []
    begin = start
    for time in times.tolist():
        if time - margin > begin + 2.0 * margin:
            spans.append((begin, time - margin))
        begin = max(begin, time + margin)
    if end > begin + 2.0 * margin:
        spans.append((begin, end))
    return spans


def first_time(t: float | ArrayLike) -> float:
    """Time [s] at which `simulate` begins: 0 where t is an end time."""
    return float(_times(t)[0])


def _numbers(value: ArrayLike, sentence: str) -> Floats:
    array = np.atleast_1d(reals(value))
    if array.ndim != 1 or array.size == 0 or not np.all(np.isfinite(array)):
        raise ValueError(f"{sentence}, not {shown(value)}")
    return array


def _times(t: float | ArrayLike) -> Floats:
    sentence = "t must be an end time or finite increasing times"
    times = _numbers(t, sentence)
    if times.size == 1:
        times = np.array([0.0, times[0]])
    if not np.all(np.diff(times) > 0.0):
        raise ValueError(f"{sentence}, not {shown(t)}")
    if np.spacing(np.max(np.abs(times))) > 1e-6 * (times[-1] - times[0]):
        raise ValueError(f"t = {times[0]:g} s is too far from 0 for floats to resolve the span; start nearer to 0")
    return times


def _start(system: System, t: float, y0: ArrayLike) -> tuple[Any, Any]:
    """Return the starting state and its rate as tuples, after checking that they fit the system."""
    y = tuple(_numbers(y0, "y0 must be a finite state, for an Oscillator (x, x')").tolist())
    name = type(system).__name__
    if (names := names_of(system)) and len(y) != len(names):
        raise ValueError(f"y0 has {len(y)} states but {name} has {len(names)}: {', '.join(names)}; give each one")
    try:
        rate = tuple(float(v) for v in system.rhs(float(omega_of(system)) * t, y))
    except (ArithmeticError, IndexError, ValueError) as error:
        raise ValueError(f"{name}.rhs does not accept y0 = {y} ({error}); give it as many states as it has") from error
    if len(rate) != len(y):
        raise ValueError(f"y0 has {len(y)} states but {name} has {len(rate)}; give as many")
    if not all(math.isfinite(v) and abs(u) < BOUND for u, v in zip(y, rate, strict=True)):
        raise ValueError(f"at y0 = {y} {name}.rhs gives the rates {rate}; start closer to equilibrium")
    return y, rate
