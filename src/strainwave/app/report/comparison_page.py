"""The page of a comparison: one table and one figure of several drives, in a file that needs nothing else."""

from collections.abc import Sequence
from html import escape
from typing import Any
from urllib.parse import quote

from ... import __version__
from ..console import WHAT_X_IS, number
from ..figures.comparison import comparison_figure
from ..view import View
from .report import Report

STYLE = """
body { margin: 0 auto; max-width: 62rem; padding: 1.2rem; color: #1d2430;
  font: 15px/1.55 "Segoe UI", "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; text-align: left; vertical-align: top; border-bottom: 1px solid #d9dee5; }
.n { text-align: right; } tr.over td { background: #fff7f1; } figure { margin: 1rem 0; max-width: 30rem; }
td.g { white-space: nowrap; }
svg { width: 100%; height: auto; } .note { color: #5b6675; font-size: .87rem; }
@page { size: A4 landscape; margin: 14mm; }
@media print { body { max-width: none; padding: 0; font-size: 9.5pt; } figure, tr { break-inside: avoid; }
  thead { display: table-header-group; } .scroll { overflow: visible; } figure { max-width: 135mm; } }
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
    "oscillation": "Oscillation is the largest distance of the error from its mean in a slow run-up or run-down.",
    "load": "Oscillation, speeds and torque are those under all torques of the load, gravity among them, as in "
    "`strainwave analyze`; each curve is for the torque on the load that has the largest oscillation.",
    "x": f"{WHAT_X_IS[0].upper()}{WHAT_X_IS[1:]}.",
    "rest": "Speeds are those of the motor or of the forcing. Natural frequency and damping ratio are those at rest, "
    "in the motor mode of the file, without its loop. A shaded row is above its limit.",
}
NOTE = " ".join(NOTES.values())


def comparison_page(rows: Sequence[dict[str, Any]], figure: str) -> str:
    """Write the HTML page of rows of `strainwave compare` and its figure (SVG), the smallest oscillation first."""
    numbered = [row | {"title": f"{i}: {row['title']}"} for i, row in enumerate(rows, 1)]  # as the figure has them
    ordered = sorted(numbered, key=lambda row: row["oscillation_arcsec"])
    head = "".join(f"<th{'' if key in TEXTS else ' class=n'}>{escape(name)}</th>" for key, name in COLUMNS)
    body = "\n".join(_row(row) for row in ordered)
    return _page(len(rows), summary(ordered), head, body, figure, NOTE)


def verdicts_page(reports: dict[str, Report]) -> str:
    """Write the HTML page of several reports: pass or fail of each drive and its smallest change, then the responses.

    The reports stand in folders beside the page, named by the keys.
    """
    heads = ("drive", "pass or fail", *ANSWERS)
    head = "".join(f"<th>{name}</th>" for name in heads)
    body = "\n".join(_verdict(i, name, report) for i, (name, report) in enumerate(reports.items(), 1))
    views = [report.view for report in reports.values()]
    passed = sum(report.results["verdict"]["answer"] == "all right" for report in reports.values())
    figure = comparison_figure(
        [view.project.title for view in views], [view.analysis.loudest for view in views],
        [view.project.limit for view in views], views[0].speeds,
    )  # fmt: skip
    said = f"{passed} of {len(reports)} drives pass at all their speeds."
    loads = "".join(_load(i, view) for i, view in enumerate(views, 1))
    note = f"{NOTES['oscillation']} {NOTES['x']}{loads} Each drive has its own report: follow its name."
    return _page(len(reports), said, head, body, figure, note)


def _load(i: int, view: View) -> str:
    """Which torque of its load the curve of a drive is for, where that has a range."""
    low, high = view.project.load_torques
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


def _page(count: int, said: str, head: str, body: str, figure: str, note: str) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Comparison of {count} drives</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>Comparison of {count} drives</h1>\n<p>{escape(said)}</p>\n"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>\n'
        f'<figure>{figure}</figure>\n<p class="note">{escape(note)}</p>\n'
        f'<p class="note">strainwave {escape(__version__)}</p>\n</body>\n</html>\n'
    )


def summary(ordered: Sequence[dict[str, Any]]) -> str:
    """Which drive oscillates least, and how many keep to their limits, in sentences."""
    best = ordered[0]
    said = f"The smallest oscillation, {number(best['oscillation_arcsec'])} arcsec, is that of drive {best['title']}."
    limited = [row for row in ordered if row["limit_arcsec"] is not None]
    if limited:
        kept = sum(not _over(row) for row in limited)
        said += f" {kept} of {len(limited)} drives with a limit keep to it at all their speeds."
    return said


def _over(row: dict[str, Any]) -> bool:
    return row["limit_arcsec"] is not None and row["oscillation_arcsec"] > row["limit_arcsec"]


def _row(row: dict[str, Any]) -> str:
    cells = "".join(
        f"<td{' class=g' if key == 'gear' else ''}>{escape(row[key])}</td>"
        if key in TEXTS
        else f'<td class="n">{"–" if row[key] is None else escape(number(row[key]))}</td>'
        for key, _ in COLUMNS
    )
    return f"<tr{' class=over' if _over(row) else ''}>{cells}</tr>"
