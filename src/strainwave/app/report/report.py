"""The report: results as plain data, CSV files of every curve, and one self-contained HTML page."""

import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ... import __version__
from ...files.project import Project
from ...study.analysis.analysis import Analysis
from ...units import RPM
from ..console import WHAT_X_IS, number, to_json
from ..figures import curves, plots
from ..units import angle_unit
from . import curve_files
from .advice import advice_data
from .beyond import beyond_data, beyond_figures
from .data import collect
from .train import reduction, train_warning
from .words import jump_verdict, peak_verdict, sweep_sentences, warnings, with_unit


def write(project: Project, analysis: Analysis, folder: Path) -> dict[str, Any]:
    """Write report.html, results.json and the CSV files into a folder and return the results as plain data."""
    results = collect(project, analysis) | beyond_data(project, analysis)
    angle = angle_unit(results["largest_error"]["peak_rad"])
    results["advice"] = advice_data(project, analysis, angle)
    results["reduction"] = reduction(analysis, angle)
    results["warnings"] = [*train_warning(analysis, angle), *warnings(project, analysis)]
    results["files"] = [*curve_files.write(project, analysis, folder), "results.json", "report.html"]
    (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
    (folder / "report.html").write_text(page(project, analysis, results), encoding="utf-8")
    return results


def page(project: Project, analysis: Analysis, results: dict[str, Any]) -> str:
    """Render the HTML page.

    Raises
    ------
    RuntimeError
        If jinja2 is not installed.
    """
    try:
        import jinja2
    except ModuleNotFoundError as error:
        raise RuntimeError("the report needs jinja2; pip install 'strainwave[report]'") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["number"] = number
    environment.filters["rpm"] = lambda omega: number(omega / RPM)
    environment.filters["hertz"] = lambda omega: number(omega / (2.0 * math.pi))
    environment.filters["sentence"] = lambda text: text[:1].upper() + text[1:].rstrip(".") + "." if text else ""
    angle = angle_unit(results["largest_error"]["peak_rad"])
    environment.filters["in_unit"] = lambda rad: number(None if rad is None else rad * angle.factor)
    environment.filters["angle"] = angle.text
    environment.filters["angles"] = lambda text: with_unit(text, angle)
    figures = {
        "range": curves.speed_range(curves.report_panel(project, analysis, angle)),
        "responses": [
            (i, results["resonances"][i - 1], curves.response(project, analysis, regime, angle))
            for i, regime in enumerate(analysis.regimes, 1)
            if regime.response is not None and regime.response.branches
        ],
        "cases": [plots.time_figure(case, angle) for case in analysis.cases],
    } | beyond_figures(analysis, angle)
    template = environment.get_template("report.html.j2")
    return template.render(
        r=results,
        unit=angle.name,
        figures=figures,
        jumps=sweep_sentences(project, analysis.response, angle),
        verdict=peak_verdict,
        jump_verdict=jump_verdict,
        forcing=project.shaft == "forcing",
        coast_down=analysis.response.back is not None,
        software=_software(),
        what_x_is=WHAT_X_IS,
    )


def _software() -> str:
    parts = [f"strainwave {__version__}"]
    for package in ("numpy", "scipy", "numba"):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return ", ".join(parts)
