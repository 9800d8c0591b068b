"""Reading a project file: YAML with units, resolved to a `Project` in SI, or every problem with its place."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError, create_model

from ..model.gears import catalogue
from ..model.gears.gear import Gear
from ..study.move.mover import Task
from ..study.train.loop_margin import unstable
from .complaints import complaints
from .contradictions import contradictions
from .move.fields import task_of
from .own_gears import read_gears
from .project import Project
from .python_law import with_python_laws
from .resolve import resolved
from .schema import ExplicitGear, NamedGear, ProjectSpec, Spec
from .yaml_text import FileError, Located, Problem, as_path, complaint, name, read, read_text, shown


class ProjectError(FileError):
    """A project file cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


def read_project(path: str | Path) -> Project:
    """Read a project file.

    Parameters
    ----------
    path : str or Path
        YAML file of at most 256 KiB, see `examples/projects`.

    Raises
    ------
    ProjectError
        If the file cannot be read or does not describe a drive; all problems found, one line each.
    """
    path = as_path(path)
    text = read_text(path)
    if isinstance(text, Problem):
        raise _error(path, [text])
    return from_text(text, path)


def from_text(text: str, path: Path) -> Project:
    """Read the text of a project file that is, or could be, at a path (ProjectError as `read_project`)."""
    return from_located(read(text), text, path)


def from_located(located: Located, text: str, path: Path) -> Project:
    """Make a project of what was read of a text (ProjectError as `read_project`)."""
    content, wrong = with_python_laws(located, path.parent)
    problems = [*located.problems, *wrong]
    if located.content is None:
        if not problems:
            problems.append(Problem(1, 1, "file", "is empty; begin with a line such as 'gear: CSG-40-50'"))
        raise _error(path, problems)
    try:
        spec = ProjectSpec.model_validate(content)
    except ValidationError as error:
        problems += complaints(error, located)
        if not isinstance(located.content, dict):
            raise _error(path, problems) from None
        spec = _what_is_right(content)
    gear: Gear | ExplicitGear | None = None
    elsewhere: list[str] = []
    task: Task | None = None
    try:
        task = task_of(spec.move, path.parent)
    except FileError as error:
        elsewhere.append(str(error))
    try:
        gear = _gear(spec, path)
    except FileError as error:
        elsewhere.append(str(error))
    except ValueError as error:
        problems.append(Problem(*located.place(("gear", "name")), "gear.name", str(error)))
    else:
        found = contradictions(spec, gear if isinstance(gear, Gear) else None, located.content)
        problems += [Problem(*located.place(keys), name(keys), sentence) for keys, sentence in found]
    if problems or elsewhere or gear is None:
        raise ProjectError("\n".join(part for part in (problems and complaint(path, problems), *elsewhere) if part))
    project = replace(resolved(spec, gear, path, text), move=task)
    if project.train is not None and (sentence := unstable(project.train, project.loop_inertia)):
        raise _error(path, [Problem(*located.place(("motor", "loop")), "motor.loop", sentence)])
    return project


def _what_is_right(content: dict[str, Any]) -> ProjectSpec:
    """The groups of a file that are right by themselves; None in place of the others."""
    right: dict[str, Any] = {}
    for group, info in ProjectSpec.model_fields.items():
        one = create_model(group, __base__=Spec, **{group: (info.annotation, info)})  # type: ignore[call-overload]
        try:
            given = {group: content[group]} if group in content else {}
            right[group] = getattr(one.model_validate(given), group)
        except ValidationError:
            right[group] = None
    return ProjectSpec.model_construct(**right)


def _gear(spec: ProjectSpec, path: Path) -> Gear | ExplicitGear | None:
    """The gear's record, or the gear that the file writes out; None of a file without."""
    if isinstance(spec.gear, NamedGear):
        if spec.gear.file is None:
            return catalogue.gear(spec.gear.name)
        file = path.parent / spec.gear.file
        gears = read_gears(file)
        if spec.gear.name not in gears:
            raise ValueError(f"{spec.gear.file} has no gear {shown(spec.gear.name)}; it has {', '.join(gears)[:200]}")
        return gears[spec.gear.name]
    return catalogue.gear(spec.gear) if isinstance(spec.gear, str) else spec.gear


def _error(path: Path, problems: list[Problem]) -> ProjectError:
    return ProjectError(complaint(path, problems))
