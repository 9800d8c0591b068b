"""Where each number of a project comes from: the catalogue, an assumption, the writer of the file, or a measurement."""

from collections.abc import Iterator
from typing import Any

from ..base.facts import Fact
from ..base.units import ARCSEC
from ..drive.asked import Source
from ..drive.project import Project
from ..model.gears.gear import Gear
from ..model.train.controls import USUAL
from .fields.groups import ASSUMED, CATALOGUE, MEASURED, YOURS
from .fields.rows import inside
from .fields.schema import ProjectSpec
from .variants.names import Keys, keys_of, numbers_of

NO_NUMBERS = ("scatter", "excitation.accuracy")
ACCURACY = "orders 1, 2 and 4 share the accuracy as 1 : 4 : 1"
UNNAMED = "the file names neither a mode nor a loop of the motor"


def sources_of(content: dict[str, Any], spec: ProjectSpec, gear: Gear | None) -> tuple[Source, ...]:
    """Every number of a file, and those that stand in for what it leaves out, with the source of each."""
    named = (spec.sources or {}).items()
    declared = {("speed",) if name == "speed" else keys_of(content, name): word for name, word in named}
    names = (name for name in numbers_of(content) if not name.startswith(NO_NUMBERS))
    given = (Source(name, str(_at(content, name)), word_of(declared, tuple(name.split(".")))) for name in names)
    return *_implied(content, spec, gear), *given


def word_of(said: dict[Keys, str], keys: Keys) -> str:
    """What the file says of the narrowest group with a number; a number that it gives is its writer's."""
    return next((said[keys[:n]] for n in range(len(keys), 0, -1) if keys[:n] in said), YOURS)


def _at(content: Any, name: str) -> Any:
    for key in name.split("."):
        content = inside(content, key)
    return content


def _implied(content: dict[str, Any], spec: ProjectSpec, gear: Gear | None) -> Iterator[Source]:
    """What follows from a name of the catalogue or from a default."""
    motor, loop = spec.motor, _at(content, "motor.loop")
    if gear is not None:
        yield Source("gear", gear.name, CATALOGUE, gear.source)
        if motor.inertia is None:
            yield Source("motor.inertia", f"{gear.input_inertia:.4g} kg*m^2", CATALOGUE, "the wave generator alone")
        if isinstance(spec.load_friction, str):
            yield Source("load_friction", CATALOGUE, CATALOGUE, "from its efficiency")
    if not motor.named:
        yield Source("motor.mode", motor.mode, ASSUMED, UNNAMED)
    if isinstance(loop, dict) and "bandwidth" in loop and "damping" not in loop:
        yield Source("motor.loop.damping", f"{USUAL.damping:g}", ASSUMED, "the default of a loop")
    if spec.excitation.accuracy is not None:
        given = gear.accuracy if gear is not None and gear.accuracy else 0.0
        given = given if isinstance(spec.excitation.accuracy, str) else spec.excitation.accuracy
        yield Source("excitation.accuracy", f"{given / ARCSEC:.4g} arcsec", ASSUMED, ACCURACY)


def source_facts(project: Project) -> tuple[tuple[Fact, ...], ...]:
    """A row for every number: its name, its text, its source, and why where the file does not give it."""
    keys = ("name", "value", "source", "why")
    return tuple(tuple(map(Fact, keys, row)) for row in project.sources)


def sources_said(project: Project) -> str:
    """Numbers by where they come from; of the catalogue and of measurements, and what is assumed."""
    words = {ASSUMED: "assumed", MEASURED: "measured", CATALOGUE: "from the catalogue"}
    told = [one for one in project.sources if not one.name.endswith(".order")]
    some = {word: [f"{one.name} {one.value}".strip() for one in told if one.word == word] for word in words}
    parts = [f"{words[word]}: {', '.join(names)}" for word, names in some.items() if names]
    return "; ".join([*parts, "the other numbers are yours" if parts else "all numbers are yours"])
