"""What the error equations leave out: both reductions of a drive against the whole drive train, over the speed."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.protocols import orders_of
from ..base.quantities import numbers, shown
from ..base.results import Floats, Orbit, SolveError
from ..base.sentences import Sentence, Speed, on_screen
from ..model.drive import Drive
from ..model.excitation import KinematicError
from ..model.laws.friction import NO_FRICTION
from ..model.oscillator import Oscillator
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import AngleTorque
from ..model.train.shafts import NO_DRAG
from ..model.train.train_forms import SteadyTrain
from ..numerics.shooting import find_orbit

SAMPLES = 512  # of a cycle, for its largest values
APART = 0.5  # relative difference beyond which the two are taken for motions on different branches


@dataclass(frozen=True, eq=False)
class Reductions:
    """Largest |dynamic error| of a drive with kinematic error, by the whole train and by the error equations.

    Attributes
    ----------
    omega : (n,) array
        Mean motor speeds [rad/s].
    exact : (n,) array
        Of the whole train with the motor free, at that mean speed [rad]; nan where no periodic motion was found.
    free, held : (n,) arrays
        Of the error equation with the motor free (which drops terms of order N e' and the speed ripple), and with the
        motor held [rad].
    error_slope : float
        Largest N |e'|, how far the ratio of the gear varies, relative to 1/N.
    ripple : (n,) array
        Largest |theta_m' - omega|/omega of the whole train.
    """

    omega: Floats
    exact: Floats
    free: Floats
    held: Floats
    error_slope: float
    ripple: Floats

    @property
    def difference(self) -> Floats:
        """Error (n,) of the free error equation, relative to the whole train."""
        moves = self.exact != 0.0
        return np.divide(self.free - self.exact, self.exact, out=np.zeros_like(self.exact), where=moves)

    def sentence(self) -> str:
        """One sentence for a report: how large the difference is, where, and what it comes from."""
        same = np.flatnonzero(np.abs(self.difference) < APART)
        if len(same) == 0:
            return "No periodic motion of the whole drive train was found to compare the error equation with."
        worst = same[int(np.argmax(np.abs(self.difference[same])))]
        apart = self.omega[np.abs(self.difference) >= APART]
        said = "; at {} one of them has jumped and the other not yet"
        jumped = Sentence(said, Speed(*apart, digits=5, between=", ")) if len(apart) else ""
        return Sentence(
            "With the motor free the error equation leaves out the motor's answer to the changing ratio, N e' up to "
            f"{self.error_slope:.2g}, and the speed ripple, up to {np.max(self.ripple[same]):.2g} of the speed: "
            "the largest |x| differs from that of the whole drive train by up to "
            f"{100.0 * abs(self.difference[worst]):.2g} % ({{}}){{}}.",
            Speed(self.omega[worst], digits=5), jumped,
        )  # fmt: skip

    def __str__(self) -> str:
        rows = (
            f"{w:>10.5g} {e:>12.6g} {f:>12.6g} {d:>+9.2%} {r:>9.2%} {h:>12.6g}"
            for w, e, f, d, r, h in zip(
                self.omega, self.exact, self.free, self.difference, self.ripple, self.held, strict=True
            )
        )
        head = f"{'rad/s':>10} {'whole train':>12} {'free':>12} {'diff.':>9} {'ripple':>9} {'held':>12}"
        return on_screen("\n".join([f"Largest |x| [rad]; N e' up to {self.error_slope:.3g}", head, *rows]))


def compare_reductions(
    drive: Drive,
    kinematic_error: KinematicError,
    omega: ArrayLike,
    *,
    motor_torque: Any = None,
    load_torque: Any = None,
    harmonics: int | None = None,
) -> Reductions:
    """Compare the error equations of a drive with its whole train, at constant mean speeds.

    Parameters
    ----------
    drive : Drive
        The drive.
    kinematic_error : KinematicError
        Its kinematic error; the lines follow the motor's angle.
    omega : (n,) array_like
        Mean motor speeds [rad/s], each followed from the one before: a sweep up where they ascend. The whole train is
        sought next to the orbit of the free error equation.
    motor_torque, load_torque : Harmonic or Harmonics, optional
        As in `Drive.error_equation`, on orders of the motor's angle. A mean motor torque does not matter: the one that
        keeps the mean speed is found.
    harmonics : int, optional
        Highest harmonic of the whole train. Default: grown as in `find_orbit`, which takes long for a law with kinks.

    Returns
    -------
    Reductions
        The largest |x| [rad] of each at `omega` [rad/s], the `difference` and what it comes from.

    Raises
    ------
    ValueError, TypeError
        As `Drive.error_equation` and `find_orbit`.
    SolveError
        If no periodic motion of the whole train is found at any of the speeds.
    """
    if not isinstance(drive, Drive):
        raise TypeError(f"drive is {shown(drive)}; it must be a Drive(J_m, J_l, N, B, law)")
    torques = {"motor_torque": motor_torque, "load_torque": load_torque}
    train = drive.train(kinematic_error=kinematic_error, **torques)
    free = drive.error_equation(kinematic_error=kinematic_error, **torques)
    held = drive.error_equation(kinematic_error=kinematic_error, load_torque=load_torque, motor="held")
    table = compare_with_train(train, free, held, omega, harmonics)
    if np.all(np.isnan(table.exact)):
        raise SolveError(
            f"no periodic motion of the whole drive train was found at {len(table.omega)} speeds from "
            f"{table.omega[0]:.4g} rad/s on; give some nearer to its natural frequency, {drive.omega_0:.4g} rad/s"
        )
    return table


def compare_with_train(
    train: DriveTrain, free: Oscillator, held: Oscillator | None, omega: ArrayLike, harmonics: int | None = None
) -> Reductions:
    """Compare error equations with the train they come from, as `compare_reductions`; nan for a `held` that is None."""
    speeds = numbers("omega", omega)
    whole = SteadyTrain(train, 1.0)
    table = np.full((len(speeds), 4), np.nan)
    before: list[Orbit | None] = [None, None]
    phase = _angles(train)
    for i, speed in enumerate(speeds):
        for j, equation in enumerate((free, held)):
            if equation is not None:
                orbit = before[j] = _followed(equation._replace(omega=float(speed)), before[j])
                table[i, 1 + j] = np.nan if orbit is None else orbit.peak
        if before[0] is not None:
            exact = find_orbit(
                whole._replace(omega=float(speed)), guess=_extended(train, free, before[0]), harmonics=harmonics
            )
            if exact.status.found:
                table[i, 0], table[i, 3] = exact.peak, np.max(np.abs(exact.state(phase)[2])) / speed
    return Reductions(speeds, table[:, 0], table[:, 1], table[:, 2], error_slope(train), table[:, 3])


def error_slope(train: DriveTrain) -> float:
    """Largest N |e'| of a train, how far the ratio of its gear varies, relative to 1/N."""
    return float(train.N * np.max(np.abs(train.error.slope(_angles(train)))))


def _angles(train: DriveTrain) -> Floats:
    """Angles (n,) of a turn of the motor, `SAMPLES` of each cycle of the highest order."""
    count = SAMPLES * math.ceil(max((1, *orders_of(train), *orders_of(train.error))))
    return 2.0 * np.pi * np.arange(count) / count


THE_LOOP = "the motor's loop"


def left_out(train: DriveTrain) -> tuple[str, ...]:
    """Parts of a train that its error equation does not hold and that change the dynamic error, in words.

    That equation has a motor ideally held or free, the gear, and a rigid load. The drag of a motor that is ideally held
    changes nothing: the motor keeps its speed whatever opposes it. What a free motor does with the kinematic error is
    the approximation that `compare_reductions` measures, no part that is missing.
    """
    motor, load = train.motor, train.load.end()
    held, couplings = motor.held, len(train.load.couplings())
    parts = (
        (not held and not motor.free, THE_LOOP),
        (not held and motor.drag != NO_DRAG, "the motor's drag"),
        (not held and train.friction != NO_FRICTION, "the friction of the meshing"),
        (load.drag != NO_DRAG, "the gravity of the load" if isinstance(load.drag, AngleTorque) else "the load's drag"),
        (couplings > 0, "the coupling" if couplings == 1 else f"the {couplings} couplings"),
    )
    return tuple(words for there, words in parts if there)


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
