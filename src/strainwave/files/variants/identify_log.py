"""`identify_log`: the numbers of a joint from the logs of its two angles, and a project file with them."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.facts import Fact, lines
from ...base.number_text import unit_text
from ...base.quantities import number, shown
from ...base.results import Floats
from ...base.sentences import listed
from ...base.terminal import Progress, on_screen, silent
from ...base.units import ARCSEC, RPM
from ...drive.project import Project
from ...model.gears.catalogue import gear as gear_of
from ...model.laws.hysteresis import Parallel
from ...model.laws.springs import PiecewiseLinear
from ...study.identification.fitted import Fit
from ...study.identification.joint.answer import Answer, fit_joint, residuals_of
from ...study.identification.joint.estimates import Tie
from ...study.identification.joint.pieces import angles_of
from ...study.identification.log import Log
from ..logs.read import read_log
from .identified_project import identified_project

EXPLAINED_SHARE, SHARE_WITH_REST = 0.9, 0.98  # of the motion: to be explained, alone and beside a rest above scatter
UNITS = {
    "K1": "N*m/rad", "K2": "N*m/rad", "K3": "N*m/rad", "T1": "N*m", "T2": "N*m", "B": "N*m*s/rad",
    "coulomb": "N*m", "viscous": "N*m*s/rad", "gravity": "N*m", "hysteresis": "N*m/rad", "yield_twist": "rad",
    "load_friction": "", "load_inertia": "kg*m^2", "torque_constant": "N*m/A", "torque_scale": "",
    "motor_inertia": "kg*m^2", "motor_coulomb": "N*m", "motor_viscous": "N*m*s/rad", "motor_load_friction": "",
}  # fmt: skip
USUAL = 1.54, 1.79, 4.3e-4, 1.6e-3  # K2, K3, T1, T2 over K1: medians of the 179 laws of the catalogue
TOO_FAST = 3.0  # times the largest speed of the gear's input, in a tenth of a log: an angle of another unit
HELD = 0.5  # share of a moving load's readings that are the ones before


@dataclass(frozen=True, eq=False)
class IdentifiedLog(Fit):
    """A joint identified from its logs.

    Attributes
    ----------
    values, covariance, freedom, unidentified
        Of the numbers that the logs tell, as `value(name)` and `interval(name)` have them [SI]: K1, K2, K3, T1, T2, B,
        skew (the stamp of the motor's encoder less that of the load's), coulomb, viscous, load_friction, gravity,
        hysteresis (its stiffness) and yield_twist, line(j, k): an amplitude, j a turn of the motor and k of the load;
        by a motor's current or torque torque_constant or torque_scale, motor_inertia, motor_coulomb, motor_viscous and
        motor_load_friction, a share of the gear's torque; load_inertia, where a torque has weighed the load.
    tied : list of (tuple of str, str)
        Names that the logs do not part, and the move that would.
    explained : float
        Share of the torsion's motion that the model explains.
    causes : tuple of str
        Effects that the logs show and the model lacks, or that the load inertia given does not fit.
    project : Project or None
        The drive with the numbers found; None where they are not usable.
    answer : Answer
        The fit.
    """

    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    tied: list[Tie]
    explained: float
    causes: tuple[str, ...]
    project: Project | None
    answer: Answer

    by_logarithm: ClassVar[tuple[str, ...]] = (
        "K1", "K2", "K3", "T1", "T2", "B", "hysteresis", "yield_twist", "torque_constant", "motor_inertia",
        "load_inertia",
    )  # fmt: skip

    @property
    def usable(self) -> bool:
        """True where the model explains the logs so well that its numbers may be used."""
        return self.project is not None

    def _name(self, path: str) -> str:
        return super()._name(str(path).replace(",", ", ").replace("  ", " ").replace("( ", "("))

    def unit(self, name: str) -> str:
        """SI unit of a number."""
        return "s" if name.endswith("skew") else UNITS.get(name, "rad")

    def residuals(self, logs: Any) -> list[tuple[Floats, Floats]]:
        """Stamps [s] and measured less predicted angles of the load [rad] in other logs, for each piece without gaps.

        Only the start of each piece is fitted.
        """
        return residuals_of(self.answer, _logs(logs))

    def headline(self) -> str:
        """Sentence on the share of the motion that the model explains."""
        share = f"{100.0 * max(self.explained, 0.0):.{1 if self.explained < 0.99 else 2}f} % of the motion"
        lacks = ", which the model lacks" if all(cause.of_model for cause in self.answer.causes) else ""
        shows = f"The log shows {listed(self.causes)}{lacks}" if self.causes else ""
        if self.explained < EXPLAINED_SHARE:
            several = len({piece.log for piece in self.answer.joint.pieces}) > 1
            hints = f"{shows}." * bool(shows), "The logs may be of different joints: fit each alone." * several
            return " ".join([f"The model explains only {share}. Do not use its numbers.", *filter(None, hints)])
        if self.causes:
            return f"{shows}: it explains {share}."
        if self.answer.more:
            use = "" if self.explained >= SHARE_WITH_REST else " Do not use its numbers."
            more = f"{self.answer.more:.2g} times the readings' scatter is left"
            return f"Something outside of the model moves the load: it explains {share}, and {more}.{use}"
        if not self.answer.inertia_known:
            return f"Without the load's inertia or a torque no stiffness can be known; the model explains {share}."
        if not {"K1", "B"} & {*self.values}:
            return f"The log tells neither the stiffness nor the damping; the model explains {share}."
        return f"The model explains {share}."

    def quality(self) -> list[str]:
        """Sentences on what is left, and on what the logs do not tell."""
        left = self.answer.residual / ARCSEC, self.answer.scatter / ARCSEC
        sentences = [f"What is left is {left[0]:.3g} arcsec rms; the load's readings scatter by {left[1]:.3g} arcsec."]
        sentences += self.answer.notes
        return sentences + [f"The log does not separate {listed(tie)}; required: {move}." for tie, move in self.tied]

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of the joint, once, with the intervals of 95 %."""
        heads = ("number", "found", "from", "to", "unit")
        rows = [(name, value, *self.interval(name), unit_text(self.unit(name))) for name, value in self.values.items()]
        return (
            Fact("headline", self.headline(), "{}"), Fact("usable", self.usable), Fact("explained", self.explained),
            Fact("numbers", self.numbers()),
            Fact("", tuple(tuple(map(Fact, [""] * 5, row, heads)) for row in rows), "{}"),
            Fact("tied", [{"names": list(names), "takes": move} for names, move in self.tied]),
            Fact("causes", list(self.causes)), Fact("said", list(self.answer.notes)),
            Fact("residual_rms_rad", self.answer.residual), Fact("scatter_rad", self.answer.scatter),
            Fact("", tuple(self.quality()), "{}"),
        )  # fmt: skip

    def __str__(self) -> str:
        return on_screen("\n".join([f"IdentifiedLog: {len(self.values)} numbers", *lines(self.facts())]))

    __repr__ = __str__


