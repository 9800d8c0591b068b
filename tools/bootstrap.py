"""Install what a task needs into .venv, then run the task: `python tools/bootstrap.py test`.

Standard library only. The installation is skipped when the stamp in .venv says that these files, this Python and
these extras are already there.
"""

from __future__ import annotations  # so that an old Python gets as far as check_python

import argparse
import hashlib
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
SCRIPTS = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = SCRIPTS / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "installed.stamp"
OLDEST, NEWEST = (3, 11), (3, 13)
PYTEST = ["pytest", "-q", "-n", "auto", "--dist", "loadfile", "--no-loadscope-reorder"]
FAST, REST = ["-m", "not slow or guard"], ["-m", "slow and not guard"]
SINGLE = {"OPENBLAS_NUM_THREADS": "1"}  # each test process has a core: threads of its own would take that of others
NETWORK_SIGNS = (
    "connection",
    "from versions: none",
    "getaddrinfo",
    "max retries",
    "name resolution",
    "proxy",
    "timed out",
)


def fail(sentence: str) -> None:
    """Leave with one sentence on standard error."""
    sys.exit(f"bootstrap: {sentence}")


def check_python() -> None:
    """Refuse a Python that the dependencies do not serve."""
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        fail(
            f"Python {sys.version_info[0]}.{sys.version_info[1]} is not supported; run this with Python 3.11, 3.12 or "
            "3.13 (for make: `make PYTHON=python3.12 test`)."
        )


def fingerprint() -> str:
    """Return the hash of all that decides what gets installed, the extras left aside."""
    parts = [(ROOT / name).read_bytes() for name in ("pyproject.toml", "constraints.txt")]
    return hashlib.sha256(b"\0".join([*parts, sys.version.encode(), str(ROOT).encode()])).hexdigest()


def versions() -> str:
    """Return the hash of names and versions of what .venv has: `uv run` puts others in place of those constrained."""
    found = [*VENV.glob("lib/python*/site-packages/*.dist-info"), *VENV.glob("Lib/site-packages/*.dist-info")]
    return hashlib.sha256("\n".join(sorted(path.name for path in found)).encode()).hexdigest()


def installed_extras(key: str) -> set[str] | None:
    """Return the extras that the stamp promises, None when it is absent or .venv is of something else."""
    try:
        stamped, installed, *extras = STAMP.read_text(encoding="utf-8").split()
    except (OSError, ValueError):
        return None
    return set(extras) if (stamped, installed) == (key, versions()) and PYTHON.exists() else None


def usable() -> bool:
    """Tell whether .venv is whole, was made by this Python, and has not been moved or copied here."""
    probe = "import sys, pip; print(sys.version)"
    try:
        made_here = str(VENV) in (VENV / "pyvenv.cfg").read_text(encoding="utf-8")
        run = subprocess.run([PYTHON, "-c", probe], capture_output=True, text=True, check=False)
    except OSError:
        return False
    return made_here and run.returncode == 0 and run.stdout.strip() == sys.version.strip()


