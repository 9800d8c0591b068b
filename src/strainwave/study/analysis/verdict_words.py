"""The words of the verdict of an `Analysis`: pass or fail at its speeds, what helps, and the first answers."""

import math
from typing import TYPE_CHECKING, Any

from ...base.facts import Fact
from ...base.number_text import number, percent
from ...base.sentences import Angle, Sentence, Speed, listed
from ...base.units import ARCSEC, RPM
from ...drive.demands.motor_limits import BRAKE, RMS, MotorLimits
from ...drive.speeds import Speeds
from ...model.gears.limits import Finding, gravest
from ..speed_map.avoid import out_of_reach
from . import words
from .remedies import Remedy
from .verdict import TIE_RATIO, Answer, Verdict

if TYPE_CHECKING:
    from .analysis import Analysis

ADD_LIMIT = (
    "For a pass or fail, write an oscillation limit into the project file, such as limit: {oscillation: 60 arcsec}."
)
LOOP_FIRST = (
    "Lower the gains or the bandwidth of the control loop, or reduce its delay and lag; strainwave tune finds stable "
    "gains."
)
NO_LIMIT = "the project file has no oscillation limit"
RUN_UP = " During a run-up the oscillation about the mean of each turn reaches {}."
MULTIPLE = 2.0  # times a limit, from which on the size is told as a multiple
NO_OSCILLATION = 1e-9  # relative oscillation below which nothing is left but rounding
LEAST_SHARE = 0.01  # share of the motor's torque from which on the steady part is told
MOST_LISTED = 6  # speeds of jumps that are listed; of more the ends


def facts(analysis: "Analysis") -> tuple[Fact, ...]:
    """The verdict on an `Analysis` for a terminal, as JSON and for a page: answer, sentences, speeds and change."""
    verdict, change, speeds = analysis.verdict, analysis.verdict.change, analysis.project.speeds
    row = None
    if change is not None:
        size = _after(analysis)
        row = {"change": str(change), "from": change.before, "to": change.gear or change.after, "unit": change.unit}
        row |= {"oscillation_rad": size, "oscillation_arcsec": size / ARCSEC, "at_rad_per_s": change.at}
    passed, sentences = analysis.avoid.passed if analysis.avoid else (), answers(analysis)
    headline, sentence, remedy = first_lines(analysis)
    return (
        Fact("", analysis.project.title, "{}"),
        Fact("", headline, "{}"),
        Fact("verdict.answer", str(verdict.answer)),
        Fact("verdict.headline", headline),
        Fact("verdict.largest_over_limit", share(analysis)),
        Fact("verdict.sentence", sentence),
        Fact("verdict.what_to_do", remedy),
        Fact("verdict.how_sure", words.how_sure(analysis)),
        Fact("verdict.speeds_to_keep_out_of", [band_data(speeds, *band) for band in verdict.speeds]),
        Fact("verdict.allowed_speeds", [band_data(speeds, *band) for band in verdict.allowed]),
        Fact("verdict.postures", words.postures_data(analysis)),
        Fact("verdict.run_up_adds", [band_data(speeds, *band) for band in passed]),
        Fact("verdict.smallest_change", row),
        Fact("verdict.answers", sentences),
        Fact("", tuple(f"{what}: {text}" for what, text in sentences.items()), "{}"),
    )


def first_lines(analysis: "Analysis") -> tuple[str, Sentence, str]:
    """Headline, sentence and remedy."""
    verdict = analysis.verdict
    return _headline(analysis, verdict), _sentence(analysis, verdict), _remedy(analysis, verdict)


def share(analysis: "Analysis") -> float | None:
    """Largest oscillation, in the worst posture where there are some, over its limit; None without a limit."""
    avoid = analysis.avoid
    limit = None if avoid is None else avoid.limit
    return None if limit is None else words.largest_of_all(analysis)[0] / limit


def _headline(analysis: "Analysis", verdict: Verdict) -> str:
    """Pass or fail, by how much or why, and whether the drive hunts."""
    resting = None if analysis.train is None else analysis.train.resting
    hunts = f"; hunting at standstill: ±{number(resting.size / ARCSEC, 3)} arcsec" if resting and resting.hunts else ""
    return _passes(analysis, verdict) + hunts


