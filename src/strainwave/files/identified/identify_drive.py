"""`identify_drive`: a project with the numbers that the log of its drive tells, and their scatter."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...model.excitation import Harmonic, KinematicError
from ...model.train.controls import Held
from ...model.train.drive_train import DriveTrain
from ...model.train.shafts import Load
from ...numerics.driven.signal import Between
from ...quantities import parameters, shown
from ...results import Floats
from ...sentences import listed, on_screen
from ...study.analysis.runup import silent
from ...study.identification.channels import channels_of
from ...study.identification.identified import Identified
from ...study.identification.identify import identify
from ...study.identification.intervals import Interval
from ...study.identification.orders.order_scan import SHARE, order_scan
from ...study.identification.run import Run
from ...tree import numbers
from ...units import ARCSEC
from ..project import Project
from ..project_text import project_text
from ..reading import from_text
from ..schema import MOST_SCATTER
from .places import OF_SIGNAL, Places
from .torsion import with_torsion

STIFFNESSES = ("K", "K1", "K2", "K3", "yield_twist")  # numbers of a law that are free unless others are named
HIGHEST, CLEAR = 30.0, 5.0  # order looked for in the residual, and deviations from which on its amplitude is told
SEEN = 1e-3  # of the torque: what changing a number by its own size must change


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

    def quality(self) -> list[str]:
        """Sentences on what the numbers leave, and on what was kept or left out."""
        return [*self.found.quality(), *self.remarks]

    def __str__(self) -> str:
        width = max(map(len, self.names))
        lines = [f"IdentifiedDrive: {self.project.title!r}, {len(self.names)} numbers"]
        for name in self.names:
            low, high = self.interval(name)
            lines.append(f"  {name:<{width}}  {self.value(name):.6g}  (95 %: {low:.6g} to {high:.6g})")
        return on_screen("\n".join([*lines, *(f"  {line}" for line in self.quality())]))

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

    Raises
    ------
    ValueError
        If a channel is missing, the drive has parts that these angles do not tell, or numbers cannot be told apart.
    SolveError
        If the motion leaves every bound from the given numbers.
    """
    train = _on_measured_motor(project)
    logs = [with_torsion(channels_of(one), train.N) for one in (log if isinstance(log, list | tuple) else [log])]
    places = Places(project, train)
    remarks: list[str] = []
    names = tuple(_usual(places, logs, remarks) if free is None else free)
    paths = [places.path(name) for name in names]
    inputs = {"reference": "motor_angle"}
    if "load_torque" in logs[0]:
        inputs["load.excitation"] = "load_torque"
    found = identify(train, logs, paths, inputs=inputs, outputs={"x": "torsion"}, between=between, progress=progress)
    remarks += _orders_left(found, logs)
    scatter, correlation = _scatter(places, names, found, remarks)
    better = replace(_with_numbers(project, found.system), scatter=scatter, correlation=correlation)
    better = from_text(project_text(better), project.path)
    return IdentifiedDrive(better, found, names, tuple(remarks))


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
    terms = getattr(whole.load.excitation, "terms", ())
    if any(term.amplitude for term in terms):
        raise ValueError(
            "excitation.load_torque has lines over the motor's turn, which no log in time holds; measure load_torque"
        )
    mean = Harmonic(0.0, mean=float(sum(term.mean for term in terms)))
    motor = whole.motor._replace(control=Held(), excitation=Harmonic(0.0))
    return whole._replace(motor=motor, load=whole.load._replace(excitation=mean), omega=1.0)


def _usual(places: Places, logs: Sequence[Mapping[str, Any]], remarks: list[str]) -> list[str]:
    """Names that are free unless others are given; those that the motion does not tell are kept and said."""
    train = places.train
    reach = max(0.5 * float(np.ptp(one["torsion"][np.isfinite(one["torsion"])])) for one in logs)
    found: list[str] = []
    kept: list[str] = []
    for path, owner, field, value in numbers(train):
        name = places.name(path)
        if path.startswith("law.") and field in STIFFNESSES and isinstance(value, float) and name:
            told = hasattr(owner, "states") or _matters(owner, field, value, reach)
            (found if told else kept).append(name)
    if kept:
        remarks.append(f"{listed(kept)} was kept: a torsion of {reach:.3g} rad does not reach it.")
    found.append("damping.B")
    if isinstance(train.error, KinematicError):
        for i in range(len(train.error.lines)):
            found += [f"kinematic_error.{i}.{field}" for field in ("amplitude", "phase")]
    return [*found, "torsion.offset"]


