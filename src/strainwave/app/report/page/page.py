"""One HTML file of a drive whose response follows sliders, by the kernel `answer` in WebAssembly.

The kernels are those of the package, made once (`tools/wasm.py`); the functions of the drive's own laws are compiled
beside them when the file is written.
"""

import base64
import json
import re
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ....base.archive import atomic
from ....base.facts import UNITS, Fact
from ....base.law import breakpoints_of, depends
from ....base.quantities import shown
from ....base.sentences import listed
from ....base.units import ARCSEC
from ....compile.address import VECTOR, kind_of, words_of
from ....compile.wasm import Wanted, beside, compiled
from ....drive.project import Project
from ....drive.reductions import left_out
from ....drive.response import POINTS
from ....drive.train_curve import POINTS as OF_TRAIN
from ....drive.train_curve import at_load, follows_its_angle, has_curve, without_gravity
from ....files.reading import from_text
from ....files.variants.names import Keys, keys_of, nominal_of, of_record
from ....files.variants.replaced import OF_RECORD, replaced
from ....files.yaml_text import read
from ....model.gears import catalogue
from ....model.gears.gear import Gear
from ....model.laws.friction import NO_FRICTION
from ....model.laws.springs import Linear
from ....model.train.controls import PositionLoop
from ....model.train.drive_train import DriveTrain
from ....model.train.shafts import NO_DRAG
from ....numerics.addressed import _breakpoints, _stiffnesses, _torques
from ....numerics.balance.piecewise import is_piecewise_linear
from ....numerics.curves.answer import MOST_POINTS
from ....numerics.curves.inner_balance import MOST_KINKS
from .sliders import TORQUE, OnPage, Slider, sliders

HERE = Path(__file__).parent

FACTS = (
    Fact("largest.oscillation_arcsec", None, "largest oscillation {}"),
    Fact("largest.speed", None, "at {}"),
    Fact("largest.torque_N_m", None, "largest torque in the gear {}"),
    Fact("above", None, "speeds at which the oscillation exceeds the limit: {}"),
    Fact("allowed", None, "speeds within it: {}"),
    Fact("none_above", None, "the oscillation stays within the limit"),
    Fact("none_stable", None, "speeds at which no motion of the curve is stable: {}"),
    Fact("unstable", None, "dashed motions are unstable: the drive leaves them"),
    Fact("floats", None, "at some speeds the gear carries nothing in its gap and any mean is in balance: one is drawn"),
    Fact("others", None, "there is another motion at an end of the range: `strainwave analyze` follows it"),
    Fact("gravity", None, "without the torque that follows the load's own angle, as gravity does"),
    Fact("held", None, "dotted is the drive with its motor ideally held and its load rigid: largest oscillation {}"),
    Fact("map", None, "in the map a larger oscillation is stronger; red exceeds the limit or has no stable motion"),
    Fact("loads", None, "speeds within the limit under each of nine load torques from {}: {}"),
    Fact("lost", None, "no steady motion was found with these numbers"),
    Fact("turned", None, "the curve does not reach the other end of the range: `strainwave analyze` says why"),
    Fact("unknown", None, "the speeds are too low, or the damping too high, for the stability of the page's method"),
    Fact("range", None, "the speeds must ascend, from above 0"),
    Fact("tail", None, "the harmonics left out hold more than 0.1 % of the response"),
    Fact("no_simd", None, "this browser has no WebAssembly with SIMD, which the page computes with: take a newer one"),
)  # fmt: skip


def write_page(project: Project, path: Path) -> None:
    """Write the page of a project.

    Raises
    ------
    ValueError
        If the page cannot hold the drive; the sentence names the part, and what to use.
    """
    written(page_of(project), path)


def written(text: str, path: Path) -> None:
    """Write a page, whole or not at all."""
    with atomic(path) as part:
        Path(part).write_text(text, encoding="utf-8", newline="\n")


def page_of(project: Project) -> str:
    """Text of the page of a project."""
    return page_with(*data_of(project))


