"""Sentences about what went wrong in an analysis or needs care, and about results that no gear gives."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...base.results import Branch, Status
from ...base.sentences import Angle, Sentence, Speed
from ...drive.demands.usage import Usage
from ...drive.equation.gear_torque import UNDAMPED, loses_energy
from ...model.gears.gear import Gear
from ...model.gears.limits import RATCHETING
from ..gear.hysteresis_loop import GearLoop

if TYPE_CHECKING:
    from .analysis import Analysis

DISAGREEMENT = 0.01  # of the largest |x|: more than truncation of the series explains
LARGEST_LOSS = 3.0 * math.pi / 10800.0  # 3 arcmin: the largest hysteresis loss that catalogues print, of ratio 30
FIT_ROUNDING = 1.05  # of a fit to the printed value


def cautions(analysis: "Analysis") -> Iterator[str]:
    """Sentences on an `Analysis`, the gravest first."""
    yield from analysis.doubts
    exact, study, motions = analysis.exact, analysis.train, (*analysis.run_up.up, *analysis.run_up.down)
    if analysis.point.omega_0 == 0.0:
        yield (
            "The torsion law has no stiffness at the operating point (backlash). There is no natural frequency, and "
            "multiple scales does not apply; all results here are from numerical integration."
        )
    if not loses_energy(analysis.system):
        yield f"{UNDAMPED[0].upper()}{UNDAMPED[1:]}."
    yield from not_exact("The response curve", exact.curve)
    if exact.rounding:
        yield f"The harmonic balance of beating motions smooths the torsion law: {exact.rounding}."
    difference = analysis.run_up.difference()
    if difference is not None and difference > DISAGREEMENT:
        yield (
            f"The integrated run-up and run-down differ from the response curve by up to {100.0 * difference:.2g} % "
            "in the largest |x| at one speed: the drive can settle on another motion there."
        )
    if failed := [motion for motion in motions if not motion.status]:
        yield f"{len(failed)} of {len(motions)} simulated speeds have no steady motion: {failed[0].message}."
    for case in analysis.cases:
        if not case.transient.status:
            text = f" ({case.name}) the simulation from rest {case.transient.message}."
            yield "At " + Speed(case.omega, digits=5) + text
    if study is not None and study.curve is not None:
        yield from not_exact("The steady curve of the whole drive train", study.curve.curve)
    if study is not None and study.left_out is not None:
        yield study.left_out.sentence()


def not_exact(name: str, curve: Branch) -> list[str]:
    """Sentence on a curve that ends inside the range or leaves too many harmonics out."""
    if curve.status:
        return []
    state = "inaccurate" if curve.status is Status.TRUNCATED else "incomplete"
    return [f"{name} is {state}: " + curve.message + "."]


def implausible(gear: Gear | None, rated: float | None, loop: GearLoop | None, run_usage: Usage) -> Iterator[str]:
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
    run_usage : Usage
        Largest torques of the run.
    """
    loss = LARGEST_LOSS if gear is None or gear.hysteresis_loss is None else gear.hysteresis_loss
    if loop is not None and loop.rated and loop.full.loss > FIT_ROUNDING * loss:
        yield Sentence(
            f"The hysteresis loss at the rated torque of {loop.torque:g} N*m is {{}}, above the largest loss of "
            f"{'catalogue gears' if gear is None else gear.name}, {{}}; check the hysteresis values, or compute them "
            "from a datasheet with fit_hysteresis.",
            Angle(loop.full.loss, digits=3),
            Angle(loss, digits=3),
        )
    limited = gear is not None and gear.ratcheting_torque is not None  # then it is among the limits
    if not limited and rated is not None and run_usage.peak_torque > RATCHETING * rated:
        yield Sentence(
            f"The gear torque reaches {run_usage.peak_torque:.4g} N*m at {{}}, {run_usage.peak_torque / rated:.3g} "
            "times the rated torque. Gear teeth ratchet at 5 to 16 times the rated torque; the model neglects "
            "ratcheting, so the computed error is invalid. Check load, damping and torques.",
            Speed(run_usage.at_peak, digits=5),
        )
