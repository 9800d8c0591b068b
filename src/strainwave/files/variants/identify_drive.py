"""`identify_drive`: a project with the numbers that the log of its drive tells, and their scatter.

Which numbers of a project are free unless others are named: those that the torsion of a log's law tells. The torsion of
a gear from the angles of its two shafts.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.law import states_of, torque_of
from ...base.protocols import terms_of
from ...base.quantities import joined, parameters, shown
from ...base.results import Floats
from ...base.sentences import listed, on_screen, silent
from ...base.units import ARCSEC
from ...compile.tree import numbers
from ...drive.asked import Source
from ...drive.project import Project
from ...model.excitation import Harmonic, KinematicError
from ...model.train import DriveTrain, Held, Load
from ...study.identification.driven import Between
from ...study.identification.identified import Identified, channels_of, row_of
from ...study.identification.identify import identify
from ...study.identification.intervals import Interval
from ..fields.groups import MEASURED, MOST_OF_PHASE, MOST_SCATTER, Radians
from ..project_text import project_text
from ..reading import from_text
from .missing_orders import hidden, missing_lines
from .names import OF_SIGNAL, Places

POOR = 0.1  # of the motion: what the numbers may leave of it

STIFFNESSES = ("K", "K1", "K2", "K3", "yield_twist")  # numbers of a law that are free unless others are named
SEEN = 1e-3  # of the torque: what changing a number by its own size must change
HALVINGS = 60

Range = tuple[float, float]

LARGEST = 0.1  # of the load's turn, and
NO_MORE = 0.02  # rad: what a gear may twist


def with_torsion(channels: Mapping[str, Any], N: float) -> dict[str, Any]:
    """Channels with the torsion theta_m/N - theta_l [rad]; a load that turns against the motor is counted with it.

    Raises
    ------
    ValueError
        If an angle is missing, or the angles are not those of a gear of this ratio.
    """
    for name in ("motor_angle", "load_angle"):
        if name not in channels:
            raise ValueError(f"log has no channel {name!r}; it has {joined(channels)}: name the column of it")
    motor, load = [row_of("log", name, channels[name]) for name in ("motor_angle", "load_angle")]
    if motor.shape != load.shape:
        raise ValueError(f"log: motor_angle has {len(motor)} samples and load_angle {len(load)}; give equally many")
    finite = np.isfinite(motor) & np.isfinite(load)
    if np.count_nonzero(finite) < 2:
        raise ValueError("log: motor_angle and load_angle have no two samples in common; give both at the same times")
    sense = -1.0 if np.cov(motor[finite], load[finite])[0, 1] < 0.0 else 1.0
    torsion = motor / N - sense * load
    turned, twisted = float(np.ptp(load[finite])), float(np.ptp(torsion[finite]))
    if twisted > max(LARGEST * turned, NO_MORE):
        raise ValueError(
            f"log: motor_angle turns {np.ptp(motor[finite]):.4g} rad and load_angle {turned:.4g} rad, which is no gear "
            f"of ratio {N:g}; take the gear of the log, or give both angles on their own shafts"
        )
    return {**channels, "torsion": torsion}


def usual(places: Places, reach: Range, certain: Collection[str] = ()) -> tuple[list[str], list[str]]:
    """Names that are free unless others are given, and stiffnesses that a range of torsion [rad] does not determine.

    Stiffnesses of `certain` are determined whatever the range is.
    """
    free, fixed = stiffnesses(places, places.train, reach, certain)
    free.append("damping.B")
    if isinstance(places.train.error, KinematicError):
        for i in range(len(places.train.error.lines)):
            free += [f"kinematic_error.{i}.{field}" for field in ("amplitude", "phase")]
    return [*free, "torsion.offset"], fixed


def stiffnesses(
    places: Places, train: Any, reach: Range, certain: Collection[str] = ()
) -> tuple[list[str], list[str]]:  # fmt: skip
    """Names of a law's stiffnesses that a range of its torsion [rad] determines, and of the others."""
    free: list[str] = []
    fixed: list[str] = []
    for path, owner, field, value in numbers(train):
        name = places.name(path)
        if path.startswith("law.") and field in STIFFNESSES and isinstance(value, float) and name:
            matters = name in certain or hasattr(owner, "states") or _matters(owner, field, value, reach)
            (free if matters else fixed).append(name)
    return free, fixed


