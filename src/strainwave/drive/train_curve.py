"""The response of a whole drive train through a speed range: pointing error of the load, and torque in the gear.

Gravity follows the load's angle, which turns N times slower than the motor: to the vibration it is a constant torque,
another one at every angle (quasi-static). Its own stiffness is left out: that of a gear is hundreds of times larger.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.blas import one_thread
from ..base.branch_labels import DECAYS, FOLD, TOP
from ..base.law import stated
from ..base.protocols import System, lacking, terms_of
from ..base.quantities import number, shown
from ..base.results import Floats
from ..base.sentences import listed
from ..base.series import largest_of_samples, largest_size, oscillation
from ..model.error_spectrum import extremes
from ..model.excitation import Harmonics, shortest
from ..model.gears.limits import cubic_means
from ..model.laws.dry import is_dry, rubbing, smooth
from ..model.laws.hysteresis import Parallel
from ..model.orders import order_pair
from ..model.oscillator import Oscillator
from ..model.train.controls import Held
from ..model.train.drive_train import DriveTrain, forces
from ..model.train.motion import AngleTorque
from ..model.train.shafts import NO_DRAG, Load, Motor
from ..model.train.train_forms import AtLoad, own_state, turning
from ..numerics.balance.fourier import from_blocks, synthesis
from ..numerics.continuation.trace import Trace, series_of, solve, with_crests, with_multipliers
from ..numerics.curves.over_a_turn import traced_turn
from .drive_response import DriveResponse
from .equation.gear_torque import gear_torque
from .equation.left_out import left_out
from .friction.stick_slip import slides, with_slips
from .operating_point import with_more
from .response import LEAST_HARMONIC, PER_HARMONIC, TurnResponse, sizes_of, sweep_on, turn_response

POINTS, PEAK_POINTS = 60, 24  # about so many, and more where the curve bends; and for a peak alone

NO_MOTION = (
    "the whole drive has no stable steady motion that repeats with every turn in this range; `strainwave analyze` "
    "computes its run-up, drive_run its motion in time, and system(reduced=True) gives the error equation alone"
)


@one_thread
def train_curve(
    train: DriveTrain, speeds: tuple[float, float], harmonics: int | None = None, *, coexisting: bool = True,
    points: int = POINTS, torques: bool = True,
) -> DriveResponse | None:  # fmt: skip
    """Follow the steady motions of a train; None where none is found.

    A free motor gets the mean torque that keeps its mean speed; it has no curve where friction or memory is in the
    train.

    Parameters
    ----------
    train : DriveTrain
        The train at constant speed (the `Steady` reference); its omega is replaced.
    speeds : (float, float)
        Range of the motor speed [rad/s].
    harmonics : int, optional
        Highest harmonic of the base angle. Default: grown until those left out are negligible.
    coexisting : bool
        Whether motions that do not join the curve are looked for at the ends of the range.
    points : int
        About so many points, and more where the curve bends.
    torques : bool
        False to leave out what the motions ask of gear and motor, where dry friction does not depend on it.
    """
    system = at_load(train)
    if train.motor.free and system.linear_part() is None:
        return None
    motions = turn_response(system, speeds, points, harmonics, coexisting)
    if not len(motions.curve):
        return None
    if torques or is_dry(train):
        response = of_train(system, motions, follows_its_angle(train), train if is_dry(train) else None)
    else:
        response = DriveResponse(motions.curve, sweep_on(motions.curve), has_reference=not train.motor.free)
    return None if response.sweep is None else response  # nothing stable to follow


def has_curve(train: DriveTrain) -> bool:
    """True if a train has a curve and needs one: the error equation serves a free motor with gear and rigid load."""
    return not train.motor.free or (bool(left_out(train)) and at_load(train).linear_part() is not None)


def unfollowed(train: DriveTrain | None, curve: DriveResponse | None) -> bool:
    """True if no motion of a whole train is stable: those of its error equation are not the drive's."""
    return curve is None and train is not None and has_curve(train)


def refuse_free(train: DriveTrain) -> None:
    """Refuse a free motor in a train that has neither a curve nor an error equation with all of it (ValueError)."""
    if (parts := left_out(train)) and not has_curve(train):
        raise ValueError(
            "with a free motor and friction or hysteresis in the drive, an analysis uses the error equation, which "
            f"neglects {listed(parts)}; give the motor a loop or hold it ('mode: held'), or use "
            "find_orbit(SteadyTrain(train, omega))"
        )


