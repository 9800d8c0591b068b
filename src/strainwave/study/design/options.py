"""A gear with one rotor under every load and torque of a specification: what averaging says, and its worst case."""

import math
from collections import Counter
from typing import NamedTuple

from ...model.error_spectrum import accuracy_spectrum
from ...model.excitation import KinematicError
from ...model.gears.gear import HEAVY, Gear
from .specification import Check, Specification

LOADS = 2  # of one torque, by harmonic balance


class Case(NamedTuple):
    """What averaging says of a drive under one load [kg*m^2] and one torque on it [N*m]."""

    load: float
    torque: float
    size: float
    low: float
    high: float
    speed: float


class Option(NamedTuple):
    """A gear with one rotor: what is known of it under its worst load, and by averaging under each."""

    gear: Gear
    rules: Check
    rotor: float
    load: float
    torque: float
    size: float
    low: float
    high: float
    speed: float
    error: float
    cases: tuple[Case, ...]
    balanced: bool = False

    @property
    def J_m(self) -> float:
        """Inertia of the motor with the wave generator [kg*m^2]."""
        return self.rotor + (self.gear.input_inertia or 0.0)


def option_of(gear: Gear, rules: Check, rotor: float, cases: list[Case]) -> Option:
    """A gear with a rotor, from what averaging says of it."""
    load, torque, size, _, _, speed = max(cases, key=lambda case: case.size)
    low, high = max(case.low for case in cases), max(case.high for case in cases)
    return Option(gear, rules, rotor, load, torque, size, low, high, speed, 0.0, tuple(cases))


def looked_at(option: Option) -> list[Case]:
    """Cases of an option that harmonic balance looks at, the largest first: under each torque the worst loads."""
    ranked, seen = sorted(option.cases, key=lambda case: -case.size), Counter[float]()
    return [case for case in ranked if (seen.update([case.torque]) or seen[case.torque] <= LOADS)]


def bounded(option: Option, error: float) -> Option:
    """An option with what its certificate adds to the bounds of averaging."""
    low, high = option.low / (1.0 + error), option.high * (1.0 + error)
    cases = tuple(case._replace(high=case.high * (1.0 + error)) for case in option.cases)
    far = max(high / option.size - 1.0, 1.0 - low / option.size)
    return option._replace(low=low, high=high, error=far, cases=cases)


def error_of(gear: Gear, spec: Specification) -> KinematicError:
    """Kinematic error of a gear under a specification."""
    if spec.kinematic_error is not None:
        return spec.kinematic_error
    return accuracy_spectrum(spec.accuracy_of(gear) or 0.0)


def rotor_doubts(option: Option) -> tuple[str, ...]:
    """That a rotor is far heavier than the wave generator of its gear."""
    times = option.rotor / (option.gear.input_inertia or math.inf)
    if times <= HEAVY:
        return ()
    said = f"A rotor of {option.rotor:.3g} kg*m^2 is {times:.3g} times the wave generator of {option.gear.name}"
    return (f"{said}; check its unit.",)
