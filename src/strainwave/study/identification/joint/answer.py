"""`fit_joint`: a joint from its logs, what the fit explains, and why it does not explain more."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ....base.results import Floats, SolveError
from ....base.units import ARCSEC, RPM
from . import solve
from .estimates import Estimates, estimates_of, one_way
from .march import spring_torque
from .meter import OF_GEAR, OF_MOTOR, meters
from .metered import LIKELY, Metered, constant_of, doubt, joined, lacking, linear, metered
from .model import Joint, scales
from .pieces import pieces_of

GRID_STEP = 0.06  # of 1/omega of the stiffest slope: a step of the grid
CLOUD_POINTS = 600  # points
MISSED_SHARE = 0.2  # of the torsion: a residual from which on the joint's own frequency is not known
GUESSES_HZ = (6.0, 12.0, 24.0)  # Hz, resonances that are tried where no inertia is given
# Times the readings' scatter: more, also in the band, needs a cause. 60 logs of the model class (seeds 6001 to 6060 of
# benchmarks/joint_logs.py) leave at most 1.09, and 1.20 in the band.
CHANCE_RATIO, BAND_CHANCE_RATIO = 1.2, 1.3
BAND = 4.0  # of the joint's resonance: the band in which loads move
CAUSE_LEFT = 3.0  # of the readings' scatter: what a named cause leaves at most
CAUSE_SHARE = 0.8  # of the residual: what a cause leaves at most
UNLIKE_RATIO = 2.0  # times: a K1 so far off the datasheet's, or an inertia off the one given
MOST_UNEVEN = 0.25  # of the stiffness, to either side: more is no spring's
PEAK_SHARE, PEAK_WIDTH, PEAK_HEIGHT = 0.3, 0.1, 8.0  # of a residual's power; of its place; over what is beside
SECOND_RESONANCE = 1.3  # of the joint's own resonance: the least second one
LOWEST_ORDER, ORDER_GAP = 0.2, 0.1  # per turn; how far from whole an order is that no line of the model has
CAUSES = {
    "gap": "a backlash of {:.3g} arcsec in the gear",
    "asymmetry": "a stiffness that differs by {:.3g} % between the two directions (asymmetry)",
    "drag": "a drag of {:.3g} N·m·s²/rad² proportional to speed squared (quadratic drag)",
}


class Cause(NamedTuple):
    """Effect that the logs show, a noun or a clause, and whether the model lacks it; else what was given is wrong."""

    text: str
    of_model: bool = True


@dataclass(frozen=True, eq=False)
class Answer:
    """A joint that was fitted.

    Attributes
    ----------
    joint : Joint
        Its numbers.
    estimates : Estimates
        Those of them that the logs tell.
    explained : float
        Share of the torsion's motion that the model explains: 1 - rms of the residual / rms of the torsion.
    residual, scatter : float
        Root mean square of the residual [rad], and the scatter of the load's readings.
    causes : tuple of Cause
        Why the fit explains no more, as a test supports.
    inertia_known : bool
        Whether the load's inertia was given, or a channel of torque has weighed it.
    channels : tuple of Metered
        What currents and torques tell.
    notes : tuple of str
        Doubts and results of the channels, a sentence each.
    """

    joint: Joint
    estimates: Estimates
    explained: float
    residual: float
    scatter: float
    causes: tuple[Cause, ...]
    inertia_known: bool
    channels: tuple[Metered, ...]
    notes: tuple[str, ...]

    @property
    def more(self) -> float:
        """Residual in scatters of the readings, where it is more than chance and of no known cause; or 0."""
        return 0.0 if self.causes or not unexplained(self.joint) else self.residual / self.scatter


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of motions that leave every bound
def fit_joint(
    logs: Sequence[Any], ratio: float, law: Sequence[float], inertia: float | None, constant: float | None,
    progress: solve.Progress,
) -> Answer:  # fmt: skip
    """Fit a joint to its logs; law is the datasheet's K1, K2, K3, T1, T2, constant the torque of a current [N*m/A].

    Raises
    ------
    ValueError
        If the angles are none of such a gear, or nothing moves.
    SolveError
        If the motion leaves every bound.
    """
    joint, causes = _first_fit(logs, ratio, law, inertia, progress)
    if not np.isfinite(solve.rms(joint)):
        fastest = max(float(np.max(np.abs(piece.motor_rate))) for piece in joint.pieces) / RPM
        raise SolveError(
            f"the simulated motion diverges; in this log the motor turns at up to {fastest:.4g} rpm: check the unit of "
            "the angles, and that gear, load inertia and log are of one joint"
        )
    by, notes = None, list[str]()
    if inertia is None:
        joint, by, notes = _with_weighed_inertia(joint, logs, ratio, law, constant, progress)
        inertia = None if by is None else joint.values["inertia"]
    noise = solve.scatter(joint)
    if not causes:
        joint, causes = _fit_or_cause(joint, logs, ratio, law, inertia, by is None, progress)
    progress("intervals", 0.95)
    if "load_friction" not in joint.free and not one_way(joint):  # without a reversal it is a stiffness
        joint = replace(joint, free=(*joint.free, "load_friction"))  # after a choice intervals are too narrow
    joint = solve.settled(joint)  # where a term was tried, or left out, the others may not be at their best
    residual = float(np.sqrt(np.mean(np.concatenate(joint.residuals()) ** 2)))
    torsion = np.concatenate([torsion_of(joint, i) for i in range(len(joint.pieces))])
    explained = 1.0 - residual / max(float(np.sqrt(np.mean(torsion**2))), 1e-300)
    joint = _with_measured_torques(joint, logs, by, constant)
    of_joint, channels = estimates_of(joint, inertia is not None), list[Metered]()
    for names in (OF_GEAR, OF_MOTOR):
        meter, why = meters(joint, logs, names)
        notes += why
        if meter is None:
            continue
        if (fit := linear(meter)) is None:
            notes.append(f"{meter.name} has too few samples with a turning motor and is omitted.")
            continue
        weighs = None if inertia is None else meter.name == by
        channels.append(metered(meter, fit, of_joint.of_free, constant_of(meter.name, constant), weighs))
        notes += channels[-1].notes
    estimates = joined(of_joint, channels, next((c for c in channels if c.name == by), None), joint.values["inertia"])
    return Answer(
        joint=joint, estimates=estimates, explained=explained, residual=residual, scatter=noise, causes=tuple(causes),
        inertia_known=inertia is not None, channels=tuple(channels), notes=tuple(notes),
    )  # fmt: skip


def _with_weighed_inertia(
    joint: Joint, logs: Sequence[Any], ratio: float, law: Sequence[float], constant: float | None,
    progress: solve.Progress,
) -> tuple[Joint, str | None, list[str]]:  # fmt: skip
    """The fit with the load's inertia by a channel whose torque is known, the channel's name, and doubts.

    A motion without torques tells all inertias, stiffnesses and torques but for a common factor, which is K1's here.
    """
    notes: list[str] = []
    for names in (OF_GEAR, OF_MOTOR):
        meter, _ = meters(joint, logs, names)
        one = None if meter is None else constant_of(meter.name, constant)
        if meter is None or one is None or (fit := linear(meter)) is None:
            continue
        scale = abs(fit.values["scale"])
        factor = scale * one
        doubts = doubt(meter, 1.0 / factor, LIKELY)
        notes += doubts
        if doubts or lacking(meter, fit, float(np.sqrt(fit.covariance[0, 0])) / scale):
            continue
        inertia = factor * joint.values["inertia"]
        first = _start_of(logs, ratio, law, inertia, solve.BASIC)
        again = solve.fitted(first, float(np.sqrt(law[0] / inertia)), progress)
        return _with_measured_torques(again, logs, meter.name, constant), meter.name, notes
    return joint, None, notes


def _with_measured_torques(joint: Joint, logs: Sequence[Any], by: str | None, constant: float | None) -> Joint:
    """The joint with the torques that a channel says."""
    meter, one = (None, None) if by is None else (meters(joint, logs, (by,))[0], constant_of(by, constant))
    if meter is None or one is None or (fit := linear(meter)) is None:
        return joint
    return joint.scaled(abs(fit.values["scale"]) * one)


def torsion_of(joint: Joint, i: int, about: float = 1.0) -> Floats:
    """Torsion about its mean (m,) in a piece, or from 0."""
    torsion = joint.pieces[i].turned / joint.ratio - joint.pieces[i].value
    return torsion - about * np.mean(torsion)


def _start_of(logs: Sequence[Any], ratio: float, law: Sequence[float], inertia: float, free: tuple[str, ...]) -> Joint:
    """Joint before a fit: numbers of the datasheet, and offsets by the mean torsion of each log."""
    pieces, _ = pieces_of(logs, ratio, GRID_STEP / float(np.sqrt(max(law[:3]) / inertia)))
    of = scales(inertia, law, float(np.sqrt(law[0] / inertia)))
    values = {name: scale.first for name, scale in of.items()} | {"hysteresis": 0.0}
    empty = Joint(tuple(pieces), ratio, of, values, (), np.zeros((len(pieces), 3)), free, np.zeros(2))
    means = {piece.log: -float(np.mean(torsion_of(empty, i, 0.0))) for i, piece in enumerate(pieces)}
    values["offset"] = means[pieces[0].log]
    more = {f"offset {log + 1}": mean - values["offset"] for log, mean in means.items() if log != pieces[0].log}
    of |= dict.fromkeys(more, of["offset"])
    return replace(empty, values=values | more, scales=of, free=(*free, *more))


def _first_fit(
    logs: Sequence[Any], ratio: float, law: Sequence[float], inertia: float | None, progress: solve.Progress
) -> tuple[Joint, list[Cause]]:  # fmt: skip
    """The fit, and that the inertia given does not fit; without one the best of several resonances, K1 as printed.

    With an inertia that is far too small a fit takes long: where a first one is unlikely, others are asked first.
    """
    if inertia is None:
        return _fit_any_inertia(logs, ratio, law, lambda joint, omega: solve.fitted(joint, omega, progress)), []
    first, omega = _start_of(logs, ratio, law, inertia, solve.BASIC), float(np.sqrt(law[0] / inertia))
    stiff = omega > 2.0 * np.pi * GUESSES_HZ[-1]
    if stiff and not _likely(solve.running(first, omega, solve.FIRST_LINES, False), law):
        other, causes = _other_inertia(logs, ratio, law, inertia, np.inf, memory=False)
        if causes:
            return other, causes
    return solve.fitted(first, omega, progress), []


def _fit_any_inertia(
    logs: Sequence[Any], ratio: float, law: Sequence[float], fit: Callable[[Joint, float], Joint]
) -> Joint:  # fmt: skip
    """The best of fits from several resonances, with K1 as the datasheet has it."""
    free = "inertia", *(name for name in solve.BASIC if name != "K1")
    guesses = [2.0 * np.pi * frequency for frequency in GUESSES_HZ]
    return min((fit(_start_of(logs, ratio, law, law[0] / w**2, free), w) for w in guesses), key=solve.rms)


def _fit_or_cause(
    joint: Joint, logs: Sequence[Any], ratio: float, law: Sequence[float], inertia: float | None, given: bool,
    progress: solve.Progress,
) -> tuple[Joint, list[Cause]]:  # fmt: skip
    """The fit with what the model lacks, or with an inertia that is not the one given: what leaves less."""
    likely, misgiven, limit = _likely(joint, law), list[Cause](), solve.rms(joint)
    if not likely and given and inertia is not None:
        limit *= CAUSE_SHARE
        other, misgiven = _other_inertia(logs, ratio, law, inertia, limit, memory="hysteresis" in joint.free)
        limit = solve.rms(other)
    if likely and not solve.shown(joint, solve.OUTSIDE):
        return joint, []
    progress("causes", 0.8)
    fitted, causes = _fit_with_cause(joint, logs, ratio, law, inertia)
    if misgiven and limit < solve.rms(fitted):
        return joint, misgiven
    ratio = _stiffness_ratio(fitted, law)
    if not causes and given and inertia is not None and not 1.0 / UNLIKE_RATIO < ratio < UNLIKE_RATIO:
        causes = [_wrong_inertia(inertia, inertia / ratio)]  # stiffness and inertia times a factor explain as much
    return fitted, causes


def _likely(joint: Joint, law: Sequence[float]) -> bool:
    """True for a fit that leaves nothing, with a stiffness like that of the datasheet."""
    return not unexplained(joint) and 1.0 / UNLIKE_RATIO < _stiffness_ratio(joint, law) < UNLIKE_RATIO


def _stiffness_ratio(joint: Joint, law: Sequence[float]) -> float:
    """Stiffness of a fit over K1 of the datasheet; a hysteresis that does not yield is a spring."""
    v = joint.values
    return float((v["K1"] + v["hysteresis"] * (v["yield_twist"] > v["T1"] / v["K1"])) / law[0])


def _wrong_inertia(given: float, likely: float) -> Cause:
    """Cause of a load inertia [kg*m^2] that does not fit, beside the one that goes with the datasheet's K1."""
    hint = f"with the gear's K1 the load inertia is near {likely:.3g} kg·m²"
    return Cause(f"that the given load inertia of {given:.3g} kg·m² is wrong ({hint})", of_model=False)


