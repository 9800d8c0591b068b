"""The report of a drive: results.json, CSV files of its curves, two HTML pages, and a summary for a terminal."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...base.terminal import Progress, silent
from ...compile.jit import light_as_python
from ...drive.project import Project
from ...files.fields.groups import ASSUMED
from ...files.reading import read_project
from ..console import number, slug, to_json, write_csv
from ..console.output_files import staged
from ..curves import WHAT_X_IS, curve_columns, drive_columns, speed_columns
from ..view import View
from .page import plain_page
from .section import Part, rendered_part
from .sections import SECTIONS
from .sections.whole_train import about_appendix

ERRORS = f"{WHAT_X_IS[0].upper()}{WHAT_X_IS[1:]}."
REST = (
    'The <a href="appendix.html">appendix</a> has assumptions, certificates, resonances, motions in time, hysteresis, '
    f"derived numbers and the project file. {ERRORS}"
)
CONVENTIONS = (
    f"Conventions: {WHAT_X_IS} (the vendors' angular transmission error is −x); u = x − e is the torsion; largest |x| "
    "includes the mean; amplitudes of single harmonics are 0-to-peak. All numbers with units are in results.json, all "
    "curves in the CSV files of the same folder. Formulas: method of multiple scales, first and second order, with the "
    "corrections of the errata list in the documentation; response: {}; time integration: Dormand–Prince 5(4) with "
    "event location."
)
PAGES = {"appendix.html": True, "report.html": False}  # and whether the parts of the appendix stand there


class Report(NamedTuple):
    """A written report: the content of results.json, the summary for a terminal, and their view."""

    results: dict[str, Any]
    summary: str
    view: View


ANALYSIS, WRITING = 0.75, 0.98  # shares of the time that are gone after the analysis, and when it is written


def write(
    project: Project | str | Path,
    folder: str | Path | None = None,
    *,
    sections: Sequence[Any] = SECTIONS,
    progress: Progress = silent,
) -> Report:
    """Analyse a drive and write report.html, appendix.html, results.json and CSV files of its curves into a folder.

    Parameters
    ----------
    project : Project, str or Path
        The project, or its file.
    folder : str or Path, optional
        Folder of the files, written all at once; it keeps its other files. Default: none is written.
    sections : sequence of functions of a View, or of Section
        Parts of the report in order. Default: `SECTIONS`.
    progress : callable
        progress(stage, share): called before each stage. Default: none.

    Raises
    ------
    ProjectError
        If the project file is invalid.
    ValueError
        If two sections have the same key, or the analysis refuses the drive.
    SolveError
        If the law cannot carry the mean torque, or no simulation finishes.
    OSError
        If the folder cannot be written; nothing is left behind.
    """
    project = project if isinstance(project, Project) else read_project(project)
    with nullcontext() if folder is None else staged(Path(folder)) as part:
        share = ANALYSIS if any(source.word == ASSUMED for source in project.sources) else WRITING
        view = View.of(project, project.analyze(lambda stage, part: progress(stage, share * part)))
        progress("range for assumed values", share)
        with light_as_python():
            _ = project.sureness  # which several sections tell
        progress("writing the report", WRITING)
        return write_view(view, part, sections)


def write_view(view: View, folder: Path | None, sections: Sequence[Any] = SECTIONS) -> Report:
    """Write the report of an analysis, if there is a folder; errors as `write`."""
    parts = [rendered_part(section, view) for section in sections]
    files = [] if folder is None else [*write_curves(view, folder), "results.json", *PAGES]
    results = together([*(part.data for part in parts), {"files": files}])
    if folder is not None:
        (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
        for name, appendix in PAGES.items():
            (folder / name).write_text(page(view, parts, appendix), encoding="utf-8")
    lines = [f"  {line}" for part in parts for line in part.lines]
    headline = results.get("verdict", {}).get("headline")
    title = f"{view.project.title}: {headline}" if headline else view.project.title
    return Report(results, "\n".join([title, *lines]), view)


def together(parts: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Join the data of all sections, each of which has keys of its own (ValueError)."""
    joined: dict[str, Any] = {}
    for part in parts:
        if both := sorted(joined.keys() & part.keys()):
            raise ValueError(f"two sections of the report have the key {both[0]!r}; rename one of them")
        joined |= part
    return joined


def page(view: View, parts: Iterable[Part], appendix: bool = False) -> str:
    """Write the page of the report or of its appendix, each section below its heading."""
    letters = iter("ABCDEFGHIJKLMNOPQRSTUVWXYZ")
    title, about = view.project.title, about_appendix(view) if appendix else ""
    body = [
        f"<h1>{escape(title)}: appendix</h1>\n",
        f'<p class="sub">The <a href="report.html">report</a> has the verdict. <b>{escape(about)}</b></p>\n',
    ] if appendix else []  # fmt: skip
    for part in parts:
        if part.appendix is appendix and (html := part.html(view)):
            named = f"{next(letters)}. {part.heading}" if appendix else part.heading
            body.append((f"<h2>{escape(named)}</h2>\n" if named else "") + html)
    foot = escape(CONVENTIONS.format(view.analysis.exact.method)) if appendix else REST
    return plain_page(f"{title} – {'appendix' if appendix else 'dynamic error'}", "".join(body), foot=foot)


def write_curves(view: View, folder: Path) -> list[str]:
    """Write the CSV files of the run-up, the response curves and the time responses; return their names."""
    tables = {name: columns for name, columns in _tables(view) if len(columns[0][1])}
    for name, columns in tables.items():
        write_csv(folder / f"{name}.csv", columns)
    return [f"{name}.csv" for name in tables]


def _tables(view: View) -> Iterator[tuple[str, list[tuple[str, Floats]]]]:
    """Names of the files without their ending, and their columns."""
    analysis, speeds, exact = view.analysis, view.speeds, view.analysis.exact.curve
    for name, motions in (("run-up", analysis.run_up.up), ("run-down", analysis.run_up.down)):
        good = [m for m in motions if m.status]
        sizes = {"peak_x_rad": [m.peak for m in good], "periodic": [m.closed for m in good]}
        columns = speed_columns(speeds, np.array([m.omega for m in good]))
        yield name, columns + [(key, np.array(values, float)) for key, values in sizes.items()]
    of_equation = {"oscillation_of_x_rad": exact.oscillation, "peak_x_rad": exact.peak}
    yield "exact-response", curve_columns(speeds, exact, of_equation)
    for torque, response in analysis.curves:
        under = "" if torque is None else f"-at-{number(torque, 5).replace('−', '-')}-Nm"
        yield f"drive-response{under}", drive_columns(speeds, response)
    for regime in analysis.regimes:
        for i, branch in enumerate(regime.response.branches if regime.response else ()):
            polar = ("amplitude_rad", branch.amplitude), ("phase_rad", branch.phase)
            columns = [("omega_rad_per_s", branch.omega), *polar, ("stable", branch.stable.astype(float))]
            yield f"response-{slug(regime.label)}{'' if i == 0 else f'-branch-{i + 1}'}", columns
    for i, case in enumerate(analysis.cases, 1):
        name, c = f"case-{i}-{slug(case.name)}", case.cycle
        theory = [] if case.comparison is None else [("x_multiple_scales_rad", case.comparison.theory.x)]
        yield f"{name}-from-rest", [("t_s", case.transient.t), ("x_integration_rad", case.transient.y[0]), *theory]
        if c is not None:
            steady = [("t_s", c.t), ("x_rad", c.x), ("v_rad_per_s", c.v), ("u_rad", c.u), ("torque_Nm", c.torque)]
            yield f"{name}-steady", steady