def _passes(analysis: "Analysis", verdict: Verdict) -> str:
    """Pass or fail, by how much or why."""
    if verdict.fault:
        return f"Fail at every speed; {_begun(verdict.fault)}"
    part, avoid, case = share(analysis), analysis.avoid, words.largest_of_all(analysis)[1]
    if verdict.answer is Answer.ALL_RIGHT:
        below = "" if part is None else f"the oscillation{case} is {percent(1.0 - part, 2)} below its limit"
        added = f"; but in a run-up avoid {ranges(avoid.passed)}" if avoid and avoid.passed else ""
        return f"Pass; {below or NO_LIMIT}{added}"
    faults = []
    if part is not None and part <= 1.0 and avoid and avoid.limit and avoid.apart:
        part, case = avoid.apart[1] / avoid.limit, " of another periodic motion at the same speed"
    if part is not None and part > 1.0:
        size = f"{number(part, 3)} times" if part > MULTIPLE else f"{percent(part - 1.0, 2)} above"
        faults.append(f"the oscillation{case} is {size} its limit")
    passed = gravest(verdict.exceeded)
    first = [finding for finding in passed if finding.limit not in words.MOTOR][:1]
    faults += map(words.excess_text, [*first, *(finding for finding in passed if finding.limit in words.MOTOR)])
    if avoid is None:
        faults.append(analysis.project.undamped.partition(":")[0] or words.NOTHING_STABLE)
    elif avoid.unstable:
        faults.append("the steady motion is unstable at some speeds")
    if not faults and analysis.jumping:
        faults.append("the oscillation jumps")
    if (worst := analysis.posture) and worst.answer is not Answer.ALL_RIGHT:
        rows = analysis.postures
        failing = sum(row.answer is not Answer.ALL_RIGHT for row in rows)
        several = f"{failing} of {len(rows)} postures fail" + f", {worst.title} by the most" * (worst.title not in case)
        text = several if failing > 1 else f"1 of {len(rows)} postures fails, {worst.title}"
        faults.append(": ".join([text, *(words.excess_text(one) for one in worst.exceeded[:1])]))
    faults += [f"in the move of the project file, {words.excess_text(one)}" for one in words.move_failures(analysis)]
    if part is None and not verdict.exceeded and verdict.answer is Answer.BUT:
        return "; ".join(["Avoid some speeds", *faults, NO_LIMIT])
    return "; ".join(["Fail at some speeds" if verdict.answer is Answer.BUT else "Fail", *(faults or [NO_LIMIT])])


def _sentence(analysis: "Analysis", verdict: Verdict) -> Sentence:
    """The answer, with the largest oscillation and torque against their limits."""
    if verdict.fault:
        return Sentence("Fail: {}; the drive reaches none of the computed steady motions.", _begun(verdict.fault))
    steady = verdict.exceeded or verdict.speeds or not words.move_failures(analysis)  # else the move alone fails
    begin = "Fail" if verdict.answer is Answer.NOT and steady else "Pass at all speeds"
    if verdict.answer is Answer.BUT:
        avoid = share(analysis) is None and not verdict.exceeded
        begin = ("Avoid " if avoid else "Fail at ") + ranges(verdict.speeds)
    sentence = Sentence("{}: {}; {}.", begin, _oscillation(analysis), torque_text(analysis, verdict))
    of_file = Sentence(" These values are for the nominal load. {}", words.posture_sentence(analysis))
    return sentence + of_file if analysis.postures else sentence


def apart_said(apart: tuple[float, float]) -> tuple[Angle | str, Speed]:
    """Size and speed of a motion apart from the curve; of one that grows beyond every bound in words."""
    return Angle(apart[1]) if math.isfinite(apart[1]) else "infinity", Speed(apart[0], digits=5)