def unexplained(joint: Joint) -> bool:
    """True for a residual that is more than the readings' scatter, at all frequencies or where loads move."""
    scatter, power, many = solve.scatter(joint), 0.0, 0
    if solve.rms(joint) > CHANCE_RATIO * scatter:
        return True
    if not solve.is_white(joint):
        return False
    highest = BAND * float(np.sqrt(joint.values["K1"] / joint.values["inertia"])) / (2.0 * np.pi)
    for piece, residual in zip(joint.pieces, joint.residuals(), strict=True):
        frequencies, spectrum = _spectrum(piece.time, residual)
        inside = frequencies < highest
        power, many = power + float(np.sum(spectrum[inside])), many + int(np.count_nonzero(inside))
    return power > many * (BAND_CHANCE_RATIO * scatter) ** 2


def _other_inertia(
    logs: Sequence[Any], ratio: float, law: Sequence[float], given: float, limit: float, *, memory: bool
) -> tuple[Joint, list[Cause]]:  # fmt: skip
    """The fit with any inertia, completed where it leaves less than a limit; and that the one given does not fit."""
    free = _fit_any_inertia(logs, ratio, law, lambda first, w: solve.running(first, w, solve.FIRST_LINES, memory))
    free = solve.completed(free) if solve.rms(free) < limit else free
    fitted = free.values["inertia"]
    if unexplained(free) or 1.0 / UNLIKE_RATIO < fitted / given < UNLIKE_RATIO:
        return free, []
    return free, [_wrong_inertia(given, fitted)]


