"""The JSON API of the page, open to any program on this machine.

Work in the background: a few jobs at a time, each with its progress and its end, in a process that can be killed.
"""

import asyncio
import json
import re
import secrets
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from time import monotonic
from typing import Any, NamedTuple

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from ...base.results import SolveError
from ...model.gears import catalogue
from . import requests
from .guard import refusal
from .worker import Unexpected
from .workers import Abandoned, Work, Workers

Handler = Callable[[Request], Awaitable[Response]]
OF_STATE, RESPONSE = Work("state", "of_state"), Work("views", "response")
JOBS = {  # what a page waits for, in words, and its work
    "speed-map": ("a speed map", Work("views", "mapped")),
    "compensation": ("a compensation", Work("goals", "compensated")),
    "tuning": ("a tuning", Work("goals", "tuned")),
    "report": ("a report", Work("exports", "report_of")),
    "identify": ("an identification", Work("logs", "identified")),
}


class Answer(NamedTuple):
    """The body that an address takes, the work that answers it, and the fields that this is given; all where none."""

    body: type[requests.Body]
    work: tuple[Work, ...]
    fields: tuple[str, ...] = ("state",)


ANSWERS = {
    "/api/project": Answer(requests.OfState, (Work("parameters", "about"),)),
    "/api/response": Answer(requests.ResponseRequest, (OF_STATE, RESPONSE), ("state", "whole")),
    "/api/sureness": Answer(requests.OfState, (OF_STATE, Work("views", "sureness"))),
    "/api/loads": Answer(requests.OfState, (OF_STATE, Work("views", "allowed_under_every_load"))),
    "/api/motion": Answer(requests.MotionRequest, (OF_STATE, Work("views", "motion")), ("state", "speed")),
    "/api/goal": Answer(requests.GoalRequest, (OF_STATE, Work("goals", "goal")), ("state", "name")),
    "/api/move": Answer(requests.OfState, (OF_STATE, Work("views", "moved"))),
    "/api/export/project": Answer(requests.OfState, (OF_STATE, Work("state", "yaml_of"))),
    "/api/export/script": Answer(requests.ScriptRequest, (Work("exports", "script_of"),), ()),
}

LATER = ("/api/goal", "/api/loads", "/api/sureness")  # after a pause: in a process that no slider step waits for
MOST_JOBS, AT_ONCE = 16, 1  # jobs that are held, and that run
KEPT, LEFT = 900.0, 150.0  # seconds without a question after which a finished job is forgotten, and another is stopped


class Full(Exception):
    """There are as many jobs as the server takes."""


@dataclass
class Job:
    """One piece of work; `state` is "waiting", "running", "done", "failed" or "cancelled"."""

    kind: str
    state: str = "waiting"
    stage: str = "waiting"
    share: float = 0.0
    begun: float = field(default_factory=monotonic)
    seen: float = field(default_factory=monotonic)
    result: Any = None
    error: str = ""
    task: asyncio.Task[None] | None = None

    def run(self) -> None:
        """Record that the work begins."""
        self.state, self.begun = "running", monotonic()

    def progress(self, stage: str, share: float) -> None:
        """Record the progress."""
        self.stage, self.share = stage, max(self.share, min(1.0, float(share)))

    def cancel(self) -> None:
        """Stop the work, unless it has ended."""
        if self.state in ("waiting", "running"):
            self.state = "cancelled"
        if self.task is not None:
            self.task.cancel()

    def as_dict(self) -> dict[str, Any]:
        """The job as data for the page."""
        took = monotonic() - self.begun
        left = took * (1.0 / self.share - 1.0) if self.state == "running" and self.share > 0.02 else None
        data = {"kind": self.kind, "state": self.state, "stage": self.stage, "share": self.share, "seconds_left": left}
        return data | {"result": self.result, "error": self.error or None}


