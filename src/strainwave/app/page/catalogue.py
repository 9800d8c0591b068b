"""The page of the catalogue: one axis, in which every gear answers; `strainwave export catalogue --to html`."""

import re
from pathlib import Path
from typing import Any

from ...files.reading import from_text
from ...model.gears import catalogue
from .page import data_of, page_with, written
from .sliders import Slider

TITLE = "Gears of the catalogue"
AXIS = """\
title: @gear@
gear: @gear@
motor: {inertia: @motor.inertia@, mode: @mode@}
load: {inertia: @load.inertia@}
damping: {ratio: @damping.ratio@}
speed: {from: @speed.from@, to: @speed.to@, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: @excitation.kinematic_error.0.amplitude@}]
  load_torque: {mean: 0 N*m}
limit: {oscillation: @limit.oscillation@}
"""
FIRST = "CSG-25-100"
MODES = "held", "free"
ORDER_2 = "excitation.kinematic_error.0.amplitude"
SLIDERS = (  # the axis first, as `ofGear` takes it
    Slider("load.inertia", "load inertia", 1.0, "kg*m^2", 1e-3, 1e3, ()),
    Slider("damping.ratio", "damping ratio of the gear", 3.0, "%", 0.5, 10.0, ()),
    Slider("motor.inertia", "inertia of a free motor, without wave generator", 0.5, "kg*cm^2", 0.01, 100.0, ()),
    Slider(ORDER_2, "kinematic error, order 2 alone; assumed", 26.0, "arcsec", 2.0, 120.0, ()),  # its share of 1 arcmin
    Slider("limit.oscillation", "limit of the oscillation", 60.0, "arcsec", 5.0, 500.0, ()),
    Slider("speed.from", "motor speed from", 100.0, "rpm", 20.0, 1000.0, ()),
    Slider("speed.to", "motor speed to (at most that of the gear)", 3000.0, "rpm", 1200.0, 8000.0, ()),
)
COLUMNS = (
    "gear", "ratio", "rated torque [N·m]", "largest speed [rpm]", "stiffness K1 [kN·m/rad]",
    "resonance of order 2 [rpm]", "largest oscillation [arcsec]", "speeds within the limit [rpm]",
)  # fmt: skip


def axis_of(gear: str, mode: str, values: dict[str, float]) -> str:
    """Project file of a gear in the axis, with numbers in the units of the sliders."""
    texts = {one.name: f"{values.get(one.name, one.value)!r} {one.unit}" for one in SLIDERS}
    return re.sub("@([a-z_.0]+)@", lambda place: ({"gear": gear, "mode": mode} | texts)[place[1]], AXIS)


def data_of_catalogue() -> tuple[dict[str, Any], bytes]:
    """What the page knows of the gears that have a torsion law, and the machine code of the functions of all."""
    data, code = data_of(from_text(axis_of(FIRST, MODES[0], {}), Path(f"{FIRST}.yaml")))
    moves = {slider["name"]: slider["moves"] for slider in data["sliders"] if slider["name"] != SLIDERS[0].name}
    gears = [gear for gear in map(catalogue.gear, catalogue.names()) if gear.has_law]
    rows = [
        {
            "name": gear.name, "ratio": gear.ratio, "torque": gear.rated_torque, "fastest": gear.max_rpm,
            "inertia": gear.input_inertia, "law": tuple(gear.law),
        }
        for gear in gears
    ]  # fmt: skip
    names = [gear.name for gear in gears]
    return data | {
        "title": TITLE, "gears": rows, "columns": COLUMNS, "project": AXIS,
        "sliders": [slider._replace(moves=moves.get(slider.name, ())).data() for slider in SLIDERS],
        "choices": [
            {"label": "gear", "options": names, "value": names.index(FIRST)},
            {"label": "motor", "options": ["held at its speed", "free"], "value": 0},
        ],
    }, code  # fmt: skip


def write_catalogue(path: Path) -> None:
    """Write the page of the catalogue."""
    written(page_with(*data_of_catalogue(), "catalogue.js"), path)
