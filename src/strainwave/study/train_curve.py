"""The response of a whole drive train through a speed range: error between motor and load, and torque in the gear.

That error is x = theta_m/N - theta_l, of the load behind all couplings; the motor's own deviation from its reference is
not in it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model.drive_train import DriveTrain
from ..model.hysteresis import Parallel
from ..model.limits import cubic_mean
from ..model.motion import AngleTorque
from ..model.shafts import NO_DRAG, Elastic, Free, end_of
from ..model.train_forms import AtLoad, own_state, turning
from ..numerics.branches import Trace, leaf_of, tail_of
from ..numerics.description import describe
from ..numerics.floquet import displacement_peaks
from ..numerics.fourier import from_blocks, synthesis
from ..numerics.response import traced_points
from ..results import Floats
from .exact import ExactResponse
from .jumps import jumps
from .usage import Usage

POINTS, FEW = 60, 24  # about so many, and more where the curve bends; and for a peak alone
PER_ORDER, MOST = 4, 32  # harmonics to begin with per order of the excitation, and at most
ENOUGH = 2e-3  # size of the last two harmonics that a figure does not show
SAMPLES = 512  # of a turn, for its largest torque


@dataclass(frozen=True, eq=False)
class TrainCurve:
    """Steady motions of a drive train through a range of motor speeds.

    Attributes
    ----------
    response : ExactResponse
        The curve: its x is the error between motor and load, twists of couplings included.
    usage : Usage
        Largest torques in the gear over the motions that a slow run-up or coast-down visits.
    gear_peak : float
        Largest |x| across the gear alone [rad] in them.
    without_angle : bool
        Whether a torque that follows the load's own angle, gravity for one, is left out: it repeats once in N turns of
        the motor, so that no motion with it repeats with every turn.
    """

    response: ExactResponse
    usage: Usage
    gear_peak: float
    without_angle: bool


def train_curve(train: DriveTrain, speeds: tuple[float, float]) -> TrainCurve | None:
    """Follow the steady motions of a train whose motor is held or has a loop; None of another, or where none is found.

    Parameters
    ----------
    train : DriveTrain
        The train at constant speed (the `Steady` reference); its omega is replaced.
    speeds : (float, float)
        Range of the motor speed [rad/s].
    """
    if isinstance(train.motor.control, Free):
        return None
    system = AtLoad(without_gravity(train), train.omega)
    problem, found, tail, origin = _traced(system, speeds, POINTS)
    if not len(found.points):
        return None
    curve = describe(problem, "omega", found, tail, origin, locate=False)
    try:
        response = ExactResponse(curve, jumps(curve))
    except ValueError:  # nothing stable to follow
        return None
    series = series_of(problem, found.points)
    path = response.visited()
    own = np.array([np.any(np.all(row == curve.coefficients[path], axis=1)) for row in from_blocks(series[:, 0].T).T])
    strain = _strain(system, found.points[own, -1], series[own])
    return TrainCurve(response, *strain, follows_its_angle(train))


def largest_oscillation(
    train: DriveTrain, speeds: tuple[float, float], harmonics: int
) -> tuple[float, float] | None:  # fmt: skip
    """Speed [rad/s] and size [rad], largest |x - mean| of the load, of the largest oscillation in a short range."""
    problem, found, _, _ = _traced(AtLoad(without_gravity(train), train.omega), speeds, FEW, harmonics)
    if not len(found.points):
        return None
    series = series_of(problem, found.points)[:, 0]
    series[:, 0] = 0.0
    sizes = displacement_peaks(series)
    return float(found.points[np.argmax(sizes), -1]), float(np.max(sizes))


def follows_its_angle(train: DriveTrain) -> bool:
    """Whether the load is opposed by a torque of its own angle, which repeats once in N turns of the motor."""
    return _of_angle(end_of(train.load).drag)


def without_gravity(train: DriveTrain) -> DriveTrain:
    """Return the train without the torques that follow the load's own angle."""
    return train._replace(load=_without_gravity(train.load)) if follows_its_angle(train) else train


def _without_gravity(load: Any) -> Any:
    if isinstance(load, Elastic):
        return load._replace(load=_without_gravity(load.load))
    return load._replace(drag=_no_angle(load.drag))


def _no_angle(law: Any) -> Any:
    if isinstance(law, AngleTorque):
        return NO_DRAG
    return Parallel(*map(_no_angle, law)) if isinstance(law, Parallel) else law


def _of_angle(law: Any) -> bool:
    if isinstance(law, Parallel):
        return any(map(_of_angle, law))
    return isinstance(law, AngleTorque)


def _traced(
    system: AtLoad, speeds: tuple[float, float], points: int, given: int | None = None
) -> tuple[Any, Trace, float, str]:
    """Balance problem and points of a curve, with the harmonics that the x of the load takes, or those given."""
    leaf, top = leaf_of(system, "omega"), max((1, *system.orders()))
    middle = system._replace(omega=(speeds[0] * speeds[1]) ** 0.5)
    most = max(MOST, top + 2)
    harmonics = given or min(most, PER_ORDER * top)
    while True:
        problem, found, _, origin = traced_points(middle, leaf, *speeds, harmonics, 1, points)
        tail = float(np.max(tail_of(series_of(problem, found.points)[:, 0]), initial=0.0))
        if tail <= ENOUGH or harmonics >= most or given:
            return problem, found, tail, origin
        harmonics = min(most, 2 * harmonics)


def series_of(problem: Any, points: Floats) -> Floats:
    """Coefficients (points, states, 2H+1) in blocks."""
    return np.asarray(points[:, :-1].reshape(len(points), len(problem.sizes), -1) * problem.sizes[:, None])


def _strain(system: AtLoad, omega: Floats, series: Floats) -> tuple[Usage, float]:
    """What motions ask of the gear: its torques, and the largest |x| across it."""
    angles = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    y = np.moveaxis(series @ synthesis(series.shape[2] // 2, SAMPLES), 1, 0)
    own = own_state(system, tuple(y))
    each: Any = omega[:, None]
    torque = np.asarray(turning(system._replace(omega=each)).torque(angles, own))
    peaks, means = np.max(np.abs(torque), axis=1), np.array([cubic_mean(row) for row in torque])
    at, at_mean = int(np.argmax(peaks)), int(np.argmax(means))
    used = Usage(float(peaks[at]), float(omega[at]), float(means[at_mean]), float(omega[at_mean]))
    return used, float(np.max(np.abs(own[0])))