def _fit_with_cause(
    joint: Joint, logs: Sequence[Any], ratio: float, law: Sequence[float], inertia: float | None
) -> tuple[Joint, list[Cause]]:  # fmt: skip
    """The fit with what a test supports beyond the model, and the names of it."""
    given = joint.values["inertia"] if inertia is None else inertia
    omega = float(np.sqrt(law[0] / given))
    part = CAUSE_SHARE if solve.rms(joint) > CHANCE_RATIO * solve.scatter(joint) else 1.0
    for afresh in (False, True):
        trials = dict[str, Joint]()
        for cause in solve.OUTSIDE:
            first = _start_of(logs, ratio, law, given, solve.BASIC) if afresh else joint
            first = replace(first, free=(*first.free, cause))
            if cause == "gap":
                first = _with_gap(first)
            memory = "hysteresis" in joint.free
            trials[cause] = solve.running(first, omega, joint.lines, memory) if afresh else solve.settled(first)
        trials = {n: trial for n, trial in trials.items() if abs(trial.values["asymmetry"]) < MOST_UNEVEN}
        name = min(trials, key=lambda cause: solve.rms(trials[cause]))
        best = solve.completed(trials[name])
        if solve.fell(joint, best) and solve.rms(best) < min(part * solve.rms(joint), CAUSE_LEFT * solve.scatter(best)):
            best = solve.without(best, name)
            if name not in best.free:  # it has but led out of a trap
                return best, _cause_of_residual(best) if unexplained(best) else []
            value = best.values[name]
            size = {"gap": 2.0 * value / ARCSEC, "asymmetry": 200.0 * value, "drag": value}[name]
            return best, [Cause(CAUSES[name].format(size))]
    return joint, _cause_of_residual(joint) if unexplained(joint) else []


