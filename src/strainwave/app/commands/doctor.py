"""`strainwave doctor`: versions, cache, processor and optional parts of this installation."""

import importlib.metadata
import importlib.util
import os
import platform
import sys
import tempfile
from pathlib import Path
from typing import Any

import click

from ... import __version__
from ...compile import cache, jit
from ...compile.jit import target_cpu
from ..console import to_json
from .options import json_option

CORE = ("numpy", "scipy", "numba", "llvmlite", "xarray", "zarr", "pint", "ruamel.yaml", "click", "rich", "platformdirs")
EXTRAS = {
    "plot": ("matplotlib",),
    "report": ("jinja2",),
    "sym": ("sympy",),
    "cluster": ("distributed",),
    "control": ("control",),
    "fmi": ("fmpy",),
    "logs": ("pyarrow", "asammdf", "mcap_ros2"),
    "docs": ("sphinx", "myst_parser", "sphinx_gallery", "furo"),
    "dev": ("pytest", "hypothesis", "ruff", "mypy"),
}


def report() -> dict[str, Any]:
    """Collect the facts that `doctor` prints."""
    units, cpu = target_cpu()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    folder = cache.cache_folder()
    writable, reason = _writable(folder)
    size = sum(f.stat().st_size for f in folder.glob("**/*") if f.is_file()) if os.path.isdir(folder) else 0
    return {
        "strainwave": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "packages": {name: _version(name) for name in CORE},
        "compilation": "on" if jit.enabled() else "off (STRAINWAVE_JIT=0 or NUMBA_DISABLE_JIT=1)",
        "cache": {"folder": str(folder), "writable": writable, "why": reason, "bytes": size},
        "cores": {"machine": os.cpu_count(), "usable": cores},
        "cpu": cpu,
        "simd": units,
        "extras": {extra: all(importlib.util.find_spec(m) for m in modules) for extra, modules in EXTRAS.items()},
    }


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _writable(folder: Path) -> tuple[bool, str]:
    """Whether compiled code can be stored, tried in the nearest folder that exists; and the reason where it cannot."""
    place = folder
    while not os.path.exists(place) and place != place.parent:
        place = place.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            return True, ""
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        return False, f"{place}: {reason}; set STRAINWAVE_CACHE_DIR to a folder that can be written"


@click.command()
@json_option
def doctor(as_json: bool) -> None:
    """Report versions, cache, processor and optional parts."""
    facts = report()
    if as_json:
        click.echo(to_json(facts))
        return
    cache, cores = facts["cache"], facts["cores"]
    state = (
        "writable" if cache["writable"] else f"NOT writable, so code is compiled again at every start: {cache['why']}"
    )
    rows = {
        "system": facts["system"],
        "cpu": f"{facts['cpu']}, {cores['usable']} of {cores['machine']} cores usable",
        "simd": " ".join(facts["simd"]) or "none known",
        "compilation": facts["compilation"],
        "cache": f"{cache['folder']} ({cache['bytes'] / 1e6:.1f} MB, {state})",
        "packages": ", ".join(f"{name} {v or 'MISSING'}" for name, v in facts["packages"].items()),
    }
    for extra, installed in facts["extras"].items():
        rows[f"extra {extra}"] = "installed" if installed else f"not installed; pip install 'strainwave[{extra}]'"
    click.echo(f"strainwave {facts['strainwave']}, Python {facts['python']} ({facts['executable']})")
    click.echo("\n".join(f"{name:<13} {value}" for name, value in rows.items()))