def _matters(law: Any, field: str, value: float, reach: float) -> bool:
    """Whether a number of a spring changes its torque up to a torsion."""
    x = np.linspace(-reach, reach, 101)
    before, after = law.torque(x), law._replace(**{field: 1.5 * value}).torque(x)
    return bool(np.max(np.abs(after - before)) > SEEN * np.max(np.abs(before)))


def _orders_left(found: Identified, logs: Sequence[Mapping[str, Any]]) -> list[str]:
    """A sentence on orders of the motor's angle in the residual: lines that the drive has and the file has not."""
    begin, runs = 0, []
    try:
        for log in logs:
            angle = np.asarray(log["motor_angle"], float)
            left = found.residual[0][begin : begin + len(angle)]
            begin += len(angle)
            known = np.isfinite(left)
            runs.append(Run(np.asarray(log["time"], float)[known], angle[known], left[known], "rad"))
        shown = min(SHARE * len(run.time) / run.turns for run in runs)
        lines = order_scan(runs, highest=min(HIGHEST, 0.99 * shown)).lines
    except ValueError:  # too short, or no way in one direction
        return []
    named = [
        f"{line.order:.4g} ({line.amplitude / ARCSEC:.3g} arcsec)"
        for line in sorted(lines, key=lambda line: -line.amplitude)
        if line.kind != "frequency" and line.amplitude > CLEAR * line.amplitude_error
    ]
    if not named:
        return []
    what = "order" if len(named) == 1 else "orders"
    return [f"What is left repeats with the motor's angle: {what} {listed(named[:3])}. The file lacks such lines."]


def _scatter(
    places: Places, names: Sequence[str], found: Identified, remarks: list[str]
) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[float, ...], ...] | None]:
    """Relative standard deviations by name, and their correlations; what a file does not hold is left out and said."""
    deviation: Floats = np.sqrt(np.diag(found.covariance))
    share = deviation / np.maximum(np.abs(found.values), 1e-300)
    own = [not path.startswith(("x.", "reference.", "load.excitation.")) for path in found.names]
    keep = [i for i in range(len(names)) if own[i] and share[i] <= MOST_SCATTER]
    wide = [names[i] for i in range(len(names)) if own[i] and share[i] > MOST_SCATTER]
    if wide:
        remarks.append(f"scatter leaves out {listed(wide)}: known to worse than {100 * MOST_SCATTER:g} % of itself.")
    if not keep:
        return (), None
    table = found.covariance[np.ix_(keep, keep)] / np.outer(deviation[keep], deviation[keep])
    sense = np.sign(found.values[keep])
    table = np.round(table * np.outer(sense, sense), 9)
    np.fill_diagonal(table, 1.0)
    scatter = tuple((places.name(found.names[i]), float(share[i])) for i in keep)
    return scatter, tuple(map(tuple, table.tolist())) if len(keep) > 1 else None


def _with_numbers(project: Project, system: Any) -> Project:
    """The project with law, damping, error, friction and load of a train."""
    if project.drive.J_l != system.load.J:
        project = project.with_load_inertia(system.load.J)
    parts = {name: getattr(system, name) for name in ("law", "B", "error", "friction")}

    def changed(train: DriveTrain | None) -> DriveTrain | None:
        return train and train._replace(**parts, load=train.load._replace(drag=system.load.drag))

    error = system.error if isinstance(system.error, KinematicError) else None
    drive = project.drive._replace(law=system.law, B=system.B)
    return replace(
        project, drive=drive, kinematic_error=error, train=changed(project.train), whole=changed(project.whole)
    )
