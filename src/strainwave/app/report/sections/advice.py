"""Advice to the engineer: the speeds to avoid, and remedies that make the error smaller, a controller among them."""

import math
from typing import TYPE_CHECKING, Any

from ....base.sentences import Angle, Sentence, Speed, listed
from ....plot.svg import figure
from ....study.analysis.remedies import CANCELLED
from ....study.analysis.verdict_words import apart_said, band_data
from ....study.analysis.words import MOTOR, postures_data, under_load
from ....study.speed_map.avoid import Avoid
from ....study.speed_map.bands import AMPLIFIED
from ...console import number
from ...view import View, sizes, speed_data
from ..remedies import bare_speed, no_help, remedies_data
from ..section import Part, Table

if TYPE_CHECKING:
    from ....study.compensation.result import Compensation as Found

OSCILLATION = "the oscillation of the error (its largest distance from its mean, in a steady motion)"
APART = "and wherever run-up and run-down are on different motions"
NOMINAL = (
    "The speeds to avoid are those of the nominal drive; with 'scatter' and 'limit' in the project file 'strainwave "
    "exceedance' computes how probable it is that a drive exceeds its limit."
)
BARS = (
    "Each number is changed by 10 % (30 % where 10 % does little), one at a time, in the better direction, and the "
    "drive computed again. With another gear the load keeps its speeds."
)
FEED_FORWARD = (
    "A feed-forward that cancels a line of the kinematic error exactly needs the phase of that line, which no "
    "datasheet gives. What a real controller leaves: strainwave compensate."
)
TURNS = "Two turns of the {}, after everything has settled, at {}."
BEYOND = " The curve goes a fifth beyond the single speeds of the file, and so do the speeds to avoid."


def speeds_to_avoid(view: View) -> Part:
    """Bands of speed and remedies with their numbers, rule and sentences; None where no motion is stable."""
    advice = _advice(view) or dict.fromkeys(("sentence", "about", "rule", "nominal"), "")
    sentences, notes = ([advice[key] for key in keys] for keys in (("sentence", "about"), ("rule", "nominal")))
    return Part(data={"advice": _advice(view)}, sentences=sentences, notes=notes, kind="do")


def postures(view: View) -> Part:
    """The drive in every posture of the file, whose numbers are in `verdict.postures`."""
    return Part("Postures", tables=[Table(postures_data(view.analysis))])


def remedies(view: View) -> Part:
    """Changes that make the error smaller, the most helpful first; its numbers are those of `speeds_to_avoid`."""
    avoid, changes = view.analysis.avoid, view.analysis.remedies
    if avoid is None:
        return Part()
    rows = [row for row in remedies_data(view, avoid)["remedies"] if row["helps"]]
    limit = "" if view.project.limit is None else " above_limit"
    columns = f"what change from to unit relative_oscillation oscillation_rad at_rad_per_s{limit}"
    cancelled = FEED_FORWARD * any(one.share == CANCELLED for one in changes)
    tried = [f"Not tried: {sentence}." for sentence in view.analysis.not_tried]
    notes = [BARS * bool(rows), cancelled, no_help(changes), *tried]
    return Part("What would help", tables=[Table(rows, columns)], notes=notes)


def _advice(view: View) -> dict[str, Any] | None:
    avoid = view.analysis.avoid
    if avoid is None:
        return None
    run_up = dict[str, Any]()  # where the curve leaves out some of its torques
    if avoid.largest_passed is not None:
        speed, size = avoid.largest_passed
        run_up = {**sizes(size, "largest_oscillation_in_run_up"), "in_run_up_at_rad_per_s": speed}
    return {
        "rule": _rule(avoid) + (BEYOND if view.speeds.single else ""),
        "limit_rad": avoid.limit,
        "bands": [band_data(view.speeds, *band) for band in avoid.bands],
        **sizes(avoid.largest, "largest_oscillation"),
        "at_rad_per_s": avoid.at,
        **run_up,
        "slow_oscillation_rad": avoid.slow,
        "peaks": [view.speed_data(w) | {"oscillation_rad": size} for w, size in avoid.peaks],
        "sentence": _avoid(view, avoid) + _limits(view, avoid),
        "by_load_torque": [
            {"load_torque_Nm": case.torque, "bands": [band_data(view.speeds, *band) for band in case.bands]}
            for case in view.analysis.load_cases
        ],
        "run_up_bands": [band_data(view.speeds, *band) for band in avoid.passed],
        "about": _about(view, avoid),
        "nominal": NOMINAL if avoid.bands else "",
        **remedies_data(view, avoid),
    }


