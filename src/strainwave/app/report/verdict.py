"""Whether the drive is all right at its speeds and, if not, the smallest change, as data and in words."""

from typing import Any

from ...base.sentences import Angle, Sentence, Speed, listed
from ...model.gears.limits import Finding, gravest
from ...study.analysis.avoid import out_of_reach
from ...study.analysis.remedies import Remedy
from ...study.analysis.verdict import Answer, Verdict
from ..console import number, percent
from ..view import View, sizes
from .remedies import more
from .sections.whole_train import under_load

ADD_LIMIT = (
    "To have the oscillation judged, write its limit into the file, for example limit: {oscillation: 60 arcsec}."
)
NO_LIMIT = "the file has no limit of the oscillation"
TWICE = 2.0  # times a limit, from which on the size is told as a multiple
NONE = 1e-9  # relative oscillation below which nothing is left but rounding
MOTOR = ("motor torque", "motor speed")
REST = ("max_rpm", "average_rpm", "average_torque", *MOTOR)  # limits that are named only where they are passed
NAMES = {
    "max_rpm": "largest input speed", "average_rpm": "average input speed", "motor torque": "motor's largest torque",
    "motor speed": "motor's largest speed",
}  # fmt: skip


def verdict_data(view: View) -> dict[str, Any]:
    """The answer, its sentence, what to do, and the speeds and the change in numbers."""
    verdict, change = view.analysis.verdict, view.analysis.verdict.change
    row = None
    if change is not None:
        row = {"change": more(change), "from": change.before, "to": change.gear or change.after, "unit": change.unit}
        row |= {**sizes(_after(view), "oscillation"), "at_rad_per_s": change.at}
    return {
        "answer": str(verdict.answer),
        "headline": _headline(view, verdict),
        "largest_over_limit": share(view),
        "sentence": _sentence(view, verdict),
        "what_to_do": _remedy(view, verdict),
        "speeds_to_keep_out_of": [_band(view, *band) for band in verdict.speeds],
        "allowed_speeds": [_band(view, *band) for band in verdict.allowed],
        "smallest_change": row,
    }


def share(view: View) -> float | None:
    """Largest oscillation over its limit; None without a limit."""
    avoid = view.analysis.avoid
    limit = None if avoid is None else avoid.limit
    return None if limit is None else view.analysis.largest_oscillation().peak / limit


def _headline(view: View, verdict: Verdict) -> str:
    """Pass or fail, by how much or why."""
    part, avoid = share(view), view.analysis.avoid
    if verdict.answer is Answer.ALL_RIGHT:
        below = "" if part is None else f"the oscillation is {percent(1.0 - part, 2)} below its limit"
        return f"Pass; {below or NO_LIMIT}"
    why = []
    if part is not None and part > 1.0:
        size = f"{number(part, 3)} times" if part > TWICE else f"{percent(part - 1.0, 2)} above"
        why.append(f"the oscillation is {size} its limit")
    passed = gravest(verdict.exceeded)
    first = [finding for finding in passed if finding.limit not in MOTOR][:1]
    for finding in (*first, *(finding for finding in passed if finding.limit in MOTOR)):
        why.append(f"{number(finding.value)} {_unit(finding)} are above {_named(finding)}")
    if avoid is not None and avoid.unstable:
        why.append("at some speeds no motion of the curve is stable")
    sweep = view.analysis.response.sweep
    if not why and sweep is not None and sweep.jumping:
        why.append("the motion jumps")
    if part is None and not verdict.exceeded and verdict.answer is Answer.BUT:
        return "; ".join(["Some speeds are to be avoided", *why, NO_LIMIT])
    return "; ".join(["Fail at some speeds" if verdict.answer is Answer.BUT else "Fail", *(why or [NO_LIMIT])])


def _sentence(view: View, verdict: Verdict) -> Sentence:
    """The answer, with the largest oscillation and torque against their limits."""
    begin: str = "All right at all speeds"
    if verdict.answer is Answer.BUT:
        begin = "All right but for " + ranges(verdict.speeds)
    elif verdict.answer is Answer.NOT:
        begin = "Not all right"
    return Sentence("{}: {}; {}.", begin, _oscillation(view), torque_said(view, verdict))


def _oscillation(view: View) -> Sentence:
    """The largest oscillation against its limit."""
    analysis, avoid = view.analysis, view.analysis.avoid
    if avoid is None:
        return Sentence("no steady motion of the range is stable")
    largest = analysis.largest_oscillation()
    where = Speed(largest.omega, digits=5) + under_load(largest.torque)
    if avoid.limit is not None:
        how = "above" if largest.peak > avoid.limit else "within"
        against = Sentence("{} the limit of {}", how, Angle(avoid.limit))
    elif avoid.slow > 0.0:
        against = Sentence("{} times that of quasi-static rotation", number(largest.peak / avoid.slow, 2))
        against += ", and the file has no limit of it"
    else:
        against = Sentence("and the file has no limit of it")
    text = Sentence("the error oscillates with up to {} at {}, {}", Angle(largest.peak), where, against)
    if avoid.limit is not None and avoid.largest_passed is not None and avoid.largest_passed[1] > avoid.limit:
        text += Sentence(" (in the run-up with up to {})", Angle(avoid.largest_passed[1]))
    if said := out_of_reach(avoid.limit, avoid.slow):
        text += "; " + said
    sweep = analysis.response.sweep
    return text if sweep is None or not sweep.jumping else text + ", and the motion jumps"


