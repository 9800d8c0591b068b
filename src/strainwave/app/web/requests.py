"""Bodies of requests: their fields, and the reading of JSON from a stranger."""

import json
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from starlette.requests import Request

from ...files.yaml_text import FILE_BYTES

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
    raise Refused(f"the request holds {text}, which is not a JSON number")


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
