"""The report: results as plain data, CSV files of every curve, and one self-contained HTML page."""

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ... import __version__
from ...files.project import Project
from ...sentences import told
from ...study.analysis.analysis import Analysis
from ..console import WHAT_X_IS, number, to_json
from ..figures import curves, plots
from ..units import Units, angle_unit
from . import curve_files
from .advice import advice_data
from .beyond import beyond_data, beyond_figures
from .data import collect
from .train import reduction, train_warning
from .words import jump_verdict, peak_verdict, sweep_sentences, warnings


def write(project: Project, analysis: Analysis, folder: Path) -> dict[str, Any]:
    """Write report.html, results.json and the CSV files into a folder and return the results as plain data."""
    results: dict[str, Any] = collect(project, analysis) | beyond_data(project, analysis)
    units = Units(angle_unit(results["largest_error"]["peak_rad"]), project.speeds)
    results["advice"] = advice_data(project.speeds, analysis)
    results["reduction"] = reduction(analysis)
    results["warnings"] = [*train_warning(analysis), *warnings(project, analysis)]
    results["files"] = [*curve_files.write(project, analysis, folder), "results.json", "report.html"]
    results = told(results, units.write)
    (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
    (folder / "report.html").write_text(page(project, analysis, results, units), encoding="utf-8")
    return results


def page(project: Project, analysis: Analysis, results: dict[str, Any], units: Units) -> str:
    """Render the HTML page; every sentence of `results` is rendered already.

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
    environment.filters |= _filters(units)
    angle = units.angle
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
        speed_unit=project.speeds.unit,
        speed_name=project.speeds.name,
        jumps=told(sweep_sentences(analysis.response), units.write),
        verdict=peak_verdict,
        jump_verdict=jump_verdict,
        run_down=analysis.response.back is not None,
        software=_software(),
        what_x_is=WHAT_X_IS,
    )


def _filters(units: Units) -> dict[str, Callable[..., str]]:
    """How the page writes numbers: those with a unit get it here, and speeds and angles are in the report's units."""

    def speed(omega: float | None) -> str:
        return number(None if omega is None else omega * units.speeds.scale, 5)

    return {
        "number": number,
        "speed": speed,
        "speed_unit": lambda omega: f"{speed(omega)} {units.speeds.unit}",
        "angle": lambda rad: number(None if rad is None else rad * units.angle.factor),
        "angle_unit": units.angle.text,
        "percent": lambda share, digits=4: f"{number(100.0 * share, digits)} %",
        "with_unit": lambda value, unit, digits=4: f"{number(value, digits)} {unit}",
        "sentence": lambda text: text[:1].upper() + text[1:].rstrip(".") + "." if text else "",
    }


def _software() -> str:
    parts = [f"strainwave {__version__}"]
    for package in ("numpy", "scipy", "numba"):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return ", ".join(parts)
