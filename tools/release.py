"""Check what a user will install: `python tools/release.py python3.11 python3.12 python3.13`.

Builds the wheel, and under Linux on x86-64 one that brings the code of kernels for each Python given (without any: the
one that runs this), into `dist`. Holds them under 3 MB, installs each in an empty environment, and runs there the
README's first script and the reports of `demo`, away from the clone. Standard library only; pip needs its index.
"""

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parent.parent
LARGEST = 3_000_000  # bytes of the wheel
DATA = (
    "app/report/page.css",
    "app/projects/antenna.yaml",
    "app/web/static/index.html",
    "base/units.txt",
    "files/fields/descriptions.txt",
    "py.typed",
)


def run(command: list[str | Path], folder: Path, **more: str) -> str:
    """Run a command away from the clone and return what it prints; a failure ends the check with its messages."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | more
    done = subprocess.run(command, cwd=folder, env=clean, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"release: `{' '.join(map(str, command))}` ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def build(python: str | Path, folder: Path, kernels: bool = False) -> Path:
    """Build the wheel, with the code of kernels or without, and check its size and the files that are not Python."""
    made = folder / ("kernels" if kernels else "plain")
    command = [python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", made, ROOT]
    run(command, folder, STRAINWAVE_KERNELS=f"{kernels:d}")
    wheel = next(made.glob("*.whl"))
    names = ZipFile(wheel).namelist()
    missing = [name for name in (*DATA, *["compile/kernels.xz"] * kernels) if f"strainwave/{name}" not in names]
    if missing:
        sys.exit(f"release: {wheel.name} lacks {', '.join(missing)}")
    if wheel.stat().st_size >= LARGEST:
        sys.exit(f"release: {wheel.name} has {wheel.stat().st_size} bytes, the limit is {LARGEST}")
    print(f"{wheel.name}: {wheel.stat().st_size} bytes, {len(names)} files", flush=True)
    return wheel


def first_script() -> tuple[str, str]:
    """Return the README's first script and what the README says that it prints."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    found = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", readme, re.DOTALL)
    if found is None:
        sys.exit("release: README.md has no script with its output")
    return found[1], found[2]


def check(plain: Path, python: str, folder: Path) -> Path:
    """Install a wheel with one Python, with kernels where it can be, and run the README's script and reports."""
    started = time.perf_counter()
    home = folder / f"env-{re.sub(r'[^0-9A-Za-z.]', '-', python)}"
    if python == sys.executable:
        venv.create(home, with_pip=True)
    else:
        run([python, "-m", "venv", home], folder)
    programs, wheel = home / ("Scripts" if os.name == "nt" else "bin"), plain
    inside = programs / "python"
    pip = [inside, "-m", "pip", "install", "--quiet", "-c", ROOT / "constraints.txt"]
    run([*pip, f"{plain}[plot,web]"], folder)
    if (sys.platform, platform.machine()) == ("linux", "x86_64"):
        run([inside, ROOT / "tools" / "kernels.py"], folder)
        wheel = build(inside, home, kernels=True)
        run([*pip, "--force-reinstall", "--no-deps", wheel], folder)
    script, expected = first_script()
    printed = run([inside, "-c", script], folder)
    if printed != expected:
        sys.exit(f"release: with {python} the README's script prints\n{printed}in place of\n{expected}")
    run([programs / "strainwave", "demo", "-o", home / "demo"], folder, STRAINWAVE_CACHE_DIR=str(home / "cache"))
    version = run([inside, "-c", "import platform; print(platform.python_version())"], folder).strip()
    print(f"Python {version}: installed, script and reports right, {time.perf_counter() - started:.0f} s", flush=True)
    return wheel


def main() -> None:
    """Build once, check with every Python."""
    parser = argparse.ArgumentParser(description="Build the wheel and try it in empty environments.")
    parser.add_argument("pythons", nargs="*", default=[sys.executable], help="programs, such as python3.12")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plain = build(sys.executable, folder)
        wheels = {plain, *(check(plain, python, folder) for python in chosen.pythons)}
        (ROOT / "dist").mkdir(exist_ok=True)
        for wheel in wheels:
            shutil.copy(wheel, ROOT / "dist")


if __name__ == "__main__":
    main()
