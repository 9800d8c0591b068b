"""The project of a state: a gear of the catalogue or the text of a project file, with changed values.

Bodies of requests: their fields, and the reading of JSON from a stranger.
"""

import io
import json
import math
from collections.abc import Callable
from functools import lru_cache, reduce
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from ruamel.yaml import YAML
from starlette.requests import Request

from ...base.units import ARCSEC
from ...drive.project import Project
from ...files.fields.entries import EXAMPLE_LOOP
from ...files.fields.groups import ASSUMED, CATALOGUE, UNPRINTED
from ...files.fields.rows import inside
from ...files.project_text import project_text
from ...files.reading import ProjectError, from_text
from ...files.variants.names import quantity
from ...files.variants.replaced import PLACE, replaced
from ...files.yaml_text import FILE_BYTES, read
from ...model.gears import catalogue

NOWHERE = Path("/nonexistent-strainwave-app/project.yaml")  # a project of the page has no files beside it
FROM_FILES = ("python", "file")  # fields that name a file
FIRST_RPM = 3000.0  # rpm of a gear's first project, where the gear's own average is not lower

MOST_VALUES, LONGEST = 64, 80
MOST_LOADS = 40  # of a speed map
MOST_ACTIONS = 200  # of a session


class Refused(ValueError):
    """Input of a visitor that cannot be used; the sentence says why."""