def _with_gap(joint: Joint) -> Joint:
    """The joint with a first gap: where its law is soft up to T1, that is the gap, and the datasheet's law beyond."""
    v, first = joint.values, {name: joint.scales[name].first for name in ("K1", "K2", "K3", "T1", "T2")}
    soft = v["K1"] < first["K1"] / UNLIKE_RATIO
    more = first | {"gap": v["T1"] / v["K1"]} if soft else {"gap": 10.0 * joint.scales["gap"].unit}
    return replace(joint, values=v | more)


def _cause_of_residual(joint: Joint) -> list[Cause]:
    """Cause of the residual in the longest piece, if a test supports it: a line of the motor's turn, or a resonance."""
    i = int(np.argmax([len(piece.time) for piece in joint.pieces]))
    piece, residual = joint.pieces[i], joint.residuals()[i]
    turned = piece.turned / (2.0 * np.pi)
    size = float(np.sqrt(np.mean(residual**2))) / ARCSEC
    resonance = np.sqrt(joint.values["K1"] / joint.values["inertia"]) / (2.0 * np.pi)
    frequency, of_time = _peak(piece.time, residual, SECOND_RESONANCE * resonance)
    if len(set(np.sign(np.diff(turned)).tolist())) == 1:
        torsion = torsion_of(joint, i)  # a line that the model lacks bends its fit, and the residual with it
        slow = np.polynomial.Polynomial.fit(turned, torsion, 4)(turned)
        order, of_turn = _peak(turned * np.sign(turned[-1] - turned[0]), torsion - slow, LOWEST_ORDER)
        if of_turn and abs(order - round(order)) > ORDER_GAP:
            return [Cause(f"a line of order {order:.3g} of the motor's turn, {size:.3g} arcsec rms")]
    known = float(np.std(residual)) < MISSED_SHARE * float(np.std(torsion_of(joint, i)))  # else K1 is no measure
    if of_time and known:
        return [Cause(f"a vibration near {frequency:.3g} Hz (a second resonance), {size:.3g} arcsec rms")]
    return []


