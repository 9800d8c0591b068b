"""`tune`: gains of the motor's loop that are best for a drive, from classical rules on, with what binds them."""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from math import inf, isfinite, pi
from typing import Any

import numpy as np

from ...base.number_text import number
from ...base.quantities import choice
from ...base.quantities import number as checked_number
from ...base.results import Floats, SolveError
from ...base.sentences import listed
from ...base.terminal import silent
from ...drive.demands.motor_limits import MotorLimits
from ...drive.drive_response import DriveResponse
from ...drive.operating_point import refuse_overload
from ...drive.project import Project
from ...model.train.controls import SpeedLoop
from ...model.train.filters import NotchFilter
from .cost import GOALS, SETTLED_S, Extras, Trial, TuningLimits, TuningPoint, TuningTask
from .loop import STEP, Loop, loads_of, rule, small_steps, with_control
from .result import GainCost, GainSensitivity, NotchAdvice, TunedLoop, gains_text
from .search import COARSE, WORTH, Search, front, least_broken

ASSUMED_DELAY_S = 0.5e-3  # s: delay of a loop where the file gives neither a lag nor samples
SPAN = 10.0  # times the gains of the rule and of the file, up and down; squared of those that go with the frequency
SLOWER = np.geomspace(1.0, 1e3, 121)  # times the sum of lags and delays, of the rule
MARGINS = ("peak sensitivity", "gain margin", "phase margin")
BINDING_SHARE = 0.97  # share of a limit from which on it binds
NOTCH_WIDTH, NOTCH_DEPTH = 0.5, 0.1  # width over the frequency, and depth
NOTCH_GAIN = 0.01  # of the measure: a notch that gains less is not offered
USUAL_SENSITIVITY = 2.0  # largest peak sensitivity where no margin is given
WHOSE = "the gains of the file", "those of the rule", "the recommended gains"
NO_NOTCH = "A notch filter at the resonance with a free motor does not improve the goals."
SLACK = 1.015  # times the compliance and settling of the file, where no goal is given
STABILITY, EVERYTHING = Extras(motor=True), Extras(motor=True, move=True)
NOTHING = 1e-12  # rad, s, N*m: a goal that rounding makes


