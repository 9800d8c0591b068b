"""Functional mock-up units: the plant in C with the interface FMI 2.0 or 3.0, as sources and, with a compiler, built.

The same plant gives the same file to the byte, on one machine with one compiler.
"""

import hashlib
import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import UUID

from ...base.archive import atomic
from .model_description import build_description, description_2, description_3
from .plant import Plant
from .plant_code import plant_code

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared", "-fPIC")
ENDINGS = {"linux": ".so", "darwin": ".dylib", "win32": ".dll"}
X86 = {"linux": "linux64", "darwin": "darwin64", "win32": "win64"}  # folders of FMI 2.0, which names no other machine
SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}
FIRST_DATE = (1980, 1, 1, 0, 0, 0)  # that a ZIP file knows


def write_fmu(plant: Plant, path: Path, name: str, number: int) -> bool:
    """Write a unit of FMI 2.0 (number = 2) or 3.0 (3) to a path, and say whether it has a binary for this machine.

    Raises
    ------
    Unrecordable
        If a law of the train branches on a value.
    OSError
        If the path cannot be written.
    """
    code = plant_code(plant, "plant")
    compiled = ("plant.c", f"fmi{number}.c")
    templates = Path(__file__).with_name("sources")
    sources = {n: (templates / n).read_text(encoding="utf-8") for n in ("instance.h", compiled[1])}
    sources |= {"plant.c": code.source, "plant.h": code.header}
    token = f"{{{UUID(hashlib.sha256(''.join(sources.values()).encode()).hexdigest()[:32])}}}"
    sources["token.h"] = f'#define TOKEN "{token}"\n'
    files = {f"sources/{n}": text.encode() for n, text in sources.items()}
    if number == 2:
        files["modelDescription.xml"] = description_2(plant, name, token, compiled).encode()
    else:
        files["modelDescription.xml"] = description_3(plant, name, token).encode()
        files["sources/buildDescription.xml"] = build_description(name, compiled).encode()
    binary = _built(sources, compiled)
    if binary is not None:
        folder, ending = _binary_name(number)
        files[f"binaries/{folder}/{name}{ending}"] = binary
    with atomic(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as unit:
        for n, content in files.items():
            unit.writestr(zipfile.ZipInfo(n, FIRST_DATE), content, zipfile.ZIP_DEFLATED)
    return binary is not None


def _binary_name(number: int) -> tuple[str, str]:
    """Folder of the binaries for this machine, and their ending."""
    machine = MACHINES.get(platform.machine().lower(), platform.machine().lower())
    folder = f"{machine}-{SYSTEMS.get(sys.platform, sys.platform)}"
    if number == 2 and machine == "x86_64":
        folder = X86.get(sys.platform, folder)
    return folder, ENDINGS.get(sys.platform, ".so")


def _built(sources: dict[str, str], compiled: tuple[str, ...]) -> bytes | None:
    """Shared library of the sources, or None without the compiler `cc`."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    with TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8", newline="\n")
        command = [compiler, *FLAGS, *compiled, "-lm", "-o", "unit"]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            reason = (run.stderr.strip().splitlines() or ["no reason given"])[0]
            raise RuntimeError(f"the compiler {compiler} could not build the unit: {reason}; export to C and build it")
        return (Path(folder) / "unit").read_bytes()
