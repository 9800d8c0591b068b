"""Passage through resonance at a finite rate: `passage`, a run-up or run-down of the slow flow.

The wave generator (or whatever the base angle is tied to) follows theta' = omega(t), exactly, from one speed to the
other at a constant rate, and then stays at the last speed. The start is the steady state at the first speed, the one
of lowest amplitude where there are several. Near omega_0 the drive needs time, about 2/mu, to take up its steady
amplitude: a fast passage stays below it, and a drive that would jump in a slow one passes without (Lewis 1932, Trans.
ASME 54, 253-261, for a linear drive).

The history of a passage put together: the whole motion's envelope, and what follows at the last speed.
"""

import math
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....base.arguments import typed
from ....base.protocols import with_parts
from ....base.quantities import numbers, shown
from ....base.results import Floats, SolveError
from ....base.sentences import Sentence, Speed
from ..certificate import certify
from ..flow import SlowFlow, slow_flow
from ..response import envelope, response
from ..setting import Complexes, Resonance
from ..states import polished
from .basins import March, destinations, march, refuse_turned, stable_states
from .moving import DelayedJump, Passage, Passages, tabulated
from .ride import Way, folds_ahead

MOST_RATES = 200
ROOM = 2.0  # of the largest steady amplitude: so far a table reaches
TRUSTED = 0.03  # largest estimated error of a valid passage
BESIDE, APART = 0.1, 0.15  # of a rate, and of the largest amplitude: it may change so much at rates so near
HURRY = {1: 2.0, 2: 0.8}  # error of a linear passage over a power of Omega'/Omega^2: 1/2 at first order, 1 at second
FASTEST = 0.3  # rate/omega_0^2 beyond which an amplitude that changes slowly is no description
LEAST = 1e-8  # rate/omega_0^2: there rounding is 3e-4 of the amplitude, and it grows as the rate falls
SLOWEST, FACTOR, PARTS = (
    -3,
    4.0,
    (16, 8, 1),
)  # of the search for the rate without a jump: powers, and parts of a bracket

SETTLED = 0.02  # of the steady amplitude
TRACKED = 200  # speeds at which the last steady state is followed back
HELD = 201  # samples at the last speed
LONGER = 1.5  # than a linear drive would need


@dataclass(frozen=True, eq=False)
class After:
    """What follows at the last speed.

    Attributes
    ----------
    t, z : (n,) arrays
        Times [s] after the end of the ramp, and slow states [rad].
    settling : float or None
        Settling time [s]; see `Passage`.
    """

    t: Floats
    z: Complexes
    settling: float | None


def settled(sweep: Way, rates: Floats, motions: March, jumps: list[tuple[DelayedJump, ...]]) -> list[After]:
    """Hold the last speed until the motion settles, and find when it did."""
    end = motions.z[:, -1]
    held = sweep.quick.at(sweep.last)
    states, label = destinations(held, end)
    steady = np.array([states[i] if i >= 0 else complex(np.nan) for i in label])
    distance = np.abs(end - steady) / np.maximum(SETTLED * np.abs(steady), 1e-6 * sweep.size)
    time = LONGER * 2.0 * np.log(np.maximum(np.nan_to_num(distance, nan=1.0), 1.0) * 2.0) / sweep.flow.setting.mu
    refuse_turned(abs(held.setting.fast - held.setting.omega_0) * float(np.max(time)))
    hold = march(lambda _t, z, _lanes: np.asarray(held.rates(z)), end, time, HELD, sweep.size)
    tracks: dict[int, tuple[Floats, Complexes]] = {}
    answers = []
    for i, place in enumerate(label.tolist()):
        t, z = motions.t[i], motions.z[i]
        if place < 0:
            answers.append(After(hold.t[i, 1:], hold.z[i, 1:], None))
            continue
        if place not in tracks:
            tracks[place] = _track(sweep, states[place])
        speeds, track = tracks[place]
        omega = sweep.first + sweep.ahead * rates[i] * t
        follow = np.interp(sweep.ahead * omega, sweep.ahead * speeds, track.real, left=np.nan)
        follow = follow + 1j * np.interp(sweep.ahead * omega, sweep.ahead * speeds, track.imag, left=np.nan)
        target = np.append(follow, np.full(HELD - 1, states[place]))
        whole_t, whole_z = np.append(t, t[-1] + hold.t[i, 1:]), np.append(z, hold.z[i, 1:])
        event = float(motions.at_largest[i])
        if jumps[i]:
            event = abs(jumps[i][-1].omega - sweep.first) / float(rates[i])
        close = np.abs(whole_z - target) <= np.maximum(SETTLED * np.abs(target), 1e-6 * sweep.size)
        away = np.flatnonzero(~close)
        last = int(away[-1]) + 1 if len(away) else 0
        settling = None if last >= len(whole_t) else max(0.0, float(whole_t[last]) - event)
        answers.append(After(hold.t[i, 1:], hold.z[i, 1:], settling))
    return answers


