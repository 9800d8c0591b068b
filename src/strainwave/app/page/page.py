"""One HTML file of a drive whose response follows sliders, by the kernel `answer` in WebAssembly.

The kernels are those of the package, made once (`tools/wasm.py`); the functions of the drive's own law, excitation and
kinematic error are compiled beside them when the file is written. The page knows nothing of a project file: a slider
moves numbers of the error equation, speeds or the limit along a line, and only numbers of the file that do so have one.
"""

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base.archive import atomic
from ...base.facts import UNITS, Fact
from ...base.law import breakpoints_of, is_spring
from ...base.quantities import shown
from ...base.sentences import listed, sign
from ...base.units import ARCSEC
from ...compile.address import VECTOR, words_of
from ...compile.tree import leaves
from ...compile.wasm import Wanted, beside, compiled
from ...drive.project import Project
from ...files.variants.names import nominal_of, numbers_of
from ...files.variants.replaced import OF_RECORD, replaced
from ...files.yaml_text import read
from ...model.oscillator import Oscillator
from ...numerics.addressed import _breakpoints, _stiffnesses, _torques, _values_of_error
from ...numerics.balance.piecewise import is_piecewise_linear
from ...numerics.curves.answer import MOST_POINTS
from ...numerics.curves.inner_balance import MOST_KINKS
from ...numerics.curves.over_a_turn import MOST_OF_SPRING, SPRING, SPRING_WITH_KINKS
from .folded import POINTS, folded

HERE = Path(__file__).parent
STRAIGHT = 1e-12  # relative distance from a line at which a number still follows a slider along it
SPAN, TRIED = 4.0, (0.5, 1.0, 1.7)  # a slider goes from a fourth of its value to four times it; where it is asked
LEFT_OUT = ".order", ".T1", ".T2"  # whole numbers, and torques whose order the law asks for
PARTS = "law", "excitation", "error"
LOAD = "load.inertia"  # that every file gives

FACTS = (
    Fact("largest.oscillation_arcsec", None, "largest oscillation {}"),
    Fact("largest.speed", None, "at {}"),
    Fact("largest.torque_N_m", None, "largest torque in the gear {}"),
    Fact("above", None, "speeds at which the oscillation exceeds the limit: {}"),
    Fact("allowed", None, "speeds within it: {}"),
    Fact("none_above", None, "the oscillation stays within the limit"),
    Fact("unstable", None, "dashed motions are unstable: the drive leaves them"),
    Fact("others", None, "there is another motion at an end of the range: `strainwave analyze` follows it"),
    Fact("lost", None, "no steady motion was found with these numbers"),
    Fact("turned", None, "the curve does not reach the other end of the range: `strainwave analyze` says why"),
    Fact("unknown", None, "the speeds are too low, or the damping too high, for the stability of the page's method"),
    Fact("range", None, "the speeds must ascend, from above 0"),
    Fact("tail", None, "the harmonics left out hold more than 0.1 % of the response"),
    Fact("no_simd", None, "this browser has no WebAssembly with SIMD, which the page computes with: take a newer one"),
)  # fmt: skip


class Slider(NamedTuple):
    """A number of the project file, and what of the page's numbers it moves: place and change in a unit."""

    name: str
    label: str
    value: float
    unit: str
    low: float
    high: float
    moves: tuple[tuple[int, float], ...]

    def data(self) -> dict[str, Any]:
        """The slider as the page has it, with the unit as it is printed."""
        return self._asdict() | {"shown": sign(self.unit.replace("^", "**"))}


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


def page_with(data: dict[str, Any], own: bytes, *scripts: str) -> str:
    """Text of a page of data and of the code of its own functions; `scripts` are files that it has besides."""
    put = {
        "TITLE": _escaped(data["title"]), "STYLE": _text("page.css"),
        "CODE": "".join(map(_text, ("machine.js", *scripts, "page.js"))),
        "DATA": json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"), "OWN": _packed(own),
        "KERNELS": _packed(kernels()), "GEARS": _text("catalogue.html") if scripts else "",
    }  # fmt: skip
    return re.sub(r"@([A-Z]+)@", lambda found: put[found[1]], _text("page.html"))


def refused_parts(project: Project) -> list[str]:
    """Parts of a drive that no page holds."""
    parts = []
    if project.train is not None:
        parts.append("a motor with its loop, couplings or friction")
    if project.has_memory:
        parts.append("a law with friction or memory")
    if project.damping is not None or project.stiffness is not None:
        parts.append("a damping or stiffness that varies")
    if project.mean_range is not None:
        parts.append("a range of load torques")
    if project.postures:
        parts.append("loads in postures")
    if project.beats:
        parts.append("a line of the output's turn")
    return parts


def error_equation(project: Project) -> tuple[Oscillator, list[float], int]:
    """The equation of a page, its speeds [rad/s] and the limit [rad], and how often its period is in a turn."""
    own, g = folded(project)
    system: Any = own.system()
    limit = project.limit if project.limit is not None else 0.0
    return system, [*own.speeds.limits, limit], g