def identify_log(
    logs: Any,
    gear: str | None = None,
    project: Project | None = None,
    load_inertia: float | None = None,
    *,
    torque_constant: float | None = None,
    progress: Progress = silent,
) -> IdentifiedLog:
    """Find the numbers of a joint in logs of its motor's and its load's angle, as they were recorded.

    The motor is held on its measured angle and the load runs freely behind the gear: three slopes, damping, hysteresis,
    gravity, friction that sticks, lines of both turns, and the skew of the two encoders' stamps are found together. A
    current or a torque then tells the motor's inertia and friction.
    Stamps may be uneven, rows may be missing; the load's angles are compared at their own stamps.

    Parameters
    ----------
    logs : path, Log, dict of str to array, or sequence of these
        Channels "time" [s], "motor_angle" and "load_angle" [rad], each on its own shaft; perhaps "current" [A] or
        "motor_torque" [N*m] of the motor, and "torque" [N*m] at the load.
    gear : str, optional
        Name of a gear of the catalogue: its numbers are the first guess, and stay where the log does not tell them.
    project : Project, optional
        The drive as far as it is known, instead of the gear.
    load_inertia : float, optional
        Inertia behind the gear [kg*m^2]. Default: the project's. Without one, or a torque that weighs the load, no
        stiffness can be known.
    torque_constant : float, optional
        Torque of the motor per current [N*m/A]. Default: the project's. With the load's inertia it is found.
    progress : callable
        progress(stage, share): called before each stage.

    Returns
    -------
    IdentifiedLog
        `value(name)`, `interval(name, 0.95)`, `tied`, `explained`, `usable`, `project`.

    Raises
    ------
    ValueError
        If a channel is missing, the angles are not those of the gear, or nothing moves.
    SolveError
        If the motion leaves every bound from the first numbers.

    References
    ----------
    Ljung 1999, System Identification, 2nd ed., ch. 7 (output error); Bouc 1967 and Wen 1976 (hysteresis).
    """
    if (gear is None) == (project is None):
        raise ValueError("give the gear's name or a project, one of the two: gear='CSG-25-100'")
    inertia = None if load_inertia is None else number("load_inertia [kg*m^2]", load_inertia, positive=True)
    constant = None if torque_constant is None else number("torque_constant [N*m/A]", torque_constant, positive=True)
    if project is not None:
        law, ratio, record = _slopes(project), project.drive.N, project.gear
        inertia = project.subject.load.J if inertia is None else inertia
        sheet = project.motor_limits
        constant = sheet.K_t if constant is None and sheet is not None and np.isfinite(sheet.K_t) else constant
    else:
        record = gear_of(str(gear))
        law, ratio = _slopes(record), record.ratio
    records = _logs(logs)
    _refuse_fast(records, None if record is None else record.max_speed)
    answer = fit_joint(records, ratio, law, inertia, constant, progress)
    causes = (*(cause.text for cause in answer.causes), *(_held(records) if answer.explained < EXPLAINED_SHARE else ()))
    fit = answer.estimates
    least = SHARE_WITH_REST if answer.more else EXPLAINED_SHARE
    enough = project is not None or {"K1", "B"} & {*fit.values}  # else nothing is known beside the catalogue
    usable = bool(not causes and answer.explained >= least and answer.inertia_known and enough)
    made = identified_project(answer, gear, project) if usable else None
    progress("identified", 1.0)
    return IdentifiedLog(
        fit.values, fit.covariance, fit.freedom, fit.unidentified, fit.tied, answer.explained, causes, made,
        answer,
    )  # fmt: skip