def torque_said(view: View, verdict: Verdict, with_motor: bool = True) -> str:
    """The largest torque against the rating, and every limit of the gear, and of the motor, that is passed."""
    used = view.analysis.usage
    exceeded = [one for one in gravest(verdict.exceeded) if with_motor or one.limit not in MOTOR]
    size = f"the torque through the gear reaches {number(used.peak_torque)} N·m"
    torques = [finding for finding in view.analysis.limits if finding.limit not in REST]
    if not torques:
        said = f"{size}, and its largest torques are not known"
    elif passed := [finding for finding in exceeded if finding.limit not in REST]:
        said = f"{size}, above {_named(passed[0])}"
    else:
        said = f"{size}, within {_named(min(torques, key=lambda finding: finding.bound))}"
    for finding in exceeded:
        if finding.limit in REST:
            said += f"; {number(finding.value)} {_unit(finding)} are above {_named(finding)}"
    return said


def _named(finding: Finding) -> str:
    name = NAMES.get(finding.limit, finding.limit.replace("_", " "))
    return f"the {name} of {number(finding.bound)} {_unit(finding)}"


def _unit(finding: Finding) -> str:
    return finding.unit.replace("*", "·")


def _remedy(view: View, verdict: Verdict) -> str:
    """The smallest change that suffices, or what the best one leaves; and the speeds that need none."""
    avoid = view.analysis.avoid
    if verdict.answer is Answer.ALL_RIGHT:
        return "" if avoid is None or avoid.limit is not None else ADD_LIMIT
    said = changes_said(view, verdict)
    if verdict.answer is Answer.BUT:
        keep = "Without a change: keep to {}." if said else "Keep to {}."
        said.append(Sentence(keep, ranges(verdict.allowed)))
    elif over_limit(view) and not verdict.allowed:
        said.append(Sentence("No speed of the range is without it."))
    if avoid is not None and avoid.limit is None:
        said.append(Sentence(ADD_LIMIT))
    return Sentence(" ").join(said)


def over_limit(view: View) -> bool:
    """Whether a steady motion oscillates with more than the limit of the file."""
    avoid = view.analysis.avoid
    return avoid is not None and avoid.limit is not None and avoid.largest > avoid.limit


def changes_said(view: View, verdict: Verdict) -> list[Sentence]:
    """The smallest change that suffices, or what the best one leaves, and what a passed limit of the gear needs."""
    avoid, said = view.analysis.avoid, []
    if verdict.change is not None:
        text = "Smallest change that was found to bring the oscillation within its limit: {}; it leaves {}."
        said.append(Sentence(text, more(verdict.change) + _ends(verdict.change), _left(view, verdict.change)))
    elif over_limit(view) and avoid is not None and view.analysis.remedies:
        best = view.analysis.remedies[0]
        under = " under every load torque" if best.exceeds is False else ""
        text = "No change of one thing was found that brings the oscillation within its limit{}; the best, {}, "
        text += "leaves {}{}."
        there = " at the torque of the largest oscillation" if under else ""
        said.append(Sentence(text, under, more(best), Angle(best.ratio * avoid.largest), there))
    elif over_limit(view):
        said.append(Sentence("No change was tried that could bring the oscillation within its limit."))
    of_motor = [finding.limit in MOTOR for finding in verdict.exceeded]
    if not all(of_motor):
        said.append(Sentence("What passes a limit of the gear needs less load or speed, or a larger gear."))
    if any(of_motor):
        text = "What passes a limit of the motor needs less load or speed, another ratio, or a stronger motor."
        said.append(Sentence(text))
    return said


def _ends(change: Remedy) -> str:
    """What a number is and what it becomes, with its unit; nothing for what is exchanged or cancelled."""
    if change.gear or change.by or change.share == -1.0:
        return ""
    return f" ({number(change.before)} to {number(change.after)} {change.unit})".replace(" )", ")")


def _left(view: View, change: Remedy) -> Sentence:
    """What a change leaves of the oscillation, and where."""
    if change.ratio < NONE:
        return Sentence("no oscillation")
    return Sentence("{} at {}", Angle(_after(view)), Speed(change.at, digits=5))


def _after(view: View) -> float:
    """Largest oscillation [rad] after the smallest change."""
    change, avoid = view.analysis.verdict.change, view.analysis.avoid
    assert change is not None
    assert avoid is not None
    return change.ratio * avoid.largest


def ranges(bands: tuple[tuple[float, float], ...]) -> Sentence:
    """Bands of speeds [rad/s] in words, with their unit at the end."""
    return listed(Sentence("{}", Speed(*band, digits=4, between=" to ", bare=True)) for band in bands) + " " + Speed()


def _band(view: View, low: float, high: float) -> dict[str, Any]:
    ends = {"from_rad_per_s": low, "to_rad_per_s": high}
    return ends | {"from_rpm": view.speeds.rpm(low), "to_rpm": view.speeds.rpm(high)}
