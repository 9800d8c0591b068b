"""`strainwave doctor`: versions, cache, processor and optional parts of this installation."""

import importlib.metadata
import importlib.util
import os
import platform
import sys
import tempfile
from pathlib import Path

import click

from .... import __version__
from ....base.facts import Fact, data, lines
from ....compile import cache, jit
from ....compile.numba_import import target_cpu
from ...console import to_json
from ...console.terminal import echo
from ..options import json_option

CORE = ("numpy", "scipy", "numba", "llvmlite", "xarray", "zarr", "pint", "ruamel.yaml", "click", "rich", "platformdirs")
OFF = "off (STRAINWAVE_JIT=0 or NUMBA_DISABLE_JIT=1)"
EXTRAS = {
    "plot": ("matplotlib",),
    "sym": ("sympy",),
    "cluster": ("distributed",),
    "control": ("control",),
    "fmi": ("fmpy",),
    "logs": ("pyarrow", "asammdf", "mcap_ros2"),
    "docs": ("sphinx", "myst_parser", "sphinx_gallery", "furo"),
    "dev": ("pytest", "hypothesis", "ruff", "mypy"),
}


def facts() -> tuple[Fact, ...]:
    """Everything that `doctor` says, once."""
    units, cpu = target_cpu()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    folder = cache.cache_folder()
    writable, reason = _writable(folder)
    size = sum(f.stat().st_size for f in folder.glob("**/*") if f.is_file()) if os.path.isdir(folder) else 0
    state = "writable" if writable else f"NOT writable, so code is compiled again at every start: {reason}"
    packages = {name: _version(name) for name in CORE}
    extras = {extra: all(importlib.util.find_spec(m) for m in modules) for extra, modules in EXTRAS.items()}
    return (
        Fact("strainwave", __version__, "strainwave {}"), Fact("python", platform.python_version(), "Python: {}"),
        Fact("executable", sys.executable, "executable: {}"),
        Fact("system", f"{platform.system()} {platform.release()} {platform.machine()}", "system: {}"),
        Fact("cpu", cpu, f"cpu: {{}}, {cores} of {os.cpu_count()} cores usable"),
        Fact("cores", {"machine": os.cpu_count(), "usable": cores}),
        Fact("simd", units), Fact("", " ".join(units) or "none known", "simd: {}"),
        Fact("compilation", "on" if jit.enabled() else OFF, "compilation: {}"),
        Fact("cache", {"folder": str(folder), "writable": writable, "why": reason, "bytes": size}),
        Fact("", f"{folder} ({size / 1e6:.1f} MB, {state})", "cache: {}"),
        Fact("packages", packages),
        Fact("", ", ".join(f"{name} {v or 'MISSING'}" for name, v in packages.items()), "packages: {}"),
        Fact("extras", extras),
        Fact("", tuple(f"{one}: installed" if installed else f"{one}: not installed; pip install 'strainwave[{one}]'"
                       for one, installed in extras.items()), "extra {}"),
    )  # fmt: skip


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _writable(folder: Path) -> tuple[bool, str]:
    """True where compiled code can be stored, by a trial in the nearest existing folder; and the reason where not."""
    existing = folder
    while not os.path.exists(existing) and existing != existing.parent:
        existing = existing.parent
    try:
        with tempfile.TemporaryFile(dir=existing):
            return True, ""
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        return False, f"{existing}: {reason}; set STRAINWAVE_CACHE_DIR to a folder that can be written"


@click.command()
@json_option
def doctor(as_json: bool) -> None:
    """Report versions, cache, processor and optional parts."""
    report = facts()
    echo(to_json(data(report)) if as_json else "\n".join(lines(report)))
