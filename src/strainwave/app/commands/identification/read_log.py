"""`strainwave read-log`: the channels of a log as a table, a figure, and CSV in SI."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ....base.results import Floats
from ....files.logs.read import read_log as log_of
from ....plot.fits import log_panels
from ....plot.svg import WIDTH, stacked
from ....study.identification.log import Log, LogSegment
from ...console import in_options, number, print_table, staged, to_json
from ...view import sign
from ..options import file_type, json_option, output_option, reading_options

CSV, SVG = "log.csv", "log.svg"
SIZES = ("least", "largest", "mean", "rms")  # of a channel


@click.command()
@click.argument("file", type=file_type)
@output_option("Folder for log.csv and log.svg.")
@reading_options
@json_option
def read_log(file: Path, output: Path | None, as_json: bool, **reading: Any) -> None:
    """Read a log and say what is in it, and what is doubtful.

    FILE is CSV in any dialect, gzipped too, .npz, .mat, .parquet, .mf4, .mcap or a guide log of PHD2. Angles and speeds
    of the load count on the output shaft.
    """
    read = log_of(file, **reading)
    parts = read.segments() if read.moving else ()
    if output is not None:
        with staged(output) as folder:
            read.save(folder / CSV)
            (folder / SVG).write_text(
                stacked(log_panels(read, parts), 165.0, "a log over the time", WIDTH) + "\n", encoding="utf-8"
            )
    if as_json:
        click.echo(to_json(_data(file, read, parts)))
        return
    _print(file, read, parts)
    if output is not None:
        click.echo(f"written: {output / CSV}, {output / SVG}")


def _sizes(values: Floats) -> list[float]:
    """Least and largest value, mean and root mean square."""
    return [float(size) for size in (np.min(values), np.max(values), np.mean(values), np.sqrt(np.mean(values**2)))]


def _data(file: Path, log: Log, parts: tuple[LogSegment, ...]) -> dict[str, Any]:
    return {
        "file": file.name,
        "samples": len(log),
        "start_s": log.time[0],
        "stop_s": log.time[-1],
        "rate_hz": log.rate,
        "jitter_s": log.jitter,
        "ratio": log.ratio,
        "channels": {
            name: {"unit": log.units[name], **dict(zip(SIZES, _sizes(values), strict=True))}
            for name, values in log.channels.items()
        },
        "gaps": [gap._asdict() for gap in log.gaps],
        "segments": [
            {
                "kind": part.kind, "start_s": part.start, "stop_s": part.stop, "speed_rad_per_s": part.speed,
                "acceleration_rad_per_s2": part.acceleration,
            }
            for part in parts
        ],
        "notes": list(map(in_options, log.notes)),
        "doubts": list(map(in_options, log.doubts)),
    }  # fmt: skip


def _print(file: Path, log: Log, parts: tuple[LogSegment, ...]) -> None:
    rows = [(name, sign(log.units[name]) or "–", *_sizes(values)) for name, values in log.channels.items()]
    title = f"{file.name}: {len(log)} samples, {log.time[0]:.6g} to {log.time[-1]:.6g} s, {number(log.rate, 6)} Hz"
    print_table(title, ("channel", "unit", *SIZES), rows)
    if parts:
        body = [(part.kind, f"{part.start:.13g}", f"{part.stop:.13g}", part.speed, part.acceleration) for part in parts]
        shaft = "load" if {"load_angle", "load_speed"} & set(log.channels) else "motor"
        columns = ("segment", "from (s)", "to (s)", f"{shaft} speed (rad/s)", "acceleration (rad/s²)")
        print_table("", columns, body)
    if log.ratio is not None:
        click.echo(f"the motor turns {number(log.ratio, 6)} times as far as the load")
    gaps = [f"{gap.start:.13g} to {gap.stop:.13g} s" for gap in log.gaps[:5]]
    gaps += [f"{len(log.gaps) - 5} more"] if len(log.gaps) > 5 else []
    for kind, texts in {"gap": gaps, "note": log.notes, "doubt": log.doubts}.items():
        for text in texts:
            click.echo(f"{kind}: {in_options(text)}")
