"""What a drive has beyond a spring and a constant damping: hysteresis, a varying stiffness, a whole drive train."""

from dataclasses import dataclass
from typing import Any

from ...law import depends
from ...model.varying import VaryingOscillator
from ...numerics.loading import SPEED
from ...quantities import parameters
from ...results import SolveError
from ...sentences import Sentence
from ..gear.hysteresis import SMALL_LOOP, HysteresisLoop, hysteresis_loop
from ..gear.parametric import ParametricResonance, parametric_resonances
from .train_study import TrainStudy

ABOVE = 30.0  # widths of a smoothed friction: at that speed it is 99.9 % of the dry one


@dataclass(frozen=True, eq=False)
class GearLoop:
    """The datasheet's measurements on the law: input locked, the torque slowly 0, +T, -T, +T.

    Attributes
    ----------
    full, small : HysteresisLoop
        Loops at full load and at 4 % of it; `full.loss` is the hysteresis loss, `small.span` the lost motion [rad].
    torque : float
        Full load [N*m].
    rated : bool
        Whether that is the gear's rated torque; else it is the largest torque of the steady motions.
    """

    full: HysteresisLoop
    small: HysteresisLoop
    torque: float
    rated: bool


@dataclass(frozen=True, eq=False)
class Beyond:
    """Results of the parts that most drives do not have.

    Attributes
    ----------
    loop : GearLoop or None
        For a law with friction or memory.
    parametric : tuple of ParametricResonance
        For a stiffness that varies, in the speed range.
    train : TrainStudy or None
        The whole drive train, where the error equation leaves something of it out.
    remarks : tuple of str
        Why one of them is missing.
    """

    loop: GearLoop | None
    parametric: tuple[ParametricResonance, ...]
    train: TrainStudy | None
    remarks: tuple[str, ...]


def study_beyond(
    system: Any,
    speeds: tuple[float, float],
    *,
    largest_torque: float,
    rated_torque: float | None = None,
    study: TrainStudy | None = None,
) -> Beyond:
    """Study those of the three that a drive has.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    largest_torque : float
        Largest torque in the gear [N*m] in a steady motion.
    rated_torque : float, optional
        Rated torque [N*m] of the gear.
    study : TrainStudy, optional
        That of the whole train.
    """
    remarks: list[str] = []
    loop = None
    if depends(system.law) > 1:
        torque = largest_torque if rated_torque is None else rated_torque
        try:
            loop = gear_loop(system.law, torque, rated_torque is not None)
        except (ValueError, SolveError) as error:
            remarks.append(Sentence("There is no hysteresis loop to measure: {}.", error))
    found: tuple[ParametricResonance, ...] = ()
    if isinstance(system, VaryingOscillator):
        try:
            found = tuple(parametric_resonances(system, speeds))
        except ValueError as error:
            remarks.append(Sentence("Parametric resonances are not searched for: {}.", error))
    return Beyond(loop, found, study, tuple(remarks))


def gear_loop(law: Any, torque: float, rated: bool) -> GearLoop:
    """Measure a law at full load [N*m] and at 4 % of it, at a speed well above the widths of smoothed friction.

    Raises
    ------
    ValueError
        If the law does not carry the torque.
    """
    widths = [p.value for p in parameters(law) if p.path.endswith("width") and p.unit == "rad/s"]
    speed = max([SPEED, *(ABOVE * width for width in widths)])
    full, small = (hysteresis_loop(law, share * torque, speed=speed) for share in (1.0, SMALL_LOOP))
    return GearLoop(full, small, torque, rated)