def _oscillation(analysis: "Analysis") -> Sentence:
    """The largest oscillation against its limit."""
    avoid = analysis.avoid
    if avoid is None:
        return Sentence(analysis.project.undamped or words.NOTHING_STABLE)
    largest = analysis.largest_oscillation()
    speed = words.largest_text(largest)
    against: str = "no limit set"
    if avoid.limit is not None:
        against = ("above" if largest.peak > avoid.limit else "within") + " the limit of " + Angle(avoid.limit)
    elif avoid.slow > 0.0:
        against = f"{number(largest.peak / avoid.slow, 2)} times the oscillation at very low speed, {against}"
    text = Sentence("oscillation up to {} at {}, {}", Angle(largest.peak), speed, against)
    if avoid.apart is not None and avoid.apart[1] > TIE_RATIO * largest.peak:
        text += Sentence(" (another periodic motion has up to {} at {})", *apart_said(avoid.apart))
    if avoid.limit is not None and avoid.largest_passed is not None and avoid.largest_passed[1] > avoid.limit:
        text += Sentence(" (during a run-up up to {} about the mean of each turn)", Angle(avoid.largest_passed[1]))
    if reason := out_of_reach(avoid.limit, avoid.slow, analysis.project.train):
        text += "; " + reason
    text = text + ", and the oscillation jumps" if analysis.jumping else text
    return text + "; at some speeds the steady motion is unstable" if avoid.unstable else text


def torque_text(analysis: "Analysis", verdict: Verdict, with_motor: bool = True) -> str:
    """The largest torque against the rating, and every limit of the gear, and of the motor, that is passed."""
    used = analysis.usage
    exceeded = [one for one in gravest(verdict.exceeded) if with_motor or one.limit not in words.MOTOR]
    size = f"gear torque up to {number(used.peak_torque, analysis.project.digits())} N·m"
    torques = [finding for finding in analysis.limits if finding.limit not in words.PASSED_ONLY]
    if not torques:
        against = "no torque limit known"
    elif passed := [finding for finding in exceeded if finding.limit not in words.PASSED_ONLY]:
        against = f"above {words.limit_text(passed[0])}"
    else:
        against = f"within {words.limit_text(min(torques, key=lambda finding: finding.bound))}"
    return "; ".join(
        [
            f"{size}, {against}",
            *(words.excess_text(finding) for finding in exceeded if finding.limit in words.PASSED_ONLY),
        ]
    )


def _remedy(analysis: "Analysis", verdict: Verdict) -> str:
    """The smallest change that suffices, or what the best one leaves; and the speeds that need none."""
    if verdict.fault:
        return LOOP_FIRST
    avoid = analysis.avoid
    if verdict.answer is Answer.ALL_RIGHT:
        return "" if avoid is None or avoid.limit is not None else ADD_LIMIT
    steps: list[str] = [*change_sentences(analysis, verdict)]
    if verdict.answer is Answer.BUT:
        steps.append(keep_to(verdict, "Without a change: operate" if steps else "Operate"))
    elif over_limit(analysis) and not verdict.allowed:
        steps.append("The limit is exceeded at every speed of the range.")
    return Sentence(" ").join([*steps, ADD_LIMIT] if avoid is not None and avoid.limit is None else steps)


def keep_to(verdict: Verdict, operate: str = "Operate") -> Sentence:
    """The advice of a drive that is right at some speeds."""
    return Sentence("{} only at {}.", operate, ranges(verdict.allowed, -1))


def over_limit(analysis: "Analysis") -> bool:
    """True if a steady motion oscillates with more than the limit of the file."""
    avoid = analysis.avoid
    return avoid is not None and avoid.limit is not None and avoid.largest > avoid.limit


def change_sentences(
    analysis: "Analysis", verdict: Verdict, text: str = "Smallest change that meets the limit: {}; {}."
) -> list[Sentence]:  # fmt: skip
    """The smallest change that suffices, or what the best one leaves, and what a passed limit of the gear needs."""
    avoid, sentences = analysis.avoid, []
    if verdict.change is not None:
        alone = " under the nominal load" if analysis.postures else ""
        left = Sentence("no oscillation remains")
        if verdict.change.ratio >= NO_OSCILLATION:
            left = Sentence("oscillation then {} at {}", Angle(_after(analysis)), Speed(verdict.change.at, digits=5))
        sentences.append(Sentence(text, str(verdict.change) + _ends(verdict.change) + alone, left))
    elif over_limit(analysis) and avoid is not None and analysis.remedies and analysis.remedies[0].helps:
        best = analysis.remedies[0]
        under = " under every load torque" if best.exceeds is False else ""
        text = "No single change brings the oscillation within its limit{}; the best one, {}, gives {}{}."
        torque = " under the load torque of the largest oscillation" if under else ""
        sentences.append(Sentence(text, under, str(best), Angle(best.ratio * avoid.largest), torque))
    elif over_limit(analysis):
        sentences.append(Sentence("None of the changes tried brings the oscillation within its limit."))
    of_motor = [finding.limit in words.MOTOR for finding in (*verdict.exceeded, *words.move_failures(analysis))]
    if not all(of_motor):
        sentences.append(Sentence("Gear limit exceeded: reduce load or speed, or choose a larger gear."))
    remedy = Sentence("Motor limit exceeded: reduce load or speed, or choose another ratio or a stronger motor.")
    return [*sentences, remedy] if any(of_motor) else sentences