def tune(
    project: Project,
    *,
    goals: Sequence[str] | None = None,
    gains: Sequence[str] | None = None,
    peak_sensitivity: float | None = None,
    gain_margin: float | None = None,
    phase_margin: float | None = None,
    loads: Sequence[float] | None = None,
    units: Sequence[Project] = (),
    share: float = 1.0,
    delay: float | None = None,
    notch: bool = False,
    progress: Callable[[str, float], None] = silent,
) -> TunedLoop:
    """Find the gains of the motor's loop that make what is named small, while margins and the motor's torque hold.

    Points spread over a box about the symmetric optimum, the gains of the file among them, are compared by the
    nonlinear response of the drive; from the best ones gains are changed as long as it helps. In the end no change of
    one or two gains by 2, 5 or 20 % within the limits and the range makes the measure 1 % better. Without `goals` the
    pointing error is made small: compliance, settling after a torque on the load and settling of each motion of the
    project's move stay within 2 % of those of the project's loop, or of the rule where that loop is unstable or
    assumed, and gains of which 5 % more or less cost more than 20 % are not taken. The margins are those of the linear
    loop about the mean torques at the middle speed. No result is worse than the rule, slowed to keep the limits.

    Parameters
    ----------
    project : Project
        With a loop of the motor, and with a move where a goal is one of it.
    goals : sequence of str, optional
        Goals to make small: "pointing" (largest oscillation of the pointing error over the speeds, of the nonlinear
        response), "compliance" (largest deviation of the load over a torque on it, at any frequency), and of the move
        of the project "move" (largest pointing error), "settling" (longest time of its motions) and "motor_rms"
        (torque). Of several the geometric mean counts. Default: "pointing", with compliance and settling no worse.
    gains : sequence of str, optional
        Names of the gains to change, as "K_p". Default: all of the loop that are not 0.
    peak_sensitivity : float, optional
        Largest |1/(1 + L)|. Default: 2 where no margin is given, which implies gain margin 2 and phase margin 29 deg.
    gain_margin, phase_margin : float, optional
        Least factor of the gain, and least phase [rad].
    loads : sequence of float, optional
        Torques [N*m] on the load. Default: the ends and the middle of those of the project. A move has its own.
    units : sequence of Project
        More drives with the same gains, such as `sw.sample` draws them by the scatter of the file. They and the project
        have every posture of the project.
    share : float
        Share of all drives, in (0, 1], for which each goal and each limit by itself holds; 1 for the worst of them.
    delay : float, optional
        Delay [s] of the loop beside its lag, in the margins alone. Default: that of the project's controller, or 0.5 ms
        where the file gives neither a lag nor a controller.
    notch : bool
        True to try a notch filter at the resonance with the motor free, with gains of its own.
    progress : callable
        progress(stage, share): called before each stage.

    Returns
    -------
    TunedLoop
        `recommended` gains and those on the `front` (in SI; goals in rad, s, N*m as `goals` names them), what binds,
        sensitivities, and the responses before and after.

    Raises
    ------
    ValueError
        If the motor has no loop, a goal or a gain is not known, or no gains keep the limits: by how much they miss.

    References
    ----------
    Modelica library DriveControl, user's guide, speed and position controller (symmetric optimum with a = 2 after
    Schröder, Elektrische Antriebe: Regelung von Antriebssystemen, 2009; position gain for a damping ratio of 1).
    """
    bounds = {"peak_sensitivity": peak_sensitivity, "gain_margin": gain_margin, "phase_margin [rad]": phase_margin}
    for name, bound in (*bounds.items(), ("share", share)):
        if bound is not None:
            checked_number(name, bound, positive=True)
    if share > 1.0:
        raise ValueError(f"share is {share:g}; it is a fraction of the drives, above 0 and at most 1")
    for name, some in (("loads", loads), ("gains", gains), ("goals", goals)):
        if some is not None and not len(some):
            raise ValueError(f"{name} is empty; give one or more, or omit it")
    if peak_sensitivity is None:
        peak_sensitivity = USUAL_SENSITIVITY if gain_margin is phase_margin is None else inf
    motor = project.motor_limits or MotorLimits()
    limits = TuningLimits(peak_sensitivity, gain_margin or 0.0, phase_margin or 0.0, motor)
    loop = Loop(project, gains)
    if notch and isinstance(loop.core, SpeedLoop) and loop.core.K_d:
        raise ValueError("a loop with K_d cannot have a filter: remove K_d, or tune without a notch")
    time, remarks = _delay(project, loop.lag, delay)
    drives = _drives(project, units, loop)
    if project.postures:
        remarks = (*remarks, f"The same gains are tuned for all {len(project.postures)} postures of the project.")
    named, samples = _goal_names(project, ("pointing",) if goals is None else goals), project.sampling
    setting = TuningTask(loads, named, limits, share, time, samples if delay is None else None)
    progress("linear loops", 0.0)
    trial = Trial(drives, setting, loop.control)
    search, by_rule = _search(trial, loop)
    starts = [by_rule, of_file := loop.logs(loop.core)]
    if goals is None:
        both, whose = _baseline(trial, project, of_file, by_rule)
        search, remark = _limited_to_given(search, both, whose)
        remarks = (*remarks, remark)
    best = search.run(starts, progress)
    if goals is None and search.measure(best) == inf:
        search, remark = _with_margins_of(search, both[-1], whose, any(bounds.values()))
        remarks = (*remarks[:-1], remark)
        best = search.run(starts, progress)
    if not trial.motor_limited and search.measure(best) < inf and inf in trial.point(best, STABILITY).goals:
        # the search has not looked whether motions are stable: it does so now
        search = Search(trial, (search.low, search.high), search.reference, STABILITY, search.sturdy)
        best = search.run(starts, progress)
    if search.sturdy:
        best = search.sturdiest(best)
    if search.measure(best) == inf:
        raise ValueError(_goal_sentence(search, loop.names, trial.linear(of_file)))
    progress("before and after", 0.9)
    sensitivities = tuple(_sensitivities(search, best, loop.names))
    advice = _notched(search, loop, best) if notch else None
    dearest = max(trial.costs(best, lambda x: trial.point(x, EVERYTHING)), default=None)
    today, ruled, recommended = points = [trial.point(x, EVERYTHING) for x in (of_file, by_rule, best)]
    late = [whose for whose, point in zip(WHOSE, points, strict=True) if inf in point.settlings]
    if late:
        remarks = (*remarks, f"The move does not settle with {listed(late)}.")
    before, after = [_response(drives[: len(project.postures) or 1], loads, loop.control(x)) for x in (of_file, best)]
    ranges = tuple(zip(np.exp(search.low).tolist(), np.exp(search.high).tolist(), strict=True))
    return TunedLoop(
        goals=setting.goals, gains=loop.names, limits=trial.setting.limits, ranges=ranges, before=today, rule=ruled,
        recommended=recommended, front=front(search), binding=tuple(_binding(search, best, recommended, loop.names)),
        sensitivities=sensitivities, control=loop.control(best), response_before=before, response_after=after,
        computed=trial.computed, notch=advice, remarks=(*remarks, *([NO_NOTCH] if notch and advice is None else [])),
        drive_units=project.drive_units, cost=dearest and GainCost(loop.names[dearest.gain], *dearest[2:]),
    )  # fmt: skip


