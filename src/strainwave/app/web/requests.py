"""Bodies of requests: their fields, and the reading of JSON from a stranger."""

import json
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from starlette.requests import Request

from ...files.yaml_text import LARGEST

MOST_VALUES, LONGEST = 64, 80
MOST_ALONG = 40  # points of an axis of a map


class Refused(ValueError):
    """What a visitor sent cannot be used; the sentence says why."""


class State(BaseModel):
    """A drive as a visitor has it: a gear of the catalogue or a project file, with changed values.

    The server keeps nothing of it: every request brings the whole state, and the address of the page holds it.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    gear: str | None = Field(
        default=None, max_length=LONGEST, description="Name of a gear of the catalogue, as CSG-40-50."
    )
    project: str | None = Field(
        default=None, max_length=LARGEST, description="Text of a project file, in place of a gear."
    )
    values: dict[str, str] = Field(
        default_factory=dict,
        max_length=MOST_VALUES,
        description='Changed values with their units, by their names in the file: {"load.inertia": "2 kg*m^2"}.',
    )


class Body(BaseModel):
    """A request; unknown fields, infinities and NaN are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class OfState(Body):
    """A request about a drive."""

    state: State


class ResponseRequest(OfState):
    """The response; `whole` looks for motions that do not join the curve, which takes longer."""

    whole: bool = False


class MotionRequest(OfState):
    """The motion at a speed, in rpm of the motor (rad/s of a forcing)."""

    speed: Annotated[float, Field(gt=0.0, lt=1e7)]


class Axis(Body):
    """Values of a number of the project, with their units."""

    name: Annotated[str, Field(max_length=LONGEST)]
    values: Annotated[list[Annotated[str, Field(max_length=LONGEST)]], Field(min_length=2, max_length=MOST_ALONG)]


Loads = Annotated[list[float], Field(max_length=MOST_ALONG)]


def two_axes(axes: list[Axis]) -> list[Axis]:
    """The axes of a two-parameter map (Refused)."""
    if len(axes) != 2 or axes[0].name == axes[1].name:
        raise Refused("a two-parameter map needs two axes of different names")
    return axes


class JobRequest(OfState):
    """A job: a two-parameter map (with its `axes`), the speed map, the compensation, or the report.

    With `search` the speed map looks for motions that do not join a curve. Its `loads` [N*m] are those of the project
    where none are given; a resisting one is negative.
    """

    kind: Literal["map", "speed-map", "compensation", "report"]
    axes: Annotated[list[Axis], Field(max_length=2)] = []
    search: bool = True
    loads: Loads = []


class ScriptRequest(OfState):
    """The script of a view: of a motion with its `speed`, of maps with their `axes`, or `search` and `loads`."""

    view: Literal["response", "motion", "move", "speed-map", "compensation", "map"] = "response"
    speed: Annotated[float, Field(gt=0.0, lt=1e7)] | None = None
    axes: Annotated[list[Axis], Field(max_length=2)] = []
    search: bool = True
    loads: Loads = []


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
        place = ".".join(map(str, first["loc"]))[:LONGEST]
        raise Refused(f"{place or 'the request'}: {first['msg'][:200]}") from None
