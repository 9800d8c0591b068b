"""A gear with one rotor under every load and torque of a specification: results of averaging, and the worst case."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...base.units import ARCSEC, RPM
from ...drive.project import Project
from ...drive.speeds import Speeds
from ...model.error_spectrum import accuracy_spectrum
from ...model.excitation import KinematicError
from ...model.gears.gear import HEAVY, Gear
from ...model.train.drive_train import DriveTrain
from ..speed_map.decide import decide
from ..speed_map.rules import Rules
from .specification import SURE, Check, Specification

BALANCED_LOADS = 2  # loads of one torque that are computed by harmonic balance
RANGE_TORQUES = 9  # torques of a range, as an analysis spreads them


class Case(NamedTuple):
    """Result of averaging for a drive under one load [kg*m^2] and one torque on it [N*m].

    `size` is its largest oscillation [rad], at a `speed` [rad/s] of the motor, `low` and `high` [rad] its bounds.
    """

    load: float
    torque: float
    size: float
    low: float
    high: float
    speed: float


class Option(NamedTuple):
    """A gear with a rotor [kg*m^2]: its worst case, with the bounds of all, and the case of averaging under each load.

    `rules` is the constraint that uses most of its allowance, `error` the relative error of the worst case, `balanced`
    true where that is by harmonic balance.
    """

    gear: Gear
    rules: Check
    rotor: float
    worst: Case
    error: float
    cases: tuple[Case, ...]
    balanced: bool = False

    @property
    def J_m(self) -> float:
        """Inertia of the motor with the wave generator [kg*m^2]."""
        return self.rotor + (self.gear.input_inertia or 0.0)


def option_of(gear: Gear, rules: Check, rotor: float, cases: list[Case]) -> Option:
    """A gear with a rotor, from its results of averaging."""
    low, high = max(case.low for case in cases), max(case.high for case in cases)
    worst = max(cases, key=lambda case: case.size)._replace(low=low, high=high)
    return Option(gear, rules, rotor, worst, 0.0, tuple(cases))


def cases_to_balance(option: Option) -> list[Case]:
    """Cases of an option for harmonic balance, the largest first: under each torque the worst loads."""
    ranked = sorted(option.cases, key=lambda case: -case.size)
    same_torque = ([other for other in ranked[:i] if other.torque == case.torque] for i, case in enumerate(ranked))
    return [case for case, larger in zip(ranked, same_torque, strict=True) if len(larger) < BALANCED_LOADS]


def with_error(option: Option, error: float) -> Option:
    """An option whose bounds hold the relative error of averaging as well."""
    worst = option.worst._replace(low=option.worst.low / (1.0 + error), high=option.worst.high * (1.0 + error))
    cases = tuple(case._replace(high=case.high * (1.0 + error)) for case in option.cases)
    far = max(worst.high / worst.size - 1.0, 1.0 - worst.low / worst.size)
    return option._replace(worst=worst, error=far, cases=cases)


def error_of(gear: Gear, spec: Specification) -> KinematicError:
    """Kinematic error of a gear under a specification."""
    if spec.kinematic_error is not None:
        return spec.kinematic_error
    return accuracy_spectrum(spec.accuracy_of(gear) or 0.0)


def forbidden(train: DriveTrain, gear: Gear, spec: Specification) -> tuple[float, str, str]:
    """Largest oscillation [rad] where speeds are forbidden, and two sentences on why, by all motions as of a speed map.

    The first is about torques of the duty, the second about torques between these; empty where nothing is forbidden.

    Raises
    ------
    SolveError
        If the law cannot carry a torque.
    """
    ratio, limit = gear.ratio, spec.limit * SURE
    drive = Project(gear.name, Path(), "", train, gear, Speeds((ratio * spec.speeds[0], ratio * spec.speeds[1])))
    torques = np.union1d(spec.torques, np.linspace(spec.torques[0], spec.torques[-1], RANGE_TORQUES))
    decided = decide(drive, Rules(limit), loads=torques)
    of_duty, between = [(0.0, "")], [(0.0, "")]
    for torque, motions, bands in zip(torques.tolist(), decided.by_load, decided.moving, strict=True):
        if not len(bands.forbidden):
            continue
        speed, size = motions.largest
        what = f"the error oscillates by {size / ARCSEC:.4g} arcsec"
        if size <= limit:
            what, speed = "the motion jumps" if motions.jumping else "no motion is stable", float(bands.forbidden[0, 0])
        sentence = f"at {torque:.4g} N*m {what} at {speed / RPM:.4g} rpm of the motor"
        (of_duty if torque in spec.torques else between).append((size, sentence))
    (size, reason), (size_between, reason_between) = max(of_duty), max(between)
    return max(size, size_between), reason, reason_between


def rotor_doubts(option: Option) -> tuple[str, ...]:
    """Sentence on a rotor that is far heavier than the wave generator of its gear."""
    times = option.rotor / (option.gear.input_inertia or math.inf)
    fact = f"A rotor of {option.rotor:.3g} kg*m^2 is {times:.3g} times that of the wave generator of {option.gear.name}"
    return (f"{fact}; check its unit.",) if times > HEAVY else ()
