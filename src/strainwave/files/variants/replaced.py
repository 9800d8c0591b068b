"""A project with other values in its file: read again, so that units and refusals are those of the file.

A drive is built once. The gains that the file gives as a bandwidth and the damping B that it gives as a ratio or a
quality stay those of its own drive, whatever else is varied; a name that is this notation (`loop.bandwidth`,
`damping.ratio`) changes what it names, and with another gear B follows its ratio.
"""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache, reduce
from pathlib import Path
from typing import Any, TypeVar

from ...base import quantities
from ...base.quantities import is_model, shown
from ...drive.project import Project
from ...drive.sources import Source
from ...model.laws.springs import PiecewiseLinear
from ..fields.entries import Loop
from ..fields.groups import YOURS
from ..fields.kinds import Entry
from ..fields.rows import inside, rows_of
from ..reading import ProjectError, from_located
from ..yaml_text import read, read_again
from .names import Keys, keys_of, numbers_of, quantity

Subject = TypeVar("Subject", Project, Any)
Placed = dict[str, tuple[Keys, str]]  # by its name in the file: where a text belongs, and the text
LOOP, DAMPING = ("motor", "loop"), ("damping",)
GEAR = ("gear",), ("gear", "name")  # what names another gear of the catalogue
OF_RECORD = rows_of(PiecewiseLinear)  # of a catalogue gear's law
PLACE = re.compile(r"^.*?:\d+:\d+: ", re.MULTILINE)  # of a complaint, in a file that nobody wrote


def replaced(project: Subject, values: Mapping[str, Any], *, retune: bool = False) -> Subject:
    """Read a project again with other values in its file, or change parameters of a model.

    Gains that the file gives as a bandwidth, and the damping B that it gives as a ratio or a quality, keep the numbers
    that they have in the drive of the file, and the text then has these numbers. A name that is this notation, such as
    "loop.bandwidth" or "damping.ratio", changes what it names. With another gear B follows its damping ratio.

    Parameters
    ----------
    project : Project or NamedTuple
        As `read_project` returns it; or any system, law or excitation.
    values : dict of str to str, or to number
        Of a model: numbers (SI) by their paths, {"law.alpha": 2.0, "error.lines.0.amplitude": 1e-4}. Of a project:
        values as the file has them, with their units ("2 kg*m^2", "30 Hz", "SHG-40-50"), by their names in the file:
        "load.inertia", "excitation.kinematic_error.0.amplitude", "gear", "speed" for a single one. "motor.", "load."
        and "excitation." may be left out ("loop.K_p", "coupling.law.K"). "gear.K1", K2, K3, T1, T2 are also those of a
        gear of the catalogue.
    retune : bool
        True to compute gains given as a bandwidth and damping given as a ratio or a quality anew for the changed
        drive, as if the file had been written for it.

    Returns
    -------
    Project or NamedTuple
        The text of a project is what was read.

    Raises
    ------
    ValueError
        If there is no such field or path, the file may not have such a value, or a model would have NaN.
    TypeError
        If it is neither a project nor a model.
    """
    if not isinstance(project, Project):
        return quantities.replace(project, values)
    content = json.loads(_content(project.text))
    placed = {path: (keys_of(content, path), text) for path, text in values.items()}
    of_record = {keys[1]: _of_record(path, text) for path, (keys, text) in placed.items() if _in_record(keys)}
    placed = {path: (keys, text) for path, (keys, text) in placed.items() if not _in_record(keys)}
    if not any(keys[0] == "gear" for keys, _ in placed.values()):  # the text of the project has no changed slopes
        of_record = _changed_slopes(project, _read(project, content)) | of_record
    result = _read(project, _with(content, placed))
    if not retune:
        result = _as_built(project, content, placed, result)
    return _with_law(result, of_record) if of_record else result


