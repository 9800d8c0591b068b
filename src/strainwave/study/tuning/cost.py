"""What gains cost: goals that shall be small and limits that hold, over all loads and units of a drive.

Gains come as logarithms. All is deterministic.
"""

from collections.abc import Callable, Iterator, Sequence
from math import inf, isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats, SolveError
from ...drive.demands.motor_limits import PEAK, RMS, MotorLimits
from ...drive.loops.linear_control import control_parts
from ...drive.project import Project
from ...drive.steady import drive_curve, top_of
from ...drive.train_curve import PEAK_POINTS, Crest
from ...drive.two_turns import BeatCrest
from ...model.controllers.closed_loop import Sampling
from ..move.move import move
from ..move.profiles import path_of
from .loop import gains_of, loads_of, small_steps, with_control
from .open_loop import UNSTABLE, LoopFigures, OpenLoop

CRESTS, CREST_DISTANCE = 3, 0.1  # crests of a drive that are kept, and the least relative distance of their speeds
SHORTEST_S = 1e-4  # s: a move that is settled at its end counts as settled then
SETTLED_S = 1e-3  # s: shorter settling times of a move are equal, where no goal is one
CLIFF = 0.2  # of a number, from which on a small change of a gain costs too much


class Goal(NamedTuple):
    """Goal, which shall be small: its words, its key in JSON with the unit, its unit; `of_move` for one of a move."""

    words: str
    key: str
    unit: str
    of_move: bool = False


GOALS = {
    "pointing": Goal("largest oscillation of the pointing error", "pointing_arcsec", "rad"),
    "compliance": Goal("largest compliance at the load over all frequencies", "compliance_rad_per_N_m", "rad/(N*m)"),
    "move": Goal("largest pointing error in the move", "move_arcsec", "rad", True),
    "settling": Goal("settling time of the move", "settling_time_s", "s", True),
    "motor_rms": Goal("rms torque of the motor in the move", "motor_rms_N_m", "N*m", True),
}


class TuningLimits(NamedTuple):
    """Limits that hold: largest sensitivity, least gain margin (a factor) and phase margin [rad], sheet of the motor.

    Where no goal is given, also the largest compliance [rad/(N*m)], and settling times [s] after a torque on the load
    and of each motion of the move.
    """

    peak_sensitivity: float = inf
    gain_margin: float = 0.0
    phase_margin: float = 0.0
    motor: MotorLimits = MotorLimits()
    compliance: float = inf
    settling: float = inf
    settlings: tuple[float, ...] = ()


class TuningPoint(NamedTuple):
    """Gains and what they give, over all loads the worst.

    Attributes
    ----------
    gains, goals : tuple of float
        Gains that are tuned, and goals, in SI; goals are infinite where no motion is stable.
    figures : LoopFigures
        Margins, compliance and settling of the linear loop.
    motor_torque : float
        Largest torque [N*m] of the motor at steady speeds, and in the move where it was computed; nan where neither
        was.
    motor_share : float
        Largest share of what the motor gives at each speed, peak and rms.
    pointing : float
        Largest oscillation [rad] of the pointing error; nan where it was not computed.
    settlings : tuple of float
        Settling time [s] of each motion of the move; empty or nan where it was not computed.
    """

    gains: tuple[float, ...]
    goals: tuple[float, ...]
    figures: LoopFigures
    motor_torque: float = nan
    motor_share: float = nan
    pointing: float = nan
    settlings: tuple[float, ...] = ()

    @property
    def move_settling(self) -> float:
        """Longest settling time [s] of the motions of the move; nan where it was not computed."""
        return max(self.settlings, default=nan)

    def used(self, limits: TuningLimits) -> dict[str, float]:
        """Share of every limit that is taken; above 1 it is broken."""
        peak, gain, phase, compliance, settling = self.figures
        limited = bool(limits.settlings) and not isnan(self.move_settling)
        late = zip(self.settlings, limits.settlings, strict=True) if limited else ()
        return {
            "peak sensitivity": _share_of_most(peak, limits.peak_sensitivity),
            "gain margin": _share_of_least(gain, limits.gain_margin),
            "phase margin": _share_of_least(phase, limits.phase_margin),
            "motor torque": 0.0 if isnan(self.motor_share) else self.motor_share,
            "compliance": _share_of_most(compliance, limits.compliance),
            "settling after a torque": _share_of_most(settling, limits.settling),
            "settling of the move": max((time / limit for time, limit in late), default=0.0),
        }

    def measures(self, goals: Sequence[str]) -> dict[str, tuple[float, str]]:
        """Measures that a change of gains may make worse, with their units: goals, compliance, settling."""
        of_goals = {GOALS[name].words: (value, GOALS[name].unit) for name, value in zip(goals, self.goals, strict=True)}
        return of_goals | {
            "compliance": (self.figures.compliance, "rad/(N*m)"),
            "settling after a torque": (self.figures.settling, "s"),
            "settling of the move": (max(self.move_settling, SETTLED_S), "s"),
        }