def create() -> None:
    """Make .venv, in the place of one that another Python made or that was left half-made."""
    if importlib.util.find_spec("ensurepip") is None:
        major, minor = sys.version_info[:2]
        fail(
            f"{sys.executable} has no module ensurepip, which puts pip into .venv; on Debian or Ubuntu run "
            f"`apt install python{major}.{minor}-venv`, elsewhere take a Python that has it, then run this again."
        )
    if VENV.exists():
        print("building .venv anew: it is incomplete, or from another Python or folder", flush=True)
    run = subprocess.run([sys.executable, "-m", "venv", "--clear", VENV], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        reason = (run.stdout + run.stderr).strip().splitlines() or ["no reason given"]
        fail(f"Python could not create {VENV} ({reason[-1].strip()}); mend that, then run this again.")


def install(extras: Sequence[str]) -> None:
    """Install the package in place, with its extras, into .venv, unless the stamp says that this is done."""
    key = fingerprint()
    present = installed_extras(key)
    if present is not None and present >= set(extras):
        return
    started = time.perf_counter()
    wanted = sorted((present or set()) | set(extras))
    STAMP.unlink(missing_ok=True)
    print(f"installing strainwave[{','.join(wanted)}] into .venv, about a minute ...", flush=True)
    if not usable():
        create()
    # Python compiles what it imports; compiling all of SymPy and SciPy beforehand would take as long as the rest.
    pip = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--no-compile"]
    what = ["-c", "constraints.txt", "-e", f".[{','.join(wanted)}]"]
    run = subprocess.run([*pip, *what], cwd=ROOT, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode != 0:
        sys.stderr.write(run.stderr)
        errors = run.stderr.lower()
        if any(sign in errors for sign in NETWORK_SIGNS):
            fail("pip could not reach the package index (see above); check the network or proxy, then run this again.")
        fail(f"pip failed with exit code {run.returncode} (its messages are above); mend that, then run this again.")
    draft = STAMP.with_suffix(".part")
    draft.write_text("\n".join([key, versions(), *wanted, ""]), encoding="utf-8")
    draft.replace(STAMP)
    print(f"installed in {time.perf_counter() - started:.0f} s", flush=True)


def run_all(commands: Sequence[list[str]], **env: str) -> list[str]:
    """Run every command from the project root and return those that failed."""
    failed = []
    for command in commands:
        shown = shlex.join(command)
        print(f"$ {shown}", flush=True)
        program = shutil.which(command[0], path=str(SCRIPTS))
        if program is None:
            fail(f"{command[0]} is missing from .venv; delete that folder and run this again.")
        if subprocess.run([str(program), *command[1:]], cwd=ROOT, env=os.environ | env, check=False).returncode != 0:
            failed.append(shown)
    return failed


def demo(rest: list[str]) -> list[str]:
    """Run the demonstration of the command line."""
    return run_all([["strainwave", "demo", *rest]])


def lint(rest: list[str]) -> list[str]:
    """Check style, types, layers and size."""
    checks = [["ruff", "check"], ["ruff", "format", "--check"], ["mypy", *rest], ["lint-imports"]]
    return run_all([*checks, ["python", "tools/budget.py", "--check"]])


def test(rest: list[str]) -> list[str]:
    """Lint, and run the fast tests and those of tests/guard.txt."""
    return lint([]) + run_all([[*PYTEST, *FAST, *rest]], **SINGLE)


def test_all(rest: list[str]) -> list[str]:
    """Lint, and run all tests."""
    return lint([]) + run_all([[*PYTEST, *rest]], **SINGLE)


def check(rest: list[str]) -> list[str]:
    """Build the documentation, then run the tests that `test` leaves out."""
    return docs(["-D", "plot_gallery=0"]) + run_all([[*PYTEST, *REST, *rest]], **SINGLE)  # tests run the examples


def coverage(rest: list[str]) -> list[str]:
    """Measure the coverage of the tests that run as Python, which takes three times as long as running them."""
    return run_all([[*PYTEST, "-m", "not slow", "--cov", "--cov-report=term", *rest]], **SINGLE)


def docs(rest: list[str]) -> list[str]:
    """Build the documentation into docs/_build/html, a warning being an error."""
    failed = run_all(
        [["sphinx-build", "-E", "-W", "--keep-going", "-q", "-b", "html", *rest, "docs", "docs/_build/html"]]
    )
    if not failed:
        print("open docs/_build/html/index.html")
    return failed


def figures(rest: list[str]) -> list[str]:
    """Make the figure and the screenshot of the README anew."""
    return run_all([["python", "tools/figures.py", *rest], ["python", "tools/screenshot.py"]])


def bench(rest: list[str]) -> list[str]:
    """Run the benchmarks, each a script of its own."""
    scripts = rest or ["benchmarks/simulate.py", "benchmarks/response.py"]
    return run_all([["python", script] for script in scripts])


TESTED = ("plot", "web", "sym", "cluster", "control", "fmi", "dev")
TASKS: dict[str, tuple[Callable[[list[str]], list[str]], tuple[str, ...]]] = {
    "demo": (demo, ()),
    "test": (test, TESTED),
    "test-all": (test_all, TESTED),
    "check": (check, (*TESTED, "docs")),
    "coverage": (coverage, TESTED),
    "docs": (docs, ("plot", "sym", "docs")),
    "figures": (figures, ("plot", "web", "dev")),
    "lint": (lint, ("plot", "web", "sym", "cluster", "dev")),
    "bench": (bench, ("plot", "sym", "cluster", "dev")),
}


def main() -> None:
    """Read the task, install what it needs, run it."""
    parser = argparse.ArgumentParser(description="Install what a task needs into .venv, then run the task.")
    parser.add_argument("task", choices=TASKS)
    parser.add_argument("rest", nargs=argparse.REMAINDER, help="passed on to the task's (last) command")
    chosen = parser.parse_args()
    check_python()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # each of some hundred processes would compile all that it imports
    task, extras = TASKS[chosen.task]
    try:
        install(extras)
        failed = task(chosen.rest)
    except KeyboardInterrupt:
        print("\nbootstrap: interrupted; run it again to go on.", file=sys.stderr)
        sys.exit(130)
    if failed:
        fail("failed: " + "; ".join(failed))


if __name__ == "__main__":
    main()