def tuning(project: Project, names: Iterable[str], retune: bool) -> str:
    """Sentence on gains and damping where these numbers of a file are varied; empty where they stay.

    The sentence is about what the file gives by a notation: see `replaced`.
    """
    content = json.loads(_content(project.text))
    keys = [keys_of(content, name) for name in names]
    loop = "the gains of the motor's loop", _has_bandwidth(content), LOOP
    damping = "the damping B", bool(_ratios(content)), DAMPING
    parts = [what for what, g, group in (loop, damping) if g and any(key[: len(group)] != group for key in keys)]
    if not parts:
        return ""
    if retune:
        return f"Computed anew for every drive: {' and '.join(parts)}."
    return f"Kept as in the drive of the file: {' and '.join(parts)}; retune computes them anew for every drive."


def _read(project: Project, content: dict[str, Any]) -> Project:
    return _reading(json.dumps(content, ensure_ascii=False), project.path)


@lru_cache(64)
def _reading(text: str, path: Path) -> Project:
    try:
        return from_located(read_again(text), text, path)
    except ProjectError as error:
        raise ValueError("; ".join(PLACE.sub("", str(error)).splitlines())) from None


def _with(content: dict[str, Any], placed: Placed) -> dict[str, Any]:
    """The content of a file with texts at their keys."""
    changed: dict[str, Any] = json.loads(json.dumps(content))
    for path, (keys, text) in placed.items():
        if keys[0] == "sources":
            changed.setdefault("sources", {})[".".join(keys[1:])] = text
            continue
        _set(changed, path, keys, text)
        if changed.get("sources") and keys != ("title",) and not _same(content, keys, text):
            changed["sources"][".".join(keys)] = YOURS
    return changed


def _same(content: dict[str, Any], keys: Keys, text: str) -> bool:
    """True for a field of the file with this text, or with the same number in the same unit."""
    if not isinstance(before := reduce(inside, keys, content), str):
        return False
    return before.split() == text.split() or (None, "") != quantity(before) == quantity(text)


def _as_built(project: Project, content: dict[str, Any], placed: Placed, result: Project) -> Project:
    """The changed project with the gains and the damping of the drive of the file, as far as they differ."""
    changed, retained = _with(content, placed), []
    if _has_bandwidth(content) and result.whole is not None:
        tuned = _read(project, _with(content, _within(placed, LOOP))).whole
        if tuned is not None and tuned.motor.control != result.whole.motor.control:
            changed["motor"]["loop"] = read(Loop().text(tuned.motor.control)).content
            retained.append("the gains of the motor's loop")
    if ratios := _ratios(content):
        B = _read(project, _with(content, _within(placed, DAMPING, *GEAR))).drive.B
        if result.drive.B != B:
            damping = {name: value for name, value in changed["damping"].items() if name not in ratios}
            changed["damping"] = {**damping, "B": f"{B!r} N*m*s/rad"}
            former = {f"damping.{name}" for name in ratios}  # B is as many percent off as they are
            if scatter := _scatter(changed):
                changed["scatter"] = {"damping.B" if key in former else key: item for key, item in scatter}
            retained.append("the damping B")
    if not retained:
        return result
    note = f"Kept from the drive before the change: {' and '.join(retained)}."
    if dropped := _drop_scatter_of_loop(changed):
        note = f"{note} Gains take the place of {' and '.join(dropped)}, whose scatter is left out."
    result = _read(project, changed)
    return replace(result, notes=(*result.notes, note))


def _scatter(content: dict[str, Any]) -> list[tuple[str, Any]]:
    return list((content.get("scatter") or {}).items())


def _drop_scatter_of_loop(content: dict[str, Any]) -> list[str]:
    """Leave out the scatter of a bandwidth and of its damping where the loop has gains now; their names."""
    named = [key for key, _ in _scatter(content) if key.removeprefix("motor.") in ("loop.bandwidth", "loop.damping")]
    if not named or _has_bandwidth(content):
        return []
    kept = [i for i, (key, _) in enumerate(_scatter(content)) if key not in named]
    content["scatter"] = dict([_scatter(content)[i] for i in kept])
    if rows := content.pop("scatter_correlation", None):
        content["scatter_correlation"] = [[rows[i][j] for j in kept] for i in kept]
    if not kept:
        del content["scatter"]
    return named