def _track(way: Way, state: complex) -> tuple[Floats, Complexes]:
    """The last steady state [rad] followed back to the speeds where it begins: speeds in the order of the way."""
    speeds, states = [way.last], [state]
    for omega in np.linspace(way.last, way.first, TRACKED + 1)[1:]:
        flow: Any = way.quick.at(float(omega))
        z = 0j if state == 0.0 else complex(polished(flow, np.array([states[-1]]))[0])
        if not abs(z - states[-1]) <= 0.5 * abs(states[-1]):
            break
        speeds.append(float(omega))
        states.append(z)
    return np.array(speeds[::-1]), np.array(states[::-1])


@typed
def passage(
    system: Any, resonance: Resonance, band: tuple[float, float], rate: float | ArrayLike, *, order: int = 2
) -> Passage | Passages:
    """Run a drive through a resonance at a finite rate, by its slow flow.

    Parameters
    ----------
    system : Oscillator
        As `slow_flow` takes it, with damping. Its own `omega` is ignored.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle.
    band : (float, float)
        First and last speed of the base angle [rad/s]: a run-up where the last is higher, otherwise a run-down. The
        speed q omega_0/p must lie between them.
    rate : float or (n,) array_like
        Change of the speed [rad/s^2], positive also for a run-down; up to 200 of them.
    order : int
        Order of the slow flow, 1 or 2. The change of the speed itself has a part in the second order only.

    Returns
    -------
    Passage or Passages
        For one rate the history `t` [s], `omega` [rad/s] and `amplitude` [rad, 0-to-peak], (n,) arrays; the `largest`
        amplitude, the `jumps`, and the time of `settling` [s]. For an array `passages`, one of these at every rate,
        and `rate_without_jump` [rad/s^2], above which the drive passes without a jump. A linear law has an exact
        formula at both orders.

    Raises
    ------
    ValueError
        If a rate or the damping is not positive, the resonance is not in the band, the band holds the resonance of
        another line too, a rate is too high for an amplitude that changes slowly, or `slow_flow` refuses.
    SolveError
        If there is no stable steady state at the first speed.

    References
    ----------
    Lewis 1932, Trans. ASME 54, 253-261; Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.
    """
    rates = _checked_rates(rate)
    first, last = _checked_band(band)
    system = with_parts("passage", system, "law", "J", "omega")
    flow = slow_flow(system._replace(omega=first), resonance, order=order)
    way = _way(flow, first, last)
    _refuse_rates(flow, rates)
    every = _passages(flow, way, rates)
    return every[0] if isinstance(rate, Real) else Passages(tuple(every), _rate_without_jump(way))


def _checked_rates(rate: Any) -> Floats:
    rates = numbers("rate [rad/s^2]", rate)
    if not np.all(rates > 0.0):
        raise ValueError(f"rate is {shown(rate)}; it must be positive [rad/s^2]: a run-down is a band (high, low)")
    if len(rates) > MOST_RATES:
        raise ValueError(f"there are {len(rates)} rates; give at most {MOST_RATES}")
    return rates


def _checked_band(band: Any) -> tuple[float, float]:
    first, last = numbers("the band [rad/s]", band, count=2)
    if not (first > 0.0 and last > 0.0 and first != last):
        raise ValueError(f"the band [rad/s] is {shown(band)}; it must be two different positive speeds, first and last")
    return float(first), float(last)


