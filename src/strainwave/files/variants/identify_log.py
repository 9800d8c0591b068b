"""`identify_log`: the numbers of a joint from the logs of its two angles, and a project file with them."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ...base.facts import Fact, lines
from ...base.number_text import unit_text
from ...base.quantities import number, shown
from ...base.results import Floats
from ...base.sentences import listed
from ...base.terminal import Progress, on_screen, silent
from ...base.units import ARCSEC, RPM
from ...drive.demands.motor_limits import MotorLimits
from ...drive.project import Project
from ...drive.sources import Source
from ...model.excitation import Harmonic, KinematicError, Line
from ...model.gears.catalogue import gear as gear_of
from ...model.laws.friction import Coulomb, LoadFriction, Viscous
from ...model.laws.hysteresis import BoucWen, Parallel
from ...model.laws.springs import PiecewiseLinear
from ...model.train.motion import AngleTorque
from ...study.identification.fitted import Fit
from ...study.identification.joint import solve
from ...study.identification.joint.answer import Answer, fit_joint, residuals_of
from ...study.identification.joint.estimates import Tie
from ...study.identification.joint.model import line_names
from ...study.identification.joint.pieces import angles_of
from ...study.identification.log import Log
from ..fields.groups import ASSUMED, MEASURED
from ..logs.read import read_log
from ..project_text import project_text
from ..reading import from_text

EXPLAINED_SHARE, SHARE_WITH_REST = 0.9, 0.98  # of the motion: to be explained, alone and beside a rest above scatter
UNITS = {
    "K1": "N*m/rad", "K2": "N*m/rad", "K3": "N*m/rad", "T1": "N*m", "T2": "N*m", "B": "N*m*s/rad",
    "coulomb": "N*m", "viscous": "N*m*s/rad", "gravity": "N*m", "hysteresis": "N*m/rad", "yield_twist": "rad",
    "load_friction": "", "load_inertia": "kg*m^2", "torque_constant": "N*m/A", "torque_scale": "",
    "motor_inertia": "kg*m^2", "motor_coulomb": "N*m", "motor_viscous": "N*m*s/rad", "motor_load_friction": "",
}  # fmt: skip
LAW = ("K1", "K2", "K3", "T1", "T2")
USUAL = 1.54, 1.79, 4.3e-4, 1.6e-3  # K2, K3, T1, T2 over K1: medians of the 179 laws of the catalogue
SURE = 3.4  # standard deviations that an amplitude of a line in the project is away from 0: a file takes 30 %
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
        Effects that the logs show and the model lacks.
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
        lacks = "" if self.causes and self.causes[0].startswith("that") else ", which the model lacks"
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
        return sentences + [f"The log does not part {listed(names)}: it takes {move}." for names, move in self.tied]

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
    causes = (*answer.causes, *(_held(records) if answer.explained < EXPLAINED_SHARE else ()))
    fit = answer.estimates
    least = SHARE_WITH_REST if answer.more else EXPLAINED_SHARE
    enough = project is not None or {"K1", "B"} & {*fit.values}  # else nothing is known beside the catalogue
    usable = bool(not causes and answer.explained >= least and answer.inertia_known and enough)
    made = _project(answer, gear, project) if usable else None
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
        time, motor, *_ = angles_of(log, i)
        speed = float(np.quantile(np.abs(np.diff(motor) / np.diff(time)), 0.9)) if len(time) > 1 else 0.0
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


def _project(answer: Answer, gear: str | None, given: Project | None) -> Project:
    """The project with the numbers found, and their scatter."""
    joint, values = answer.joint, answer.estimates.values
    kept = {name: joint.scales[name].first for name in (*LAW, "B") if name not in values}  # what the logs do not tell
    v, speeds = joint.values | kept, np.abs(np.concatenate([piece.motor_rate for piece in joint.pieces]))
    if given is None:
        top = float(np.max(speeds))
        given = from_text(
            f"gear: {gear}\nmotor: {{mode: held}}\nload: {{inertia: {v['inertia']!r} kg*m^2}}\n"
            "damping: {quality: 20}\n"
            f"speed: {{from: {0.05 * top!r} rad/s, to: {top!r} rad/s, shaft: motor}}\n"
            "excitation: {kinematic_error: [{order: 2, amplitude: 1 arcsec}]}\n",
            Path("identified.yaml"),
        )
    law: Any = PiecewiseLinear(v["K1"], v["K2"], v["K3"], v["T1"], max(v["T2"], v["T1"]))
    if v["hysteresis"]:
        law = Parallel(law, BoucWen(v["hysteresis"], 0.0, v["yield_twist"]))
    lines = [Line(j + k / joint.ratio, *_wave(v, line_names((j, k)))) for j, k in joint.lines]
    sizes = {pair: line for pair, line in zip(joint.lines, lines, strict=True) if _certain(answer, pair)}
    error = KinematicError(tuple(sizes.values())) if sizes else given.subject.error
    size, phase = _wave(v, ("gravity_sin", "gravity_cos"))
    drag = _with_friction(AngleTorque(size, 1, -phase), values, "")
    pulled = {"excitation": Harmonic(0.0, mean=-v["gravity_mean"])} if v["gravity_mean"] else {}
    B = v["B"] if "B" in values else given.subject.B
    train = given.subject.with_load(J=v["inertia"], drag=drag, **pulled)._replace(law=law, B=B, error=error)
    if values.get("motor_inertia", 0.0) > 0.0:
        train = train.with_motor(J=values["motor_inertia"])
    if (friction := _with_friction(None, values, "motor_")) is not None:
        train = train.with_motor(drag=friction)
    if v["load_friction"] > 0.0:
        train = train._replace(friction=LoadFriction(v["load_friction"]))
    measured = {"gear": {*LAW} & {*values}, "damping": {"B"} & {*values}}
    sources = (*given.sources, *(Source(name, "", MEASURED) for name, numbers in measured.items() if numbers))
    if gear is not None and not sizes:
        sources += (Source("excitation.kinematic_error", "", ASSUMED),)
    limits = given.motor_limits
    if "torque_constant" in values:
        limits = (limits or MotorLimits())._replace(K_t=values["torque_constant"])
    scatter, correlation = _scatter(answer, list(sizes))
    spread = {"scatter": scatter, "correlation": correlation}
    better = replace(given, subject=train, sources=sources, motor_limits=limits, **spread)
    return from_text(project_text(better), given.path)


def _with_friction(law: Any, values: dict[str, float], shaft: str) -> Any:
    """A law, or None, with the dry and viscous friction that was found of a shaft."""
    for name, kind in (("coulomb", Coulomb), ("viscous", Viscous)):
        if values.get(shaft + name, 0.0) > 0.0:
            part = kind(values[shaft + name])
            law = part if law is None else Parallel(law, part)
    return law


def _scatter(answer: Answer, lines: Sequence[tuple[int, int]]) -> tuple[Any, Any]:
    """Deviations of the numbers that were found, relative, by their names in the file, and their correlation."""
    names = {name: f"gear.law.{name}" for name in LAW}
    names |= {"B": "damping.B", "motor_inertia": "motor.inertia"}
    names |= {f"line({j}, {k})": f"excitation.kinematic_error.{i}.amplitude" for i, (j, k) in enumerate(lines)}
    fit, values = answer.estimates, list(answer.estimates.values)
    indices = [values.index(name) for name in names if name in values]
    part = fit.covariance[np.ix_(indices, indices)]
    size = np.sqrt(np.diag(part))
    rows = [(names[values[i]], float(sd / fit.values[values[i]])) for i, sd in zip(indices, size, strict=True)]
    return tuple(rows), tuple(map(tuple, (part / np.outer(size, size)).tolist())) if len(indices) > 1 else None


def _wave(values: dict[str, float], names: Sequence[str]) -> tuple[float, float]:
    """Amplitude and phase of a cosine and a sine: amplitude cos(angle + phase)."""
    a, b = (values[name] for name in names)
    return float(np.hypot(a, b)), float(np.arctan2(-b, a))


def _certain(answer: Answer, pair: tuple[int, int]) -> bool:
    """True for a line that stands out of its scatter: other than order 2, which every gear has, as those looked for."""
    name, fit = f"line({pair[0]}, {pair[1]})", answer.estimates
    if name not in fit.values:
        return False
    index, least = list(fit.values).index(name), max(solve.SURE, solve.POWER_OF_TERM * len(answer.joint.weights))
    return bool(fit.values[name] ** 2 > fit.covariance[index, index] * (SURE**2 if pair == (2, 0) else least))
