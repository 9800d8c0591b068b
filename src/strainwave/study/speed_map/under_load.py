"""A drive under one load of the map, and all its stable steady motions through the range of speeds."""

from collections.abc import Iterable
from dataclasses import replace
from math import gcd, inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from ...base.law import depends, is_linear
from ...base.number_text import number
from ...base.protocols import linear_part_of, orders_of
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence
from ...base.units import RPM
from ...drive.drive_response import DriveResponse
from ...drive.equation.left_out import left_out
from ...drive.jumps import doubled_spans
from ...drive.project import Project
from ...drive.state_space import state_space
from ...drive.steady import equation_curve, train_motions
from ...drive.train_curve import NO_MOTION, at_load, has_curve, refuse_free, without_gravity
from ...drive.two_turns import A_TURN, NONE_STABLE, beat_said
from ...model.oscillator import Oscillator
from ...model.train.drive_train import DriveTrain
from ...theory.slow_flow.setting import active_orders
from .error_equation import OperatingPoint, equation_orders, operating_point, quasi_static
from .intervals import Span, gaps
from .motions import OMEGA, LoadMotions, MotionCurve
from .rules import Rules
from .search import MotionStart, search

NO_RULES = Rules()
SPEED_STEP = 0.025  # relative distance of the speeds of the search
LARGE_SHARE = 0.99  # of a motion under another load
HIGHEST_HARMONIC = 100  # harmonic of an order that may still meet a resonance
BEAT_TEXT = (
    "the error {}, {} s at {} and {} s at {}; the oscillation is that of the "
    f"motor turn with the largest error; {A_TURN}"
)
UNSETTLED = (
    "simulations do not settle in the allowed steps (very light damping or a very stiff part); other periodic motions "
    "at the same speed may be missing"
)


class Case(NamedTuple):
    """A drive under one load: the load, its error equation with its operating point, and the whole train or None.

    `full_train` is that train also where the error equation is followed in its place, `held` whether its motor is held.
    """

    load: float
    equation: Any
    point: OperatingPoint
    train: DriveTrain | None
    full_train: DriveTrain | None = None
    held: bool = True

    @property
    def system(self) -> Any:
        """Integrated system: the error equation where that is the drive, or the whole train."""
        if self.train is None or (self.train.motor.held and not left_out(without_gravity(self.train))):
            return self.equation
        return at_load(self.train)

    @property
    def level(self) -> DriveTrain | None:
        """The train without gravity, whose motions repeat with every turn."""
        return self.train and without_gravity(self.train)

    @property
    def searched(self) -> bool:
        """True if motions beside the curve are looked for: not of a linear drive, nor of one that drifts."""
        train = self.train
        if train is not None and not train.motor.free and state_space(train, speed=train.omega).drifts:
            return False
        if self.system is self.equation:
            laws: tuple[Any, ...] = (self.equation.law,)
        else:
            part = linear_part_of(self.system)
            laws = () if part is None else part.laws
        linear = bool(laws) and all(map(is_linear, laws))
        return is_searched(self.equation) and not linear


def is_searched(equation: Any) -> bool:
    """True if damping and stiffness of an error equation are constant, and its excitation repeats with a turn."""
    return isinstance(equation, Oscillator) and not any(order % 1 for order in orders_of(equation))


def seeks_coexisting(law: Any) -> bool:
    """True if motions beside a curve are looked for: not with memory or a gap, where that takes most of the time."""
    return depends(law) == 1 and bool(law.stiffness(0.0) > 0.0)


def slowest_searched(case: Case) -> float:
    """Speed [rad/s] below which the drive follows its excitation: no harmonic that counts meets its resonance."""
    natural = sqrt(max(case.point.stiffness, 0.0) / case.equation.J)
    return natural / (HIGHEST_HARMONIC * max(equation_orders(case.equation), default=1))


def case_of(project: Project, load: float, span: Span) -> Case:
    """The drive of a project as it is, whose load is what the map calls `load`.

    Raises
    ------
    ValueError
        If the motor is free and the drive has parts that the error equation leaves out.
    SolveError
        If the law cannot carry the mean torque.
    """
    equation = project.system(0.5 * (span[0] + span[1]), reduced=True)
    point = operating_point(equation)
    train = project.train
    if train is not None:
        refuse_free(train)
        train = train._replace(omega=equation.omega) if has_curve(train) else None
    return Case(load, equation, point, train, project.whole if train is None else None, project.motor == "held")


def main_curve(case: Case, span: Span, level: float = inf) -> DriveResponse:
    """The curve of the drive from one end of the range to the other, in a beat with points at a level [rad].

    Raises
    ------
    SolveError
        If no stable periodic motion is found.
    """
    if case.train is not None:
        curve = train_motions(case.train, span, level, coexisting=False)
    else:
        others = seeks_coexisting(case.equation.law)
        curve = equation_curve(case.equation, span, level, case.full_train, coexisting=others, has_reference=case.held)
    if curve is None:
        raise SolveError(NO_MOTION)
    if curve.sweep is None:
        raise SolveError(NONE_STABLE if curve.curve.beat else NO_MOTION if len(curve.curve) else curve.message)
    return curve