class Jobs:
    """The jobs of one server.

    Parameters
    ----------
    kept, left : float
        Times [s] without a question after which a job that has ended is forgotten, and another one is stopped.
    """

    def __init__(self, kept: float = KEPT, left: float = LEFT) -> None:
        self._jobs: dict[str, Job] = {}
        self._kept, self._left = kept, left
        self._workers = Workers(AT_ONCE, background=True)
        self._watch = asyncio.create_task(self._expiring())

    def begin(self, kind: str, work: Callable[..., Any], *args: Any) -> str:
        """Start a job, `work(*args, progress=...)`, and return its name (Full)."""
        if len(self._jobs) >= MOST_JOBS:
            raise Full(f"{MOST_JOBS} jobs exist already; cancel one, or wait until one has finished and expired")
        name, job = secrets.token_hex(8), Job(kind)
        self._jobs[name] = job
        job.task = asyncio.create_task(self._run(job, work, args))
        return name

    def find(self, name: str) -> Job | None:
        """Job of a name, which stays for a while longer; None where there is none."""
        job = self._jobs.get(name)
        if job is not None:
            job.seen = monotonic()
            if job.state == "waiting":
                job.stage = self._awaited(job)
        return job

    def _awaited(self, job: Job) -> str:
        """Sentence on the jobs that a job waits for."""
        ahead = [one for one in self._jobs.values() if one.state in ("waiting", "running")]
        kinds = [JOBS[one.kind][0] if one.kind in JOBS else "a job" for one in ahead[: ahead.index(job)]]
        return " ".join(["waiting for", " and ".join(kinds), "of this page or of another"]) if kinds else "starting"

    def cancel(self, name: str) -> Job | None:
        """Stop a job and forget it; None where there is none."""
        job = self._jobs.pop(name, None)
        if job is not None:
            job.cancel()
        return job

    async def close(self) -> None:
        """Stop all jobs."""
        self._watch.cancel()
        for name in list(self._jobs):
            self.cancel(name)
        await self._workers.close()

    async def _expiring(self) -> None:
        """Remove jobs without a request for a while; a job whose page has gone is stopped."""
        while True:
            await asyncio.sleep(min(self._left, self._kept) / 10.0)
            now = monotonic()
            for name, job in list(self._jobs.items()):
                if now - job.seen > (self._left if job.state in ("waiting", "running") else self._kept):
                    self.cancel(name)

    async def _run(self, job: Job, work: Callable[..., Any], args: tuple[Any, ...]) -> None:
        try:
            result, _ = await self._workers.run(work, *args, begun=job.run, progress=job.progress)
            job.result = json.loads(result)
            job.state, job.stage, job.share = "done", "done", 1.0
        except requests.Refused as error:
            job.state, job.error = "failed", str(error)
        except Unexpected as error:  # whatever it is, a visitor gets one sentence
            job.state, job.error = "failed", f"the job failed unexpectedly ({error})"


def guarded(handler: Handler) -> Handler:
    """Turn exceptions of a handler about its input into a sentence."""

    async def answered(request: Request) -> Response:
        try:
            return await handler(request)
        except (ValueError, SolveError) as error:
            return refusal(422, " ".join(str(error).split()))
        except Full as error:
            return refusal(429, str(error))
        except Abandoned:
            return refusal(409, "the request was replaced by a newer one")

    return answered


async def _computed(request: Request, work: Callable[..., Any], *args: Any) -> tuple[bytes, float]:
    """JSON of the result of `work`, and the processor time [s]; not computed where the visitor no longer waits."""
    state = request.app.state
    workers: Workers = state.later if request.url.path in LATER else state.workers

    async def waiting() -> bool:
        return not await request.is_disconnected()

    return await workers.run(work, *args, visitor=request.client, waiting=waiting)


async def _view(request: Request, work: Callable[..., Any], *args: Any) -> Response:
    """Answer with the result of `work`, an export as text, and the processor time that it took."""
    content, took = await _computed(request, work, *args)
    if request.url.path.startswith("/api/export/"):
        return PlainTextResponse(json.loads(content))
    timing = {"server-timing": f"compute;dur={1e3 * took:.2f}"}
    return Response(content, media_type="application/json", headers=timing)


@cache
def _gears() -> list[dict[str, Any]]:
    complete = [gear for gear in map(catalogue.gear, catalogue.names()) if gear.K2 is not None and gear.T1 is not None]
    return [{"name": gear.name, "series": gear.series, "size": gear.size, "ratio": gear.ratio} for gear in complete]