class TuningTask(NamedTuple):
    """Requirements of a tuning.

    Attributes
    ----------
    loads : sequence of float or None
        Torques [N*m] on the load of each drive; None for its own.
    goals : tuple of str
        Names of `GOALS`.
    limits : TuningLimits
        Limits that hold.
    share : float
        Share of the units for which each goal and each limit holds.
    delay : float
        Delay [s] of the loop beside its lag, in the margins.
    sampling : Sampling or None
        Samples of the controller, of whose loop the margins are; None of a continuous one.
    """

    loads: Sequence[float] | None
    goals: tuple[str, ...]
    limits: TuningLimits
    share: float
    delay: float
    sampling: Sampling | None = None


class WorseMeasure(NamedTuple):
    """Measure that a change of one gain makes worse: ratio, number of the gain, its change, measure, values, unit."""

    ratio: float
    gain: int
    step: float
    measure: str
    before: float
    after: float
    unit: str


class Extras(NamedTuple):
    """Figures that are computed beside those of goals and limits: torque of the motor with stability, and the move."""

    motor: bool = False
    move: bool = False


NO_EXTRAS = Extras()
Surplus = Callable[[Floats], bool]  # True for goals that are too large


class NonlinearFigures(NamedTuple):
    """Figures of motions with some gains, as `TuningPoint` has them; nan where they were not computed."""

    torque: float
    share: float
    pointing: float
    settlings: Floats
    goals: Floats


