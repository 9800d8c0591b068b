"""What a drive has beyond a spring of constant stiffness: the hysteresis loop of its gear, parametric resonances."""

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


def loop_of(law: Any, largest: float, rated: float | None) -> tuple[GearLoop | None, list[str]]:
    """Loop of a law with friction or memory, or why it has none.

    It is at the rated torque [N*m], or without one at the largest of the steady motions.
    """
    if depends(law) < 2:
        return None, []
    try:
        return gear_loop(law, largest if rated is None else rated, rated is not None), []
    except (ValueError, SolveError) as error:
        return None, [Sentence("There is no hysteresis loop to measure: {}.", error)]


def parametric_of(system: Any, speeds: tuple[float, float]) -> tuple[tuple[ParametricResonance, ...], list[str]]:
    """Parametric resonances of a stiffness that varies, in a range of speeds [rad/s], or why none are searched for."""
    if not isinstance(system, VaryingOscillator):
        return (), []
    try:
        return tuple(parametric_resonances(system, speeds)), []
    except ValueError as error:
        return (), [Sentence("Parametric resonances are not searched for: {}.", error)]


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
