"""`TunedLoop`: what `tune` returns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import expm1, isfinite, isnan
from typing import Any, ClassVar, NamedTuple, get_type_hints

import numpy as np

from ...base.facts import Fact
from ...base.number_text import number, percent, unit_text
from ...base.records import Labelled, Result
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...drive.sources import DriveUnit
from ...model.train.controls import HERTZ
from ...model.train.filters import apart
from .cost import CLIFF, GOALS, TuningLimits, TuningPoint
from .loop import with_control

LABELS = {"settling": "settling of the move", "move": "error in the move", "motor_rms": "rms motor torque"}


class GainSensitivity(NamedTuple):
    """Sensitivity of the measure to one gain: its relative change for a step up and a step down.

    None where the step breaks a limit or leaves the range; the measure is the geometric mean of the goals.
    """

    gain: str
    step: float
    up: float | None
    down: float | None

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return tuple(map(Fact, self._fields, self))


class GainCost(NamedTuple):
    """Largest cost of 5 % more or less of a gain: the gain, its change, the worse measure, before, after, its unit."""

    gain: str
    step: float
    measure: str
    before: float
    after: float
    unit: str

    def __str__(self) -> str:
        word = "more" if self.step > 0.0 else "less"
        ratio = self.after / self.before - 1.0
        much = f"{number(100.0 * ratio, 2)} % larger" if isfinite(ratio) else "unbounded"
        return f"{number(100.0 * abs(self.step))} % {word} {self.gain} makes {self.measure} {much}"


class NotchAdvice(NamedTuple):
    """A notch filter that makes the goals better: frequency [rad/s], width over it, depth, gains, the control."""

    frequency: float
    width: float
    depth: float
    point: TuningPoint
    control: Any


@dataclass(frozen=True, eq=False)
class TunedLoop(Result):
    """Gains of a loop that are best for a drive.

    Attributes
    ----------
    goals, gains : tuple of str
        Goals, which are made small, and the gains that are tuned.
    limits : TuningLimits
        Limits that hold.
    ranges : tuple of (float, float)
        Range of each gain that was searched.
    before, rule, recommended : TuningPoint
        The gains of the project, the symmetric optimum slowed down until it keeps the limits (else the nearest gains
        that do), and the recommended ones, with what they give.
    front : tuple of TuningPoint
        Gains that no other of those tried beats in all goals and in the peak sensitivity at once.
    binding : tuple of str
        Limits, and ends of the range of a gain, at which the recommended gains stand.
    sensitivities : tuple of GainSensitivity
        Changes of the goals by each gain.
    control : loop
        The loop with the recommended gains.
    response_before, response_after : DriveResponse or None
        Nonlinear response of the project with both, under the load with the largest oscillation; None where no motion
        is stable.
    computed : int
        Number of nonlinear responses and moves that were computed.
    notch : NotchAdvice or None
        A notch filter that makes the goals better, where one was asked for and does.
    remarks : tuple of str
        Assumptions.
    drive_units : tuple of DriveUnit
        Sizes of 1 of the drive's own parameters, where the file gives them.
    cost : GainCost or None
        Largest cost of a change of one gain by 5 %; None where nothing becomes worse.
    """

    goals: tuple[str, ...]
    gains: tuple[str, ...]
    limits: TuningLimits
    ranges: tuple[tuple[float, float], ...]
    before: TuningPoint
    rule: TuningPoint
    recommended: TuningPoint
    front: tuple[TuningPoint, ...]
    binding: tuple[str, ...]
    sensitivities: tuple[GainSensitivity, ...]
    control: Any
    response_before: DriveResponse | None
    response_after: DriveResponse | None
    computed: int
    notch: NotchAdvice | None = None
    remarks: tuple[str, ...] = ()
    drive_units: tuple[DriveUnit, ...] = ()
    cost: GainCost | None = None

    rows: ClassVar[str] = "point"

    def applied(self, project: Project, *, notch: bool = False) -> Project:
        """The project with the recommended loop, or with the one that has the notch filter."""
        tuned = with_control(project, self.notch.control if notch and self.notch else self.control)
        kept = tuple(f"motor.loop.{name}" for name in apart(tuned.whole and tuned.whole.motor.control)[1])
        changed = [s.name.startswith("motor.loop") and not s.name.startswith(kept) for s in project.sources]
        sources = [s._replace(word="yours") if new else s for s, new in zip(project.sources, changed, strict=True)]
        return replace(tuned, sources=tuple(sources))

    def variables(self) -> Labelled:
        """Gains, goals and peak sensitivity of the points on the front."""
        names = (*self.gains, *self.goals, "peak_sensitivity")
        units = [*(gain_unit(self.control, n) for n in self.gains), *(GOALS[n].unit for n in self.goals), "1"]
        table = np.array([(*p.gains, *p.goals, p.figures.peak_sensitivity) for p in self.front])
        return {name: ("point", table[:, i], units[i]) for i, name in enumerate(names)}

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of a tuning, once."""
        rows = (("file", self.before), ("rule", self.rule), ("recommended", self.recommended))
        stable = isfinite(self.before.figures.peak_sensitivity)
        broken = [name for name, used in self.before.used(self.limits).items() if used > 1.0]
        return (
            Fact("", " and ".join(GOALS[name].words for name in self.goals), "minimised (worst case): {}"),
            Fact("points", tuple((Fact("gains", name, "gains"), *self._row(p)) for name, p in rows), "{}"),
            Fact("unstable", not stable, "the present loop is unstable with the delay of the margins" * (not stable)),
            Fact("broken", tuple(broken), "the present gains violate the limit of the {}" if stable else ""),
            *self._in_drive_units(),
            Fact("binding", self.binding, "limit reached: {}"),
            Fact("sensitivities", tuple(change.facts() for change in self.sensitivities)),
            *(() if self.cost is None else self._cost(self.cost)),
            Fact("front", tuple(self._row(p) for p in self.front)),
            Fact("computed", self.computed),
            *(() if self.notch is None else self._notch(self.notch)),
            Fact("remarks", self.remarks, "note: {}"),
        )

    def _row(self, p: TuningPoint) -> tuple[Fact, ...]:
        """Gains, goals and figures of a point."""
        return (
            *(Fact(n, p.gains[i], f"{n} [{unit_text(gain_unit(self.control, n))}]") for i, n in enumerate(self.gains)),
            *(Fact(GOALS[n].key, v, LABELS.get(n, n)) for n, v in zip(self.goals, p.goals, strict=True)),
            Fact("peak_sensitivity", p.figures.peak_sensitivity, "peak sensitivity"),
            Fact("gain_margin", p.figures.gain_margin), Fact("phase_margin_rad", p.figures.phase_margin),
            *(Fact(GOALS[n].key, v, LABELS.get(n, n)) for n, v in self._beside(p)),
            Fact("disturbance_settling_s", p.figures.settling, "settling after a torque step"),
            Fact("motor_torque_N_m", p.motor_torque if isfinite(p.motor_torque) else None, "motor torque"),
        )  # fmt: skip

    def _beside(self, p: TuningPoint) -> Iterator[tuple[str, float | None]]:
        """Figures beside the goals: the same of every point, None where an unstable loop has none."""
        beside = {"pointing": p.pointing, "compliance": p.figures.compliance, "settling": p.move_settling}
        moves = not isnan(self.recommended.move_settling)
        for name, value in beside.items():
            if name not in self.goals and (moves or name != "settling"):
                yield name, value if isfinite(value) else None

    def _cost(self, cost: GainCost) -> Iterator[Fact]:
        """Numbers of the largest cost, and a sentence where it is a cliff."""
        yield from (Fact(f"cost.{key}", value) for key, value in cost._asdict().items())
        if cost.after > (1.0 + CLIFF) * cost.before:
            yield Fact("", str(cost), "{}")

    def _in_drive_units(self) -> Iterator[Fact]:
        """The recommended gains in the drive's own units, where the file gives their sizes."""
        gains = dict(zip(self.gains, self.recommended.gains, strict=True))
        values = {}
        for one in self.drive_units:
            if one.gain in gains and gain_unit(self.control, one.gain) == one.unit:
                values[one.gain] = gains[one.gain] / one.size
        if values:
            text = ", ".join(f"{gain} {number(value)}" for gain, value in values.items())
            yield Fact("in_drive_units", values)
            yield Fact("", text, "recommended, in the drive's own units: {}")

    def _notch(self, notch: NotchAdvice) -> tuple[Fact, ...]:
        """Numbers of the notch filter, and a sentence on what it changes."""
        change = np.mean(np.log(np.array(notch.point.goals) / np.array(self.recommended.goals)))
        before, after = self.recommended.figures.settling, notch.point.figures.settling
        sentence = (
            f"a notch filter at {number(notch.frequency / HERTZ)} Hz with "
            f"{gains_text(self.control, self.gains, notch.point.gains)} changes the goal by {percent(expm1(change), 2)}"
            f"; settling after a torque step {number(after)} s, without the filter {number(before)} s"
        )
        numbers = [("frequency_rad_per_s", notch.frequency), ("width_rad_per_s", notch.width * notch.frequency)]
        numbers += [("depth", notch.depth), *((fact.key, fact.value) for fact in self._row(notch.point))]
        return (*(Fact(f"notch.{key}", value) for key, value in numbers), Fact("", sentence, "{}"))


def gain_unit(control: Any, name: str) -> str:
    """Unit of a gain of the loop within a control."""
    return str(get_type_hints(type(apart(control)[0]), include_extras=True)[name].__metadata__[0])


def gains_text(control: Any, names: Sequence[str], gains: Sequence[float]) -> str:
    """Gains of a control with their units, in a row."""
    units = (unit_text(gain_unit(control, name)) for name in names)
    return ", ".join(f"{name} {number(gain)} {unit}" for name, gain, unit in zip(names, gains, units, strict=True))