def _way(flow: SlowFlow, first: float, last: float) -> Way:
    s, (lo, hi) = flow._flow.setting, sorted((first, last))
    if flow.resonance.ratio is None:
        raise ValueError("without resonance there is nothing to pass; give the Resonance(p, q) in the band")
    if not s.mu > 0.0:
        raise ValueError(f"B is {flow.system.B:.6g} N*m*s/rad; a passage needs positive damping: give B")
    middle = s.omega_0 / float(flow.resonance.ratio)
    if not lo < middle < hi:
        raise ValueError(
            Sentence(
                f"the band {lo:.6g} .. {hi:.6g} rad/s does not contain the resonance ({flow.resonance}) at omega = {{}}"
                "; widen it",
                Speed(middle),
            )
        )
    for k, soft in zip(s.orders, s.on_fast, strict=True):
        if not soft and lo <= s.omega_0 / k <= hi:
            raise ValueError(
                f"the line of order {k} meets omega_0 = {s.omega_0:.6g} rad/s at omega = {s.omega_0 / k:.6g} rad/s, "
                f"inside the band {lo:.6g} .. {hi:.6g} rad/s; narrow the band to one resonance"
            )
    quick = flow._flow
    if s.soft != 0.0:  # where what it feeds in is lost again at the latest
        most = max(abs(s.at(w).soft) / (s.mu * w * s.fast / s.omega) for w in (lo, hi, middle))
        quick = tabulated(quick, (lo, hi), ROOM * most)
    steady = response(quick, lo, hi)
    if s.soft == 0.0:
        quick = tabulated(quick, (lo, hi), ROOM * (steady.peak[1] or max(s.scales())))
    stable = stable_states(quick.at(first))
    if not stable:
        raise SolveError(Sentence("the slow flow has no stable steady state at the first speed {}", Speed(first)))
    start = min(stable, key=abs)
    return Way(flow._flow, quick, steady, tuple(folds_ahead(quick, steady, first, last)), first, last, start)


def _refuse_rates(flow: SlowFlow, rates: Floats) -> None:
    ratio = float(flow.resonance.ratio or 1)
    most = FASTEST * flow.omega_0**2 / ratio
    if np.max(rates) > most:
        raise ValueError(
            f"rate is {np.max(rates):.6g} rad/s^2; above {FASTEST} q omega_0^2/p = {most:.6g} rad/s^2 the speed passes "
            "the resonance within one period: integrate instead"
        )
    least = LEAST * flow.omega_0**2
    if np.min(rates) < least:
        raise ValueError(
            f"rate is {np.min(rates):.6g} rad/s^2; below {LEAST:g} omega_0^2 = {least:.6g} rad/s^2 the drive follows "
            "its steady states, and rounding would show: SlowFlow.response has them, and its folds are the jumps"
        )


def _passages(flow: SlowFlow, sweep: Way, rates: Floats) -> list[Passage]:
    n = len(rates)
    tried = np.concatenate([rates, (1.0 - BESIDE) * rates, (1.0 + BESIDE) * rates]) if sweep.folds else rates
    everything = sweep.ride(tried)
    motions = everything.of(np.arange(n))
    spread = np.abs(np.abs(everything.largest.reshape(-1, n)) / np.maximum(np.abs(motions.largest), 1e-300) - 1.0)
    firm = np.max(spread, axis=0) <= APART
    jumps = sweep.jumps(rates, motions)
    after = settled(sweep, rates, motions, jumps)
    errors: dict[int, float] = {}
    passages = []
    for i, rate in enumerate(rates.tolist()):
        z = np.append(motions.z[i], motions.largest[i])
        t = np.append(motions.t[i], motions.at_largest[i])
        omega = sweep.first + sweep.ahead * rate * t
        x = envelope(sweep.flow, omega, z)
        error = _error(flow, sweep, (abs(z[-1]), float(omega[-1]), rate), jumps[i], errors)
        hold = after[i]
        valid = bool(error <= TRUSTED and firm[i] and abs(z[-1]) > 0.0)
        numbers_ = float(abs(z[-1])), float(omega[-1]), float(np.max(x))
        passages.append(
            Passage(
                sweep.first, sweep.last, rate, flow.order, sweep.linear, *numbers_, jumps[i], hold.settling,
                np.append(t[:-1], t[-2] + hold.t), np.append(omega[:-1], np.full(len(hold.t), sweep.last)),
                np.abs(np.append(z[:-1], hold.z)),
                np.append(x[:-1], envelope(sweep.flow, np.full(len(hold.t), sweep.last), hold.z)),
                error, valid, _sentence(flow, sweep, rate, numbers_, jumps[i], error, bool(firm[i])),
            )
        )  # fmt: skip
    return passages