def _drives(project: Project, units: Sequence[Project], loop: Loop) -> tuple[Project, ...]:
    """The project and its units, each in every posture; ValueError where a unit has another loop."""
    if any(type(Loop(unit, loop.names).core) is not type(loop.core) for unit in units):
        raise ValueError("units have another kind of loop than the project; give units of the same loop")
    postured = [row.on(drive) for drive in (project, *units) for row in project.postures]
    return tuple(postured) or (project, *units)


def _goal_names(project: Project, goals: Sequence[str]) -> tuple[str, ...]:
    for name in goals:
        choice("goal", name, *GOALS)
        if GOALS[name].of_move and project.move is None:
            raise ValueError(f"the goal {name!r} needs a move, and the project has none; add the group 'move'")
    return tuple(dict.fromkeys(goals))


def _delay(project: Project, lag: float, given: float | None) -> tuple[float, tuple[str, ...]]:
    """Delay [s] in the margins beside the lag, and the remarks on it."""
    if given is None and project.sampling is not None:
        fact = "Margins are computed for the sampled loop, responses for the continuous loop."
        return project.sampling.lead, (fact,)
    if given is None and not lag:
        fact = f"for the margins, a delay of {number(1e3 * ASSUMED_DELAY_S)} ms is assumed"
        return ASSUMED_DELAY_S, (
            f"The project has neither a loop lag nor a controller: {fact}. Without delay the margins limit no gain.",
        )
    if given is not None and given < 0.0:
        raise ValueError(f"delay is {given:g} s; it must be zero or more")
    return checked_number("delay [s]", given or 0.0), ()


def _search(trial: Trial, loop: Loop) -> tuple[Search, Floats]:
    """The search about the rule, slowed down until it keeps the linear limits; else about the nearest gains that do."""
    times = SLOWER * ((loop.lag + trial.setting.delay) or ASSUMED_DELAY_S)
    series = [loop.logs(rule(loop.core, loop.inertia, time)) for time in times]
    start = next((x for x in series if trial.broken(x) <= 1.0), None)
    if start is None:
        start = least_broken(trial, min([*series, loop.logs(loop.core)], key=trial.broken))
        if trial.broken(start) > 1.0:
            raise ValueError(_linear_sentence(trial, start, loop.names))
    both, reach = [start, loop.logs(loop.core)], np.log(SPAN) * np.abs(loop.powers())
    box = np.min(both, axis=0) - reach, np.max(both, axis=0) + reach
    goals = trial.point(start).goals
    if nothing := [name for name, goal in zip(trial.setting.goals, goals, strict=True) if goal < NOTHING]:
        raise ValueError(f"the goal {nothing[0]!r} is 0 with any gains; add a kinematic error, or choose another goal")
    return Search(trial, box, np.array(goals)), start


