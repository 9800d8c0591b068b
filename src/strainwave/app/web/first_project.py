"""The first project of a gear, and the parts with first values that can be added to a project."""

from functools import lru_cache, reduce

from ...base.units import ARCSEC, RPM
from ...drive.project import Project
from ...files.fields.entries import EXAMPLE_LOOP
from ...files.fields.groups import ASSUMED, CATALOGUE, UNPRINTED
from ...files.fields.rows import inside
from ...files.variants.names import quantity
from ...files.yaml_text import read
from ...model.gears import catalogue

FIRST_RPM = 3000.0  # rpm of a gear's first project, where the gear's own average is not lower


@lru_cache(256)
def first_text(name: str) -> str:
    """First project of a gear: an axis in a cascade, whose limit is its accuracy class, peak-to-peak.

    The class makes the kinematic error, as in a file of `strainwave new`. Its orders 1, 2 and 4, in the ratio 1 : 4 : 1
    with phases zero, have 1.54 times their largest value from peak to peak: so much is the limit above the error in
    slow rotation. Order 2 meets the resonance of the load, the motor held, at half of the largest speed. The stiffness
    is K1. The motor's inertia is that of the wave generator, else matched to the load.
    """
    gear = catalogue.gear(name)
    gear.check_law()
    fastest = min(FIRST_RPM, gear.average_rpm or gear.max_rpm or FIRST_RPM)
    inertia = gear.law.K1 / (fastest * RPM) ** 2
    limit, error = UNPRINTED, UNPRINTED
    if gear.accuracy is not None:
        limit, error = f"{gear.accuracy / ARCSEC:.3g} arcsec", CATALOGUE
    rotor = f"{1e4 * gear.input_inertia:.6g}" if gear.input_inertia else f"{1e4 * inertia / gear.ratio**2:.2g}"
    return (
        f"title: {gear.name}\n"
        f"gear: {gear.name}\n"
        f"motor: {{inertia: {rotor} kg*cm^2, loop: {EXAMPLE_LOOP}}}\n"
        f"load: {{inertia: {inertia:.2g} kg*m^2}}\n"
        "damping: {ratio: 3 %}\n"
        f"speed: {{from: {fastest / 8:.3g} rpm, to: {fastest:g} rpm, shaft: motor}}\n"
        "excitation:\n"
        f"  accuracy: {error}\n"
        "  load_torque: {mean: 0 N*m}\n"
        f"limit: {{oscillation: {limit}}}\n"
        "sources:\n"
        "  {motor: assumed, load: assumed, damping: assumed, speed: assumed, excitation: assumed, limit: assumed}\n"
    )


@lru_cache(64)
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
        "move": {"move.profile.0.type": "s_curve", "move.profile.0.angle": "90 deg", "move.profile.0.time": "0.6 s"},
    }
    forced, free = project.speeds.shaft == "forcing", inside(content.get("motor"), "mode") == "free"
    without = {"motor loop", "gravity", "move"} if forced else {"motor loop"} if free else set()
    paths = {name: next(iter(part)).split(".")[:2] for name, part in parts.items() if name not in without}
    return {key: parts[key] for key, keys in paths.items() if reduce(inside, keys, content) is None}


def first_sources(project: Project, values: dict[str, str]) -> dict[str, str]:
    """Changes that call the numbers of an added part assumed while they are its first ones."""
    first = {name: text for part in parts_of(project).values() for name, text in part.items()}
    numbers = [name for name, text in first.items() if values.get(name) == text and quantity(text)[0] is not None]
    return {f"sources.{name}": ASSUMED for name in numbers if not name.endswith(".order")}
