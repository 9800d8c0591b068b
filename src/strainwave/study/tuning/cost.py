"""What gains cost: goals that shall be small and limits that hold, over all loads and units of a drive.

Gains come as logarithms. All is deterministic.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import inf, isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import numbers
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
from .open_loop import UNSTABLE, LoopFigures, OpenLoop

CRESTS, CREST_DISTANCE = 3, 0.1  # crests of a drive that are kept, and the least relative distance of their speeds
SHORTEST_S = 1e-4  # s: a move that is settled at its end counts as settled then
SETTLED_S = 1e-3  # s: shorter settling times of a move are equal, where no goal is one
STEP = 0.05  # of a gain, of its sensitivity
CLIFF = 0.2  # of a number, from which on a small change of a gain costs too much


class Goal(NamedTuple):
    """Goal, which shall be small: its words, its key in JSON with the unit, its unit; `of_move` for one of a move."""

    words: str
    key: str
    unit: str
    of_move: bool = False


GOALS = {
    "pointing": Goal("largest oscillation of the pointing error", "pointing_arcsec", "rad"),
    "compliance": Goal("largest compliance of the load over all frequencies", "compliance_rad_per_N_m", "rad/(N*m)"),
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
        late = self.settlings and [time / limit for time, limit in zip(self.settlings, limits.settlings, strict=False)]
        return {
            "peak sensitivity": peak / limits.peak_sensitivity if isfinite(peak) else inf,
            "gain margin": limits.gain_margin and (limits.gain_margin / gain if gain else inf),
            "phase margin": limits.phase_margin and (limits.phase_margin / phase if phase else inf),
            "motor torque": 0.0 if isnan(self.motor_share) else self.motor_share,
            "compliance": compliance / limits.compliance if isfinite(compliance) else inf,
            "settling after a torque": settling / limits.settling if isfinite(settling) else inf,
            "settling of the move": 0.0 if isnan(self.move_settling) else max(late, default=0.0),
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
        self.full = isfinite(motor.most) or motor.lasts  # True: torque of the motor and stability are computed
        self.with_move = False  # True: the move is computed where no goal or limit asks for it, too
        self.points: dict[tuple[bytes, bool, bool], TuningPoint] = {}
        self.computed = 0  # responses and moves

    @property
    def moved(self) -> bool:
        """True where moves are computed: a goal or a limit is one of them."""
        return self.of_move or bool(self.setting.limits.settlings) or (self.with_move and self.motions > 0)

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

    def point(self, x: Floats) -> TuningPoint:
        """All that gains give, also where they break a limit; computed once."""
        key = x.tobytes(), self.full, self.moved
        if key not in self.points:
            self.points[key] = self.evaluate(x) or self.linear(x)
        return self.points[key]

    def evaluate(self, x: Floats, surplus: Callable[[Floats], bool] | None = None) -> TuningPoint | None:
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
        begin, limits = 3 + self.motions, self.setting.limits.settlings  # column of the first goal; of the motions
        worst = np.full((len(self.drives), begin + len(self.setting.goals)), nan)
        for i in tuple(self.order):
            for left, row in self._rows(i, point):
                worst[i] = np.fmax(worst[i], row)
                last = i == self.order[-1] and not left
                if not surplus or self.setting.share < 1.0 or last:
                    continue
                if (limits and np.any(row[3:begin] > limits)) or surplus(np.fmax.reduce(worst)[begin:]):
                    self._move_to_front(i)
                    return None
        torque, share, pointing, *of_moves = self._share_of_units(worst).tolist()
        times, goals = of_moves[: self.motions], of_moves[self.motions :]
        return TuningPoint(point.gains, tuple(goals), point.figures, torque, share, pointing, tuple(times))

    def sturdy(self, x: Floats, wholly: bool = False) -> bool:
        """True where no gain, 5 % more or less, costs compliance or settling (`wholly`: or goals) more than 20 %."""
        costs = self.costs(x, self.point if wholly else self.linear)
        return all(cost.ratio <= 1.0 + CLIFF for cost in costs)

    def costs(self, x: Floats, of: Callable[[Floats], TuningPoint]) -> Iterator[WorseMeasure]:
        """Measures, from the points `of` gives, that become worse where a gain is 5 % more or less."""
        base = of(x).measures(self.setting.goals)
        for i, change, step in small_steps(x):
            after = of(x + step).measures(self.setting.goals)
            for name, (value, unit) in base.items():
                worse, _ = after[name]
                if worse > value > 0.0:
                    yield WorseMeasure(worse / value, i, change, name, value, worse, unit)

    def _exceeds_at_crests(self, point: TuningPoint, surplus: Callable[[Floats], bool]) -> bool:
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

    def _rows(self, i: int, point: TuningPoint) -> Iterator[tuple[int, Floats]]:
        """Number of rows that are left; torque of the motor, its share, goals: in a move, and under each load.

        The move comes first where a goal is one of it, else last.
        """
        control, cases = self.control(np.log(point.gains)), self.loaded[i]
        if self.of_move:
            self.computed += 1
            yield len(cases), self._move_figures(with_control(self.drives[i], control))
        late, unknown = self.moved and not self.of_move, [nan] * self.motions
        for k, case in enumerate(cases):
            torque, share, largest = nan, nan, nan
            if "pointing" in self.setting.goals or self.full:
                self.computed += 1
                torque, share, largest = self._speed_figures(with_control(case, control), (i, k))
            goals = self._goal_values(pointing=largest, compliance=point.figures.compliance)
            yield len(cases) - k - 1 + late, np.array([torque, share, largest, *unknown, *goals])
        if late:
            self.computed += 1
            yield 0, self._move_figures(with_control(self.drives[i], control))

    def _speed_figures(self, drive: Project, case: tuple[int, int]) -> tuple[float, float, float]:
        """Largest torque of the motor [N*m], its share, nan where not computed; largest oscillation [rad]."""
        train, speeds = drive.train, drive.speeds.limits
        if train is not None and self.harmonics is not None:
            top = top_of(train, speeds, self.harmonics, False)
            if top:
                self._keep_crest(top, case)
            if not self.full:
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

    def _move_figures(self, drive: Project) -> Floats:
        try:
            run = move(drive)
        except SolveError:
            return np.full(3 + self.motions + len(self.setting.goals), inf)
        times = [inf if time is None else max(time, SHORTEST_S) for time in run.settling_times]
        share = max([0.0, *(finding.value / finding.bound for finding in run.findings if finding.limit in (PEAK, RMS))])
        goals = self._goal_values(move=run.peak_error, settling=max(times), motor_rms=run.rms_motor_torque)
        return np.array([run.peak_motor_torque, share, nan, *times, *goals])

    def _share_of_units(self, units: Any) -> Floats:
        """Worst values of a share of the units."""
        return np.asarray(np.quantile(np.array(units), self.setting.share, axis=0, method="higher"))


def gains_of(x: Floats) -> tuple[float, ...]:
    """Gains of these logarithms, as numbers of seven digits that a file can hold."""
    return tuple(float(f"{gain:.7g}") for gain in np.exp(x))


def small_steps(x: Floats) -> list[tuple[int, float, Floats]]:
    """Gains by their numbers, with a change up and down, and its step of logarithms."""
    return [(i, change, np.log1p(change) * row) for i, row in enumerate(np.eye(len(x))) for change in (STEP, -STEP)]


def loads_of(drive: Project, loads: Sequence[float] | None) -> list[Project]:
    """A drive under each of some loads; by default the ends and the middle of its range, or as it is."""
    low, high = drive.other_loads
    if loads is None and low == high:
        return [drive]
    torques = np.linspace(low, high, 3) if loads is None else numbers("loads [N*m]", loads)
    return [drive.under(float(torque)) for torque in torques]


def with_control(drive: Project, control: Any) -> Project:
    """A drive with another loop of its motor."""
    return replace(drive, subject=drive.subject.with_motor(control=control))


def _inverse(figures: Any) -> Floats:
    """Figures as numbers that are small when they are good, and back: margins are inverted."""
    with np.errstate(divide="ignore"):
        return np.array([figures[0], 1.0 / np.float64(figures[1]), 1.0 / np.float64(figures[2]), *figures[3:]])