def _ends(change: Remedy) -> str:
    """Value before and after a change, with its unit; nothing for what is exchanged or cancelled."""
    if change.gear or change.by or change.share == -1.0:
        return ""
    return f" ({number(change.before)} to {number(change.after)} {change.unit})".replace(" )", ")")


def _after(analysis: "Analysis") -> float:
    """Largest oscillation [rad] after the smallest change."""
    change, avoid = analysis.verdict.change, analysis.avoid
    assert change is not None
    assert avoid is not None
    return float(change.ratio * avoid.largest)


def ranges(bands: tuple[tuple[float, float], ...], outward: int = 1) -> Sentence:
    """Bands of speeds [rad/s] in words, their ends rounded outward (-1: inward), with their unit at the end."""
    some = (Speed(*band, digits=4, between=" to ", bare=True, ways=(-outward, outward)) for band in bands)
    return listed(Sentence("{}", one) for one in some) + " " + Speed()


def band_data(speeds: Speeds, low: float, high: float) -> dict[str, Any]:
    """Ends [rad/s] of a band of speeds as data."""
    ends = {"from_rad_per_s": low, "to_rad_per_s": high}
    return ends | {"from_rpm": speeds.rpm(low), "to_rpm": speeds.rpm(high)}


def answers(analysis: "Analysis") -> dict[str, Any]:
    """Sentences by what they answer, in the order of the page; a question without an answer is left out."""
    verdict, loop = analysis.verdict, analysis.project.loop
    if verdict.fault:
        return {"requirement": _requirement(analysis), "loop": verdict.fault, "smallest change": LOOP_FIRST}
    torque = torque_text(analysis, verdict, with_motor=False)
    sentences: dict[str, str] = {
        "requirement": _requirement(analysis),
        "postures": words.posture_sentence(analysis, " The other answers are for the nominal load."),
        "largest oscillation": _worst(analysis),
        "margin": _margin(analysis),
        "jumps": _jumps(analysis),
        "torque": f"{torque[0].upper()}{torque[1:]}.",
        "motor": _motor(analysis),
        "move of the file": words.move_sentence(analysis),
        "loop": "" if loop is None else loop.sentence,
        "how sure": words.how_sure(analysis),
        "smallest change": _change(analysis),
        "without a change": keep_to(verdict) if verdict.answer is Answer.BUT else "",
    }
    if (avoid := analysis.avoid) is not None and avoid.passed:
        sentences["run-up"] = Sentence("In a run-up avoid {} too.", ranges(avoid.passed))
    return {what: text for what, text in sentences.items() if text}


def _requirement(analysis: "Analysis") -> str:
    """The limit of the file, or how to write one."""
    if analysis.project.limit is None:
        return "The project file has no oscillation limit. " + ADD_LIMIT
    assumed = any((one.name, one.word) == ("limit.oscillation", "assumed") for one in analysis.project.sources)
    text = "The oscillation of the {} must not exceed {} at {}." + " The limit is assumed." * assumed
    speeds = Speed(*analysis.speeds, digits=5, between=" to ")
    sentence = Sentence(text, analysis.drive.name, Angle(analysis.project.limit), speeds)
    below = "" if (avoid := analysis.avoid) is None else out_of_reach(avoid.limit, avoid.slow, analysis.project.train)
    return sentence + f" {below[0].upper()}{below[1:]}." if below else sentence