def _peak(places: Floats, values: Floats, lowest: float) -> tuple[float, float]:
    """Frequency of a peak in the power of values, per unit of their places, and its share; 0 without a peak."""
    frequencies, power = _spectrum(places, values)
    frequency = float(frequencies[np.argmax(power * (frequencies >= lowest))])
    off = np.abs(frequencies / frequency - 1.0)
    share = float(np.sum(power[off < PEAK_WIDTH]) / max(np.sum(power), 1e-300))
    beside = np.mean(power[(off > PEAK_WIDTH) & (off < 3.0 * PEAK_WIDTH)])
    stands_out = share > PEAK_SHARE and np.mean(power[off < 0.5 * PEAK_WIDTH]) > PEAK_HEIGHT * beside
    return frequency, share if stands_out else 0.0


def _spectrum(places: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Frequencies per unit of the places of values, and the power there: of white noise its variance."""
    even, window = np.linspace(places[0], places[-1], len(places)), np.hanning(len(places))
    wave = np.fft.rfft(np.interp(even, places, values - np.mean(values)) * window)
    return np.fft.rfftfreq(len(even), even[1] - even[0]), np.abs(wave) ** 2 / np.sum(window**2)


def residual_orders(joint: Joint) -> tuple[Floats, Floats]:
    """Orders (m,) of the motor's turn, and amplitudes (m,) [rad] of what is left at them, of all pieces."""
    left, orders = np.concatenate(joint.residuals()), np.arange(LOWEST_ORDER, solve.HIGHEST + 0.5, 0.05)
    turned = np.concatenate([piece.turned for piece in joint.pieces])
    return orders, np.array([2.0 * abs(np.mean(left * np.exp(-1j * order * turned))) for order in orders])


def residuals_of(answer: Answer, logs: Sequence[Any]) -> list[tuple[Floats, Floats]]:
    """Stamps and measured less predicted angles of the load in other logs, piece by piece; only starts are fitted."""
    joint = answer.joint
    pieces, _ = pieces_of(logs, joint.ratio, joint.pieces[0].step)
    other = solve.settled(solve.started(replace(joint, pieces=tuple(pieces), free=(), kept={})))
    return [(piece.time, residual) for piece, residual in zip(pieces, other.residuals(), strict=True)]


def law_cloud(joint: Joint) -> tuple[Floats, Floats, tuple[Floats, Floats]]:
    """Torsions and torques (n,) of the spring at readings of the logs, as they were measured, and the law's curve."""
    p = joint.kernel_numbers(joint.values)
    twists, torques = [], []
    for left, twist in zip(joint.residuals(), joint.twists(), strict=True):
        some = np.linspace(0, len(left) - 1, CLOUD_POINTS // len(joint.pieces)).astype(int)
        twists.append((twist - left)[some])
        torques.append(np.array([spring_torque(float(x), p) for x in twist[some]]))
    reach = float(np.max(np.abs(np.concatenate(twists))))
    x = np.linspace(-reach, reach, 200)
    return np.concatenate(twists), np.concatenate(torques), (x, np.array([spring_torque(float(v), p) for v in x]))