def _about(view: View, avoid: Avoid) -> Sentence | str:
    """Say which torques of the load the speeds to avoid are for, and the speeds that the run-up adds."""
    cases, text = view.analysis.load_cases, ""
    if cases:
        ends = f"{len(cases)} torques of the load from {number(cases[0].torque)} to {number(cases[-1].torque)} N·m"
        torques = ", ".join(number(case.torque) for case in cases if not case.bands)
        free = f" At {torques} N·m no speed is to be avoided." if torques else ""
        each = [f"at {number(case.torque)} N·m " + _ranges(view, case.bands) for case in cases if case.bands]
        bands = ": " + Sentence("; ").join(each) if each else ""
        text = f"These speeds are for {ends} and what lies between their bands" + bands + "." + free + " "
    if avoid.largest_passed is None:
        return text
    speed, size = avoid.largest_passed
    speeds = _ranges(view, avoid.passed) + " " + Speed() if avoid.passed else "no speed"
    speeds += Sentence(", with up to {} about the mean of its turns, at {}", Angle(size), bare_speed(speed))
    if view.analysis.train_curve is None:
        return (
            "These speeds are those of the error equation, in place of the whole drive train; the run-up of that train "
            "adds " + speeds + "."
        )
    return text + "The run-up, with the torques at every angle of the load, adds " + speeds + "."


def _limits(view: View, avoid: Avoid) -> Sentence:
    """Say all speeds to avoid where limits of the gear or the motor add some to those of the oscillation."""
    verdict = view.analysis.verdict
    if verdict.fault or verdict.speeds == avoid.bands:
        return Sentence("")
    posed = ["postures"] if view.analysis.postures else []
    of = dict.fromkeys("limits of the motor" if f.limit in MOTOR else "limits of the gear" for f in verdict.exceeded)
    return Sentence(" With the {}, keep out of {} {}.", listed([*of, *posed]), _ranges(view, verdict.speeds), Speed())


def _between(low: float, high: float) -> Sentence:
    return "between " + bare_speed(low) + " and " + bare_speed(high)


def _ranges(view: View, bands: tuple[tuple[float, float], ...]) -> Sentence:
    first, last = view.analysis.speeds
    ends = {last: " (the end of the range)", first: " (from the start of the range)"}
    return listed(
        bare_speed(*band, ways=(-1, 1))
        + "".join(text for end, text in ends.items() if any(math.isclose(end, speed) for speed in band))
        for band in bands
    )


def _rule(avoid: Avoid) -> str:
    if avoid.limit is not None:
        text = f"A speed is to be avoided where {OSCILLATION} is above the project's limit of "
        return text + Angle(avoid.limit) + f", {APART}."
    return f"A speed is to be avoided where {OSCILLATION} is above {AMPLIFIED:g} times that of slow rotation, {APART}."


