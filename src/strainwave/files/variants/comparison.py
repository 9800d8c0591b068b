"""Several projects side by side: the analysis of each drive under all its loads, and what an engineer compares."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.facts import Fact, aligned, table
from ...base.quantities import index
from ...base.records import Along, Labelled, Result
from ...base.results import Floats, Interrupted
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...drive.train_curve import unfollowed
from ...model.gears.limits import gravest
from ...study.analysis.analysis import Analysis
from ...study.analysis.verdict import Verdict
from ..notes import hysteresis_note

MOST_DRIVES = 20
Quantity = Callable[[Project, Analysis], Any]


def _load(project: Project, analysis: Analysis) -> float:
    torque = analysis.largest_oscillation().torque
    return project.mean_load_torque if torque is None else torque


def _folds(_: Project, analysis: Analysis) -> int:
    low, high = analysis.loudest.curve.span
    return sum(low <= fold.omega <= high for fold in analysis.loudest.folds)


SIZES: dict[str, tuple[str, Quantity]] = {  # of motions: of a drive without a stable one there are none
    "oscillation": ("rad", lambda _, a: a.largest_oscillation().peak),
    "speed": ("rad/s", lambda _, a: a.largest_oscillation().omega),
    "load": ("N*m", _load), "torque": ("N*m", lambda _, a: a.usage.peak_torque), "jumps": ("", _folds),
}  # fmt: skip
COLUMNS: dict[str, tuple[str, Quantity]] = {
    "lowest_load": ("N*m", lambda p, _: p.load_torques[0]), "highest_load": ("N*m", lambda p, _: p.load_torques[1]),
    "omega_0": ("rad/s", lambda p, _: p.omega_0), "damping_ratio": ("1", lambda p, _: p.damping_ratio),
    "reflected_inertia": ("kg*m**2", lambda p, _: p.drive.N**2 * p.drive.J_m),
    "load_inertia": ("kg*m**2", lambda p, _: p.drive.J_l), "limit": ("rad", lambda p, _: p.limit),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class ProjectComparison(Result):
    """Drives side by side, in the order given.

    Attributes
    ----------
    titles, gears : tuple of str
        Title of each project and its gear; "own law" where the file writes it out.
    responses : tuple of DriveResponse
        Response of each drive through its own speeds: of its load torques that with the largest oscillation.
    verdicts : tuple of Verdict
        Verdict on each, with the speeds to avoid.
    scales : tuple of (float, str)
        Factor from rad/s of the base angle to the unit of its speeds, and that unit.
    oscillation, speed, load : (n,) arrays
        Largest oscillation of the error [rad] in a slow run-up or run-down under any torque of the load, the speed of
        the base angle [rad/s] and the mean torque on the load [N*m] there; nan where no steady motion of the whole
        drive is stable, and so are `torque` and `jumps`. The response is then that of the error equation alone.
    lowest_load, highest_load : (n,) arrays
        Torques of the load [N*m], gravity among them.
    torque : (n,) array
        Largest torque in the gear [N*m] under any of them, run-ups included.
    omega_0, damping_ratio, reflected_inertia, load_inertia : (n,) arrays
        Natural frequency [rad/s] and damping ratio at rest in the mode of the project, N^2 J_m and J_l [kg*m^2].
    jumps : (n,) array
        Number of folds of that response in its range.
    limit : (n,) array
        Largest oscillation that the project allows [rad]; nan where it has no limit.
    failures : tuple of str
        Sentences on the limits of gear and motor by which each drive fails; empty by none.
    files : tuple of str
        Name of the file of each project.
    remarks : tuple of str
        Effects that the numbers leave out.
    run_ups : tuple of tuple of (float, float)
        Speeds [rad/s] of the base angle that a run-up of each adds to those to keep out of.
    """

    titles: tuple[str, ...]
    gears: tuple[str, ...]
    responses: tuple[DriveResponse, ...]
    verdicts: tuple[Verdict, ...]
    scales: tuple[tuple[float, str], ...]
    oscillation: Floats
    speed: Floats
    load: Floats
    lowest_load: Floats
    highest_load: Floats
    torque: Floats
    omega_0: Floats
    damping_ratio: Floats
    reflected_inertia: Floats
    load_inertia: Floats
    jumps: Floats
    limit: Floats
    failures: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    run_ups: tuple[tuple[tuple[float, float], ...], ...] = ()

    rows: ClassVar[str] = "drive"
    arrays: ClassVar[Along] = {"drive": {name: unit for name, (unit, _) in (COLUMNS | SIZES).items()}}

    def keep_out_of(self, i: int) -> str:
        """Speeds that a drive must keep out of, in words: to avoid, or beyond a limit of the gear; empty if none."""
        i = index("i", i, len(self.titles), "drives")
        return self._bands(i, self.verdicts[i].speeds)

    def run_up_adds(self, i: int) -> str:
        """Speeds that a run-up adds to these, in words; empty if none."""
        return self._bands(i, self.run_ups[i])

    def _bands(self, i: int, bands: Iterable[tuple[float, float]]) -> str:
        scale, unit = self.scales[i]
        return ", ".join(f"{low * scale:.5g} to {high * scale:.5g} {unit}" for low, high in bands)

    def coordinates(self) -> Labelled:
        """Titles and gears."""
        return {"title": ("drive", list(self.titles), ""), "gear": ("drive", list(self.gears), "")}

    def beat(self, i: int) -> float | None:
        """Period [s] of the beat of a drive at its largest oscillation; None where its motions do not beat."""
        i = index("i", i, len(self.titles), "drives")
        turns = self.responses[i].curve.beat
        return None if turns is None or np.isnan(self.speed[i]) else 2.0 * np.pi * turns / float(self.speed[i])

    def row(self, i: int) -> tuple[Fact, ...]:
        """Compared numbers of a drive."""
        i = index("i", i, len(self.titles), "drives")
        numbers = {name: None if np.isnan(v[i]) else float(v[i]) for name, (_, v, _) in self.variables().items()}
        jumps, failures = numbers["jumps"], self.failures[i] if self.failures else ""  # saved results may have none
        return (
            Fact("file", self.files[i] if self.files else None),
            Fact("title", self.titles[i], "drive"), Fact("gear", self.gears[i], "gear"),
            Fact("oscillation_arcsec", numbers["oscillation"], "largest oscillation"),
            Fact("speed_rpm", numbers["speed"], "at speed"),
            Fact("beat_s", self.beat(i), "beat period"),
            Fact("load_torque_N_m", numbers["load"], "load torque"),
            Fact("lowest_load_torque_N_m", numbers["lowest_load"]),
            Fact("highest_load_torque_N_m", numbers["highest_load"]),
            Fact("verdict", self.verdicts[i].answer.value, "verdict"),
            Fact("keep_out_of", self.keep_out_of(i) or "none", "speeds to avoid"),
            Fact("run_up_adds", (self.run_up_adds(i) or "none") if self.run_ups else None, "also in a run-up"),
            Fact("torque_N_m", numbers["torque"], "gear torque"),
            Fact("omega_0_rad_per_s", numbers["omega_0"], "natural frequency ω₀"),
            Fact("damping_ratio", numbers["damping_ratio"], "damping ratio"),
            Fact("reflected_inertia_kg_m2", numbers["reflected_inertia"], "motor inertia at the output"),
            Fact("load_inertia_kg_m2", numbers["load_inertia"], "load inertia"),
            Fact("folds", None if jumps is None else int(jumps), "folds"),
            Fact("limit_arcsec", numbers["limit"], "limit"), Fact("failures", failures, "limits exceeded"),
        )  # fmt: skip

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is compared, once: in the text a column for each drive, the smallest oscillation first."""
        rows = tuple(map(self.row, range(len(self.titles))))
        ordered = [rows[i] for i in np.argsort(self.oscillation).tolist()]
        return (
            Fact("", f"Comparison of {len(self.titles)} drives under all their loads", "{}"),
            Fact("", tuple(f"  {line}" for line in aligned(list(zip(*table(ordered), strict=True)))), "{}"),
            Fact("drives", rows),
            Fact("remarks", self.remarks, "note: {}"),
        )


