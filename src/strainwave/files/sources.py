"""Source of each number of a project file."""

from collections.abc import Iterator
from functools import reduce
from typing import Any

from ..base.facts import Fact
from ..base.units import ARCSEC
from ..drive.project import Project
from ..drive.sources import Source
from ..model.gears.gear import Gear
from ..model.train.controls import USUAL
from .fields.groups import ASSUMED, CATALOGUE, MEASURED, YOURS
from .fields.rows import inside
from .fields.schema import ProjectSpec
from .variants.names import keys_of, numbers_of

NO_NUMBERS = ("scatter", "excitation.accuracy")
ACCURACY = "split over orders 1, 2 and 4 in the ratio 1 : 4 : 1, with zero phases"
UNNAMED = "the project file gives neither motor.mode nor motor.loop"


def sources_of(content: dict[str, Any], spec: ProjectSpec, gear: Gear | None) -> tuple[Source, ...]:
    """Every number of a file, and those that stand in for what it leaves out, with the source of each."""
    named = (spec.sources or {}).items()
    declared = {("speed",) if name == "speed" else keys_of(content, name): word for name, word in named}
    given = list[Source]()
    for name in numbers_of(content):
        if not name.startswith(NO_NUMBERS):
            keys = tuple(name.split("."))  # the source of the narrowest group; a number of the file is its writer's
            word = next((declared[keys[:n]] for n in range(len(keys), 0, -1) if keys[:n] in declared), YOURS)
            given.append(Source(name, str(reduce(inside, keys, content)), word))
    return *_implied(content, spec, gear), *given


def _implied(content: dict[str, Any], spec: ProjectSpec, gear: Gear | None) -> Iterator[Source]:
    """Sources of the numbers that follow from a name of the catalogue or from a default."""
    motor, loop = spec.motor, inside(content.get("motor"), "loop")
    if gear is not None:
        yield Source("gear", gear.name, CATALOGUE, gear.source)
        if motor.inertia is None:
            yield Source("motor.inertia", f"{gear.input_inertia:.4g} kg*m^2", CATALOGUE, "the wave generator alone")
        if spec.hysteresis == CATALOGUE:
            word = (spec.sources or {}).get("hysteresis", CATALOGUE)
            yield Source("hysteresis", CATALOGUE, word, "fitted to the hysteresis loss; it yields over a quarter")
        if isinstance(spec.load_friction, str):
            yield Source("load_friction", CATALOGUE, CATALOGUE, "from the efficiency of the gear")
    if not motor.named:
        yield Source("motor.mode", motor.mode, ASSUMED, UNNAMED)
    if isinstance(loop, dict) and "bandwidth" in loop and "damping" not in loop:
        yield Source("motor.loop.damping", f"{USUAL.damping:g}", ASSUMED, "default damping of a control loop")
    if spec.excitation.accuracy is not None:
        grade = spec.excitation.accuracy
        given = (0.0 if gear is None else gear.accuracy_of(grade) or 0.0) if isinstance(grade, str) else grade
        why = f"the accuracy is assumed; {ACCURACY}" if class_assumed(spec) else ACCURACY
        measured = _word(spec) == MEASURED
        yield Source("excitation.accuracy", f"{given / ARCSEC:.4g} arcsec", MEASURED if measured else ASSUMED, why)


def class_assumed(spec: ProjectSpec) -> bool:
    """True where the file calls its accuracy assumed: one that no record gives."""
    return _word(spec) == ASSUMED and spec.excitation.accuracy not in (None, CATALOGUE)


def _word(spec: ProjectSpec) -> str | None:
    """Source of the accuracy that the file names."""
    words = spec.sources or {}
    return words.get("excitation.accuracy", words.get("excitation"))


def source_facts(project: Project) -> tuple[tuple[Fact, ...], ...]:
    """A row for every number: its name, its text, its source, and why where the file does not give it."""
    keys = ("name", "value", "source", "why")
    return tuple(tuple(map(Fact, keys, row)) for row in project.sources)


def sources_text(project: Project) -> str:
    """Numbers by their source: of the catalogue, of measurements, and assumed ones."""
    words = {ASSUMED: "assumed", MEASURED: "measured", CATALOGUE: "from the catalogue"}
    numbers = [one for one in project.sources if not one.name.endswith(".order")]
    some = {word: [f"{one.name} {one.value}".strip() for one in numbers if one.word == word] for word in words}
    parts = [f"{words[word]}: {', '.join(names)}" for word, names in some.items() if names]
    return "; ".join(
        [*parts, "all other values are from the project file" if parts else "all values are from the project file"]
    )