def _avoid(view: View, avoid: Avoid) -> Sentence:
    sweep = view.analysis.drive.sweep
    slow = Angle(avoid.slow) + " of quasi-static rotation"
    if not avoid.bands:
        passed = 0.0 if avoid.largest_passed is None else avoid.largest_passed[1]
        largest = max(avoid.largest, passed)
        up_to: Sentence | Angle = Angle(largest)
        if passed > avoid.largest:
            up_to = Sentence("{} in steady motions and {} in the run-up", Angle(avoid.largest), Angle(passed))
        times = f"{number(largest / avoid.slow, 2)} times" if avoid.slow > 0.0 else "many times"
        comparison = f"{times} the " + slow
        if avoid.limit is not None:
            comparison = "within the limit of " + Angle(avoid.limit)
        return Sentence(
            "No speed of the range has to be avoided for its oscillation: the error oscillates with at most {}, {}{}.",
            up_to, comparison, "" if sweep is not None and sweep.alone else ", and nothing jumps",
        )  # fmt: skip
    reasons: list[str] = []
    if avoid.peaks:
        tops = listed(Angle(size) + " at " + bare_speed(speed) for speed, size in avoid.peaks)
        reasons.append(Sentence(f"the error oscillates with more than {AMPLIFIED:g} times the {{}}: {{}}", slow, tops))
    if avoid.limit is not None and avoid.largest > avoid.limit:
        text = "the error oscillates with more than the limit of {}, at most {} at {}"
        reasons.append(Sentence(text, Angle(avoid.limit), Angle(avoid.largest), bare_speed(avoid.at)))
    if avoid.apart is not None and avoid.apart[1] > (avoid.limit or AMPLIFIED * avoid.slow):
        text = "a motion apart from the curve oscillates with up to {}, at {}"
        reasons.append(Sentence(text, apart_said(avoid.apart)[0], bare_speed(avoid.apart[0])))
    jumping = [(None, band) for band in sweep.jumping] if sweep is not None else []
    if jumps := [_between(band.low, band.high) + under_load(at) for at, band in jumping or view.analysis.jumping]:
        reasons.append("the motion jumps " + listed(jumps))
    if avoid.unstable:
        reasons.append("the motion is not stable " + listed(_between(*ends) for ends in avoid.unstable))
    reason = Sentence(", and ").join(reasons)
    return Sentence("Avoid {} {}: there {}.", _ranges(view, avoid.bands), Speed(), reason)


BLIND, SEEING = "inverse", "adaptive-inverse"  # without and with an encoder on the load


def compensation(view: View) -> Part:
    """The plain loop, the linear inverse, and one that also adapts to the load's encoder, at the resonance.

    Errors before and after, torque, and the same on other gears; None without a group `controller`.
    """
    heading, speeds = "What a controller can take away", view.project.speeds
    if view.project.sampling is None:
        return Part(data={"compensation": None})
    from ....plot.compensation import error_panels, motion
    from ....study.compensation.bench import steady_bench_of
    from ....study.compensation.compensate import compensate

    try:
        bench, results = steady_bench_of(view.project), [compensate(view.project, name) for name in _names(view)]
    except ValueError as error:
        sentences = [f"compensation was not computed: {error}"]
        data = {"not_computed": str(error), "controllers": [], "remarks": []}
        return Part(heading, {"compensation": data}, sentences, lines=sentences)
    controllers, first = [_controller_row(result) for result in results], results[0]
    speed, before = first.axis.said(first.speed), sizes(first.before.rms, "rms_before")
    remarks = list(dict.fromkeys(text for result in results for text in (*result.warnings, *result.remarks)))
    body = {"not_computed": "", "speed": speed, **speed_data(speeds, first.speed), **before, "controllers": controllers}
    others = [{"controller": c["title"]} | gear for c in controllers for gear in c["other_gears"]]
    plain = motion(bench, "loop", first.speed, "plain loop")
    panels = error_panels(plain, [motion(bench, name, first.speed, name) for name in _names(view)])
    return Part(
        heading,
        {"compensation": body | {"remarks": remarks}},
        tables=[
            Table(controllers, "title rms_after_rad reduction_dB peak_torque_Nm stable excluded"),
            Table(others, "controller stiffness rms_before_rad rms_after_rad", "On gears of another stiffness"),
        ],
        notes=remarks,
        figures=[(figure([panels], 180.0, "pointing error before and after"), TURNS.format(speeds.base, speed))],
        lines=[f"controller {result.name} at {speed}: {result.said}" for result in results],
    )


def _names(view: View) -> tuple[str, ...]:
    seeing = view.project.sampling is not None and view.project.sampling.load_encoder
    return (BLIND, SEEING) if seeing else (BLIND,)


def _controller_row(result: "Found") -> dict[str, Any]:
    return {
        "name": result.name,
        "title": result.title,
        **sizes(result.after.rms, "rms_after"),
        "reduction_dB": result.reduction,
        "peak_torque_Nm": result.torque.peak,
        "stable": result.stable,
        "excluded": result.excluded,
        "other_gears": [
            {"stiffness": r.stiffness, **sizes(r.before, "rms_before"), **sizes(r.after, "rms_after")}
            for r in result.robustness
        ],
    }
