"""The response through the speed range by harmonic balance: stability, folds, what a sweep does on it.

What the gear of an error equation transmits and loses, and how strongly it is damped: with any law, and varying.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.blas import one_thread
from ..base.branch_labels import DECAYS
from ..base.law import is_spring
from ..base.protocols import System, lacking
from ..base.quantities import positive_count
from ..base.results import Branch, Floats
from ..base.series import largest_of_samples
from ..model.gears.limits import cubic_means
from ..model.train.drive_train import DriveTrain
from ..numerics.balance.harmonics import LARGEST_HARMONICS
from ..numerics.continuation.trace import describe, with_crests
from ..numerics.curves.over_a_turn import traced_turn
from ..numerics.curves.separate_motions import with_all_said, with_others
from ..numerics.stability.first_order import with_special_points, with_stability
from .drive_response import DriveResponse
from .equation.gear_torque import gear_torque
from .jumps import Jumps, jumps

POINTS, MOST_POINTS = 100, 10_000  # about so many, and more where the curve bends
PER_HARMONIC, LEAST_HARMONIC = 32, 8  # samples of a period of the highest harmonic, or of this one
ROUNDING = 1e-12  # share of the largest harmonic that is none


@one_thread
def exact_response(
    system: System, speeds: tuple[float, float], points: int = POINTS, harmonics: int | None = None,
    coexisting: bool = True, has_reference: bool = True, train: DriveTrain | None = None,
) -> DriveResponse:  # fmt: skip
    """Follow the response of an error equation through a range of base-angle speeds [rad/s].

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation; its omega is replaced.
    speeds : (float, float)
        The range.
    points : int
        About so many, and more where the curve bends.
    harmonics : int, optional
        Harmonics. Default: grown until those left out do not show; `curve.tail` says how large these are.
    coexisting : bool
        Whether motions that do not join the curve are looked for at its ends.
    has_reference : bool
        Whether the motor is held, so that the error is the pointing error.
    train : DriveTrain, optional
        The same drive with its ratio, for the torque of the motor.
    """
    return of_equation(system, turn_response(system, speeds, points, harmonics, coexisting).curve, has_reference, train)


class TurnResponse(NamedTuple):
    """A response curve, and its balance problem and points."""

    problem: Any
    points: Floats
    curve: Branch


def turn_response(
    system: Any, speeds: tuple[float, float], points: int, harmonics: int | None, coexisting: bool
) -> TurnResponse:
    """Response of any system through a range of speeds [rad/s], whose curve may be empty; see `traced_turn`.

    The speeds where stability changes are located between points of the curve.
    """
    points = positive_count("points", points, MOST_POINTS)
    harmonics = None if harmonics is None else positive_count("harmonics", harmonics, LARGEST_HARMONICS)
    problem, traced, tail, origin = traced_turn(system, speeds, points, harmonics, coexisting)
    placed, labels, sizes = with_crests(problem, traced.points, traced.labels)
    hill, floquet = problem.hill(), None
    if not hill:
        placed, labels, floquet = with_stability(problem, placed, labels, False)
        if np.any(np.diff(np.abs(floquet[:, 0]) < DECAYS)):
            placed, labels, floquet = with_special_points(problem, placed, labels, floquet)
    traced = replace(traced, points=placed, labels=labels)
    curve = describe(problem, "omega", traced, tail, origin, locate=False, floquet=floquet, sizes=sizes)
    if hill:
        return TurnResponse(problem, placed, with_all_said(problem, curve, traced))
    spring = not lacking(system, "J", "law") and is_spring(system)  # one whose stiffness or damping varies
    complete = with_all_said(problem, curve, traced) if spring else with_others(problem, curve, traced.elsewhere, [])
    return TurnResponse(problem, placed, complete)


def sweep_on(curve: Branch) -> Jumps | None:
    """Slow run-up and run-down on a curve; None where nothing is stable."""
    try:
        return jumps(curve)
    except ValueError:
        return None


def of_equation(
    system: System, curve: Branch, has_reference: bool = True, train: DriveTrain | None = None
) -> DriveResponse:
    """The motions on a curve of an error equation, with a sweep on it and its torques; as of `exact_response`."""
    sweep = sweep_on(curve)
    if not len(curve):
        return DriveResponse(curve, sweep, has_reference=has_reference)
    angles, torque = torque_along(system, curve)
    response = DriveResponse(curve, sweep, curve.peak, largest_of_samples(torque), cubic_means(torque), has_reference)
    if train is None:
        return response
    return replace(response, **sizes_of(motor_torque(train, angles, torque)))


def torque_along(system: Any, curve: Branch) -> tuple[Floats, Floats]:
    """Base angles [rad] over an orbit of an error equation, and the torque through its gear [N*m] at all its points.

    That is with the damping, on the output side.
    """
    coefficients, omega, turns = curve.coefficients, curve.omega[:, None], curve.period
    k = np.arange(1, coefficients.shape[1] // 2 + 1)[:, None] / turns
    sizes = np.max(np.hypot(coefficients[:, 1::2], coefficients[:, 2::2]), axis=0)
    g = math.gcd(*(1 + np.flatnonzero(sizes > ROUNDING * np.max(sizes))).tolist()) or 1  # times that it repeats
    theta = turns * np.linspace(0.0, 2.0 * np.pi, g * PER_HARMONIC * max(LEAST_HARMONIC, len(k) // g), endpoint=False)
    waves = np.stack([np.cos(k * theta), np.sin(k * theta)], axis=1).reshape(-1, len(theta))
    slopes = np.stack([-k * np.sin(k * theta), k * np.cos(k * theta)], axis=1).reshape(-1, len(theta))
    if is_spring(system):
        u = coefficients[:, :1] + coefficients[:, 1:] @ waves - system.error.value(theta)
        rate = omega * (coefficients[:, 1:] @ slopes - system.error.slope(theta))
        return theta, np.asarray(gear_torque(system, theta, u, rate))
    # the curve holds no internal states; the torque is tau - J x''
    bends = np.repeat(k * k, 2, axis=0) * waves
    return theta, np.asarray(system.excitation.torque(theta) + system.J * omega * omega * (coefficients[:, 1:] @ bends))


def sizes_of(motor: Floats) -> dict[str, Any]:
    """Largest size, mean and root mean square of samples (n, samples) of the torque of a motor, by their fields."""
    rms = np.sqrt(np.mean(motor * motor, axis=1))
    return {"motor_torque": largest_of_samples(motor), "motor_mean": np.mean(motor, axis=1), "motor_rms": rms}


def motor_torque(train: DriveTrain, angles: Floats, torque: Floats) -> Floats:
    """Torque (n, samples) [N*m] of a motor that turns steadily, at base angles [rad], from that in the gear [N*m].

    It is (1/N - e') T without drag; of a free motor that which it is given.
    """
    if train.motor.free:
        return np.asarray(train.motor.excitation.torque(angles) + 0.0 * torque)
    return np.asarray((1.0 / train.N - train.error.slope(angles)) * torque)
