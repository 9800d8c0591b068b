"""Error of the reduced models: the equation of a free motor against the whole drive train, over the speed."""

import math
from dataclasses import dataclass

import numpy as np

from ...base.protocols import orders_of
from ...base.results import Floats, Orbit
from ...base.sentences import Sentence, Speed
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...model.train.train_forms import SteadyTrain
from ...numerics.balanced_orbit import find_orbit

SAMPLES = 512  # of a cycle, for its largest values
BRANCH_DIFFERENCE = 0.5  # relative difference beyond which the two are taken for motions on different branches


@dataclass(frozen=True, eq=False)
class Reductions:
    """Largest |dynamic error| of a drive with kinematic error, by the whole train and by the error equation.

    Attributes
    ----------
    omega : (n,) array
        Mean motor speeds [rad/s].
    exact : (n,) array
        Of the whole train with the motor free, at that mean speed [rad]; nan where no periodic motion was found.
    free : (n,) array
        Of the error equation [rad], which drops terms of order N e' and the speed ripple.
    error_slope : float
        Largest N |e'|, how far the ratio of the gear varies, relative to 1/N.
    ripple : (n,) array
        Largest |theta_m' - omega|/omega of the whole train.
    """

    omega: Floats
    exact: Floats
    free: Floats
    error_slope: float
    ripple: Floats

    @property
    def difference(self) -> Floats:
        """Error (n,) of the free error equation, relative to the whole train."""
        moves = self.exact != 0.0
        return np.divide(self.free - self.exact, self.exact, out=np.zeros_like(self.exact), where=moves)

    def sentence(self) -> str:
        """One sentence for a report: how large the difference is, where, and what it comes from."""
        same = np.flatnonzero(np.abs(self.difference) < BRANCH_DIFFERENCE)
        if len(same) == 0:
            return "No periodic motion of the whole drive train was found to compare the error equation with."
        worst = same[int(np.argmax(np.abs(self.difference[same])))]
        apart = self.omega[np.abs(self.difference) >= BRANCH_DIFFERENCE]
        text = "; at {} only one of the two has jumped"
        jumped = Sentence(text, Speed(*apart, digits=5, between=", ")) if len(apart) else ""
        return Sentence(
            "With a free motor the error equation neglects the motor's reaction to the varying ratio, N e' up to "
            f"{self.error_slope:.2g}, and the speed ripple, up to {np.max(self.ripple[same]):.2g} of the speed: "
            "the largest |x| differs from the whole drive train by up to "
            f"{100.0 * abs(self.difference[worst]):.2g} % ({{}}){{}}.",
            Speed(self.omega[worst], digits=5), jumped,
        )  # fmt: skip


def compare_with_train(train: DriveTrain, free: Oscillator, omega: Floats, harmonics: int) -> Reductions:
    """Compare the error equation of a drive with a free motor with its whole train.

    Parameters
    ----------
    train : DriveTrain
        The whole train, whose motor is free.
    free : Oscillator
        Its error equation.
    omega : (n,) array
        Mean motor speeds [rad/s], each followed from the one before. The whole train is sought next to the orbit of
        the error equation.
    harmonics : int
        Highest harmonic of the whole train.
    """
    motions, phase = SteadyTrain(train, 1.0), _angles(train)
    table = np.full((len(omega), 3), np.nan)
    before: Orbit | None = None
    for row, speed in zip(table, omega.tolist(), strict=True):
        before = _followed(free._replace(omega=speed), before)
        if before is None:
            continue
        row[1] = before.peak
        exact = find_orbit(motions._replace(omega=speed), guess=_extended(train, free, before), harmonics=harmonics)
        if exact.status.found:
            row[0], row[2] = exact.peak, np.max(np.abs(exact.state(phase)[2])) / speed
    return Reductions(omega, table[:, 0], table[:, 1], error_slope(train), table[:, 2])


def error_slope(train: DriveTrain) -> float:
    """Largest N |e'| of a train, how far the ratio of its gear varies, relative to 1/N."""
    return float(train.N * np.max(np.abs(train.error.slope(_angles(train)))))


def _angles(train: DriveTrain) -> Floats:
    """Angles (n,) of a turn of the motor, `SAMPLES` of each cycle of the highest order."""
    count = SAMPLES * math.ceil(max((1, *orders_of(train), *orders_of(train.error))))
    return 2.0 * np.pi * np.arange(count) / count


def _followed(system: Oscillator, before: Orbit | None) -> Orbit | None:
    orbit = find_orbit(system, guess=before) if before is not None else find_orbit(system)
    if not orbit.status.found and before is not None:
        orbit = find_orbit(system)
    return orbit if orbit.status.found else None


def _extended(train: DriveTrain, free: Oscillator, orbit: Orbit) -> Floats:
    """Guess (2H+1, states) of the whole train near an orbit of the error equation: w = J x'/(N J_m) without torques."""
    table = np.zeros((len(orbit.coefficients), len(train.state_names())))
    table[:, :2] = orbit.coefficients[:, :2]
    table[1:, 2] = free.J / (train.N * train.motor.J) * orbit.coefficients[1:, 1]
    return table