class Trial:
    """Trial of gains on the drives that one loop serves: the project, then other units of it, each under all its loads.

    Of units the worst counts, or of a share of them. Gains come as logarithms.
    """

    def __init__(self, drives: Sequence[Project], setting: TuningTask, control: Callable[[Floats], Any]) -> None:
        self.setting, self.control, self.drives = setting, control, drives
        self.loaded = [loads_of(drive, setting.loads) for drive in drives]
        self.loops = [
            [OpenLoop(case.train, setting.delay, setting.sampling) for case in cases if case.train]
            for cases in self.loaded
        ]
        self.order = list(range(len(drives)))  # numbers of the drives; those that refused gains last come first
        self.last: tuple[bytes, Any, dict[int, list[LoopFigures]]] = (b"", None, {})  # gains, control, by drive
        self.harmonics: int | None = None
        self.crests: dict[tuple[int, int], list[Any]] = {}  # of drive and load, with gains before
        motor, task = setting.limits.motor, drives[0].move
        self.motions = len(path_of(task.profile, task.start).motions()) if task and task.profile else 0
        self.of_move = any(GOALS[name].of_move for name in setting.goals)
        self.motor_limited = isfinite(motor.most) or motor.lasts
        self.points: dict[tuple[bytes, bool, bool], TuningPoint] = {}
        self.computed = 0  # responses and moves

    def extent(self, extras: Extras) -> Extras:
        """Extent of what is computed: what goals and limits need, and extras."""
        moved = self.of_move or bool(self.setting.limits.settlings) or (extras.move and self.motions > 0)
        return Extras(self.motor_limited or extras.motor, moved)

    def linear(self, x: Floats) -> TuningPoint:
        """The linear figures alone; goals are infinite."""
        units = [np.max(list(map(_inverse, self._figures(i, x))), axis=0) for i in range(len(self.drives))]
        figures = LoopFigures(*_inverse(self._share_of_units(units)).tolist())
        return TuningPoint(gains_of(x), (inf,) * len(self.setting.goals), figures)

    def broken(self, x: Floats) -> float:
        """Largest share of a limit of the linear loop that gains take; above 1 it is broken."""
        return max(self.linear(x).used(self.setting.limits).values())

    def fits(self, x: Floats) -> bool:
        """True where the linear loop of every drive that counts keeps the limits."""
        if self.setting.share < 1.0:
            return self.broken(x) <= 1.0
        for i in self.order:
            points = (TuningPoint((), (), figures) for figures in self._figures(i, x))
            if any(max(point.used(self.setting.limits).values()) > 1.0 for point in points):
                self._move_to_front(i)
                return False
        return True

    def _figures(self, i: int, x: Floats) -> list[LoopFigures]:
        """Figures of the loops of a drive, one for each load; those of the last gains are kept."""
        key = x.tobytes()
        if key != self.last[0]:
            control = self.control(x)
            self.last = key, (control_parts(control), control), {}
        _, parts, figures = self.last
        if i not in figures:
            figures[i] = [loop.figures(*parts) for loop in self.loops[i]]
        return figures[i]

    def _move_to_front(self, i: int) -> None:
        self.order.sort(key=lambda k: k != i)

    def point(self, x: Floats, extras: Extras = NO_EXTRAS) -> TuningPoint:
        """All that gains give, also where they break a limit; computed once."""
        key = x.tobytes(), *self.extent(extras)
        if key not in self.points:
            self.points[key] = self.evaluate(x, extras) or self.linear(x)
        return self.points[key]

    def evaluate(self, x: Floats, extras: Extras = NO_EXTRAS, surplus: Surplus | None = None) -> TuningPoint | None:
        """Worst figures of gains over all drives and loads.

        With `surplus`, a test of the goals so far, a search cuts short: goals are infinite where the linear loop breaks
        a limit, and the result is None once a settling limit is broken or `surplus` holds.
        """
        if surplus and not self.fits(x):
            return TuningPoint(gains_of(x), (inf,) * len(self.setting.goals), UNSTABLE)
        point = self.linear(x)
        if not isfinite(point.figures.peak_sensitivity):
            return point
        if surplus and self._exceeds_at_crests(point, surplus):
            return None
        limits = self.setting.limits.settlings
        unknown = NonlinearFigures(nan, nan, nan, np.full(self.motions, nan), np.full(len(self.setting.goals), nan))
        worst = [unknown] * len(self.drives)
        for i in tuple(self.order):
            for left, row in self._rows(i, point, self.extent(extras)):
                pairs: Any = zip(worst[i], row, strict=True)
                worst[i] = NonlinearFigures(*(np.fmax(before, new) for before, new in pairs))
                last = i == self.order[-1] and not left
                if not surplus or self.setting.share < 1.0 or last:
                    continue
                late = bool(limits) and np.any(row.settlings > limits)
                if late or surplus(np.fmax.reduce([of_drive.goals for of_drive in worst])):
                    self._move_to_front(i)
                    return None
        of_units = map(self._share_of_units, zip(*worst, strict=True))
        torque, share, pointing, times, goals = (values.tolist() for values in of_units)
        return TuningPoint(point.gains, tuple(goals), point.figures, torque, share, pointing, tuple(times))

    def sturdy(self, x: Floats, of: Callable[[Floats], TuningPoint]) -> bool:
        """True where no gain, 5 % more or less, costs a measure from the points `of` gives more than 20 %."""
        return all(cost.ratio <= 1.0 + CLIFF for cost in self.costs(x, of))

    def costs(self, x: Floats, of: Callable[[Floats], TuningPoint]) -> Iterator[WorseMeasure]:
        """Measures, from the points `of` gives, that become worse where a gain is 5 % more or less."""
        base = of(x).measures(self.setting.goals)
        for i, change, step in small_steps(x):
            after = of(x + step).measures(self.setting.goals)
            for name, (value, unit) in base.items():
                worse, _ = after[name]
                if worse > value > 0.0:
                    yield WorseMeasure(worse / value, i, change, name, value, worse, unit)

    def _exceeds_at_crests(self, point: TuningPoint, surplus: Surplus) -> bool:
        """True for a surplus of goals at the speed alone about which, with gains before, a drive oscillated most."""
        if self.of_move or self.setting.share < 1.0:
            return False
        control = self.control(np.log(point.gains))
        for i in tuple(self.order):
            for k, case in enumerate(self.loaded[i]):
                train, crests = with_control(case, control).train, self.crests.get((i, k), [])
                for crest in crests:
                    size = train and crest.size_of(train)
                    if size and surplus(self._goal_values(pointing=size, compliance=point.figures.compliance)):
                        self.computed += 1
                        self._move_to_front(i)
                        crests.sort(key=lambda other: other is not crest)
                        return True
        return False

    def _goal_values(self, **values: float) -> Floats:
        return np.array([values.get(name, 0.0) for name in self.setting.goals])

    def _rows(self, i: int, point: TuningPoint, extent: Extras) -> Iterator[tuple[int, NonlinearFigures]]:
        """Number of rows that are left, and a row of figures: in a move, and under each load.

        The move comes first where a goal is one of it, else last.
        """
        control, cases = self.control(np.log(point.gains)), self.loaded[i]
        if self.of_move:
            self.computed += 1
            yield len(cases), self._move_figures(with_control(self.drives[i], control))
        late, unknown = extent.move and not self.of_move, np.full(self.motions, nan)
        for k, case in enumerate(cases):
            torque, share, largest = nan, nan, nan
            if "pointing" in self.setting.goals or extent.motor:
                self.computed += 1
                torque, share, largest = self._speed_figures(with_control(case, control), (i, k), extent.motor)
            goals = self._goal_values(pointing=largest, compliance=point.figures.compliance)
            yield len(cases) - k - 1 + late, NonlinearFigures(torque, share, largest, unknown, goals)
        if late:
            self.computed += 1
            yield 0, self._move_figures(with_control(self.drives[i], control))

    def _speed_figures(self, drive: Project, case: tuple[int, int], motor: bool) -> tuple[float, float, float]:
        """Largest torque of the motor [N*m], its share, nan where not computed; largest oscillation [rad]."""
        train, speeds = drive.train, drive.speeds.limits
        if train is not None and self.harmonics is not None:
            top = top_of(train, speeds, self.harmonics, False)
            if top:
                self._keep_crest(top, case)
            if not motor:
                return nan, nan, top[1] if top else inf
        curve = train and drive_curve(train, speeds, harmonics=self.harmonics, coexisting=False, points=PEAK_POINTS)
        need = None if curve is None else curve.need()
        if curve is None or curve.motor is None or need is None:
            return inf, inf, inf
        self.harmonics = self.harmonics or curve.curve.coefficients.shape[1] // 2
        share = max(need.share(self.setting.limits.motor, limit) for limit in (PEAK, RMS))
        return curve.motor.torque, share, float(np.max(curve.oscillation[curve.curve.inside]))

    def _keep_crest(self, crest: Crest | BeatCrest, case: tuple[int, int]) -> None:
        """Keep a crest, which stands for those of about the same speed."""
        kept = self.crests.get(case, [])
        others = (other for other in kept if abs(np.log(other.speed / crest.speed)) > CREST_DISTANCE)
        self.crests[case] = [crest, *others][:CRESTS]

    def _move_figures(self, drive: Project) -> NonlinearFigures:
        try:
            run = move(drive)
        except SolveError:
            return NonlinearFigures(inf, inf, inf, np.full(self.motions, inf), np.full(len(self.setting.goals), inf))
        times = [inf if time is None else max(time, SHORTEST_S) for time in run.settling_times]
        share = max([0.0, *(finding.value / finding.bound for finding in run.findings if finding.limit in (PEAK, RMS))])
        goals = self._goal_values(move=run.peak_error, settling=max(times), motor_rms=run.rms_motor_torque)
        return NonlinearFigures(run.peak_motor_torque, share, nan, np.array(times), goals)

    def _share_of_units(self, units: Any) -> Floats:
        """Worst values of a share of the units."""
        return np.asarray(np.quantile(np.array(units), self.setting.share, axis=0, method="higher"))


def _share_of_most(value: float, most: float) -> float:
    """Share of a largest value that is taken."""
    return value / most if isfinite(value) else inf


def _share_of_least(margin: float, least: float) -> float:
    """Share of a least margin that is taken; none where no margin is asked."""
    unreached = inf if least else 0.0
    return least / margin if margin else unreached


def _inverse(figures: Any) -> Floats:
    """Figures as numbers that are small when they are good, and back: margins are inverted."""
    with np.errstate(divide="ignore"):
        return np.array([figures[0], 1.0 / np.float64(figures[1]), 1.0 / np.float64(figures[2]), *figures[3:]])
