"""The JSON API: what the page asks, and anybody on this machine may."""

import json
from collections.abc import Awaitable, Callable
from functools import cache
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from ...model.gears import catalogue
from ...results import SolveError
from .guard import refusal
from .jobs import Full, Jobs
from .requests import Body, JobRequest, MotionRequest, OfState, ResponseRequest, ScriptRequest, asked, parsed, two_axes
from .workers import Abandoned, Work, Workers

Handler = Callable[[Request], Awaitable[Response]]
OF_STATE, RESPONSE = Work("state", "of_state"), Work("views", "response")
WHOLE = {"compensation": Work("views", "compensated"), "report": Work("exports", "report_of")}
BODIES: dict[str, type[Body]] = {
    "/api/project": OfState,
    "/api/response": ResponseRequest,
    "/api/motion": MotionRequest,
    "/api/move": OfState,
    "/api/jobs": JobRequest,
    "/api/export/project": OfState,
    "/api/export/script": ScriptRequest,
}


def _sentence(error: Exception) -> str:
    return " ".join(str(error).split())


def guarded(handler: Handler) -> Handler:
    """Turn what a handler raises about its input into a sentence."""

    async def answered(request: Request) -> Response:
        try:
            return await handler(request)
        except (ValueError, SolveError) as error:
            return refusal(422, _sentence(error))
        except Full as error:
            return refusal(429, str(error))
        except Abandoned:
            return refusal(409, "the visitor has gone on")

    return answered


async def _computed(request: Request, work: Callable[..., Any], *args: Any) -> tuple[bytes, float]:
    """JSON of what `work` gives, and the processor time [s]; not done where the visitor has gone on meanwhile."""
    workers: Workers = request.app.state.workers

    async def wanted() -> bool:
        return not await request.is_disconnected()

    return await workers.run(work, *args, wanted=wanted)


async def _view(request: Request, work: Callable[..., Any], *args: Any) -> Response:
    """Answer with what `work` gives, and the processor time that it took."""
    content, took = await _computed(request, work, *args)
    return Response(
        content, media_type="application/json", headers={"server-timing": f"compute;dur={1e3 * took:.2f}"}
    )  # fmt: skip


@cache
def _gears() -> list[dict[str, Any]]:
    found = []
    for name in catalogue.names():
        gear = catalogue.gear(name)
        if gear.K2 is not None and gear.T1 is not None:
            found.append({"name": name, "series": gear.series, "size": gear.size, "ratio": gear.ratio})
    return found


async def gears(_request: Request) -> Response:
    """Gears of the catalogue that have a torsion law."""
    return JSONResponse(_gears())


async def project(request: Request) -> Response:
    """Title, numbers with their ranges, and notes of a project."""
    return await _view(request, Work("parameters", "about"), (await asked(request, OfState)).state)


async def response(request: Request) -> Response:
    """The response of the drive over its speeds."""
    body = await asked(request, ResponseRequest)
    return await _view(request, OF_STATE, RESPONSE, body.state, body.whole)


async def motion(request: Request) -> Response:
    """The motion at one speed."""
    body = await asked(request, MotionRequest)
    return await _view(request, OF_STATE, Work("views", "motion"), body.state, body.speed)


async def move(request: Request) -> Response:
    """The move of the project."""
    body = await asked(request, OfState)
    return await _view(request, OF_STATE, Work("views", "moved"), body.state)


async def log(request: Request) -> Response:
    """What is in a log, which is the body; `name` is that of its file."""
    name, content = request.query_params.get("name", "log.csv")[:200], await request.body()
    return await _view(request, Work("logs", "log_of"), name, content)


async def identify(request: Request) -> Response:
    """Start the job that identifies a drive: the first line of the body is {"state": ...}, the log follows."""
    name = request.query_params.get("name", "log.csv")[:200]
    first, _, content = (await request.body()).partition(b"\n")
    state = parsed(first, OfState).state
    await _computed(request, OF_STATE, bool, state)
    jobs: Jobs = request.app.state.jobs
    work = OF_STATE, Work("logs", "identified")
    return JSONResponse({"id": jobs.begin("identify", *work, state, name, content)}, 201)


async def project_file(request: Request) -> Response:
    """The project file with the changed values."""
    text, _ = await _computed(request, OF_STATE, Work("state", "yaml_of"), (await asked(request, OfState)).state)
    return PlainTextResponse(json.loads(text))


async def script(request: Request) -> Response:
    """The Python script that computes what a view shows."""
    text, _ = await _computed(request, Work("exports", "script_of"), await asked(request, ScriptRequest))
    return PlainTextResponse(json.loads(text))


async def begin(request: Request) -> Response:
    """Start a job."""
    body = await asked(request, JobRequest)
    jobs: Jobs = request.app.state.jobs
    await _computed(request, OF_STATE, bool, body.state)
    work: tuple[Any, ...]
    if body.kind == "map":
        axes = [(axis.name, list(axis.values)) for axis in two_axes(body.axes)]
        work = Work("views", "two_parameters"), body.state, axes
    elif body.kind == "speed-map":
        work = Work("views", "mapped"), body.state, body.search, list(body.loads)
    else:
        work = WHOLE[body.kind], body.state
    return JSONResponse({"id": jobs.begin(body.kind, OF_STATE, *work)}, 201)


async def job(request: Request) -> Response:
    """State of a job, and its result; DELETE cancels it."""
    jobs: Jobs = request.app.state.jobs
    name = request.path_params["name"]
    found = jobs.cancel(name) if request.method == "DELETE" else jobs.find(name)
    if found is None:
        return refusal(404, "there is no such job; it was cancelled, or it has expired")
    return JSONResponse(found.as_dict())


async def status(request: Request) -> Response:
    """Sentence on what is compiled now for the views; null if nothing is."""
    workers: Workers = request.app.state.workers
    return JSONResponse({"compiling": workers.compiling or None})


async def schema(_request: Request) -> Response:
    """JSON Schemas of the bodies of all requests."""
    posts = {path: body.model_json_schema() for path, body in BODIES.items()}
    others = {
        "/api/gears": "GET: gears of the catalogue",
        "/api/jobs/{id}": "GET: state, progress, result; DELETE: cancel",
        "/api/log?name=FILE": "POST: a log of at most 20 MiB as the body",
        "/api/identify?name=FILE": 'POST: a line {"state": ...} and the log as the body; starts a job',
        "/api/schema": "GET: this",
        "/api/status": "GET: what is compiled now, or null",
    }
    return JSONResponse({"post": posts, "other": others})


routes = [
    Route("/api/gears", gears),
    Route("/api/schema", schema),
    Route("/api/status", status),
    Route("/api/project", guarded(project), methods=["POST"]),
    Route("/api/response", guarded(response), methods=["POST"]),
    Route("/api/motion", guarded(motion), methods=["POST"]),
    Route("/api/move", guarded(move), methods=["POST"]),
    Route("/api/log", guarded(log), methods=["POST"]),
    Route("/api/identify", guarded(identify), methods=["POST"]),
    Route("/api/export/project", guarded(project_file), methods=["POST"]),
    Route("/api/export/script", guarded(script), methods=["POST"]),
    Route("/api/jobs", guarded(begin), methods=["POST"]),
    Route("/api/jobs/{name:str}", job, methods=["GET", "DELETE"]),
]