def data_of(project: Project) -> tuple[dict[str, Any], bytes]:
    """What the page knows of a project, and the machine code of its own functions."""
    if parts := refused_parts(project):
        raise ValueError(
            f"a page holds a gear with a spring and a rigid load, the motor ideally held or free; this drive has "
            f"{listed(parts)}: take `strainwave app` or `strainwave report`, or leave it out of the project"
        )
    system, ends, g = error_equation(project)
    corners = len(breakpoints_of(system.law))
    if not is_spring(system) or corners > MOST_KINKS:
        raise ValueError(f"a page holds laws of the torsion alone with at most {MOST_KINKS} breakpoints; take the app")
    top = max((1, *system.orders()))
    begin = max(top, SPRING_WITH_KINKS) if corners else SPRING * top
    most = max(MOST_OF_SPRING, top + 2)
    _, moved = sliders(project)
    described = json.loads(_text("kernels.json"))
    speeds = project.speeds
    data = {
        "title": project.title, "speedName": speeds.name, "speedUnit": speeds.unit, "scale": speeds.scale / g,
        "arcsec": ARCSEC, "numbers": leaves((*_own(system), *ends)), 
        "words": {name: _words(getattr(system, name)) for name in PARTS}, "limited": project.limit is not None,
        "exact": int(is_piecewise_linear(system.law)), "kinks": corners, "points": POINTS, "most": most,
        "harmonics": min(begin, most), "mostPoints": MOST_POINTS, "sliders": [one.data() for one in moved],
        "facts": {fact.key: fact.words for fact in FACTS}, "units": {key: unit for key, (unit, _) in UNITS.items()},
        "kinds": described["arguments"], "project": project.text,
    }  # fmt: skip
    return data, beside(_functions(system, corners))


def _own(system: Any) -> tuple[Any, ...]:
    """Numbers of an equation in the order in which the page keeps them: inertia, damping, and those of the parts."""
    return float(system.J), float(system.B), *(getattr(system, name) for name in PARTS)


def _functions(system: Any, corners: int) -> bytes:
    two = VECTOR, VECTOR
    exports = [
        Wanted("torques", _torques, (system.law,), two), Wanted("stiffnesses", _stiffnesses, (system.law,), two),
        Wanted("excitation", _torques, (system.excitation,), two),
        Wanted("error", _values_of_error, (system.error,), two),
    ]  # fmt: skip
    if corners:
        exports.append(Wanted("breakpoints", _breakpoints, (system.law,), (corners,)))
    return compiled(*exports).code


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


def sliders(project: Project) -> tuple[Project, list[Slider]]:
    """Numbers of the file that move those of the page along lines, each others than the rest; and their project.

    A damping that the file gives as a ratio is there a number, as in `replaced`.
    """
    content = read(project.text).content
    names = [name for name in numbers_of(content) if not name.endswith(LEFT_OUT)]
    value, unit = nominal_of(content, project.gear, LOAD)
    base = project
    for factor in (1.5, 1.0):  # what is no other number stays as it is, and is a number then
        base = replaced(base, {LOAD: _quantity(factor * value, unit)})
    content = read(base.text).content
    if base.gear is not None and isinstance(content.get("gear"), str):
        names += [f"gear.{name}" for name in OF_RECORD]
    rows: list[Slider] = []
    places: set[int] = set()
    for name in [*numbers_of(content), *(name for name in names if name.startswith("gear."))]:
        if name.endswith(LEFT_OUT):
            continue
        one = _slider(base, content, name)
        if one is not None and places.isdisjoint(place for place, _ in one.moves):
            rows.append(one)
            places |= {place for place, _ in one.moves}
    return base, rows


def _slider(project: Project, content: dict[str, Any], name: str) -> Slider | None:
    """The slider of a number of the file; None where it has none."""
    try:
        value, unit = nominal_of(content, project.gear, name)
    except ValueError:
        return None
    step = abs(value) or (1.0 if "N" not in unit else 0.1 * (project.rated_torque or 10.0))
    places = [value + (factor - 1.0) * step for factor in TRIED]
    try:
        numbers = [_numbers(replaced(project, {name: _quantity(place, unit)})) for place in places]
    except ValueError:
        return None
    if len({len(some) for some in numbers}) > 1:
        return None
    low, here, high = map(np.array, numbers)
    slope = (here - low) / (places[1] - places[0])
    if np.any(np.abs(here + slope * (places[2] - places[1]) - high) > STRAIGHT * np.abs(high)) or not np.any(slope):
        return None
    moves = tuple((int(i), float(slope[i])) for i in np.flatnonzero(slope))
    ends = (value / SPAN, value * SPAN) if value > 0.0 else (value - 5.0 * step, value + 5.0 * step)
    return Slider(name, _label(name), value, unit, *ends, moves)


def _label(name: str) -> str:
    """A name as a person reads it: "kinematic error 1 amplitude" for the first one."""
    words = name.removeprefix("excitation.").replace("_", " ").split(".")
    return " ".join(str(int(word) + 1) if word.isdigit() else word for word in words)


def _numbers(project: Project) -> list[float]:
    system, ends, _ = error_equation(project)
    return [float(number) for number in leaves((*_own(system), *ends))]


def _quantity(value: float, unit: str) -> str:
    return f"{value!r} {unit}".rstrip()


def _text(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def kernels() -> bytes:
    """The numerical kernels as a module of WebAssembly."""
    return gzip.decompress((HERE / "kernels.wasm.gz").read_bytes())


def _packed(code: bytes) -> str:
    return base64.b64encode(code).decode()


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