async def gears(_request: Request) -> Response:
    """Gears of the catalogue that have a torsion law."""
    return JSONResponse(_gears())


async def axes(_request: Request) -> Response:
    """Project files of axes to begin with, by what they are."""
    texts = [file.read_text(encoding="utf-8") for file in (files("strainwave.app") / "projects").iterdir()]
    titles = [re.findall(r'^title: "?([^:"]+)', text, re.MULTILINE)[0] for text in texts]
    return JSONResponse(dict(sorted(zip(titles, texts, strict=True))))


async def answer(request: Request) -> Response:
    """Answer with the data of one of ANSWERS."""
    kind, work, fields = ANSWERS[request.url.path]
    body = await requests.asked(request, kind)
    return await _view(request, *work, *([getattr(body, name) for name in fields] or [body]))


async def log(request: Request) -> Response:
    """Content of a log, which is the body; `name` is that of its file, `columns` says in JSON what is in it."""
    return await _view(request, Work("logs", "log_of"), _name(request), await request.body(), _columns(request))


def _name(request: Request) -> str:
    return request.query_params.get("name", "log.csv")[:200]


def _columns(request: Request) -> requests.LogColumns:
    """Columns of a log as the visitor names them (Refused)."""
    return requests.parsed(request.query_params.get("columns", "{}").encode(), requests.LogColumns)


async def identify(request: Request) -> Response:
    """Start the job that identifies a drive: the first line of the body is {"state": ...}, the log follows."""
    columns = _columns(request)
    first, _, content = (await request.body()).partition(b"\n")
    state = requests.parsed(first, requests.OfState).state
    await _computed(request, OF_STATE, bool, state)
    jobs: Jobs = request.app.state.jobs
    work = OF_STATE, JOBS["identify"][1]
    return JSONResponse({"id": jobs.begin("identify", *work, state, _name(request), content, columns)}, 201)


async def begin(request: Request) -> Response:
    """Start a job."""
    body = await requests.asked(request, requests.JobRequest)
    jobs: Jobs = request.app.state.jobs
    await _computed(request, OF_STATE, bool, body.state)
    args = (body.search, list(body.loads)) if body.kind == "speed-map" else ()
    return JSONResponse({"id": jobs.begin(body.kind, OF_STATE, JOBS[body.kind][1], body.state, *args)}, 201)


async def job(request: Request) -> Response:
    """State of a job, and its result; DELETE cancels it."""
    jobs: Jobs = request.app.state.jobs
    name = request.path_params["name"]
    asked = jobs.cancel(name) if request.method == "DELETE" else jobs.find(name)
    if asked is None:
        return refusal(404, "there is no such job; it was cancelled, or it has expired")
    return JSONResponse(asked.as_dict())


async def status(request: Request) -> Response:
    """Sentence on the code that is compiled now for the views; null if none is."""
    return JSONResponse({"compiling": request.app.state.workers.compiling or None})


async def schema(_request: Request) -> Response:
    """JSON Schemas of the bodies of all requests."""
    posts = {path: view.body.model_json_schema() for path, view in ANSWERS.items()}
    posts["/api/jobs"] = requests.JobRequest.model_json_schema()
    descriptions = {
        "/api/gears": "GET: gears of the catalogue",
        "/api/axes": "GET: project files of axes to begin with",
        "/api/jobs/{id}": "GET: state, progress, result; DELETE: cancel",
        "/api/log?name=FILE": "POST: a log of at most 20 MiB as the body; &columns= says in JSON what its columns are",
        "/api/identify?name=FILE": 'POST: a line {"state": ...} and the log as the body; starts a job',
        "/api/schema": "GET: this",
        "/api/status": "GET: what is compiled now, or null",
    }
    return JSONResponse({"post": posts, "other": descriptions})


POSTS = dict.fromkeys(ANSWERS, answer) | {"/api/log": log, "/api/identify": identify, "/api/jobs": begin}
routes = [
    Route("/api/gears", gears),
    Route("/api/axes", axes),
    Route("/api/schema", schema),
    Route("/api/status", status),
    *(Route(path, guarded(handler), methods=["POST"]) for path, handler in POSTS.items()),
    Route("/api/jobs/{name:str}", job, methods=["GET", "DELETE"]),
]