def page_with(data: dict[str, Any], laws: bytes, *scripts: str) -> str:
    """Text of a page of data and of the code of its laws; `scripts` are files that it has besides."""
    put = {
        "TITLE": escape(data["title"], quote=False), "STYLE": _lean("page.css"),
        "CODE": "".join(map(_lean, ("machine.js", *scripts, "page.js"))),
        "DATA": json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"), "LAWS": _packed(laws),
        "KERNELS": _packed((HERE / "kernels.wasm.gz").read_bytes()),
        "GEARS": _text("catalogue.html") if scripts else "",
    }  # fmt: skip
    return re.sub(r"@([A-Z]+)@", lambda found: put[found[1]], _text("page.html"))


def refused_parts(project: Project) -> list[str]:
    """Parts of a drive that no page holds."""
    reasons = {
        "a law with friction or memory": project.has_memory,
        "a damping or stiffness that varies": project.damping is not None or project.stiffness is not None,
        "a range of load torques": project.mean_range is not None,
        "loads in postures": project.postures,
        "a line of the output's turn": project.is_beating,
        "an error that depends on torque or direction": project.loaded_error is not None,
    }
    parts = [part for part, refused in reasons.items() if refused]
    if project.train is not None and not parts:
        parts += nonlinear_parts(project.train)
    return parts


def nonlinear_parts(train: DriveTrain) -> list[str]:
    """Parts of a train that are neither linear nor laws of their own twists."""
    end, smooth = train.load.end(), PositionLoop(1.0, 1.0)
    load = train.load.with_end(end._replace(drag=NO_DRAG))
    plain = train._replace(
        motor=train.motor._replace(drag=NO_DRAG, control=smooth), friction=NO_FRICTION, load=load, law=Linear(1.0)
    )
    parts = {
        "a loop that is not linear": plain._replace(motor=plain.motor._replace(control=train.motor.control)),
        "friction of the motor": plain._replace(motor=plain.motor._replace(drag=train.motor.drag)),
        "friction of the meshing": plain._replace(friction=train.friction),
        "friction of the load": plain._replace(load=without_gravity(train).load),
    }
    if not has_curve(train):
        return [f"{listed(left_out(train))} beside a free motor"] if left_out(train) else []
    nonlinear = [name for name, one in parts.items() if at_load(one).linear_part() is None]
    return nonlinear if at_load(train).linear_part() is None else []


def data_of(project: Project) -> tuple[dict[str, Any], bytes]:
    """What the page knows of a project, and the machine code of its own functions."""
    if parts := refused_parts(project):
        them = "it" if len(parts) == 1 else "them"
        raise ValueError(
            f"a page holds drives that are linear around springs; this drive has {listed(parts)}: take "
            f"`strainwave app` or `strainwave analyze`, or leave {them} out of the project"
        )
    laws = [law for kernel in OnPage(project).kernels for law in kernel.laws]
    if any(depends(law) != 1 or len(breakpoints_of(law)) > MOST_KINKS for law in laws):
        raise ValueError(f"a page holds laws of the torsion alone with at most {MOST_KINKS} breakpoints; take the app")
    base, moved, terms = sliders(project)
    drive, kinds = OnPage(base), list(dict.fromkeys(map(kind_of, laws)))
    main, *beside_it = _kernels(drive, kinds)
    content: Any = read(base.text).content
    records = {name: f"{value!r} {unit}" for name, (value, unit) in of_record(content, base.gear).items()}
    content = read(replaced(base, records).text).content  # whose gear may be written out
    speeds, train = project.speeds, project.train
    data = main | {
        "held": beside_it[0] if beside_it else None, "torque": TORQUE,
        "title": project.title, "speedName": speeds.name, "speedUnit": speeds.unit, "scale": speeds.scale,
        "arcsec": ARCSEC, "numbers": drive.numbers.tolist(), "terms": terms, "limited": project.limit is not None,
        "mostPoints": MOST_POINTS, "digits": project.digits(),
        "sliders": [one.data() | {"keys": _keys(content, one.name)} for one in moved], "content": content,
        "gear": base.gear and base.gear.has_law and _explicit(base.gear),
        "facts": {fact.key: fact.words for fact in FACTS}, "units": {key: unit for key, (unit, _) in UNITS.items()},
        "kinds": json.loads(_text("kernels.json"))["arguments"], "project": project.text,
        "gravity": train is not None and follows_its_angle(train),
    }  # fmt: skip
    return data, beside(_functions(laws, kinds))


