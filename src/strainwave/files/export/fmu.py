"""Functional mock-up units (FMI 2.0, 3.0): modelDescription.xml and the plant in C, as sources or built by a compiler.

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
from typing import NamedTuple
from uuid import UUID

from ...base.archive import atomic, version
from .plant import INPUTS, OUTPUTS, Plant
from .plant_code import plant_code
from .xml_text import Element, child, element, written

BASE = {"N*m": {"kg": "1", "m": "2", "s": "-2"}, "rad": {"rad": "1"}, "rad/s": {"rad": "1", "s": "-1"},
        "rad/s2": {"rad": "1", "s": "-2"}, "s": {"s": "1"}}  # fmt: skip
WHAT = "Motor, strain wave gear and load under the torques on motor and load"
YES = "true"
FIRST_INPUT, FIRST_OUTPUT, FIRST_STATE, FIRST_RATE = 1, 11, 101, 10001  # value references, as in instance.h


class Variable(NamedTuple):
    """Attributes of a variable of a unit, in their order; the last is the reference of the state that it is of."""

    name: str
    valueReference: str
    variability: str = "continuous"
    description: str = ""
    causality: str = "local"
    initial: str = "calculated"
    unit: str = ""
    start: str = ""
    derivative: str = ""


class Variables(NamedTuple):
    """All variables of a unit."""

    inputs: list[Variable]
    outputs: list[Variable]
    states: list[Variable]
    rates: list[Variable]

    def all(self) -> list[Variable]:
        """In the order of the file."""
        return [*self.inputs, *self.outputs, *self.states, *self.rates]


def variables(plant: Plant) -> Variables:
    """Inputs, outputs, states and their rates."""
    inputs, outputs = [
        [Variable(n, str(first + i), description=what, causality=side, unit=u) for i, (n, u, what) in enumerate(rows)]
        for side, first, rows in (("input", FIRST_INPUT, INPUTS), ("output", FIRST_OUTPUT, OUTPUTS))
    ]
    inputs = [one._replace(initial="", start="0.0") for one in inputs]
    states, rates = [], []
    for i, (name, unit) in enumerate(plant.states()):
        state, reference, begin = f"state {name}", str(FIRST_STATE + i), repr(plant.start[i])
        states.append(Variable(state, reference, initial="exact", unit=unit, start=begin))
        rate = {"rad": "rad/s", "rad/s": "rad/s2"}.get(unit, "")
        rates.append(Variable(f"der({state})", str(FIRST_RATE + i), unit=rate, derivative=reference))
    return Variables(inputs, outputs, states, rates)


def _root(name: str, number: int, attributes: dict[str, str]) -> Element:
    """Element of the whole file."""
    about = {"fmiVersion": f"{number}.0", "modelName": name, "description": WHAT} | attributes
    about |= {"generationTool": f"strainwave {version()}", "variableNamingConvention": "flat"}
    return element("fmiModelDescription", about)


def _common(root: Element, plant: Plant) -> None:
    """Units, and a run to begin with."""
    units = child(root, "UnitDefinitions")
    for unit, powers in BASE.items():
        child(child(units, "Unit", name=unit), "BaseUnit", **powers)
    child(root, "DefaultExperiment", startTime="0.0", stopTime="1.0", stepSize=repr(plant.step))


def description_2(plant: Plant, name: str, token: str, sources: tuple[str, ...]) -> str:
    """Text of modelDescription.xml for FMI 2.0: model exchange and co-simulation."""
    root = _root(name, 2, {"guid": token, "numberOfEventIndicators": "0"})
    abilities = {"modelIdentifier": name, "canGetAndSetFMUstate": YES}
    for kind, ability in (
        ("ModelExchange", "completedIntegratorStepNotNeeded"),
        ("CoSimulation", "canHandleVariableCommunicationStepSize"),
    ):
        files = child(child(root, kind, **abilities, **{ability: YES}), "SourceFiles")
        for source in sources:
            child(files, "File", name=source)
    _common(root, plant)
    groups, listed = variables(plant), child(root, "ModelVariables")
    indices = {v.valueReference: str(i + 1) for i, v in enumerate(groups.all())}
    for v in groups.all():
        scalar = child(listed, "ScalarVariable", **v._replace(unit="", start="", derivative="")._asdict())
        child(scalar, "Real", unit=v.unit, start=v.start, derivative=indices.get(v.derivative, ""))
    structure, initial = child(root, "ModelStructure"), Element("InitialUnknowns")
    states = " ".join(indices[v.valueReference] for v in groups.states)  # no output depends on an input at once
    for kind, unknowns, dependencies in (("Outputs", groups.outputs, states), ("Derivatives", groups.rates, "")):
        inside = child(structure, kind)
        for v in unknowns:
            child(inside, "Unknown", index=indices[v.valueReference], dependencies=dependencies)
            child(initial, "Unknown", index=indices[v.valueReference], dependencies=dependencies)
    structure.append(initial)
    return written(root)


def description_3(plant: Plant, name: str, token: str) -> str:
    """Text of modelDescription.xml for FMI 3.0: co-simulation."""
    root = _root(name, 3, {"instantiationToken": token})
    abilities = dict.fromkeys(("canGetAndSetFMUState", "canHandleVariableCommunicationStepSize"), YES)
    child(root, "CoSimulation", modelIdentifier=name, **abilities)
    _common(root, plant)
    groups, listed = variables(plant), child(root, "ModelVariables")
    time = Variable("time", "0", causality="independent", initial="", unit="s")
    for v in (time, *groups.all()):
        child(listed, "Float64", **v._asdict())
    tree, states = child(root, "ModelStructure"), " ".join(v.valueReference for v in groups.states)
    unknowns = [(v, states) for v in groups.outputs] + [(v, "") for v in groups.rates]
    for v, needs in unknowns:
        kind = "Output" if needs else "ContinuousStateDerivative"
        child(tree, kind, valueReference=v.valueReference, dependencies=needs)
    for v, needs in unknowns:
        child(tree, "InitialUnknown", valueReference=v.valueReference, dependencies=needs)
    return written(root)


def build_description(name: str, sources: tuple[str, ...]) -> str:
    """Text of sources/buildDescription.xml of FMI 3.0."""
    root = element("fmiBuildDescription", {"fmiVersion": "3.0"})
    files = child(child(root, "BuildConfiguration", modelIdentifier=name), "SourceFileSet", language="C99")
    for source in sources:
        child(files, "SourceFile", name=source)
    return written(root)


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