def _baseline(trial: Trial, project: Project, of_file: Floats, by_rule: Floats) -> tuple[list[Floats], str]:
    """Gains than which nothing is to become worse, and whose they are."""
    if not isfinite(trial.linear(of_file).figures.peak_sensitivity):
        return [by_rule], "those of the symmetric optimum (the present loop is unstable)"
    assumed = any(s.word == "assumed" and not s.why and s.name.startswith("motor.loop") for s in project.sources)
    return [of_file, by_rule] if assumed else [of_file], "the present values"


def _limited_to_given(search: Search, given: Sequence[Floats], whose: str, sturdy: bool = True) -> tuple[Search, str]:
    """Limit compliance and settling to the least of the given gains: the search anew, and the sentence that says so."""
    trial = search.trial
    points = [trial.point(x, Extras(move=True)) for x in given]
    times = zip(*(p.settlings for p in points if isfinite(p.move_settling)), strict=True)
    limits = trial.setting.limits._replace(
        compliance=SLACK * min(p.figures.compliance for p in points),
        settling=SLACK * min(p.figures.settling for p in points),
        settlings=tuple(SLACK * max(min(some), SETTLED_S) for some in times),
    )
    trial.setting = trial.setting._replace(limits=limits)
    sentence = f"No goal is given: compliance and settling time are limited to 102 % of {whose}."
    return Search(trial, (search.low, search.high), search.reference, sturdy=sturdy), sentence


def _with_margins_of(search: Search, x: Floats, whose: str, asked: bool) -> tuple[Search, str]:
    """Allow the margins, compliance and settling of gains x, but no less margin than is asked: search and sentence."""
    trial = search.trial
    peak = trial.setting.limits.peak_sensitivity
    if not asked:
        peak = max(peak, (1.0 + 1e-9) * trial.linear(x).figures.peak_sensitivity)
    trial.setting = trial.setting._replace(limits=trial.setting.limits._replace(peak_sensitivity=peak))
    anew, sentence = _limited_to_given(search, [x], whose, False)
    return anew, (
        f"{sentence} Within all margins, no gains are robust to a change of 5 % in "
        f"one gain{'' if asked else f'; a peak sensitivity of {number(peak)} is accepted'}."
    )


def _linear_sentence(trial: Trial, x: Floats, names: tuple[str, ...]) -> str:
    """Sentence on a limit that no gains keep, and the excess."""
    point, limits = trial.linear(x), trial.setting.limits
    used = point.used(limits)
    name = max(used, key=lambda key: used[key])
    if used[name] == inf:
        for train in filter(None, (case.train for case in chain(*trial.loaded))):
            refuse_overload(train)
        return "no gains make the loop stable; reduce lag and delay, or raise the filter frequencies"
    field, bound, value, ratio = _margin_texts(name, limits, point)
    return (
        f"no gains meet the {name} of {bound}: with the nearest, {gains_text(trial.control(x), names, point.gains)}, "
        f"it is {value}, {number(100.0 * abs(ratio - 1.0), 3)} % {'above' if ratio > 1.0 else 'below'} the limit; "
        f"loosen {field}, or reduce lag and delay of the loop"
    )


def _margin_texts(margin: str, limits: TuningLimits, point: TuningPoint) -> tuple[str, str, str, float]:
    """Argument of a margin, its bound and its value with some gains as texts, and their ratio."""
    field = margin.replace(" ", "_")
    scale, unit = (180.0 / pi, "°") if margin == "phase margin" else (1.0, "")
    bound, value = scale * getattr(limits, field), scale * getattr(point.figures, field)
    return field, f"{number(bound)}{unit}", f"{number(value)}{unit}", value / bound if bound else inf


