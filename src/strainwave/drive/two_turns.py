"""Motions of a drive in two turns, the motor's and the output's: error lines of either, and gravity, exactly.

Gravity follows the load's own angle, its stiffness included. A line of order j + k/N, see `Line`, is the wave (j, k).
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..base.blas import one_thread
from ..base.branch_labels import FOLD
from ..base.law import breakpoints_of, depends, stated
from ..base.number_text import number as plain
from ..base.protocols import System, lacking, lines_of, orders_of, terms_of
from ..base.quantities import checked, interval, number
from ..base.records import Waves
from ..base.results import Booleans, Branch, Floats, Integers, Orbit, SolveError, Status
from ..base.sentences import Sentence, Speed
from ..base.series import largest_of_samples
from ..base.units import ARCSEC
from ..model.excitation import NoError
from ..model.gears.limits import cubic_means
from ..model.orders import order_pair
from ..model.train.drive_train import DriveTrain
from ..model.train.linear_part import linear_part
from ..model.train.motion import Steady
from ..model.train.train_forms import AtLoad, own_state, turning
from ..numerics.continuation.trace import Trace, ending
from ..numerics.curves import torus_motion as motion
from ..numerics.curves.torus_follow import TwoTurns, along, at_speed, newton, with_crests, with_crossings
from ..numerics.curves.torus_growth import growth
from ..numerics.curves.torus_problem import Torus
from .drive_response import DriveResponse
from .response import sizes_of, sweep_on
from .train_curve import as_train, parts_of_angle, torques, with_rounded_corners, without_gravity

MOTION_TAIL, CURVE_TAIL = 1e-9, 1e-4  # share of the motion in a wave that is left out: at one speed, and on a curve
CORNERED_TAIL = 1e-3  # the same on a curve of a law with rounded corners

SCOPE = "the harmonic balance of beating motions requires a constant mean motor speed and springs without corners"
REMEDY = "integrate the drive with simulate"
NONE_STABLE = "no steady motion of this drive is stable in this range; drive_run computes its motion in time"
A_TURN = "a turn may begin at any motor angle, and the drift of slow waves within a turn is included"
UNDAMPED = "this drive has no damping, and its beating motions never settle; add damping, or integrate the drive"
STALL_RATIO = 2.0  # times the energy of turning: a load that is lifted so high all but stops at the top
STALL_TEXT = (
    "gravity nearly stops this free motor in every output turn: lifting the load requires {} J, and the kinetic energy "
    "is {} J at {}; hold the motor, give it a loop, or use higher speeds"
)
VARIATION_TEXT = (
    "this drive has an error order of the output turn together with varying damping or stiffness, or with forcing "
    "frequencies; remove the variation and give speeds of the motor or the load, or integrate with simulate"
)


def beat_said(train: DriveTrain | None) -> tuple[float, str]:
    """Turns of the motor after which all that drives a train in two turns repeats, and what the error does, in words.

    Raises
    ------
    ValueError
        If nothing beats, or a line with neither turn, or there is no train, as where damping or stiffness vary.
    """
    if train is None:
        raise ValueError(VARIATION_TEXT)
    of_lines = [k for _, k in _pairs(train)]
    if not any(of_lines):
        raise ValueError("this drive has no error order of the output turn")
    pulls = [law.order for law in parts_of_angle(train.load.end().drag) if law.amplitude]
    lines, both = [train.N / (math.gcd(*some) or math.inf) for some in (of_lines, [*of_lines, *pulls])]
    alone = "" if lines == both else f" (its kinematic error alone every {plain(lines)})"
    return both, f"beats every {plain(both)} turns of the motor{alone}"


@dataclass(frozen=True, eq=False)
class TwoTurnCurve:
    """Motions of a drive in two turns, in arc order over the speed; one alone is a curve of one point.

    Attributes
    ----------
    omega : (n,) array
        Speed of the motor [rad/s].
    pairs : (P + 1, 2) array of int
        Waves (j, k) of the angle j theta + k theta/N, (0, 0) first.
    waves : (n, P + 1) array of complex
        Their complex amplitudes [rad] in the pointing error, of which the motion is the real part.
    largest : (n,) array
        Largest oscillation [rad] over a turn of the motor that begins at any angle.
    folds : tuple of float
        Speeds [rad/s] where the curve turns.
    ratio : float
        Turns of the motor in one of the output.
    beats : int
        How often in a turn of the output everything that drives the motion repeats.
    status : Status
        `Status.OK`, `Status.TRUNCATED`, or why the curve ends inside the range.
    message : str
        One sentence on the curve.
    """

    omega: Floats
    pairs: Integers
    waves: Any
    largest: Floats
    folds: tuple[float, ...]
    ratio: float
    beats: int
    status: Status
    message: str
    problem: Torus
    points: Floats
    flow: Any

    @cached_property
    def growth(self) -> Floats:
        """Rate (n,) [1/s] at which the disturbances that last longest grow; negative of a stable motion."""
        return growth(self.problem, self.flow, self.points)

    @property
    def stable(self) -> Booleans:
        """Stability of each motion."""
        return np.asarray(self.growth < 0.0)

    @property
    def beat(self) -> Floats:
        """Period (n,) [s] of the beat."""
        return np.asarray(2.0 * np.pi * self.ratio / (self.beats * self.omega))

    @property
    def oscillations(self) -> Floats:
        """Largest and smallest |error - mean| (n, turns, 2) [rad] over a turn of the motor that begins in each turn.

        A turn begins at any angle; what a slow wave, as that of gravity, drifts within it counts. The turns are those
        after which motor and output stand as before.
        """
        both = motion.largest_in_turns, motion.smallest_in_turns
        return np.stack([f(self.waves, self.pairs, self.ratio) for f in both], axis=2)

    @cached_property
    def smallest(self) -> Floats:
        """Smallest oscillation (n,) [rad] over a turn of the motor that begins at any angle."""
        return motion.smallest_oscillations(self.waves, self.pairs, self.ratio)

    def amplitude(self, j: int, k: int) -> Floats:
        """Amplitude (n,) [rad] of a wave in the pointing error; 0 of one that it has not."""
        columns = np.flatnonzero(np.all(self.pairs == (j, k), axis=1) | np.all(self.pairs == (-j, -k), axis=1))
        return np.asarray(np.abs(self.waves[:, columns]).sum(axis=1))

    def branch(self, span: tuple[float, float]) -> Branch:
        """The curve as a `Branch` over a span of speeds [rad/s]: what repeats with every turn, and the envelope."""
        repeating = np.flatnonzero(self.pairs[:, 1] % self.ratio == 0.0)
        orders = np.rint(self.pairs[repeating] @ np.array([1.0, 1.0 / self.ratio])).astype(int).tolist()
        coefficients = np.zeros((len(self.omega), 2 * max(1, *map(abs, orders)) + 1))
        for order, wave in zip(orders, self.waves[:, repeating].T, strict=True):
            coefficients[:, max(0, 2 * abs(order) - 1)] += wave.real
            if order:
                coefficients[:, 2 * abs(order)] -= math.copysign(1.0, order) * wave.imag
        peak = motion.largest_sizes(self.waves, self.pairs, self.ratio)
        multipliers = np.exp(self.growth * 2.0 * np.pi / self.omega)[:, None].astype(complex)
        tail = _left_out(self.problem.part)
        folds = [
            Orbit(
                float(self.omega[i]), period=1, coefficients=coefficients[i][:, None], peak=float(peak[i]),
                multipliers=multipliers[i], stable=bool(self.stable[i]), tail=tail, status=self.status,
                message=self.message, label="fold", value=float(self.omega[i]),
            )
            for i in np.flatnonzero(np.isin(self.omega, self.folds)).tolist()
        ]  # fmt: skip
        return Branch(
            "omega", values=self.omega, omega=self.omega, coefficients=coefficients, peak=peak, multipliers=multipliers,
            stable=self.stable, folds=folds, doublings=[], period=1, closed=False, tail=tail, status=self.status,
            origin="harmonic balance in two turns", message=self.message, span=span,
            envelope=np.column_stack([self.largest, self.smallest]), beat=self.ratio / self.beats,
            waves=Waves(self.pairs, self.problem.orders, self.waves),
        )  # fmt: skip

    def states(self, number: int, angles: Floats) -> Floats:
        """States (states, m) of a motion, the pointing error and its rate first, at motor angles (m,) [rad]."""
        return motion.states_at(self.problem, self.points[[number]], angles)[0]


@one_thread
def two_turn_motion(system: System, omega: float, *, ratio: float | None = None, start: Any = None) -> TwoTurnCurve:
    """Find the motion at a speed of the motor [rad/s].

    Parameters
    ----------
    system : DriveTrain or Oscillator
        The drive, or the error equation of a gear with a `ratio`.
    omega : float
        Speed of the motor [rad/s].
    ratio : float, optional
        Ratio of an error equation.
    start : TwoTurnCurve, optional
        A motion at a speed near it, which chooses among several. Default: what Newton's method finds from rest.

    Raises
    ------
    ValueError
        If a part is none that the balance holds: the sentence says which.
    SolveError
        If no motion is found.
    """
    omega = number("omega [rad/s]", omega, positive=True)
    driven, flow = _driven(system, ratio)
    guess = None if start is None else (start.problem, start.points[0])
    _refuse_falling(system, driven, omega)
    problem, point = at_speed(driven, omega, MOTION_TAIL, guess)
    size = _sizes(problem, point[None])
    return _described(driven, flow, problem, point[None], size, (), (Status.OK, Status.OK.value))


@one_thread
def two_turn_response(
    system: System, speeds: tuple[float, float], *, ratio: float | None = None, limit: float | None = None
) -> TwoTurnCurve:  # fmt: skip
    """Follow the motions through a range of speeds of the motor [rad/s], from its upper end; as `two_turn_motion`.

    The curve has a point wherever the largest oscillation is at a `limit` [rad].
    """
    low, high = interval("speeds [rad/s]", speeds, positive=True)
    driven, flow = _driven(system, ratio)
    problem, trace, complete = _followed(system, driven, low, high)
    points, sizes = with_crests(problem, trace.points, partial(_sizes, problem))
    if limit is not None and limit < math.inf:
        points, sizes = with_crossings(problem, points, sizes, partial(_sizes, problem), limit)
    folds, how = tuple(trace.points[trace.labels == FOLD, -1].tolist()), ending(trace, "omega", trace.points[:, -1])
    lacking_waves = Status.TRUNCATED, f"{how[1]}; more than {len(problem.pairs)} waves of two turns are required"
    return _described(driven, flow, problem, points, sizes, folds, how if complete or not how[0] else lacking_waves)


def _followed(system: System, driven: TwoTurns, low: float, high: float) -> tuple[Torus, Trace, bool]:
    """The balance and the curve of a system through a range of speeds [rad/s]; whether it lacks no waves."""
    if not (driven.part.gear_damping or np.any(driven.part.damping)):
        raise SolveError(UNDAMPED)
    _refuse_falling(system, driven, high)
    return along(driven, low, high, _left_out(driven.part))


def beating_response(
    train: DriveTrain | None, speeds: tuple[float, float], limit: float | None = None
) -> DriveResponse:  # fmt: skip
    """The motions of a train in two turns through a range of speeds [rad/s], with a sweep and their torques.

    The oscillation of a motion is that of the turn of the motor in which it is largest; its coefficients are the part
    that repeats with every turn of the motor. Gravity is in it exactly, its stiffness too. Corners of a law of
    three slopes are rounded over a quarter of what parts them: under gravity the top of a SHG-25-80 moves by 0.5 %.
    Speeds at which the oscillation is at a `limit` [rad] are points of the curve.
    No train, as where damping or stiffness vary, is refused (ValueError).
    """
    if train is None:
        raise ValueError(VARIATION_TEXT)
    exact, train = train, with_rounded_corners(train)
    width = f" over {train.law.width / ARCSEC:.3g} arcsec" if hasattr(train.law, "width") else ""
    rounding = "" if train is exact else f"the corners of the torsion law are rounded{width}"
    motions = two_turn_response(train, speeds, limit=limit)
    motions = replace(motions, message=f"{motions.message}; other periodic motions are not searched")
    curve = motions.branch(speeds)
    angles, states = motion.along_turns(motions.problem, motions.points, motions.beats)
    system, sizes, starts = AtLoad(without_gravity(train), train.omega), [], []
    for omega, y in zip(motions.omega, states, strict=True):
        y, steady = own_state(system, tuple(y)), turning(system._replace(omega=float(omega)))
        starts.append([float(np.ravel(state)[0]) for state in y])
        sizes.append((y[0], *torques(steady, angles, y)))
    across, torque, motor = map(np.array, zip(*sizes, strict=True))
    return DriveResponse(
        curve, sweep_on(curve), largest_of_samples(across), largest_of_samples(torque), cubic_means(torque),
        not train.motor.free, False, **sizes_of(motor), rounding=rounding, starts=np.array(starts),
    )  # fmt: skip


class BeatCrest(NamedTuple):
    """Largest oscillation of a train in two turns: speed [rad/s], size [rad], and the balance with its point there."""

    speed: float
    size: float
    problem: Torus
    point: Floats

    def size_of(self, train: DriveTrain) -> float | None:
        """Oscillation [rad] at this speed of a train that differs in numbers alone; None where none is found."""
        problem = _driven(with_rounded_corners(train), None)[0].problem(self.problem.pairs[1:].tolist())
        point = newton(problem, self.point)
        return None if point is None else float(_sizes(problem, point[None])[0])


@one_thread
def largest_beat(train: DriveTrain, speeds: tuple[float, float], pairs: Any = ()) -> BeatCrest | None:
    """The largest oscillation of a train in two turns through a range of speeds [rad/s]; None where none is found.

    With the waves `pairs` (j, k) of a similar drive its curve is quicker.
    """
    train = with_rounded_corners(train)
    driven, _ = _driven(train, None)
    try:
        problem, trace, _ = _followed(train, replace(driven, likely=tuple(pairs)), *speeds)
    except SolveError:
        return None
    points, sizes = with_crests(problem, trace.points, partial(_sizes, problem))
    top = int(np.argmax(sizes))
    return BeatCrest(float(points[top, -1]), float(sizes[top]), problem, points[top])


def _left_out(part: Any) -> float:
    """Share of the motion in a wave that a curve leaves out."""
    return CURVE_TAIL if stated(part.laws[0], "rounded") is None else CORNERED_TAIL


def _sizes(problem: Torus, points: Floats) -> Floats:
    """Oscillation (n,) [rad] of motions in their largest turn."""
    return motion.largest_oscillations(motion.pointing(problem, points), problem.pairs, problem.ratio)


def _described(
    driven: TwoTurns, flow: Any, problem: Torus, points: Floats, sizes: Floats, folds: tuple[float, ...],
    how: tuple[Status, str],
) -> TwoTurnCurve:  # fmt: skip
    """The curve of points of a balance, with their sizes [rad]; `how` it ends and a sentence on that."""
    status, message = how
    return TwoTurnCurve(
        points[:, -1], pairs=problem.pairs, waves=motion.pointing(problem, points), largest=sizes, folds=folds,
        ratio=driven.ratio, beats=math.gcd(*(k for _, k in driven.pairs)) or 1, status=status, message=message,
        problem=problem, points=points, flow=flow,
    )  # fmt: skip


def _driven(system: System, ratio: float | None) -> tuple[TwoTurns, Any]:
    """Excitation of a system, and the part whose disturbances are meant."""
    train = as_train(checked(system), ratio)
    end, plain = train.load.end(), without_gravity(train)
    pulls = tuple(law for law in parts_of_angle(end.drag) if law.amplitude)
    part = linear_part(plain, at_load=True)
    laws = (train.law, *train.load.couplings())
    if part is None or not isinstance(train.reference, Steady):
        raise ValueError(f"{SCOPE}; this drive has friction, hysteresis or a nonlinear control: {REMEDY}")
    if part.loose >= 0 and not np.array_equal(part.zero_mean, part.motor):
        raise ValueError(f"{SCOPE}; this loop integrates the load deviation, not the motor deviation: {REMEDY}")
    if any(depends(law) != 1 or breakpoints_of(law) for law in laws):
        raise ValueError(f"{SCOPE}; this torsion law has corners: {REMEDY}, or round the corners")
    if not isinstance(train.error, NoError) and lacking(train.error, "lines"):
        raise ValueError(f"{SCOPE}; {type(train.error).__name__} lists no lines: give a KinematicError, or {REMEDY}")
    of_lines = _pairs(train)
    sizes = [a.amplitude * np.exp(-1j * a.phase) for a in lines_of(train.error) if a.amplitude]
    rows = [(*pair, size.real, size.imag) for pair, size in zip(of_lines, sizes, strict=True)]
    torques = (term for torque in (train.motor.excitation, end.excitation) for term in terms_of(torque))
    driving = [(int(k), 0) for term in torques for k in orders_of(term) if getattr(term, "amplitude", 1.0)]
    pairs = tuple(sorted({*of_lines, *driving, *((0, law.order) for law in pulls)}))
    if not pairs:
        raise ValueError("this drive has no periodic excitation; give an error order, a torque with orders or gravity")
    driven = TwoTurns(part, train.N, np.array(rows).reshape(-1, 4), pairs, pulls)
    return driven, linear_part(part.disturbed) if np.any(part.integral) else part


def _pairs(train: DriveTrain) -> list[tuple[int, int]]:
    """Repeats (j, k) per turn of motor and output of lines with an amplitude; a ValueError says which line has none."""
    pairs = []
    for i, line in enumerate(lines_of(train.error)):
        try:
            if line.amplitude:
                pairs.append(order_pair(line.order, train.N))
        except ValueError as error:
            raise ValueError(f"line {i} of the kinematic error: {error}") from None
    return pairs


def _refuse_falling(system: Any, driven: TwoTurns, omega: float) -> None:
    """Refuse a free motor whose energy of turning at a speed [rad/s] does not lift its load (SolveError)."""
    if not isinstance(system, DriveTrain) or not system.motor.free:
        return
    height = sum(2.0 * abs(law.amplitude / law.order) for law in driven.pulls)
    if height > STALL_RATIO * (energy := 0.5 * system.loop_inertia * omega**2):
        raise SolveError(Sentence(STALL_TEXT, f"{height:.3g}", f"{energy:.3g}", Speed(omega)))
