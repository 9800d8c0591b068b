"""The project of a state: a gear of the catalogue or the text of a project file, with changed values."""

import io
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from ...drive.project import Project
from ...files.project_text import project_text
from ...files.reading import ProjectError, from_text
from ...files.variants.replaced import PLACE, replaced
from ...files.yaml_text import read
from .first_project import first_sources, first_text
from .requests import LONGEST, Refused, State

NOWHERE = Path("/nonexistent-strainwave-app/project.yaml")  # a project of the page has no files beside it
FROM_FILES = ("python", "file")  # fields that name a file


def project_of(state: State) -> Project:
    """The project with the changed values (Refused)."""
    long = next((name for name, text in state.values.items() if len(name) > LONGEST or len(text) > LONGEST), None)
    if long is not None:
        raise Refused(f"a changed value is longer than {LONGEST} characters: {long[:LONGEST]!r}")
    file = next((name for name in state.values if not {*FROM_FILES}.isdisjoint(name.split("."))), None)
    if file is not None:
        raise Refused(f"{file!r} is a file; the app reads no files: write the numbers into the project")
    if (state.gear is None) == (state.project is None):
        raise Refused("the state needs either a gear of the catalogue or the text of a project file")
    text = first_text(state.gear) if state.gear is not None else str(state.project)
    try:
        base = _read(text)
        values = state.values | first_sources(base, state.values)
        return replaced(base, values, retune=True) if values else base  # the page is an editor of its file
    except ProjectError as error:
        raise Refused("; ".join(PLACE.sub("", str(error)).splitlines())) from None


def of_state(view: Callable[..., Any], state: State, *args: Any, **options: Any) -> Any:
    """Data of a view of the project of a state."""
    return view(project_of(state), *args, **options)


@lru_cache(64)
def _read(text: str) -> Project:
    """Project of a text, which may not name files: they would be the server's (Refused)."""
    content = read(text).content
    _refuse_files(content)
    return from_text(text, NOWHERE)


def _refuse_files(content: object) -> None:
    listed = enumerate(content) if isinstance(content, list) else ()
    for key, value in content.items() if isinstance(content, dict) else listed:
        if key in FROM_FILES:
            fault = f"the project refers to a file in {key!r}; the app reads no files: write the numbers into it"
            raise Refused(fault)
        _refuse_files(value)


def yaml_of(project: Project) -> str:
    """A project as a file: its own text, or the changed one in blocks."""
    text = project_text(project)
    if not text.lstrip().startswith("{"):
        return text
    yaml, out = YAML(), io.StringIO()
    yaml.width = 120
    yaml.dump(read(text).content, out)
    return out.getvalue()