def _within(placed: Placed, *groups: Keys) -> Placed:
    """Texts whose keys are in one of some groups of the file."""
    return {
        path: (keys, text)
        for path, (keys, text) in placed.items()
        if any(group == (keys if group in GEAR else keys[: len(group)]) for group in groups)
    }


def _has_bandwidth(content: dict[str, Any]) -> bool:
    """True for a file that gives the motor's loop by its bandwidth."""
    return reduce(inside, (*LOOP, "bandwidth"), content) is not None


def _ratios(content: dict[str, Any]) -> set[str]:
    """Fields by which a file gives the damping relative to the rest of the drive."""
    return {name for name in ("ratio", "quality") if inside(content.get("damping"), name) is not None}


def _in_record(keys: Keys) -> bool:
    return keys[0] == "gear" and len(keys) > 1 and keys[1] in OF_RECORD


@lru_cache(64)
def _content(text: str) -> str:
    """Content of a project file as JSON."""
    return json.dumps(read(text).content)


def _set(content: dict[str, Any], path: str, keys: Keys, text: str) -> None:
    if keys == ("speed", "at"):
        shaft = {key: value for key, value in content["speed"].items() if key == "shaft"}
        content["speed"] = {"at": [text], **shaft}
        return
    group: Any = content
    for i, key in enumerate(keys):
        inside = isinstance(group, dict) or (isinstance(group, list) and key.isdecimal() and int(key) < len(group))
        if not inside:
            raise ValueError(
                f"the project file has no {shown(path)}: {'.'.join(keys[:i])} is not a group with {shown(key)}; its "
                f"numbers are {', '.join(numbers_of(content))}"
            )
        index: Any = int(key) if isinstance(group, list) else key
        if i == len(keys) - 1:
            group[index] = text
        elif isinstance(group, list):
            group = group[index]
        else:
            group = group.setdefault(index, [{}] if keys[i + 1] == "0" else {})


def _of_record(path: str, text: str) -> float:
    try:
        return float(OF_RECORD[path.rpartition(".")[2]].kind.read(text, Entry((), [])))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def slopes(project: Project) -> Any:
    """The law of three slopes that the drive has now: that of the record, or a changed one; None without one."""
    parts = [project.drive.law]
    while parts:
        law = parts.pop()
        if hasattr(law, "K1"):
            return law
        parts += [part for part in law if isinstance(part, tuple) and hasattr(part, "_fields")]
    return None if project.gear is None else project.gear.law


def _changed_slopes(project: Project, read: Project) -> dict[str, float]:
    """Numbers of the law of a gear of the catalogue that the project has otherwise than its text says."""
    law, before = slopes(project), slopes(read)
    if project.gear is None or not type(law) is type(before) is type(project.gear.law):
        return {}
    return {name: value for name, value in law._asdict().items() if value != getattr(before, name)}


def _with_law(project: Project, numbers: dict[str, float]) -> Project:
    """Return a project of a gear of the catalogue with other numbers in its law."""
    if project.gear is None or any(name not in project.gear.law._fields for name in numbers):
        has = "no law of three slopes" if project.gear is None else f"a law of {', '.join(project.gear.law._fields)}"
        raise ValueError(f"gear.{next(iter(numbers))}: this gear has {has}")
    kind = type(project.gear.law)

    def changed(thing: Any) -> Any:
        if isinstance(thing, kind):
            return thing._replace(**numbers)
        return type(thing)(*map(changed, thing)) if is_model(thing) else thing

    law = changed(project.drive.law)
    sources = (*project.sources, *(Source(f"gear.{name}", f"{value:.6g} (SI)") for name, value in numbers.items()))
    return replace(project, subject=project.subject._replace(law=law), sources=sources)