def under_load(
    case: Case, span: Span, apart: float | None = SPEED_STEP, shift: float = 0.0, rules: Rules = NO_RULES,
    curve: DriveResponse | None = None,
) -> tuple[LoadMotions, tuple[MotionStart, ...]]:  # fmt: skip
    """All stable motions under a load; and the states that led to those apart from the main curve.

    Parameters
    ----------
    case : Case
        The drive under the load.
    span : (float, float)
        Range of speeds [rad/s].
    apart : float or None
        Relative distance of the speeds of the search; None leaves it out.
    shift : float
        Share of that distance by which the speeds are moved, so that those of many loads differ.
    rules : Rules
        A beat has points of its curve at their level.
    curve : DriveResponse, optional
        The main curve where it is known.

    Returns
    -------
    (LoadMotions, tuple of MotionStart)
        Where no motion is found there are no curves, and `remarks` says why.
    """
    slow = quasi_static(case.equation, case.point)
    try:
        response = curve or main_curve(case, span, rules.level(slow))
    except SolveError as error:
        return LoadMotions(case.load, (), slow, remarks=(str(error),)), ()
    every = gcd(*active_orders(case.equation)) or 1 if case.searched else 1
    loaded = motions_of_curve(response, slow, case.load, every)
    if response.curve.beat is not None:
        remarks = (*loaded.remarks, _beat(case.train or case.full_train, span), *filter(None, (response.rounding,)))
        loaded = replace(loaded, remarks=remarks)
    if apart is None or not case.searched:
        return loaded, ()
    speeds = search_speeds(loaded, span, apart, shift)
    return with_search_result(loaded, case, span, speeds[speeds >= slowest_searched(case)], ())


def motions_of_curve(response: DriveResponse, slow: float, load: float = 0.0, every: int = 1) -> LoadMotions:
    """The motions of one curve, whose drive oscillates by `slow` [rad] where it turns slowly.

    `every` is the number of times in a turn of the motor that what drives the motions repeats.
    """
    sweep = response.sweep
    remarks = () if response.status else (f"{response.curve.message}; a speed without a known motion is forbidden",)
    if sweep is None:
        return LoadMotions(load, (MotionCurve(response, every),), slow, remarks=remarks)
    up = [(float(jump.value), True, jump.after > jump.before) for jump in sweep.on_run_up]
    down = [(float(jump.value), False, jump.after > jump.before) for jump in sweep.on_run_down]
    return LoadMotions(
        load, (MotionCurve(response, every),), slow, jumps=(*up, *down),
        jumping=tuple((band.low, band.high) for band in sweep.jumping), flips=tuple(sweep.flips),
        doubled=doubled_spans(response.curve), remarks=remarks,
    )  # fmt: skip


def _beat(train: DriveTrain | None, span: Span) -> str:
    """Sentence on the length of a beat at both ends of a range."""
    turns, text = beat_said(train)
    ends = [end for w in span for end in (number(2.0 * pi * turns / w, 3), f"{number(w / RPM, 5)} rpm")]
    return Sentence(BEAT_TEXT, text, *ends)


def with_search_result(
    loaded: LoadMotions, case: Case, span: Span, speeds: Floats, seeds: tuple[MotionStart, ...]
) -> tuple[LoadMotions, tuple[MotionStart, ...]]:
    """The motions with those that random starts at some speeds and `seeds` lead to, and the starts that found them."""
    result = search(case, loaded.curves, speeds, seeds, span)
    loaded = replace(
        loaded, curves=(*loaded.curves, *result.curves), loose=(*loaded.loose, *result.loose),
        remarks=loaded.remarks if result.settled else (*loaded.remarks, UNSETTLED),
    )  # fmt: skip
    return loaded, result.seeds


def seeds_for(seeds: Iterable[MotionStart], loaded: LoadMotions, neighbour: LoadMotions) -> tuple[MotionStart, ...]:
    """Seeds of a load for its neighbour.

    Motions that no curve has lie at many speeds, and their seeds would add up from load to load: those near which the
    neighbour has one as large are left out.
    """
    if not neighbour.curves:
        return ()
    sizes = dict[float, float]()
    for one in loaded.loose:
        sizes[one.omega] = max(sizes.get(one.omega, 0.0), one.oscillation)

    def known(seed: MotionStart) -> bool:
        least = LARGE_SHARE * sizes.get(seed.omega, inf)
        close = (one for one in neighbour.loose if abs(one.omega - seed.omega) < SPEED_STEP * seed.omega)
        return any(one.oscillation > least for one in close)

    return tuple(seed for seed in seeds if not known(seed))


def search_speeds(loaded: LoadMotions, span: Span, apart: float, shift: float) -> Floats:
    """Speeds (n,) of the search: spread over the range, both ends, and where no stable motion is known."""
    steps = np.arange(np.log(span[1] / span[0]) / apart - shift)
    empty = [0.5 * (a + b) for a, b in gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, _ in loaded.runs], span)]
    return np.unique(np.concatenate([span, span[0] * np.exp(apart * (steps + shift)), empty]))