def _motor(analysis: "Analysis") -> str:
    """The torque and the speed that the motor must have, and what it has."""
    motor, limits = analysis.motor, analysis.project.motor_limits
    if motor is None:
        return ""
    study, run = analysis.train, " in the run-up, without the acceleration torque" * motor.in_run_up
    digits, where = analysis.project.digits(), Speed(motor.at, digits=5) + words.load_text(motor.load)
    sheet = limits or MotorLimits()
    torque, speed = sheet.most, sheet.fastest
    of = "" if sheet.peak_torque else _of(motor.torque, torque, "N·m")
    line = Sentence("Motor torque up to {} N·m{}{}, at {}", number(motor.torque, digits), run, of, where)
    if motor.holding > LEAST_SHARE * motor.torque:
        line += f"; loads and friction alone {number(motor.holding, digits)} N·m"
    current = f" Motor current up to {number(motor.torque / sheet.K_t)} A." if math.isfinite(sheet.K_t) else ""
    line += f".{current}"
    if analysis.project.speeds.by_motor:
        fastest = analysis.project.speeds.given[-1] / RPM
        line += f" Motor speed up to {number(fastest, 5)} rpm{_of(fastest, speed / RPM, 'rpm')}."
    if motor.run_up is not None and study is not None and study.ramp is not None:
        text = f" With the acceleration torque, the run-up of {number(study.ramp.duration, 3)} s requires up to "
        slower = Finding("", motor.run_up, torque, "", "").exceeded
        line += f"{text}{number(motor.run_up, digits)} N·m" + (": lengthen the run-up." if slower else ".")
    others = [f.sentence for f in analysis.limits if f.limit in (RMS, BRAKE) or f.omega is not None]
    line += "".join(" " + sentence.replace("*", "·") for sentence in others)
    return line if limits else line + " The project file gives no motor limits."


def _of(asked: float, bound: float, unit: str) -> str:
    """What a motor has available, after the demand on it; nothing where it is not known."""
    if not math.isfinite(bound):
        return ""
    only = "only " if Finding("", asked, bound, "", "").exceeded else ""
    return f" ({only}{number(bound)} {unit} available)"


def _begun(sentence: str) -> str:
    """A sentence as a part of one."""
    return sentence[0].lower() + sentence.removesuffix(".")[1:]


def _worst(analysis: "Analysis") -> Sentence:
    """The largest oscillation with its speed and load torque."""
    largest = analysis.largest_oscillation()
    return Sentence("{} at {}{}.", Angle(largest.peak), words.largest_text(largest), words.equation_alone(analysis))


def _margin(analysis: "Analysis") -> Sentence:
    """Margin of the oscillation to its limit; "" without a limit."""
    part, limit = share(analysis), analysis.project.limit
    if part is None or limit is None:
        return Sentence("")
    where = "above" if part > 1.0 else "below"
    size, case = Angle(abs(part - 1.0) * limit), words.largest_of_all(analysis)[1]
    sentence = Sentence(f"Oscillation{case} {{}} ({{}}) {{}} its limit.", size, percent(abs(part - 1.0), 2), where)
    avoid = analysis.avoid
    if avoid is not None and avoid.largest_passed is not None and avoid.largest_passed[1] > limit:
        sentence += Sentence(RUN_UP, Angle(avoid.largest_passed[1]))
    return sentence


def _jumps(analysis: "Analysis") -> Sentence:
    """The speeds at which a slow run-up or run-down jumps, under every load torque."""
    sweeps = [drive.sweep for _, drive in analysis.curves]
    speeds = sorted({jump.value for sweep in filter(None, sweeps) for jump in (*sweep.on_run_up, *sweep.on_run_down)})
    if not speeds:
        return Sentence("No jumps in a slow run-up or run-down." if None not in sweeps else "")
    if len(speeds) > MOST_LISTED:
        return Sentence("Jumps in a slow run-up or run-down between {}.", Speed(speeds[0], speeds[-1], digits=5))
    every = listed(Sentence("{}", Speed(omega, digits=5, bare=True)) for omega in speeds) + " " + Speed()
    return Sentence("Jumps in a slow run-up or run-down at {}.", every)


def _change(analysis: "Analysis") -> Sentence:
    """The smallest change that makes a failing drive pass."""
    sentences = change_sentences(analysis, analysis.verdict, "{}; {}.")
    passes = analysis.verdict.answer is Answer.ALL_RIGHT and analysis.project.limit is not None
    return Sentence(" ").join(sentences) if sentences or not passes else Sentence("No change is needed.")
