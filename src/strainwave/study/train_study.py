"""The whole drive train beside its error equation: Bode plot, steady motions, and a run-up with its energies."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .._dispatch import parts_of
from ..model.drive_train import DriveTrain
from ..model.excitation import Harmonic
from ..model.gear import Gear
from ..model.motion import AngleTorque, SpeedProfile
from ..model.shafts import Elastic, Free, Held
from ..numerics.integrate import Dopri5
from ..numerics.orbits import find_orbit
from ..results import Floats
from .bode import Bode, bode
from .drive_runs import DriveRun, drive_run
from .gear_forces import damping_of
from .reductions import Reductions, compare_with_train

FREQUENCIES, SPEEDS, MOST_HARMONICS = 240, 3, 31
SLOW, BEFORE = 40.0, 8.0  # length of the run-up and of the time before it, in units of 1/mu
MOST_TURNS, SAMPLES = 1000.0, 40  # of the motor in a run-up, and samples per cycle of the highest order
METHOD = Dopri5(rtol=1e-8, atol=1e-12)


@dataclass(frozen=True, eq=False)
class TrainStudy:
    """What the whole train does, and what the error equation makes of it.

    Attributes
    ----------
    train : DriveTrain
        The train at constant speed.
    bode : Bode
        Speeds of motor and load over a torque, linear, about standstill.
    omega, whole, reduced : (n,) arrays
        Motor speeds [rad/s]; largest |x| [rad] across the gear of the train and of the error equation; nan where no
        periodic motion was found. Empty where the train has none.
    run : DriveRun or None
        Run-up from the lowest to the highest speed; None where the motor is free.
    begin : float
        Time [s] at which the ramp begins; before it the motion settles.
    left_out : Reductions or None
        The comparison of a free motor.
    remarks : tuple of str
        Why a part is missing.
    """

    train: DriveTrain
    bode: Bode
    omega: Floats
    whole: Floats
    reduced: Floats
    run: DriveRun | None
    begin: float
    left_out: Reductions | None
    remarks: tuple[str, ...]


def train_study(
    train: DriveTrain, system: Any, speeds: tuple[float, float], worst: float, gear: Gear | None = None
) -> TrainStudy:
    """Study a drive train over a range of motor speeds [rad/s]; `worst` is the one of the largest error.

    Parameters
    ----------
    train : DriveTrain
        The train at constant speed (the `Steady` reference).
    system : Oscillator
        Its error equation.
    """
    remarks: list[str] = []
    low, high = speeds
    top = max(1, *system.orders()) if system.orders() else 1
    grid = np.geomspace(0.2 * low, 1.5 * top * high, FREQUENCIES)
    plot = bode(train, grid, source="load" if isinstance(train.motor.control, Held) else "motor")
    at = np.unique(np.append(np.linspace(low, high, SPEEDS), np.clip(worst, low, high)))
    left_out, whole, reduced = None, np.empty(0), np.empty(0)
    run, begin = None, 0.0
    if not isinstance(train.motor.control, Free):
        run, begin = _run_up(train, system, speeds, top, gear)
    harmonics = min(MOST_HARMONICS, 4 * top)
    if isinstance(train.motor.control, Free):
        here = np.array([w for w in (0.5 * worst, worst) if low <= w <= high])
        left_out = compare_with_train(train, system, None, here, harmonics)
        at, whole, reduced = here, left_out.exact, left_out.free
    elif _gravity(train.load):
        remarks.append(
            "What depends on the load's own angle repeats once in N turns of the motor, so that the train has no "
            "motion that repeats with every turn to compare with; the run-up has it."
        )
        at = np.empty(0)
    else:
        if run is not None and run.trajectory.status:  # where the run-up is loudest
            loudest = int(np.argmax(np.abs(run.error) * (run.trajectory.t >= begin)))
            at = np.unique(np.append(at, np.clip(run.motor_speed[loudest], low, high)))
        whole = np.array([_peak(train._replace(omega=float(w)), harmonics) for w in at])
        reduced = np.array([_peak(system._replace(omega=float(w)), harmonics) for w in at])
        if np.any(np.isnan(whole)):
            remarks.append("At speeds without a value no motion of the train that repeats with every turn was found.")
    if run is None:
        remarks.append("A free motor follows its torque, not a speed: there is no run-up to prescribe; give it a loop.")
    else:
        if any(h.amplitude for torque in _torques(train) for h in getattr(torque, "terms", (torque,))):
            remarks.append("The run-up has the mean torques; lines of a torque, which follow an angle, are left out.")
    return TrainStudy(train, plot, at, whole, reduced, run, begin, left_out, tuple(remarks))


def _peak(system: Any, harmonics: int) -> float:
    orbit = find_orbit(system, harmonics=harmonics)
    return orbit.peak if orbit.status else float("nan")


def _gravity(load: Any) -> bool:
    """Whether the load, behind its couplings, is opposed by a torque that follows its own angle."""
    while isinstance(load, Elastic):
        load = load.load
    return _follows_angle(load.drag)


def _follows_angle(law: Any) -> bool:
    return isinstance(law, AngleTorque) or any(_follows_angle(part) for part in parts_of(law))


def _torques(train: DriveTrain) -> tuple[Any, Any]:
    load = train.load
    while isinstance(load, Elastic):
        load = load.load
    return train.motor.excitation, load.excitation


def _mean(torque: Any) -> Harmonic:
    return Harmonic(0.0, mean=sum(h.mean for h in getattr(torque, "terms", (torque,))))


def _with_means(load: Any) -> Any:
    if isinstance(load, Elastic):
        return load._replace(load=_with_means(load.load))
    return load._replace(excitation=_mean(load.excitation))


def _run_up(
    train: DriveTrain, system: Any, speeds: tuple[float, float], top: int, gear: Gear | None
) -> tuple[DriveRun, float]:
    """Run-up that takes 40/mu, after 8/mu at the lowest speed; shorter where that were more than 1000 turns."""
    low, high = speeds
    mean = 0.5 * (low + high)
    mu = max(damping_of(system) / system.J, 0.02 * mean)
    length = min(SLOW / mu, MOST_TURNS * 2.0 * np.pi / mean)
    begin = min(BEFORE / mu, 0.2 * length)
    profile = SpeedProfile((0.0, begin, begin + length), (low, low, high))
    motor = train.motor._replace(excitation=_mean(train.motor.excitation))
    timed = train._replace(motor=motor, load=_with_means(train.load), omega=1.0, reference=profile)
    cycles = top * mean * (begin + length) / (2.0 * np.pi)
    times = np.linspace(0.0, begin + length, int(SAMPLES * cycles) + 2)
    start = np.zeros(len(timed.state_names()))
    return drive_run(timed, start, times, gear=gear, method=METHOD), begin
