"""Sentences about what went wrong in an analysis, or needs care."""

from collections.abc import Iterator
from typing import Any

from ...results import Branch, Status
from ...sentences import Speed
from ..response.gear_forces import loses_energy
from .load_range import searched

DISAGREE = 0.01  # of the largest |x|: more than truncation of the series explains


def cautions(found: Any) -> Iterator[str]:
    """Sentences on an `Analysis`, the gravest first."""
    yield from found.doubts
    exact, study, every = found.exact, found.train, (*found.run_up.up, *found.run_up.down)
    if found.point.omega_0 == 0.0:
        yield (
            "The law has no stiffness where the mean torque holds the drive (backlash), so there is no natural "
            "frequency to resonate with and multiple scales does not apply; everything here is from integration."
        )
    if not loses_energy(found.system):
        yield (
            "The drive has no damping: transients never decay, the amplitude at resonance is bounded by the "
            "nonlinearity alone, and simulated points depend on the start; give a damping, a damping ratio or a "
            "quality factor."
        )
    yield from not_exact("The response curve", exact.curve)
    difference = found.run_up.difference()
    if difference is not None and difference > DISAGREE:
        yield (
            f"The run-up and run-down by integration differ from the response curve by up to {100.0 * difference:.2g} "
            "% in the largest |x| at one speed: the drive can settle on another motion there."
        )
    if failed := [motion for motion in every if not motion.status]:
        yield f"{len(failed)} of {len(every)} simulated speeds have no steady motion: {failed[0].message}."
    for case in found.cases:
        if not case.transient.status:
            text = f" ({case.name}) the simulation from rest {case.transient.message}."
            yield "At " + Speed(case.omega, digits=5) + text
    if found.load_cases and not searched(found.system.law):
        yield (
            "Motions that do not join the response curve are looked for at the ends of the speed range under the mean "
            "load torque alone; for those of another torque give it as the mean."
        )
    if study is not None and study.curve is not None:
        yield from not_exact("The steady curve of the whole drive train", study.curve.response.curve)
    if study is not None and study.left_out is not None:
        yield study.left_out.sentence()


def not_exact(name: str, curve: Branch) -> list[str]:
    """Sentence on a curve that ends inside the range or leaves too many harmonics out."""
    if curve.status:
        return []
    state = "rough" if curve.status is Status.TRUNCATED else "not complete"
    return [f"{name} is {state}: " + curve.message + "."]
