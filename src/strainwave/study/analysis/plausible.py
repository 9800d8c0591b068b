"""Results that no gear gives: a hysteresis larger than catalogues print, a torque at which the teeth skip."""

import math
from collections.abc import Iterator

from ...model.gears.gear import Gear
from ...sentences import Angle, Sentence, Speed
from .gear_studies import GearLoop
from .usage import Usage

LOSS = 3.0 * math.pi / 10800.0  # 3 arcmin: the largest hysteresis loss that catalogues print, of ratio 30
ROUNDING = 1.05  # of a fit to the printed value
RATCHETING = 16.0  # times the rated torque: CSF/CSG catalogue, p. 14, has 4.8 (CSG-17-120) to 15.7 (CSG-14-50)


def implausible(gear: Gear | None, rated: float | None, loop: GearLoop | None, used: Usage) -> Iterator[str]:
    """Sentences about the hysteresis loop and the largest torque of a run.

    Parameters
    ----------
    gear : Gear or None
        Its record, with the largest hysteresis loss that its catalogue prints: below 1 arcmin, of ratio 30 below
        3 arcmin (Harmonic Drive, CHA catalogue, accuracy and hysteresis), which holds for a gear without one too.
    rated : float or None
        Rated torque [N*m].
    loop : GearLoop or None
        Hysteresis loop of the law.
    used : Usage
        Largest torques of the run.
    """
    most = LOSS if gear is None or gear.hysteresis_loss is None else gear.hysteresis_loss
    if loop is not None and loop.rated and loop.full.loss > ROUNDING * most:
        yield Sentence(
            f"The hysteresis loss at the rated torque of {loop.torque:g} N*m is {{}}, and "
            f"{'catalogues print' if gear is None else 'that of ' + gear.name + ' is'} at most {{}}; check the "
            "numbers of the hysteresis, fit_hysteresis finds them from those of a datasheet.",
            Angle(loop.full.loss, digits=3),
            Angle(most, digits=3),
        )
    known = gear is not None and gear.ratcheting_torque is not None  # then it is among the limits
    if not known and rated is not None and used.peak_torque > RATCHETING * rated:
        yield Sentence(
            f"The torque in the gear reaches {used.peak_torque:.4g} N*m at {{}}, "
            f"{used.peak_torque / rated:.3g} times the rated torque, and gears ratchet from 5 to 16 times on: the "
            "teeth skip, which this model does not do, and the error is no result; check load, damping and torques.",
            Speed(used.at_peak, digits=5),
        )