def _goal_sentence(search: Search, names: tuple[str, ...], today: TuningPoint) -> str:
    """Sentence on a goal that no gains reach, or on the excess of torque of the gains that need least of it."""
    limits = search.trial.setting.limits
    if isfinite(limits.compliance):
        name = max(MARGINS, key=today.used(limits).__getitem__)
        field, bound, value, _ = _margin_texts(name, limits, today)
        return (
            f"no gains meet the {name} of {bound} with the present compliance and settling time; the present {name} "
            f"is {value}; loosen {field}, or choose a goal, which removes the limits of compliance and settling"
        )
    goals, points = search.trial.setting.goals, search.computed.values()
    heavy = [point for point in points if 1.0 < point.motor_share < inf]
    if not heavy:
        tried = [point.goals for point in points if np.isfinite(point.figures.peak_sensitivity)]
        missed = next((name for i, name in enumerate(goals) if all(inf == g[i] for g in tried)), "")
        if missed == "settling":
            return "no gains tried make the move settle; use a wider settling window, or a dwell at the end"
        if missed and GOALS[missed].of_move:
            return "no gains tried make the drive follow the move; use a longer move"
        return "no gains within the limits give a stable steady motion in the speed range; use other speeds"
    least = min(heavy, key=lambda point: point.motor_share)
    return (
        "no gains tried meet both the margins and the motor's torque limit at every speed: the nearest, "
        f"{gains_text(search.trial.control(np.log(least.gains)), names, least.gains)}, require "
        f"{number(least.motor_torque)} N·m, {number(100.0 * (least.motor_share - 1.0), 3)} % above the limit; "
        "use a stronger motor or less load"
    )


def _sensitivities(search: Search, best: Floats, names: tuple[str, ...]) -> Iterator[GainSensitivity]:
    """Sensitivity of the measure to each gain; its sides are None where a limit is broken there."""
    values = [search.measure(best + step) - search.measure(best) for _, _, step in small_steps(best)]
    sides = [float(np.expm1(value)) if value < inf else None for value in values]
    yield from map(GainSensitivity, names, [STEP] * len(names), sides[::2], sides[1::2])


def _binding(search: Search, best: Floats, point: TuningPoint, names: tuple[str, ...]) -> Iterator[str]:
    control = search.trial.control(best)
    for limit, used in point.used(search.trial.setting.limits).items():
        if used >= BINDING_SHARE:
            yield limit
    for side, ends in (("lower", search.low), ("upper", search.high)):
        for name, x, end in zip(names, best, ends, strict=True):
            if abs(x - end) < np.log1p(STEP):
                yield f"{side} end of the range, {gains_text(control, (name,), (float(np.exp(end)),))}"


def _response(drives: Sequence[Project], loads: Sequence[float] | None, control: Any) -> DriveResponse | None:
    """Response of drives under the load with the largest oscillation; None where one has no stable motion."""
    try:
        cases = [case for drive in drives for case in loads_of(drive, loads)]
        responses = [with_control(case, control).response() for case in cases]
    except SolveError:
        return None
    return max(responses, key=lambda response: float(response.oscillation[response.top]))


def _notched(search: Search, loop: Loop, best: Floats) -> NotchAdvice | None:
    """The notch filter at the resonance of the free train, with gains of its own, where these are better by 1 %."""
    frequency, trial = max(loop.resonance for loop in search.trial.loops[0]), search.trial
    if not frequency:
        return None
    added = NotchFilter(frequency, NOTCH_WIDTH * frequency, NOTCH_DEPTH)
    with_notch = Trial(trial.drives, trial.setting, lambda x: loop.control(x, added))
    notched = Search(with_notch, (search.low, search.high), search.reference)
    x = notched.refine(notched.descend(least_broken(notched.trial, best), COARSE, WORTH))
    trial.computed += with_notch.computed
    if notched.measure(x) > search.measure(best) - NOTCH_GAIN:
        return None
    return NotchAdvice(frequency, NOTCH_WIDTH, NOTCH_DEPTH, with_notch.point(x, EVERYTHING), with_notch.control(x))