def _matters(law: Any, field: str, value: float, reach: Range) -> bool:
    """Whether a number of a spring changes its torque in a range of torsion."""
    x = np.linspace(*reach, 201)
    before, after = law.torque(x), law._replace(**{field: 1.5 * value}).torque(x)
    return bool(np.max(np.abs(after - before)) > SEEN * np.max(np.abs(before)))


def expected_range(train: Any, logs: Sequence[Mapping[str, Any]]) -> Range:
    """Least and largest torsion [rad] of the law in logs, from the load that the train holds.

    Two encoders tell the torsion up to a constant. It follows from the mean torque: gravity and other loads twist the
    gear to one side.
    """
    parts = [_twisted(train, log) for log in logs]
    return min(float(np.min(x)) for x in parts), max(float(np.max(x)) for x in parts)


def _twisted(train: Any, log: Mapping[str, Any]) -> Floats:
    """Measured torsion with the mean at which the law has the mean torque of the load."""
    x = np.asarray(log["torsion"], float)
    known = np.isfinite(x)
    time, motor = np.asarray(log["time"], float)[known], np.asarray(log["motor_angle"], float)[known]
    x = x[known]
    load, speed = motor / train.N - x, np.gradient(motor, time) / train.N
    drag = torque_of(train.load.drag, load, speed, (0.0,) * states_of(train.load.drag))
    pull = np.asarray(log["load_torque"], float)[known] if "load_torque" in log else train.load.excitation.torque(0.0)
    mean = float(np.mean(drag) - np.mean(pull)) + train.load.J * float(speed[-1] - speed[0]) / float(time[-1] - time[0])
    x = x - np.mean(x)

    def torque(shift: float) -> float:
        return float(np.mean(torque_of(train.law, x + shift, 0.0 * x, (0.0 * x,) * states_of(train.law))))

    size = float(np.ptp(x))
    while abs(torque(np.copysign(size, mean))) < abs(mean) and size < 1.0:
        size *= 2.0
    low, high = -size, size
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if torque(middle) < mean else (low, middle)
    return np.asarray(x + 0.5 * (low + high))


def found_range(fit: Identified, logs: Sequence[Mapping[str, Any]]) -> Range:
    """Least and largest torsion [rad] of the law in logs, by the offset and the kinematic error that were found."""
    offset = fit.value("x.offset") if "x.offset" in fit.names else 0.0
    parts = []
    for log in logs:
        motor = np.asarray(log["motor_angle"], float)
        parts.append(np.asarray(log["torsion"], float) - offset - fit.system.error.value(motor))
    return min(float(np.nanmin(x)) for x in parts), max(float(np.nanmax(x)) for x in parts)


@dataclass(frozen=True, eq=False)
class IdentifiedDrive:
    """A drive identified from its log.

    Attributes
    ----------
    project : Project
        The project with the numbers found; `scatter` and `scatter_correlation` have their uncertainty. Its loop,
        speeds and limits are those of the given one.
    found : Identified
        How the train with a held motor meets the log.
    names : tuple of str
        Free numbers by their names in the project file.
    remarks : tuple of str
        Sentences on what was kept as it was, and on what the scatter leaves out.
    """

    project: Project
    found: Identified
    names: tuple[str, ...]
    remarks: tuple[str, ...]

    def _path(self, name: str) -> str:
        if name not in self.names:
            raise ValueError(f"{shown(name)} was not free; found are {', '.join(self.names)}")
        return self.found.names[self.names.index(name)]

    def value(self, name: str) -> float:
        """Value [SI] of a number by its name in the file (ValueError)."""
        return self.found.value(self._path(name))

    def interval(self, name: str, level: float = 0.95) -> Interval:
        """Interval [SI] that covers a number with this probability, if the model is right (ValueError)."""
        return self.found.interval(self._path(name), level)

    def unit(self, name: str) -> str:
        """Unit of a number (ValueError)."""
        path = self._path(name)
        units = {p.path: p.unit for p in parameters(self.found.system)}
        return units[path] if path in units else OF_SIGNAL[path.rpartition(".")[2]]

    @property
    def unexplained(self) -> float:
        """What the numbers leave of the motion: root mean square of the residual over that of the torsion."""
        return float(self.found.rms[0] / self.found.size[0])

    @property
    def usable(self) -> bool:
        """Whether the model explains so much of the motion that its numbers may be used."""
        return self.unexplained <= POOR

    def headline(self) -> str:
        """What the model explains of the motion, before any number."""
        if self.usable:
            return f"The model explains {_percent(1.0 - self.unexplained)} % of the motion."
        explained = max(1.0 - self.unexplained, 0.0)
        return f"The model explains only {100.0 * explained:.0f} % of the motion. Do not use these numbers yet."

    def quality(self) -> list[str]:
        """Sentences on what the numbers leave, and on what was kept or left out."""
        return [self.headline(), *self.found.quality(), *self.remarks]

    def __str__(self) -> str:
        width = max(map(len, self.names))
        lines = [f"IdentifiedDrive: {self.project.title!r}, {len(self.names)} numbers", f"  {self.headline()}"]
        for name in self.names:
            low, high = self.interval(name)
            lines.append(f"  {name:<{width}}  {self.value(name):.6g}  (95 %: {low:.6g} to {high:.6g})")
        return on_screen("\n".join([*lines, *(f"  {line}" for line in self.quality()[1:])]))

    __repr__ = __str__