def at_load(train: DriveTrain) -> AtLoad:
    """The train without gravity, whose shafts slide forward, in coordinates of the load.

    Its dry friction is a constant torque beside those of the shafts.
    """
    plain, drags = without_gravity(train), (train.motor.drag, train.load.end().drag)
    if is_dry(train):
        motor, load = plain.motor, plain.load.end()
        given = [with_more(shaft.excitation, -rubbing(d)) for shaft, d in zip((motor, load), drags, strict=True)]
        plain = plain.with_motor(drag=smooth(motor.drag), excitation=given[0])
        plain = plain.with_load(drag=smooth(load.drag), excitation=given[1])
    return AtLoad(plain, train.omega)


class Crest(NamedTuple):
    """Largest oscillation of a curve: speed [rad/s], size [rad], and the balance problem with its point there.

    `tail` tells what the harmonics leave out; None where it was not looked at. It is not `stable` where no motion is.
    """

    speed: float
    size: float
    problem: Any
    point: Floats
    tail: Any = None
    stable: bool = True

    def size_of(self, train: DriveTrain) -> float | None:
        """Oscillation [rad] at this speed of a train that differs in numbers alone; None where none is found."""
        problem = self.problem.of(at_load(train)._replace(omega=self.problem.system.omega))
        point = solve(problem, self.point)
        return None if point is None else float(_oscillations(problem, point[None])[0])


def largest_crest(
    system: Any, speeds: tuple[float, float], harmonics: int | None, coexisting: bool = True, points: int = PEAK_POINTS
) -> Crest | None:
    """Largest oscillation |x - mean| of a train or an error equation in a range of speeds [rad/s].

    None where no motion is found. Without `harmonics` they are grown; without `coexisting`, motions that do not join
    the curve are not looked for.
    """
    if isinstance(system, DriveTrain):
        system = at_load(system)
    grown = harmonics is None
    problem, trace, tail, _ = traced_turn(system, speeds, points, harmonics, coexisting, truncation=grown)
    return crest_in(problem, trace, speeds)._replace(tail=tail) if len(trace.points) else None


def crest_in(problem: Any, trace: Trace, speeds: tuple[float, float]) -> Crest:
    """The largest oscillation of the stable motions on a curve that lie in a range; of all where none is stable."""
    points, labels, _ = with_crests(problem, trace.points, trace.labels)
    crest = _largest_of(problem, points, speeds)
    if abs(with_multipliers(problem, crest.point[None], labels[:1], False)[2][0, 0]) < DECAYS:
        return crest
    points, labels, floquet = with_multipliers(problem, np.ascontiguousarray(points), labels)
    stable = np.abs(floquet[:, 0]) < DECAYS
    stable |= ((labels == FOLD) | (labels > TOP)) & (np.convolve(stable, [1, 1, 1], "same") > 0)  # where stability ends
    stable &= (points[:, -1] >= speeds[0]) & (points[:, -1] <= speeds[1])
    return _largest_of(problem, points[stable], speeds) if stable.any() else crest._replace(stable=False)


def _largest_of(problem: Any, points: Floats, speeds: tuple[float, float]) -> Crest:
    points = points[(points[:, -1] >= speeds[0]) & (points[:, -1] <= speeds[1])]
    sizes = _oscillations(problem, points)
    top = int(np.argmax(sizes))
    return Crest(float(points[top, -1]), float(sizes[top]), problem, points[top])


def _oscillations(problem: Any, points: Floats) -> Floats:
    return np.asarray(oscillation(series_of(problem, points)))


def follows_its_angle(train: DriveTrain) -> bool:
    """True if the load is opposed by a torque of its own angle, which repeats once in N turns of the motor."""
    return bool(without_gravity(train) != train)


def without_gravity(train: DriveTrain) -> DriveTrain:
    """Return the train without the torques that follow the load's own angle."""
    return train.with_load(drag=_no_angle(train.load.end().drag))


def _no_angle(law: Any) -> Any:
    if isinstance(law, AngleTorque):
        return NO_DRAG
    return Parallel(*map(_no_angle, law)) if isinstance(law, Parallel) else law


