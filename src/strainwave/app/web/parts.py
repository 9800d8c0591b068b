"""Parts that the page can add to a project: a motor loop, gravity, a limit, a move."""

from ...drive.project import Project
from ...files.fields.entries import EXAMPLE_LOOP
from ...files.fields.groups import ASSUMED
from ...files.fields.rows import inside
from ...files.variants.names import quantity
from ...files.yaml_text import read


def parts_of(project: Project) -> dict[str, dict[str, str]]:
    """Parts that the page can add to a project without them, with first values."""
    content = read(project.text).content
    torque = 0.25 * project.rated_torque if project.rated_torque else 10.0
    parts = {
        "motor loop": {f"motor.loop.{key}": text for key, text in read(EXAMPLE_LOOP).content.items()},
        "gravity": {
            "load.drag.type": "angle_torque",
            "load.drag.amplitude": f"{torque:.2g} N*m",
            "load.drag.order": "1",
        },
        "limit": {"limit.oscillation": "120 arcsec"},
        "move": {
            "move.profile.0.type": "s_curve",
            "move.profile.0.angle": "90 deg",
            "move.profile.0.time": "0.6 s",
        },
    }
    if project.speeds.shaft == "forcing":
        del parts["motor loop"], parts["gravity"], parts["move"]
    elif inside(content.get("motor"), "mode") == "free":
        del parts["motor loop"]
    places = {name: next(iter(part)).split(".")[:2] for name, part in parts.items()}
    return {name: part for name, part in parts.items() if inside(content.get(places[name][0]), places[name][1]) is None}


def first_sources(project: Project, values: dict[str, str]) -> dict[str, str]:
    """Changes that call the numbers of an added part assumed, as long as they are its first ones."""
    first = {name: text for part in parts_of(project).values() for name, text in part.items()}
    numbers = [name for name, text in first.items() if values.get(name) == text and quantity(text)[0] is not None]
    return {f"sources.{name}": ASSUMED for name in numbers if not name.endswith(".order")}