def identify_drive(
    project: Project,
    log: Any,
    free: Sequence[str] | None = None,
    *,
    between: Between = "band-limited",
    progress: Callable[[str, float], None] = silent,
) -> IdentifiedDrive:
    """Find numbers of a project from measured angles of the motor and the load.

    The motor is held on its measured angle, so that its loop need not be known. The kinematic error follows that
    angle: the phases of its lines belong to the zero of the motor's encoder. The load is rigid.

    Parameters
    ----------
    project : Project
        The drive as far as it is known: its numbers are the first guess, its law is the one that is fitted.
    log : Log, dict of str to array, or sequence of these
        Channels "time" [s], "motor_angle" [rad] and "load_angle" [rad]; "load_torque" [N*m], where it was measured. A
        load that turns against the motor is counted the other way round.
    free : sequence of str, optional
        Names of numbers in the project file, as a sweep and a scatter have them: "gear.K1", "damping.B",
        "load.inertia", "hysteresis.yield_twist", "excitation.kinematic_error.0.amplitude"; "torsion.offset" or
        "torsion.delay" [s]. Default: stiffnesses and yield twist as far as the motion tells them, damping, the lines of
        the kinematic error, and the offset of the torsion.
    between : {"band-limited", "linear", "held"}
        What the motor's angle does between samples, as `identify` takes it.
    progress : callable
        Told what is done, and which share of all.

    Returns
    -------
    IdentifiedDrive
        `project` with the numbers found; `value(name)` and `interval(name)` in SI; `unexplained`, the share of
        the motion that the model leaves.

    Raises
    ------
    ValueError
        If a channel is missing, the drive has parts that these angles do not tell, or numbers cannot be told apart.
    SolveError
        If the motion leaves every bound from the given numbers.
    """
    if project.loaded_error is not None:
        raise ValueError(
            "the kinematic error depends on torque or direction, and a log tells one amplitude of a line; write one"
        )
    train = _on_measured_motor(project)
    logs = [with_torsion(channels_of(one), train.N) for one in (log if isinstance(log, list | tuple) else [log])]
    if not logs:
        raise ValueError(f"log is {shown(log)}; give at least one log of the drive's angles")
    places = Places(project, train)
    inputs = {"reference": "motor_angle"}
    if "load_torque" in logs[0]:
        inputs["load.excitation"] = "load_torque"

    def fitted(first: DriveTrain, names: Sequence[str]) -> Identified:
        paths = [places.path(name) for name in names]
        return identify(first, logs, paths, inputs=inputs, outputs={"x": "torsion"}, between=between, progress=progress)

    remarks: list[str] = []
    names, fixed = usual(places, expected_range(train, logs)) if free is None else ([*free], [])
    fit = fitted(train, names)
    if free is None:
        reach = found_range(fit, logs)
        more = [name for name in stiffnesses(places, fit.system, reach)[0] if name in fixed]
        if more:
            names, fixed = usual(places, reach, {*names, *more})
            fit = fitted(fit.system, names)
            reach = found_range(fit, logs)
        if fixed:
            remarks.append(
                f"{listed(fixed)} was kept: a torsion of {reach[0]:.3g} to {reach[1]:.3g} rad does not reach it."
            )
    scaled = {"load.inertia", "load.excitation"}.isdisjoint((*names, *inputs))
    stiff = any(name.startswith(("gear.", "hysteresis.")) for name in names)
    if stiff and scaled and train.load == Load(train.load.J):
        kept = f"load.inertia was kept at {train.load.J:.4g} kg*m^2: without a torque of the load"
        remarks.append(f"{kept} a log does not tell it; stiffness and damping are in proportion to it.")
    remarks += _orders_left(fit, logs)
    scatter, correlation = _scatter(places, names, fit, remarks)
    known = filter(None, map(places.name, fit.names))
    sources = (*project.sources, *(Source(name, "", MEASURED) for name in known))
    better = replace(_with_numbers(project, fit.system), scatter=scatter, correlation=correlation, sources=sources)
    better = from_text(project_text(better), project.path)
    return IdentifiedDrive(better, fit, tuple(names), tuple(remarks))