def _logs(logs: Any) -> list[Any]:
    """Logs, those that are paths read."""
    several = list(logs) if isinstance(logs, list | tuple) else [logs]
    if not several:
        raise ValueError("logs is empty; give one log at least")
    read = [read_log(one, trim=0.0) if isinstance(one, str | os.PathLike) else one for one in several]
    for one in read:
        if not (isinstance(one, Log) or hasattr(one, "keys")):
            raise TypeError(f"a log is a path, a Log or a dict of channels; this is {shown(one)}")
        if not isinstance(one, Log) and "time" not in one:
            raise ValueError(f"log has no channel 'time'; it has {', '.join(map(str, one))}")
    return read


def _refuse_fast(logs: Sequence[Any], limit: float | None) -> None:
    """Refuse angles in which the motor turns far faster than the gear allows."""
    for i, log in enumerate(logs):
        angles = angles_of(log, i)
        speeds = np.abs(np.diff(angles.motor) / np.diff(angles.motor_time))
        speed = float(np.quantile(speeds, 0.9)) if len(speeds) else 0.0
        if limit is not None and speed > TOO_FAST * limit:
            fact = f"in log {i + 1} the motor turns at {speed / RPM:.4g} rpm, and the gear allows {limit / RPM:.4g} rpm"
            raise ValueError(f"{fact}; the angles seem to be in deg and were read in rad: give units")


def _slopes(of: Any) -> tuple[float, ...]:
    """K1, K2, K3, T1, T2 of a gear or a project, as a first guess.

    Of a law without three slopes K1 is its stiffness at rest, and the others are `USUAL`.
    """
    law = of.law if not isinstance(of, Project) else of.subject.law
    while isinstance(law, Parallel):
        law = law.first
    if isinstance(law, PiecewiseLinear):
        return law.K1, law.K2, law.K3, law.T1, law.T2
    K = float(law.stiffness(0.0))
    return K, *(part * K for part in USUAL)


def _held(logs: Sequence[Any]) -> list[str]:
    """A load's angle that repeats its readings though the motor turns."""
    causes = []
    for i, log in enumerate(logs):
        channels = log.channels if isinstance(log, Log) else log
        motor, load = (np.diff(np.asarray(channels[name], float)) for name in ("motor_angle", "load_angle"))
        moving = motor != 0.0
        if np.any(moving) and np.mean(load[moving] == 0.0) > HELD:
            causes.append(f"readings of load_angle in log {i + 1} that are held (most are those before)")
    return causes