def _error(
    flow: SlowFlow, sweep: Way, place: tuple[float, float, float], jumps: tuple[DelayedJump, ...],
    errors: dict[int, float],
) -> float:  # fmt: skip
    """Estimated relative error of the largest amplitude and |x|: that of steady states like it, and that of the rate.

    The steady states are the one of the same amplitude, or the highest, and those at the folds where it jumped.
    """
    amplitude, speed, rate = place
    ratio = float(flow.resonance.ratio or 1)
    # what is left out is of higher order in Omega'/Omega^2: at a low speed it is more
    hurry = rate * ratio / min(flow.omega_0, ratio * speed) ** 2
    late = HURRY[flow.order] * hurry ** (0.5 * flow.order)
    if sweep.linear:
        return 0.0
    if not sweep.response.branches:
        return float(late)
    branch = sweep.response.branches[0]
    top = int(np.argmax(branch.amplitude))
    i = top if amplitude >= branch.amplitude[top] else int(np.argmin(np.abs(branch.amplitude - amplitude)))
    states = [(i, float(branch.omega[i]), branch.amplitude[i] * np.exp(-1j * branch.phase[i]))]
    jumped = {jump.fold for jump in jumps}
    states += [(-1 - i, fold.omega, fold.z) for i, fold in enumerate(sweep.folds) if fold.omega in jumped]
    for key, omega, z in states:
        if key not in errors:
            certificate = certify(sweep.flow.at(omega), complex(z), flow.order)
            errors[key] = max(certificate.amplitude, certificate.waveform, abs(certificate.speed))
    return float(late) + max(errors[key] for key, _, _ in states)


def _sentence(
    flow: SlowFlow, sweep: Way, rate: float, largest: tuple[float, float, float], jumps: tuple[DelayedJump, ...],
    error: float, firm: bool,
) -> str:  # fmt: skip
    name = "run-up" if sweep.ahead > 0.0 else "run-down"
    text = "; ".join(
        f"it jumps at {j.omega:.6g} rad/s, {j.delay:.3g} rad/s after the fold (estimate {j.estimate:.3g})"
        for j in jumps
    )
    if math.isinf(error) or error > TRUSTED:
        better = "take second order, or integrate" if flow.order == 1 else "integrate"
        verdict = f"not valid: the estimated error is {100.0 * error:.2g} % (limit {100.0 * TRUSTED:.0f} %); {better}"
    elif largest[0] == 0.0:
        verdict = "not valid: the passage starts at a = 0, which the slow flow never leaves undisturbed; integrate"
    elif not firm:
        verdict = f"not valid: at a rate {100.0 * BESIDE:.0f} % off the largest amplitude is another; integrate"
    else:
        verdict = f"valid: the estimated error is {100.0 * error:.2g} %"
    return (
        f"{name} from {sweep.first:.6g} to {sweep.last:.6g} rad/s at {rate:.6g} rad/s^2: largest amplitude "
        f"{largest[0]:.6g} rad at {largest[1]:.6g} rad/s, largest |x| {largest[2]:.6g} rad; {text or 'no jump'}; "
        f"{verdict}"
    )


def _rate_without_jump(sweep: Way) -> float | None:
    """Rate [rad/s^2] above which the drive passes without jumping, to 1 %; None where there is no such rate."""
    if not sweep.folds:
        return None
    s = sweep.flow.setting
    fastest = FASTEST * s.omega_0**2 / (s.fast / s.omega)
    rates = s.mu**2 * FACTOR ** np.arange(SLOWEST, 1.0 + math.log(fastest / s.mu**2) / math.log(FACTOR))
    for parts in PARTS:
        stays = np.flatnonzero(~sweep.jumped(rates))
        if not len(stays) or stays[0] == 0:
            return None
        low, high = rates[stays[0] - 1], rates[stays[0]]
        rates = np.geomspace(low, high, parts + 1)
    return math.sqrt(low * high)
