"""`strainwave compare`: several project files side by side, in one table and one figure."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ...base.units import ARCSEC, RPM
from ...files.reading import read_project
from ...files.variants.comparison import ProjectComparison, compare_projects
from ...plot.drive import comparison_panels
from ...plot.svg import stacked
from ..console import Progress, finished, number, print_table, to_json
from ..output import staged
from ..report.report import comparison_page
from .design import as_csv
from .options import file_type, json_option, output_option

CSV, SVG, HTML = "comparison.csv", "comparison.svg", "comparison.html"


@click.command()
@click.argument("projects", type=file_type, nargs=-1, required=True)
@output_option("Folder for comparison.html, .csv and .svg.", required=True)
@json_option
def compare(projects: tuple[Path, ...], output: Path, as_json: bool) -> None:
    """Put the response of several project files side by side: one table, one figure."""
    drives = [read_project(path) for path in projects]
    if len({drive.speeds.by_motor for drive in drives}) > 1:
        raise ValueError("some projects have speeds of a forcing, others of a shaft; compare one kind at a time")
    with Progress("comparison") as progress:
        found, stop = finished(lambda: compare_projects(drives, progress=lambda t, s: progress.show(t, 0.95 * s)))
        progress.show("writing", 0.95)
        rows = _rows(found, [path.name for path in projects[: len(found.titles)]])
        with staged(output) as folder:
            text = as_csv(list(rows[0]), [row.values() for row in rows])
            (folder / CSV).write_text(text, encoding="utf-8", newline="\n")
            limits = [drive.limit for drive in drives]
            panels = comparison_panels(found.titles, found.responses, limits, drives[0].speeds)
            figure = stacked(panels, 360.0, "oscillation of several drives over the speed")
            (folder / SVG).write_text(figure + "\n", encoding="utf-8")
            (folder / HTML).write_text(comparison_page(rows, figure), encoding="utf-8", newline="\n")
    if as_json:
        click.echo(to_json({"drives": rows}))
    else:
        _print(rows, output)
    if stop is not None:
        raise stop


def _print(rows: list[dict[str, Any]], output: Path) -> None:
    columns = (
        "file",
        "gear",
        "oscillation arcsec",
        "at rpm",
        "load N·m",
        "torque N·m",
        "ω₀ rad/s",
        "folds",
        "limit arcsec",
    )
    cells = [
        (row["file"], row["gear"], row["oscillation_arcsec"], row["speed_rpm"], row["load_torque_N_m"],
         row["torque_N_m"], row["omega_0_rad_per_s"], number(row["folds"]), row["limit_arcsec"])
        for row in sorted(rows, key=lambda row: row["oscillation_arcsec"])
    ]  # fmt: skip
    print_table(
        "drives by their largest oscillation",
        columns,
        cells,
        "speeds are those of the motor or the forcing; all torques of the load count, gravity among them",
    )
    for row in rows:
        click.echo(f"  {row['file']}: {row['verdict']}; speeds to keep out of: {row['keep_out_of']}")
        if row["failures"]:
            click.echo(f"    {row['failures']}")
    click.echo(f"written: {', '.join(str(output / name) for name in (HTML, CSV, SVG))}")


def _rows(found: ProjectComparison, files: list[str]) -> list[dict[str, Any]]:
    def known(value: float) -> float | None:
        return float(value) if np.isfinite(value) else None

    return [
        {
            "file": files[i], "title": found.titles[i], "gear": found.gears[i],
            "oscillation_arcsec": float(found.oscillation[i]) / ARCSEC, "speed_rpm": float(found.speed[i]) / RPM,
            "load_torque_N_m": float(found.load[i]), "lowest_load_torque_N_m": float(found.lowest_load[i]),
            "highest_load_torque_N_m": float(found.highest_load[i]), "verdict": found.verdicts[i].answer.value,
            "keep_out_of": found.keep_out_of(i) or "none", "torque_N_m": float(found.torque[i]),
            "omega_0_rad_per_s": float(found.omega_0[i]),
            "damping_ratio": known(found.damping_ratio[i]),
            "reflected_inertia_kg_m2": float(found.reflected_inertia[i]),
            "load_inertia_kg_m2": float(found.load_inertia[i]), "folds": int(found.jumps[i]),
            "limit_arcsec": known(found.limit[i] / ARCSEC),
            "failures": found.failures[i],
        }
        for i in range(len(files))
    ]  # fmt: skip
