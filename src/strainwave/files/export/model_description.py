"""Description of a functional mock-up unit: modelDescription.xml of FMI 2.0 and 3.0, and how FMI 3.0 builds it."""

from typing import NamedTuple

from ...base.archive import version
from .plant import INPUTS, OUTPUTS, Plant
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
