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
from ...units import ARCSEC
from ..entries import MOST_OF_PHASE, MOST_SCATTER, Radians
from ..project import Project
from ..project_text import project_text
from ..reading import from_text
from .free_numbers import expected_range, found_range, stiffnesses, usual
from .missing_orders import missing_lines
from .places import OF_SIGNAL, Places
from .torsion import with_torsion

POOR = 0.1  # of the motion: what the numbers may leave of it


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
    inputs = {"reference": "motor_angle"}
    if "load_torque" in logs[0]:
        inputs["load.excitation"] = "load_torque"

    def fitted(first: DriveTrain, names: Sequence[str]) -> Identified:
        paths = [places.path(name) for name in names]
        return identify(first, logs, paths, inputs=inputs, outputs={"x": "torsion"}, between=between, progress=progress)

    remarks: list[str] = []
    if free is None:
        names, kept = usual(places, expected_range(train, logs))
        found = fitted(train, names)
        reach = found_range(found, logs)
        more = [name for name in stiffnesses(places, found.system, reach)[0] if name in kept]
        if more:
            names, kept = usual(places, reach, {*names, *more})
            found = fitted(found.system, names)
            reach = found_range(found, logs)
        if kept:
            remarks.append(
                f"{listed(kept)} was kept: a torsion of {reach[0]:.3g} to {reach[1]:.3g} rad does not reach it."
            )
    else:
        names = list(free)
        found = fitted(train, names)
    remarks += _orders_left(found, logs)
    scatter, correlation = _scatter(places, names, found, remarks)
    better = replace(_with_numbers(project, found.system), scatter=scatter, correlation=correlation)
    better = from_text(project_text(better), project.path)
    return IdentifiedDrive(better, found, tuple(names), tuple(remarks))


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
    terms = getattr(whole.load.excitation, "terms", ())
    if any(term.amplitude for term in terms):
        raise ValueError(
            "excitation.load_torque has lines over the motor's turn, which no log in time holds; measure load_torque"
        )
    mean = Harmonic(0.0, mean=float(sum(term.mean for term in terms)))
    motor = whole.motor._replace(control=Held(), excitation=Harmonic(0.0))
    return whole._replace(motor=motor, load=whole.load._replace(excitation=mean), omega=1.0)


def _orders_left(found: Identified, logs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Sentences on orders of the motor's angle that the drive has and the file has not."""
    lines = missing_lines(found, logs)
    said = []
    for in_reading, sentence in (
        (False, "The drive has a kinematic error of {}, which the file lacks."),
        (True, "What was read of the torsion repeats with {}: a sensor may have it, the gear has not."),
    ):
        named = [
            f"{line.order:.4g} ({line.amplitude / ARCSEC:.3g} arcsec)"
            for line in lines
            if line.in_reading is in_reading
        ]
        if named:
            said.append(sentence.format(f"order{'s' * (len(named) > 1)} {listed(named)} of the motor's angle"))
    return said


def _scatter(
    places: Places, names: Sequence[str], found: Identified, remarks: list[str]
) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[float, ...], ...] | None]:
    """Standard deviations by name, relative or of a phase [rad], and their correlations; what is left out is said."""
    deviation: Floats = np.sqrt(np.diag(found.covariance))
    phases = np.array([path.endswith(".phase") for path in found.names])
    size = np.where(phases, deviation, deviation / np.maximum(np.abs(found.values), 1e-300))
    most = np.where(phases, MOST_OF_PHASE, MOST_SCATTER)
    own = [not path.startswith(("x.", "reference.", "load.excitation.")) for path in found.names]
    keep = [i for i in range(len(names)) if own[i] and size[i] <= most[i]]
    wide = [names[i] for i in range(len(names)) if own[i] and size[i] > most[i]]
    if wide:
        remarks.append(
            f"scatter leaves out {listed(wide)}: known to worse than {100 * MOST_SCATTER:g} % of itself, a phase to "
            f"worse than {MOST_OF_PHASE:g} rad."
        )
    if not keep:
        return (), None
    table = found.covariance[np.ix_(keep, keep)] / np.outer(deviation[keep], deviation[keep])
    sense = np.where(phases[keep], 1.0, np.sign(found.values[keep]))
    table = np.round(table * np.outer(sense, sense), 9)
    np.fill_diagonal(table, 1.0)
    scatter = tuple((places.name(found.names[i]), Radians(size[i]) if phases[i] else float(size[i])) for i in keep)
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
