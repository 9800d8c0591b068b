"""The report: results as plain data, CSV files of every curve, one self-contained HTML page, and a summary.

The page of a comparison: one table and one figure of several drives, in a file that needs nothing else.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from html import escape
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np

from ...base.archive import version
from ...base.results import Branch, Floats
from ...base.sentences import Angle, Speed, listed, silent
from ...base.units import Speeds
from ...compile.jit import light_as_python
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...files.reading import read_project
from ...plot.drive import comparison_panels
from ...plot.svg import stacked
from ...study.analysis.words import equation_alone
from ..console import WHAT_X_IS, number, percent, slug, staged, to_json, write_csv
from ..view import View
from .section import Part, Section, asked
from .sections import SECTIONS
from .sections.whole_train import about_appendix

# of a page of one wide table, after that of a report
STYLE = """
main { padding: 1.2rem; } h1 { margin-bottom: .6rem; } p { max-width: none; } main > figure { max-width: 30rem; }
tr.over td { background: #fff7f1; }
@page { size: A4 landscape; margin: 14mm; } @media print { main > figure { max-width: 135mm; } }
"""
# keys of a row, and what stands above them
COLUMNS = (
    ("title", "drive"), ("gear", "gear"), ("oscillation_arcsec", "largest oscillation (arcsec)"),
    ("limit_arcsec", "limit (arcsec)"), ("speed_rpm", "at (rpm)"), ("load_torque_N_m", "under a load of (N·m)"),
    ("keep_out_of", "speeds to keep out of"), ("torque_N_m", "torque in the gear (N·m)"),
    ("omega_0_rad_per_s", "natural frequency ω₀ (rad/s)"), ("damping_ratio", "damping ratio"),
    ("reflected_inertia_kg_m2", "motor inertia at the load (kg·m²)"), ("load_inertia_kg_m2", "load inertia (kg·m²)"),
    ("folds", "folds"),
)  # fmt: skip
ANSWERS = ("largest oscillation", "margin", "jumps", "torque", "motor", "smallest change", "without a change")
TEXTS = ("title", "gear", "keep_out_of")
NOTES = {
    "oscillation": "Oscillation is the largest distance of the error from its mean, of all stable motions.",
    "load": "Oscillation, speeds and torque are those under all torques of the load, gravity among them, as in "
    "`strainwave analyze`; each curve is for the torque on the load that has the largest oscillation.",
    "x": f"{WHAT_X_IS[0].upper()}{WHAT_X_IS[1:]}.",
    "rest": "Speeds are those of the motor or of the forcing. Natural frequency and damping ratio are those at rest, "
    "in the motor mode of the file, without its loop. A shaded drive is above its limit or has no stable motion.",
}
NOTE = " ".join(NOTES.values())

PAGES = {"appendix.html": True, "report.html": False}  # and whether the parts of the appendix stand there
HERE = Path(__file__).parent


class Report(NamedTuple):
    """A written report: the content of results.json, the summary for a terminal, and their view."""

    results: dict[str, Any]
    summary: str
    view: View


def write(
    project: Project | str | Path,
    folder: str | Path | None = None,
    *,
    sections: Sequence[Section] = SECTIONS,
    progress: Callable[[str, float], None] = silent,
) -> Report:
    """Analyse a drive and write report.html, appendix.html, results.json and CSV files of its curves into a folder.

    Parameters
    ----------
    project : Project, str or Path
        The project, or its file.
    folder : str or Path, optional
        Where the files go, all at once when they are complete; it keeps its other files. Default: none is written.
    sections : sequence of Section
        Parts of the report in order. Default: `SECTIONS`.
    progress : callable
        Told before every step what is done now, and the share of the work that is done; default: nobody.

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
        view = View.of(project, project.analyze(progress))
        progress("range for assumed numbers", 0.95)
        with light_as_python():
            _ = project.sureness  # which several sections tell
        progress("writing the report", 0.99)
        return write_view(view, part, sections)


def write_view(view: View, folder: Path | None, sections: Sequence[Section] = SECTIONS) -> Report:
    """Write the report of an analysis, if there is a folder; errors as `write`."""
    parts = [asked(section, view) for section in sections]
    files = [] if folder is None else [*write_curves(view, folder), "results.json", *PAGES]
    results = together([*(part.data for part in parts), {"files": files}])
    if folder is not None:
        (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
        for name, appendix in PAGES.items():
            (folder / name).write_text(page(view, parts, appendix), encoding="utf-8")
    lines = [f"  {line}" for part in parts for line in part.lines]
    return Report(results, "\n".join([view.project.title, *lines]), view)


def together(parts: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Join the data of all sections, each of which has keys of its own (ValueError)."""
    found: dict[str, Any] = {}
    for part in parts:
        if both := sorted(found.keys() & part.keys()):
            raise ValueError(f"two sections of the report have the key {both[0]!r}; rename one of them")
        found |= part
    return found


def page(view: View, parts: Iterable[Part], appendix: bool = False) -> str:
    """Render the page of the report or of its appendix, each section by its template."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters |= _filters(view)
    environment.globals |= {
        "view": view,
        "unit": view.angle.name,
        "speed_unit": view.speeds.unit,
        "speed_name": view.speeds.name,
        "what_x_is": WHAT_X_IS,
    }

    def rendered(template: Path, names: dict[str, Any]) -> str:
        return environment.from_string(template.read_text(encoding="utf-8")).render(names)

    style = (HERE / "page.css").read_text(encoding="utf-8")
    bodies = [
        (p.section.heading, body)
        for p in parts
        if getattr(p.section, "appendix", False) is appendix
        if (body := rendered(p.template, p.data | p._asdict() | {"rows": p.rows})).strip()
    ]
    about = about_appendix(view) if appendix else ""
    names = {"bodies": bodies, "appendix": appendix, "style": style, "about_appendix": about}
    return rendered(HERE / "page.html.j2", names)


def _filters(view: View) -> dict[str, Callable[..., Any]]:
    """Filters of numbers on the page: they add units, and write speeds and angles in the units of the report."""
    speeds = view.speeds

    def speed(omega: float | None) -> str:
        return "–" if omega is None else view.write(Speed(omega, digits=5, bare=True))

    def angle(rad: float | None) -> str:
        return "–" if rad is None else view.write(Angle(rad, bare=True))

    return {
        "number": number,
        "speed": speed,
        "speed_unit": lambda omega: f"{speed(omega)} {speeds.unit}",
        "angle": angle,
        "angle_unit": lambda rad: f"{angle(rad)} {view.angle.name}",
        "percent": percent,
        "with_unit": lambda value, unit, digits=4: f"{number(value, digits)} {unit}",
        "sentence": lambda text: text[:1].upper() + text[1:].rstrip(".") + "." if text else "",
    }


def comparison_page(rows: Sequence[dict[str, Any]], figure: str) -> str:
    """Write the HTML page of rows of `strainwave compare` and its figure (SVG), the smallest oscillation first."""
    numbered = [row | {"title": f"{i}: {row['title']}"} for i, row in enumerate(rows, 1)]  # as the figure has them
    ordered = sorted(numbered, key=lambda row: math.inf if _lost(row) else row["oscillation_arcsec"])
    head = "".join(f"<th{'' if key in TEXTS else ' class=n'}>{escape(name)}</th>" for key, name in COLUMNS)
    return _page(len(rows), summary(ordered), head, map(_row, ordered), figure, NOTE)


def verdicts_page(reports: dict[str, Report]) -> str:
    """Write the HTML page of several reports: pass or fail of each drive and its smallest change, then the responses.

    The reports stand in folders beside the page, named by the keys.
    """
    head = "".join(f"<th>{name}</th>" for name in ("drive", "pass or fail", *ANSWERS))
    body = (_verdict(i, name, report) for i, (name, report) in enumerate(reports.items(), 1))
    views = [report.view for report in reports.values()]
    passed = sum(report.results["verdict"]["answer"] == "all right" for report in reports.values())
    panels = comparison_panels(
        [view.project.title for view in views], [view.analysis.loudest for view in views],
        [view.project.limit for view in views], views[0].speeds,
        [bool(equation_alone(view.analysis)) for view in views],
    )  # fmt: skip
    figure = stacked(panels, 360.0, "oscillation of several drives over the speed")
    said = f"{passed} of {len(reports)} drives pass at all their speeds."
    loads = "".join(_load(i, view) for i, view in enumerate(views, 1))
    note = f"{NOTES['oscillation']} {NOTES['x']}{loads} Each drive has its own report: follow its name."
    return _page(len(reports), said, head, body, figure, note)


def _load(i: int, view: View) -> str:
    """Sentence on the load torque of the curve of a drive, where the load has a range."""
    low, high = view.project.other_loads
    torque = view.analysis.largest_oscillation().torque
    if torque is None:
        return ""
    return (
        f" The curve of drive {i} is for {number(torque)} N·m on its load, which has the largest oscillation; pass or "
        f"fail is for all from {number(low)} to {number(high)} N·m."
    )


def _verdict(i: int, name: str, report: Report) -> str:
    """Row of one report."""
    verdict = report.results["verdict"]
    cells = (
        f'<td><a href="{quote(name)}/report.html">{i}: {escape(report.view.project.title)}</a></td>',
        f"<td><b>{escape(verdict['headline'])}</b></td>",
        *(f"<td>{escape(verdict['answers'].get(what, '–'))}</td>" for what in ANSWERS),
    )
    return f"<tr{'' if verdict['answer'] == 'all right' else ' class=over'}>{''.join(cells)}</tr>"


def _page(count: int, sentence: str, head: str, body: Iterable[str], figure: str, note: str) -> str:
    rows = "\n".join(body)
    return plain_page(
        f"Comparison of {count} drives",
        f"<p>{escape(sentence)}</p>\n"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody></table></div>\n'
        f'<figure>{figure}</figure>\n<p class="note">{escape(note)}</p>\n',
        STYLE,
    )


def plain_page(title: str, body: str, style: str = "") -> str:
    """Write an HTML page of a body in the style of the report, that needs nothing else."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{(HERE / 'page.css').read_text('utf-8')}{style}</style>\n"
        f"</head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}"
        f'<p class="note">strainwave {escape(version())}</p>\n</main>\n</body>\n</html>\n'
    )


def summary(ordered: Sequence[dict[str, Any]]) -> str:
    """Sentences on the drive with the smallest oscillation, and on the number of drives within their limits."""
    best, lost = ordered[0], [f"drive {row['title']}" for row in ordered if _lost(row)]
    text = f"The smallest oscillation, {number(best['oscillation_arcsec'])} arcsec, is that of drive {best['title']}."
    if lost:
        text = f"{'' if _lost(best) else text} No steady motion is stable of {listed(lost)}.".strip()
    limited = [row for row in ordered if row["limit_arcsec"] is not None]
    if limited:
        passing = sum(not _over(row) for row in limited)
        text += f" {passing} of {len(limited)} drives with a limit of the oscillation keep to it at all their speeds."
    return " ".join([text, *(f"{row['title']}: {row['failures']}" for row in ordered if row.get("failures"))])


def _over(row: dict[str, Any]) -> bool:
    return _lost(row) or (row["limit_arcsec"] is not None and row["oscillation_arcsec"] > row["limit_arcsec"])


def _lost(row: dict[str, Any]) -> bool:
    """Whether no steady motion of a drive is stable."""
    return row["oscillation_arcsec"] is None


def _row(row: dict[str, Any]) -> str:
    cells = "".join(
        f"<td{' class=w' if key == 'gear' else ''}>{escape(row[key])}</td>"
        if key in TEXTS
        else f'<td class="n">{"–" if row[key] is None else escape(number(row[key]))}</td>'
        for key, _ in COLUMNS
    )
    return f"<tr{' class=over' if _over(row) else ''}>{cells}</tr>"


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
    yield "exact-response", _columns(speeds, exact, of_equation)
    for torque, found in analysis.curves:
        under = "" if torque is None else f"-at-{number(torque, 5).replace('−', '-')}-Nm"
        yield f"drive-response{under}", drive_columns(speeds, found)
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


def speed_columns(speeds: Speeds, omega: Floats) -> list[tuple[str, Floats]]:
    """Speed of the base angle, and of the motor where the base angle is its own."""
    named = [("omega_rad_per_s", omega)]
    return [*named, ("motor_speed_rpm", speeds.scale * omega)] if speeds.by_motor else named


def drive_columns(speeds: Speeds, drive: DriveResponse) -> list[tuple[str, Floats]]:
    """Columns of the motions of a drive in arc order; the error is the pointing error, or x without a reference."""
    error = "pointing_error" if drive.has_reference else "x"
    sizes = {
        f"oscillation_of_{error}_rad": drive.oscillation, f"peak_{error}_rad": drive.peak,
        "peak_x_across_gear_rad": drive.across, "peak_torque_in_gear_Nm": drive.torque,
    }  # fmt: skip
    if drive.curve.beat is not None and drive.curve.envelope is not None:
        sizes[f"smallest_oscillation_of_{error}_rad"] = drive.curve.envelope[:, 1]
    sizes_of_motor = {"peak": drive.motor_torque, "rms": drive.motor_rms}
    motor = [(f"{name}_torque_of_motor_Nm", size) for name, size in sizes_of_motor.items() if size is not None]
    return [*_columns(speeds, drive.curve, sizes), *motor]


def _columns(speeds: Speeds, curve: Branch, sizes: dict[str, Floats]) -> list[tuple[str, Floats]]:
    """Columns of a response curve in arc order: speed, sizes, first harmonics of x, stability."""
    harmonics = range(1, min(9, curve.coefficients.shape[1] // 2) + 1)
    amplitudes = [(f"amplitude_{k}_rad", curve.amplitude(k)) for k in harmonics]
    return [
        *speed_columns(speeds, curve.omega), *sizes.items(), *amplitudes, ("stable", curve.stable.astype(float)),
    ]  # fmt: skip
