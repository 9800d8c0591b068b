"""`strainwave read-log`: the channels of a log as a table, a figure, and CSV in SI."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ....base.facts import Fact, data, lines
from ....base.number_text import unit_text
from ....base.results import Floats
from ....files.logs.read import read_log as log_of
from ....plot.fits import log_panels
from ....plot.svg import WIDTH, stacked
from ....study.identification.log import Log, LogSegment
from ...console import echo, in_options, staged, to_json
from ..options import file_type, json_option, output_option, reading_options

CSV, SVG = "log.csv", "log.svg"
PRINTED = 20  # segments on a terminal
SIZES = ("least", "largest", "mean", "rms")  # of a channel


@click.command()
@click.argument("file", type=file_type)
@output_option("Folder for log.csv and log.svg.")
@reading_options
@json_option
def read_log(file: Path, output: Path | None, as_json: bool, **reading: Any) -> None:
    """Read a log; print its channels and what is doubtful in it.

    FILE is CSV in any dialect, gzipped too, .npz, .mat, .parquet, .mf4, .mcap or a guide log of PHD2. Angles and speeds
    of the load refer to the output shaft.
    """
    read = log_of(file, keep=True, **reading)
    parts = read.segments() if read.moving else ()
    if output is not None:
        with staged(output) as folder:
            read.save(folder / CSV)
            drawn = stacked(log_panels(read, parts), 165.0, "a log over time", WIDTH)
            (folder / SVG).write_text(drawn + "\n", encoding="utf-8")
    report = facts(file, read, parts)
    written = [] if output is None else [f"written: {output / CSV}, {output / SVG}"]
    echo(to_json(data(report)) if as_json else "\n".join([*lines(report), *written]))


def _sizes(values: Floats) -> list[float]:
    """Least and largest value, mean and root mean square."""
    return [float(size) for size in (np.min(values), np.max(values), np.mean(values), np.sqrt(np.mean(values**2)))]


def facts(file: Path, log: Log, parts: tuple[LogSegment, ...]) -> tuple[Fact, ...]:
    """Every fact of a log, once."""
    sizes, shaft = {name: _sizes(values) for name, values in log.channels.items()}, "motor"
    if {"load_angle", "load_speed"} & set(log.channels):
        shaft = "load"
    stretches = tuple(_row(part, shaft) for part in parts)
    rows = [(name, unit_text(log.units[name]) or "–", *some) for name, some in sizes.items()]
    channels = {name: {"unit": log.units[name], **dict(zip(SIZES, some, strict=True))} for name, some in sizes.items()}
    gaps = [f"{gap.start:.13g} to {gap.stop:.13g} s" for gap in log.gaps[:5]]
    gaps += [f"{len(log.gaps) - 5} more"] if len(log.gaps) > 5 else []
    return (
        Fact("file", file.name),
        Fact("", f"{file.name}: {log.length}", "{}"),
        Fact("samples", len(log)), Fact("start_s", log.time[0]), Fact("stop_s", log.time[-1]),
        Fact("rate_hz", log.rate), Fact("jitter_s", log.jitter), Fact("channels", channels),
        Fact("", tuple(tuple(map(Fact, [""] * 6, row, ("channel", "unit", *SIZES))) for row in rows), "{}"),
        Fact("segments", stretches), Fact("", stretches[:PRINTED], "{}"),
        Fact("", (f"{len(parts) - PRINTED} more",) * (len(parts) > PRINTED), "segments: {}"),
        Fact("ratio", log.ratio, "" if log.ratio is None else "the motor turns {} times as far as the load"),
        Fact("gaps", [gap._asdict() for gap in log.gaps]), Fact("", tuple(gaps), "gap: {}"),
        Fact("notes", tuple(map(in_options, log.notes)), "note: {}"),
        Fact("doubts", tuple(map(in_options, log.doubts)), "doubt: {}"),
    )  # fmt: skip


def _row(part: LogSegment, shaft: str) -> tuple[Fact, ...]:
    return (
        Fact("kind", part.kind, "segment"), Fact("start_s", part.start), Fact("stop_s", part.stop),
        Fact("", f"{part.start:.13g}", "from [s]"), Fact("", f"{part.stop:.13g}", "to [s]"),
        Fact("speed_rad_per_s", part.speed, f"{shaft} speed"),
        Fact("acceleration_rad_per_s2", part.acceleration, "acceleration"),
    )  # fmt: skip