class Body(BaseModel):
    """A request; unknown fields, infinities and NaN are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


CHANGED = 'Changed values with their units, by their names in the file: {"load.inertia": "2 kg*m^2"}.'


class State(Body):
    """A drive as a visitor has it: a gear of the catalogue or a project file, with changed values.

    The server keeps nothing of it: every request brings the whole state, and the address of the page holds it.
    """

    gear: str | None = Field(
        default=None, max_length=LONGEST, description="Name of a gear of the catalogue, as CSG-40-50."
    )
    project: str | None = Field(
        default=None, max_length=FILE_BYTES, description="Text of a project file, in place of a gear."
    )
    values: dict[str, str] = Field(default_factory=dict, max_length=MOST_VALUES, description=CHANGED)


class OfState(Body):
    """A request about a drive."""

    state: State


class ResponseRequest(OfState):
    """The response; `whole` looks for motions that do not join the curve, which takes longer."""

    whole: bool = False


class MotionRequest(OfState):
    """The motion at a speed, in rpm of the motor (rad/s of a forcing)."""

    speed: Annotated[float, Field(gt=0.0, lt=1e7)]


class Mapped(Body):
    """Body of a request for a speed map."""

    search: bool = True
    loads: Annotated[list[float], Field(max_length=MOST_LOADS)] = []


class JobRequest(Mapped, OfState):
    """A job: the speed map, the compensation, the tuning, or the report.

    With `search` the speed map looks for motions that do not join a curve. Its `loads` [N*m] are those of the project
    where none are given; a resisting one is negative.
    """

    kind: Literal["speed-map", "compensation", "tuning", "report"]


class Seen(Mapped):
    """A view that was looked at: a motion with its `speed`, a speed map with its `search` and `loads`."""

    view: Literal["response", "motion", "move", "speed-map", "compensation", "tuning", ""] = "response"
    speed: Annotated[float, Field(gt=0.0, lt=1e7)] | None = None


class Action(Seen):
    """An action of a session: the changed values of the drive, and the view of it; none where that is ""."""

    values: dict[str, str] = Field(default_factory=dict, max_length=MOST_VALUES)


class ScriptRequest(Seen, OfState):
    """The script of a session: its actions `before`, and the present drive in its view."""

    view: Literal["response", "motion", "move", "speed-map", "compensation", "tuning"] = "response"
    before: Annotated[list[Action], Field(max_length=MOST_ACTIONS)] = []


class LogColumns(Body):
    """Columns of a log: indices from 0 on and units by channel, and the rate [Hz] without a time."""

    columns: Annotated[dict[str, int], Field(max_length=MOST_VALUES)] = {}
    units: Annotated[dict[str, str], Field(max_length=MOST_VALUES)] = {}
    rate: Annotated[float, Field(gt=0.0)] | None = None


class GoalRequest(OfState):
    """The number that is to meet the limit."""

    name: Annotated[str, Field(max_length=LONGEST)]


Asked = TypeVar("Asked", bound=Body)


def _no_number(text: str) -> Any:
    raise Refused(f"the request holds {text}, which is no number of JSON")


async def asked(request: Request, kind: type[Asked]) -> Asked:
    """Read the body of a request (Refused)."""
    return parsed(await request.body(), kind)


def parsed(raw: bytes, kind: type[Asked]) -> Asked:
    """Read JSON from a stranger (Refused)."""
    try:
        content = json.loads(raw, parse_constant=_no_number)
    except RecursionError:
        raise Refused("the request is nested too deeply") from None
    except Refused:
        raise
    except ValueError:
        raise Refused("the body of the request is no JSON") from None
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        path = ".".join(map(str, first["loc"]))[:LONGEST]
        raise Refused(f"{path or 'the request'}: {first['msg'][:200]}") from None


def project_of(state: State) -> Project:
    """The project with the changed values (Refused)."""
    long = next((name for name, text in state.values.items() if len(name) > LONGEST or len(text) > LONGEST), None)
    if long is not None:
        raise Refused(f"a changed value is longer than {LONGEST} characters: {long[:LONGEST]!r}")
    file = next((name for name in state.values if not {*FROM_FILES}.isdisjoint(name.split("."))), None)
    if file is not None:
        raise Refused(f"{file!r} names a file; the app reads none: write its numbers into the project")
    if (state.gear is None) == (state.project is None):
        raise Refused("the state needs either a gear of the catalogue or the text of a project file")
    text = first_text(state.gear) if state.gear is not None else str(state.project)
    values = dict(state.values)
    try:
        base = _read(text)
        values |= first_sources(base, values) if values else {}
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
    for key, value in content.items() if isinstance(content, dict) else ():
        if key in FROM_FILES:
            fault = f"the project names a file in {key!r}; the app reads none: write its numbers into the project"
            raise Refused(fault)
        _refuse_files(value)
    for value in content if isinstance(content, list) else ():
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


@lru_cache(256)
def first_text(name: str) -> str:
    """First project of a gear: an axis in a cascade, whose limit is its accuracy class, 1.54 times its slow error.

    Order 2 meets the resonance of the load, the motor held, at half of the largest speed. The stiffness is K1. The
    motor's inertia is that of the wave generator, else matched to the load. The kinematic error is the accuracy class,
    as in a file of `strainwave new`.
    """
    gear = catalogue.gear(name)
    gear.check_law()
    fastest = min(FIRST_RPM, gear.average_rpm or gear.max_rpm or FIRST_RPM)
    inertia = (gear.K1 or 1e4) / (fastest * math.pi / 30.0) ** 2
    accuracy = UNPRINTED if gear.accuracy is None else f"{gear.accuracy / ARCSEC:.3g} arcsec"
    rotor = f"{1e4 * gear.input_inertia:.6g}" if gear.input_inertia else f"{1e4 * inertia / gear.ratio**2:.2g}"
    return (
        f"title: {gear.name}\n"
        f"gear: {gear.name}\n"
        f"motor: {{inertia: {rotor} kg*cm^2, loop: {EXAMPLE_LOOP}}}\n"
        f"load: {{inertia: {inertia:.2g} kg*m^2}}\n"
        "damping: {ratio: 3 %}\n"
        f"speed: {{from: {fastest / 8:.3g} rpm, to: {fastest:g} rpm, shaft: motor}}\n"
        "excitation:\n"
        f"  accuracy: {CATALOGUE if gear.accuracy else accuracy}\n"
        "  load_torque: {mean: 0 N*m}\n"
        f"limit: {{oscillation: {accuracy}}}\n"
        "sources:\n"
        "  {motor: assumed, load: assumed, damping: assumed, speed: assumed, excitation: assumed, limit: assumed}\n"
    )


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