def _kernels(drive: OnPage, kinds: list[Any]) -> list[dict[str, Any]]:
    """What the page knows of each kernel: where its numbers begin, and all that is no number."""
    kernels, start = [], 0
    for kernel in drive.kernels:
        laws = [
            {
                "kind": kinds.index(kind_of(law)), "words": _words(law), "kinks": len(breakpoints_of(law)),
                "exact": int(is_piecewise_linear(law)),
            }
            for law in kernel.laws
        ]  # fmt: skip
        points = POINTS if kernel.drive.alone else OF_TRAIN  # those of the command
        kernels.append({
            "start": start, "shapes": [array.shape for array in kernel.arrays], "laws": laws, "points": points,
            "whole": kernel.whole, "begin": kernel.begin,
        })  # fmt: skip
        start += sum(array.size for array in kernel.arrays)
    return kernels


def _keys(content: dict[str, Any], name: str) -> Keys:
    """Where the number of a slider stands in a project file, which writes the law of the gear out."""
    keys = keys_of(content, name)
    return ("gear", "law", keys[1]) if keys[0] == "gear" and keys[1] in OF_RECORD else keys


def _explicit(gear: Gear) -> dict[str, Any]:
    """A gear of the catalogue as a file writes out a gear with other slopes."""
    slopes = {name: nominal_of({"gear": gear.name}, gear, f"gear.{name}") for name in OF_RECORD}
    law = {name: f"{value!r} {unit}" for name, (value, unit) in slopes.items()}
    return {"ratio": f"{gear.ratio!r}", "law": {"type": "piecewise_linear", **law}}


_codes: dict[Any, bytes] = {}


def _functions(laws: list[Any], kinds: list[Any]) -> bytes:
    """Code of the functions of laws, of each kind once; this process keeps it, as no number is in it."""
    first = [next(law for law in laws if kind_of(law) == kind) for kind in kinds]
    corners, two = [len(breakpoints_of(law)) for law in first], (VECTOR, VECTOR)
    key = tuple(zip(kinds, corners, strict=True))
    if key not in _codes:
        exports = []
        for i, law in enumerate(first):
            exports.append(Wanted(f"torques_of_law{i}", _torques, (law,), two))
            exports.append(Wanted(f"stiffnesses_of_law{i}", _stiffnesses, (law,), two))
            if corners[i]:
                exports.append(Wanted(f"breakpoints_of_law{i}", _breakpoints, (law,), (corners[i],)))
        _codes[key] = compiled(*exports).code
    return _codes[key]


def _words(thing: Any) -> list[float | str]:
    """Words of a part: its floats as numbers, its whole numbers as texts."""
    words, found = words_of(thing), []
    floats = words.view(np.float64)
    for i, kind in enumerate(_kinds(thing)):
        found.append(float(floats[i]) if kind is float else str(words[i]))
    return found


def _kinds(thing: Any) -> list[type]:
    if isinstance(thing, tuple):
        return [kind for item in thing for kind in _kinds(item)]
    if isinstance(thing, np.ndarray):
        raise ValueError(f"a page holds models of numbers, and this one has an array, {shown(thing)}; take the app")
    return [float if isinstance(thing, float | np.floating) else int]


def _text(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _lean(name: str) -> str:
    """A script or a style without its comments and what lines are indented by."""
    return re.sub(r"^ */\*\*.*\*/\n|^ *//.*\n|^ +", "", _text(name), flags=re.MULTILINE)


def _packed(code: bytes) -> str:
    return base64.b64encode(code).decode()


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