def compare(projects: Sequence[Project], *, progress: Callable[[str, float], None] | None = None) -> ProjectComparison:
    """Analyse several projects, without what would help them, and put them side by side.

    Parameters
    ----------
    projects : sequence of Project
        Two to twenty projects, as `read_project` gives them.
    progress : callable, optional
        progress(title, share): called before each project.

    Returns
    -------
    ProjectComparison
        `verdicts`, the largest `oscillation` [rad] with its `speed` [rad/s] and `load` [N*m], and the largest
        `torque` in the gear [N*m] of each project.

    Raises
    ------
    ValueError
        If they are fewer than two; whatever `Project.analyze` refuses.
    SolveError
        As `Project.analyze`.
    Interrupted
        On Ctrl-C after at least two projects, with the comparison of those.
    """
    drives = list(projects)
    if not 2 <= len(drives) <= MOST_DRIVES:
        raise ValueError(f"there are {len(drives)} projects; give 2 to {MOST_DRIVES} to compare")
    analyses: list[Analysis] = []
    try:
        for i, project in enumerate(drives):
            if progress is not None:
                progress(project.title, i / len(drives))
            analyses.append(project.analyze(advice=False))
    except KeyboardInterrupt:
        if len(analyses) < 2:
            raise
        extent = f"the comparison covers the first {len(analyses)} of {len(drives)} projects"
        raise Interrupted(f"interrupted; {extent}", compared(drives[: len(analyses)], analyses)) from None
    return compared(drives, analyses)


def compared(projects: list[Project], analyses: list[Analysis]) -> ProjectComparison:
    """Put analyses of projects side by side."""
    pairs = list(zip(projects, analyses, strict=True))
    lost = [unfollowed(project.train, analysis.train_curve) for project, analysis in pairs]
    columns = {name: _column(quantity, pairs) for name, (_, quantity) in COLUMNS.items()}
    sizes = {name: np.where(lost, np.nan, _column(quantity, pairs)) for name, (_, quantity) in SIZES.items()}
    return ProjectComparison(
        titles=tuple(p.title for p in projects),
        gears=tuple("own law" if p.gear is None else p.gear.name for p in projects),
        responses=tuple(analysis.loudest for analysis in analyses),
        verdicts=tuple(analysis.verdict for analysis in analyses),
        scales=tuple((p.speeds.scale, p.speeds.unit) for p in projects),
        failures=tuple(" ".join(one.sentence for one in gravest(a.limits) if one.fails) for a in analyses),
        files=tuple(p.path.name for p in projects),
        remarks=tuple(dict.fromkeys(note for p in projects for note in hysteresis_note(p))),
        run_ups=tuple(() if a.avoid is None else a.avoid.passed for a in analyses),
        **columns, **sizes,
    )  # fmt: skip


def _column(quantity: Quantity, pairs: list[tuple[Project, Analysis]]) -> Floats:
    return np.array([np.nan if (value := quantity(*pair)) is None else value for pair in pairs], float)