def of_train(
    system: AtLoad, motions: TurnResponse, without_angle: bool = False, rough: DriveTrain | None = None
) -> DriveResponse:
    """The motions on a curve of a train, with a sweep on it and what they ask of gear and motor.

    Of a `rough` train the system has the dry friction as a constant torque.
    """
    problem, points, curve = motions
    flow, orbits, times = problem.disturbed(np.ascontiguousarray(points))
    omega, series, turn = orbits[:, -1], flow.series(orbits), 2.0 * np.pi * problem.turns / times
    state = np.array(own_state(system, tuple(np.moveaxis(series, 1, 0))))  # linear in the state, so of coefficients too
    h = series.shape[2] // 2
    samples = PER_HARMONIC * max(h, LEAST_HARMONIC)
    each: Any = omega[:, None]
    states = tuple(state @ synthesis(h, samples))
    train, angles = turning(system._replace(omega=each)), turn * np.arange(samples) / samples
    torque, motor = torques(train, angles, states)
    motor = motor + (0.0 if rough is None else rubbing(rough.motor.drag))
    peaks = largest_size(from_blocks(state[0].T).T)
    response = DriveResponse(
        curve, sweep_on(curve), peaks, largest_of_samples(torque), cubic_means(torque),
        not system.train.motor.free, without_angle, **sizes_of(motor),
    )  # fmt: skip
    if rough is None or train.motor.free or np.all(keep := slides(train, rough, angles, states)):
        return response
    response = with_slips(response, without_gravity(rough), keep)
    return replace(response, sweep=sweep_on(response.curve))


def torques(train: Any, angles: Floats, y: tuple[Any, ...]) -> tuple[Floats, Floats]:
    """Torques (..., samples) [N*m] in the gear and of the motor of a train over whole periods, from states y.

    A free motor gives the mean that keeps its mean speed beside what it is given.
    """
    torque, (acceleration, control, _) = forces(train, angles, y)[5:]
    given = train.motor.excitation.torque(angles) + control + 0.0 * torque
    if train.motor.free:
        given = given - np.mean(train.motor.J * acceleration + 0.0 * torque, axis=-1, keepdims=True)
    return np.asarray(torque), np.asarray(given)


def torque_in(system: Any, phase: Floats, y: tuple[Any, ...]) -> Floats:
    """Torque in the gear [N*m, output side] of a train at its load, or of an error equation, in states y."""
    if isinstance(system, AtLoad):
        return np.asarray(turning(system).torque(phase, own_state(system, y)))
    error = system.error
    u, du = y[0] - error.value(phase), y[1] - system.omega * error.slope(phase)
    return np.asarray(gear_torque(system, phase, u, du, y[2:]))


def parts_of_angle(law: Any) -> list[AngleTorque]:
    """Torques of a shaft's own angle among the parts of its drag."""
    if isinstance(law, Parallel):
        return [part for each in law for part in parts_of_angle(each)]
    return [law] if isinstance(law, AngleTorque) else []


def torques_of_angle(law: Any) -> tuple[float, float]:
    """Least and largest torque [N*m] on a load from drags that follow its own angle, gravity for one."""
    size, order, phase = np.array(parts_of_angle(law), float).reshape(-1, 3).T
    return extremes(order, -size * np.sin(phase), -size * np.cos(phase))


def with_rounded_corners(train: DriveTrain) -> DriveTrain:
    """The train with the corners of its law rounded, where the law can do that."""
    law = stated(train.law, "rounded")
    return train if law is None or law is train.law else train._replace(law=law)


def as_train(system: System, ratio: float | None) -> DriveTrain:
    """The system, or an error equation as the train that it is of: a motor that is held, and a rigid load."""
    if isinstance(system, DriveTrain):
        return system
    if not isinstance(system, Oscillator) or ratio is None:
        raise TypeError(f"{shown(system)} is neither a DriveTrain nor an Oscillator with a ratio; give one of these")
    ratio, terms = number("ratio", ratio, positive=True), terms_of(system.excitation)
    if lacking(terms[0], "amplitude"):
        raise TypeError(f"{shown(system.excitation)} has no orders; give a Harmonic or Harmonics")
    against = Harmonics(tuple(term._replace(amplitude=-term.amplitude, mean=-term.mean) for term in terms))
    load = Load(system.J, shortest(against))
    return DriveTrain(
        Motor(1.0, control=Held()), ratio, system.B, system.law, load, system.omega, system.error
    )  # fmt: skip


def in_turns(order: float, train: DriveTrain | None) -> str:
    """An order as that of the turns to which it belongs: 2, 2 - 2/101 or 1/101; of none as a number."""
    if train is None or not order % 1:
        return f"{order:.6g}"
    try:
        j, k = order_pair(order, train.N)
    except ValueError:
        return f"{order:.6g}"
    slow = f"{abs(k)}/{train.N:g}" if k else ""
    return f"{j} {'-' if k < 0 else '+'} {slow}" if j and k else slow or f"{j}"
