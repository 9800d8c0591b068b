"""Content of an uploaded log: its channels, stretches and orders, and the parameters identified from it."""

import math
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from scipy.io import whosmat

from ...base.number_text import unit_text
from ...base.terminal import Progress
from ...base.units import ARCSEC
from ...drive.project import Project
from ...files.logs.names import canonical, named
from ...files.logs.read import columns_of, read_log
from ...files.logs.table import unit_of
from ...files.variants.identify_log import IdentifiedLog, identify_log
from ...study.identification.channels import with_torsion
from ...study.identification.joint.answer import torsion_of
from ...study.identification.log import Log
from ...study.identification.orders.order_scan import order_scan
from ...study.identification.run import CANONICAL
from .requests import LogColumns, Refused
from .state import yaml_of

SUFFIXES = (".csv", ".txt", ".dat", ".npz", ".mat", ".parquet", ".mf4", ".mcap")
MOST_SHOWN, MOST_LINES = 2000, 12
MOST_UNPACKED = 256 << 20  # bytes of a packed log
CALLS = r"(columns|units)=(\{.*?\}|\[.*?\]|names)"  # arguments of the library in its sentences
HIGHEST = 60.0  # order that a log is searched for


def log_of(name: str, content: bytes, chosen: LogColumns) -> dict[str, Any]:
    """Content of a log: channels, segments, orders of the deviation; or its columns, and why it cannot be read so.

    Raises
    ------
    Refused
        If there is no table in it.
    """
    with _filed(name, content) as path:
        rows = [
            {"name": one.name, "unit": unit_of(one), "channel": canonical(named(one.name).name) or ""}
            for one in columns_of(path, None, None)[0]
        ]
        table = {"columns": rows, "as": ["time", *CANONICAL]}
        try:
            log = read_log(path, chosen.columns or None, chosen.units, rate=chosen.rate)
        except (ValueError, RuntimeError) as error:
            why = re.sub(CALLS, "it in the table of columns", _sentence(error, path))
            return table | {"why": why.replace("log:1:1: file:", "it")}
        return table | {"why": ""} | _log_data(log)


def identified(project: Project, name: str, content: bytes, chosen: LogColumns, progress: Progress) -> dict[str, Any]:
    """Parameters of a drive identified from a log with both angles, and the project file with them (Refused)."""
    with _filed(name, content) as path:
        log = read_log(path, chosen.columns or None, chosen.units, rate=chosen.rate, trim=0.0)
    fit = identify_log(log, project=project, progress=progress)
    joint = fit.answer.joint
    residual = np.concatenate(joint.residuals())
    measured = np.concatenate([torsion_of(joint, i) for i in range(len(joint.pieces))])
    step = max(1, len(residual) // MOST_SHOWN)
    curves = {"measured": measured, "computed": measured + residual, "residual": residual}
    return {
        "headline": fit.headline(),
        "usable": fit.usable,
        "numbers": [_number(fit, name) for name in fit.values],
        "time": np.concatenate([piece.time for piece in joint.pieces])[::step],
        **{f"{name}_arcsec": values[::step] / ARCSEC for name, values in curves.items()},
        "rms_arcsec": fit.answer.residual / ARCSEC,
        "project": None if fit.project is None else yaml_of(fit.project),
        "remarks": fit.quality(),
    }


def _number(fit: IdentifiedLog, name: str) -> dict[str, Any]:
    low, high = fit.interval(name)
    unit, size = unit_text(fit.unit(name)), 1.0
    if name.startswith("line"):
        unit, size = "arcsec", ARCSEC
    return {"name": name, "value": fit.value(name) / size, "low": low / size, "high": high / size, "unit": unit}


def unpacked(path: Path) -> int:
    """Bytes of the arrays of a packed log by its headers; 0 for other files and for files that the reader refuses."""
    with suppress(Exception):  # whatever packed bytes lead to: the reader says what is wrong
        if path.suffix == ".npz":
            with ZipFile(path) as packed:
                return sum(member.file_size for member in packed.infolist())
        if path.suffix == ".mat":
            return sum(8 * math.prod(shape) for _, shape, _ in whosmat(path))
    return 0


@contextmanager
def _filed(name: str, content: bytes) -> Iterator[Path]:
    """The log as a file of its kind; its faults are reported without the file's path (Refused)."""
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES:
        raise Refused(f"a log ends in {', '.join(SUFFIXES)}; this name ends in {suffix[:20]!r}")
    if not content:
        raise Refused("the log is empty")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log{suffix}"
        path.write_bytes(content)
        if unpacked(path) > MOST_UNPACKED:
            raise Refused(f"the log unpacks to more than {MOST_UNPACKED >> 20} MiB; shorten it first")
        try:
            yield path
        except (ValueError, RuntimeError) as error:
            raise Refused(_sentence(error, path)) from None


def _sentence(error: Exception, path: Path) -> str:
    """Sentence on a fault of a log, without the path of its file."""
    return " ".join(str(error).replace(str(path), "log").split())


def _log_data(log: Log) -> dict[str, Any]:
    step = max(1, len(log) // MOST_SHOWN)
    return {
        "said": log.length,
        "samples": len(log),
        "ratio": log.ratio,
        "time": log.time[::step],
        "channels": [
            {"name": name, "unit": log.units[name], "low": np.min(v), "high": np.max(v), "values": v[::step]}
            for name, v in log.channels.items()
        ],
        "pointing": _pointing(log, step),
        "orders": _orders(log),
        "notes": [*log.notes, *log.doubts],
    }


def _pointing(log: Log, step: int) -> dict[str, Any] | None:
    """The error x between motor and load about its mean; None without both angles of a gear."""
    if not log.ratio:
        return None
    try:
        error = with_torsion(log.channels, log.ratio)["torsion"] / ARCSEC
    except ValueError:
        return None
    return {"name": "dynamic_error", "unit": "arcsec", "values": (error - np.nanmean(error))[::step]}


def _orders(log: Log) -> dict[str, Any]:
    """Lines of the error between both shafts, or of the torque, over the angle; or the reason without any."""
    channels = log.channels
    angle = next((name for name in ("motor_angle", "load_angle") if name in channels), None)
    value = next((n for n in channels if n.endswith(("error", "torque", "current", "torsion"))), None)
    if angle is None or value is None:
        return {"lines": [], "why": "orders need an angle and an error, a torque or a current in the log"}
    turning = [part for part in log.segments() if part.kind == "constant speed"]
    try:
        runs = [log.run(value, angle, part=part) for part in turning[:8]] or [log.run(value, angle)]
        scan = order_scan(runs, highest=HIGHEST)
    except ValueError as error:
        return {"lines": [], "why": " ".join(str(error).split())}
    lines = sorted(scan.lines, key=lambda line: -line.amplitude)[:MOST_LINES]
    return {
        "of": value,
        "over": angle,
        "unit": scan.unit,
        "lines": [
            {"order": ln.order, "amplitude": ln.amplitude, "error": ln.amplitude_error, "kind": ln.kind} for ln in lines
        ],
        "why": "" if lines else "no order exceeds the noise",
    }
