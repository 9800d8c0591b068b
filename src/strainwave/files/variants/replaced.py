"""A project with other values in its file: read again, so that units and refusals are those of the file."""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from ...tree import is_model
from ..entries import number
from ..project import Project
from ..reading import ProjectError, from_located
from ..yaml_text import read, read_again
from .names import Keys, keys_of, numbers_of

OF_RECORD = {"K1": "N*m/rad", "K2": "N*m/rad", "K3": "N*m/rad", "T1": "N*m", "T2": "N*m"}  # of a catalogue gear's law
PLACE = re.compile(r"^.*?:\d+:\d+: ", re.MULTILINE)  # of a complaint, in a file that nobody wrote


def replaced(project: Project, values: Mapping[str, str]) -> Project:
    """Read a project again with other values in its file.

    Parameters
    ----------
    project : Project
        As `read_project` returns it.
    values : dict of str to str
        Values as the file has them, with their units ("2 kg*m^2", "30 Hz", "SHG-40-50"), by their names in the file:
        "load.inertia", "excitation.kinematic_error.0.amplitude", "gear", "speed" for a single one. "motor.", "load."
        and "excitation." may be left out ("loop.K_p", "coupling.law.K"). "gear.K1", K2, K3, T1, T2 are also those of a
        gear of the catalogue.

    Returns
    -------
    Project
        Its text is what was read.

    Raises
    ------
    ValueError
        If there is no such field, or the file may not have such a value.
    """
    content = json.loads(_content(project.text))
    of_record: dict[str, float] = {}
    for path, text in values.items():
        keys = keys_of(content, path)
        if keys[0] == "gear" and keys[1:] and keys[1] in OF_RECORD:
            of_record[keys[1]] = _of_record(path, text)
        else:
            _set(content, path, keys, text)
    try:
        changed = json.dumps(content, ensure_ascii=False)
        found = from_located(read_again(changed), changed, project.path)
    except ProjectError as error:
        raise ValueError("; ".join(PLACE.sub("", str(error)).splitlines())) from None
    return _with_law(found, of_record) if of_record else found


@lru_cache(64)
def _content(text: str) -> str:
    """Content of a project file as JSON."""
    return json.dumps(read(text).content)


def _set(content: dict[str, Any], path: str, keys: Keys, text: str) -> None:
    if keys == ("speed", "at"):
        shaft = {key: value for key, value in content["speed"].items() if key == "shaft"}
        content["speed"] = {"at": [text], **shaft}
        return
    here: Any = content
    for i, key in enumerate(keys):
        inside = isinstance(here, dict) or (isinstance(here, list) and key.isdecimal() and int(key) < len(here))
        if not inside:
            raise ValueError(
                f"the project file has no {path!r}: {'.'.join(keys[:i])} is not a group with {key!r}; its numbers are "
                f"{', '.join(numbers_of(content))}"
            )
        at: Any = int(key) if isinstance(here, list) else key
        if i == len(keys) - 1:
            here[at] = text
        else:
            here = here[at] if isinstance(here, list) else here.setdefault(at, {})


def _of_record(path: str, text: str) -> float:
    unit = OF_RECORD[path.rpartition(".")[2]]
    try:
        return number(text, unit, "positive")
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


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
    train, whole = (one and one._replace(law=law) for one in (project.train, project.whole))
    return replace(project, drive=project.drive._replace(law=law), train=train, whole=whole)