def _percent(share: float) -> str:
    """Percentage with so many digits that what is missing to 100 is seen."""
    left = 100.0 - 100.0 * share
    return f"{100.0 * share:.{0 if left >= 1.0 else 1 if left >= 0.1 else 2}f}"


def _on_measured_motor(project: Project) -> DriveTrain:
    """The train of a project whose motor is held on a motion in time (ValueError)."""
    whole = project.whole
    if whole is None:
        raise ValueError(
            f"{project.path.name} has a damping or stiffness that varies, or speeds of a forcing; identify it without"
        )
    if not isinstance(whole.load, Load):
        raise ValueError(
            "load.coupling: two angles do not tell a coupling from the gear; measure between them and use sw.identify"
        )
    terms = terms_of(whole.load.excitation)
    if any(term.amplitude for term in terms):
        raise ValueError(
            "excitation.load_torque has lines over the motor's turn, which no log in time holds; measure load_torque"
        )
    mean = Harmonic(0.0, mean=float(sum(term.mean for term in terms)))
    motor = whole.motor._replace(control=Held(), excitation=Harmonic(0.0))
    return whole._replace(motor=motor, load=whole.load._replace(excitation=mean), omega=1.0)


def _orders_left(fit: Identified, logs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on orders of the motor's angle that the drive has and the file has not."""
    lines = missing_lines(fit, logs)
    sentences = []
    for in_reading, sentence in (
        (False, "The drive has a kinematic error of {}, which the file lacks."),
        (True, "What was read of the torsion repeats with {}: a sensor may have it, the gear has not."),
    ):
        orders = [line for line in lines if line.in_reading is in_reading]
        items = [f"{line.order:.4g} ({line.amplitude / ARCSEC:.3g} arcsec)" for line in orders]
        if items:
            plural = "s" if len(items) > 1 else ""
            sentences.append(sentence.format(f"order{plural} {listed(items)} of the motor's angle"))
    return sentences or hidden(fit)


def _scatter(
    places: Places, names: Sequence[str], fit: Identified, remarks: list[str]
) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[float, ...], ...] | None]:
    """Standard deviations by name, relative or of a phase [rad], and their correlations; what is left out is said."""
    deviation: Floats = np.sqrt(np.diag(fit.covariance))
    phases = np.array([path.endswith(".phase") for path in fit.names])
    size = np.where(phases, deviation, deviation / np.maximum(np.abs(fit.values), 1e-300))
    most = np.where(phases, MOST_OF_PHASE, MOST_SCATTER)
    of_drive = [not path.startswith(("x.", "reference.", "load.excitation.")) for path in fit.names]
    keep = [i for i in range(len(names)) if of_drive[i] and size[i] <= most[i]]
    wide = [names[i] for i in range(len(names)) if of_drive[i] and size[i] > most[i]]
    if wide:
        remarks.append(
            f"scatter leaves out {listed(wide)}: known to worse than {100 * MOST_SCATTER:g} % of itself, a phase to "
            f"worse than {MOST_OF_PHASE:g} rad."
        )
    if not keep:
        return (), None
    units = np.where(phases, deviation, np.copysign(deviation, fit.values))[keep]
    table = np.round(fit.covariance[np.ix_(keep, keep)] / np.outer(units, units), 9)
    np.fill_diagonal(table, 1.0)
    scatter = tuple((places.name(fit.names[i]), Radians(size[i]) if phases[i] else float(size[i])) for i in keep)
    return scatter, tuple(map(tuple, table.tolist())) if len(keep) > 1 else None


def _with_numbers(project: Project, system: Any) -> Project:
    """The project with law, damping, error, friction and load of a train."""
    parts = {name: getattr(system, name) for name in ("law", "B", "error", "friction")}
    train = project.subject.with_load(J=system.load.J, drag=system.load.drag)
    return replace(project, subject=train._replace(**parts))
