"""What a functional mock-up unit says of itself: modelDescription.xml of FMI 2.0 and 3.0, and how it is built.

Modelica Association, FMI 2.0.4, section 2.2, and FMI 3.0.1, section 2.4.
"""

from typing import NamedTuple

from ...archive import version
from .plant import INPUTS, OUTPUTS, Plant
from .xml_text import Element, child, element, written

BASE = {"N*m": {"kg": "1", "m": "2", "s": "-2"}, "rad": {"rad": "1"}, "rad/s": {"rad": "1", "s": "-1"},
        "rad/s2": {"rad": "1", "s": "-2"}, "s": {"s": "1"}}  # fmt: skip
WHAT = "Motor, strain wave gear and load under the torques on motor and load"
YES = "true"
FIRST_INPUT, FIRST_OUTPUT, FIRST_STATE, FIRST_RATE = 1, 11, 101, 10001  # value references, as in instance.h


class Variable(NamedTuple):
    """A variable of a unit; `start`, and the reference of the state that it is the derivative of, may be empty."""

    name: str
    reference: str
    causality: str
    initial: str
    unit: str
    description: str = ""
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
    inputs = [Variable(n, str(FIRST_INPUT + i), "input", "", u, what, "0.0") for i, (n, u, what) in enumerate(INPUTS)]
    outputs = [
        Variable(n, str(FIRST_OUTPUT + i), "output", "calculated", u, what) for i, (n, u, what) in enumerate(OUTPUTS)
    ]
    states, rates = [], []
    for i, (name, unit) in enumerate(plant.states()):
        state, of_rate = f"state {name}", {"rad": "rad/s", "rad/s": "rad/s2"}.get(unit, "")
        states.append(Variable(state, str(FIRST_STATE + i), "local", "exact", unit, "", repr(plant.start[i])))
        reference = str(FIRST_RATE + i)
        rates.append(Variable(f"der({state})", reference, "local", "calculated", of_rate, "", "", states[-1].reference))
    return Variables(inputs, outputs, states, rates)


def _root(name: str, number: int, own: dict[str, str]) -> Element:
    """Element of the whole file."""
    about = {"fmiVersion": f"{number}.0", "modelName": name, "description": WHAT} | own
    return element(
        "fmiModelDescription",
        about | {"generationTool": f"strainwave {version()}", "variableNamingConvention": "flat"},
    )


def _common(root: Element, plant: Plant) -> None:
    """Units, and a run to begin with."""
    units = child(root, "UnitDefinitions")
    for unit, powers in BASE.items():
        child(child(units, "Unit", name=unit), "BaseUnit", **powers)
    child(root, "DefaultExperiment", startTime="0.0", stopTime="1.0", stepSize=repr(plant.step))


def description_2(plant: Plant, name: str, token: str, sources: tuple[str, ...]) -> str:
    """Text of modelDescription.xml for FMI 2.0: model exchange and co-simulation."""
    root = _root(name, 2, {"guid": token, "numberOfEventIndicators": "0"})
    own = {"modelIdentifier": name, "canGetAndSetFMUstate": YES}
    for kind, ability in (
        ("ModelExchange", "completedIntegratorStepNotNeeded"),
        ("CoSimulation", "canHandleVariableCommunicationStepSize"),
    ):
        files = child(child(root, kind, **own, **{ability: YES}), "SourceFiles")
        for source in sources:
            child(files, "File", name=source)
    _common(root, plant)
    found, listed = variables(plant), child(root, "ModelVariables")
    places = {v.reference: str(i + 1) for i, v in enumerate(found.all())}
    for v in found.all():
        said = {"description": v.description, "causality": v.causality, "initial": v.initial}
        scalar = child(
            listed, "ScalarVariable", name=v.name, valueReference=v.reference, variability="continuous", **said
        )
        child(scalar, "Real", unit=v.unit, start=v.start, derivative=places.get(v.derivative, ""))
    structure, begun = child(root, "ModelStructure"), Element("InitialUnknowns")
    states = " ".join(places[v.reference] for v in found.states)  # no output depends on an input at once
    for kind, unknowns, known in (("Outputs", found.outputs, states), ("Derivatives", found.rates, "")):
        inside = child(structure, kind)
        for v in unknowns:
            child(inside, "Unknown", index=places[v.reference], dependencies=known)
            child(begun, "Unknown", index=places[v.reference], dependencies=known)
    structure.append(begun)
    return written(root)


def description_3(plant: Plant, name: str, token: str) -> str:
    """Text of modelDescription.xml for FMI 3.0: co-simulation."""
    root = _root(name, 3, {"instantiationToken": token})
    child(
        root, "CoSimulation", modelIdentifier=name, canGetAndSetFMUState=YES, canHandleVariableCommunicationStepSize=YES
    )
    _common(root, plant)
    found, listed = variables(plant), child(root, "ModelVariables")
    time = Variable("time", "0", "independent", "", "s")
    for v in (time, *found.all()):
        said = {"description": v.description, "causality": v.causality, "initial": v.initial, "unit": v.unit}
        said |= {"start": v.start, "derivative": v.derivative}
        child(listed, "Float64", name=v.name, valueReference=v.reference, variability="continuous", **said)
    structure, states = child(root, "ModelStructure"), " ".join(v.reference for v in found.states)
    known = [(v, states) for v in found.outputs] + [(v, "") for v in found.rates]
    for v, dependencies in known:
        kind = "Output" if dependencies else "ContinuousStateDerivative"
        child(structure, kind, valueReference=v.reference, dependencies=dependencies)
    for v, dependencies in known:
        child(structure, "InitialUnknown", valueReference=v.reference, dependencies=dependencies)
    return written(root)


def build_description(name: str, sources: tuple[str, ...]) -> str:
    """Text of sources/buildDescription.xml of FMI 3.0."""
    root = element("fmiBuildDescription", {"fmiVersion": "3.0"})
    files = child(child(root, "BuildConfiguration", modelIdentifier=name), "SourceFileSet", language="C99")
    for source in sources:
        child(files, "SourceFile", name=source)
    return written(root)
