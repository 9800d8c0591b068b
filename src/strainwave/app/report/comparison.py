"""Pages and figure of several drives side by side: their responses, or the verdicts of their reports."""

from html import escape
from urllib.parse import quote

import numpy as np

from ...base.facts import table
from ...drive.speeds import Speeds
from ...files.variants.comparison import ProjectComparison, compared
from ...plot.comparison import comparison_panels
from ...plot.svg import stacked
from ...study.analysis.verdict import Answer
from .page import plain_page
from .report import ERRORS, Report
from .section import figured, html_table, paragraph

# Of a page of one wide table, after that of a report.
STYLE = """
main { padding: 1.2rem; } h1 { margin-bottom: .6rem; } p { max-width: none; } main > figure { max-width: 30rem; }
@page { size: A4 landscape; margin: 14mm; } @media print { main > figure { max-width: 135mm; } }
"""
ANSWERS = ("largest oscillation", "margin", "jumps", "torque", "motor", "smallest change", "without a change")
NOTES = {
    "oscillation": "Oscillation is the largest distance of the error from its mean, over all stable steady motions.",
    "load": "Oscillation, speeds and torque are the largest under all load torques, gravity included, as in "
    "`strainwave analyze`; each curve is for the load torque with the largest oscillation.",
    "errors": ERRORS,
    "rest": "Speeds are motor speeds or forcing frequencies. Natural frequency and damping ratio are those at "
    "standstill, in the motor mode of the project file, without the control loop.",
}
NOTE = " ".join(NOTES.values())


def comparison_figure(compared: ProjectComparison, speeds: Speeds) -> str:
    """Draw the oscillation of several drives over the speed (SVG)."""
    return stacked(comparison_panels(compared, speeds), 360.0, "oscillation of several drives over the speed")


def comparison_page(compared: ProjectComparison, figure: str) -> str:
    """Write the HTML page of `strainwave compare` and its figure (SVG), the smallest oscillation first."""
    order = np.argsort(compared.oscillation).tolist()
    heads, *cells = table([compared.row(i) for i in order])
    named = [[f"{i + 1}: {title}", *row] for i, (title, *row) in zip(order, cells, strict=True)]  # as in the figure
    passed = sum(verdict.answer is Answer.ALL_RIGHT for verdict in compared.verdicts)
    first, *rows = zip(heads, *named, strict=True)
    return _page(len(order), passed, html_table(first, rows), figure, NOTE)


def verdicts_page(reports: dict[str, Report]) -> str:
    """Write the HTML page of several reports: pass or fail of each drive and its smallest change, then the responses.

    The reports stand in folders beside the page, named by the keys.
    """
    views = [report.view for report in reports.values()]
    passed = sum(report.results["verdict"]["answer"] == "pass" for report in reports.values())
    found = compared([view.project for view in views], [view.analysis for view in views])
    figure = comparison_figure(found, views[0].speeds)
    note = f"{NOTES['oscillation']} {NOTES['errors']} The name of each drive links to its report."
    rows, links = list[list[str]](), list[str]()
    for i, (name, report) in enumerate(reports.items(), 1):
        verdict, title = report.results["verdict"], escape(report.view.project.title)
        rows.append([str(i), verdict["headline"], *(verdict["answers"].get(key, "–") for key in ANSWERS)])
        links.append(f'{i}: <a href="{quote(name)}/report.html">{title}</a>')
    table = f"<p>{', '.join(links)}</p>" + html_table(("drive", "pass or fail", *ANSWERS), rows)
    return _page(len(reports), passed, table, figure, note)


def _page(count: int, passed: int, table: str, figure: str, note: str) -> str:
    title, passing = f"Comparison of {count} drives", f"{passed} of {count} drives pass at all their speeds."
    return plain_page(title, paragraph(passing) + table + figured(figure) + paragraph(note, "note"), STYLE)
