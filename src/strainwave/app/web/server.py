"""The server of the local web app: one page, its assets and the JSON API, on this machine alone.

A connection of the server: what is no HTTP, or does not come to its end, gets a sentence as well.
"""

import asyncio
import json
import lzma
import os
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from importlib.resources import files

import h11
import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route
from uvicorn.protocols.http.h11_impl import H11Protocol

from .api import OF_STATE, RESPONSE, Jobs, routes
from .guard import Guard, refusal
from .requests import Refused, State
from .worker import Died, Unexpected
from .workers import Workers

HOST, TRIES = "127.0.0.1", 20
COUNT = min(4, max(2, os.cpu_count() or 2))  # computations at a time
ANSWER_S = 10.0  # seconds of processor time of one, without those of compiling; what takes longer is a job
KINDS = {"html": "text/html", "js": "text/javascript", "css": "text/css", "txt": "text/plain", "md": "text/plain"}
FIRST = "CSG-40-50"
SOON = 1.0  # s of processor time between two looks at whether what comes later is still wanted; a process starts in it

PATIENCE = 15.0  # seconds for the head of a request
MOST_CONNECTIONS = 512  # connections


class Connection(H11Protocol):
    """A connection with a limit for the time that the head of a request takes."""

    late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for the head of a request, unless there are too many connections."""
        super().connection_made(transport)
        if len(self.connections) > MOST_CONNECTIONS:
            transport.abort()
            return
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._stop()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take data; the time of a head begins with its first byte."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._stop()
        elif self.late is None:
            self._wait()

    def send_400_response(self, msg: str) -> None:
        """Answer a request that is no HTTP; `msg` is the server's own sentence."""
        del msg
        self._refuse(400, "the request is not HTTP, or its head is larger than 64 KiB; send a smaller one")

    def _wait(self) -> None:
        self.late = self.loop.call_later(PATIENCE, self._too_late)

    def _stop(self) -> None:
        if self.late is not None:
            self.late.cancel()
            self.late = None

    def _too_late(self) -> None:
        self.late = None
        if not self.conn.trailing_data[0]:  # not a byte has come
            self.transport.close()
        elif self.conn.our_state is h11.IDLE:
            self._refuse(408, f"the head of the request took longer than {PATIENCE:g} s; send it again")

    def _refuse(self, status: int, sentence: str) -> None:
        body = json.dumps({"error": sentence}).encode()
        length = "content-length", str(len(body))
        headers = [("content-type", "application/json"), length, ("connection", "close")]
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            for event in (h11.Response(status_code=status, headers=headers), h11.Data(body), h11.EndOfMessage()):
                self.transport.write(self.conn.send(event) or b"")
        self.transport.close()


def assets() -> dict[str, bytes]:
    """Files of the page by their names, those in `.xz` unpacked: nothing else is ever sent."""
    listed = [*(files(__package__) / "static").iterdir(), files("strainwave.app") / "skill.md"]
    contents = {file.name: file.read_bytes() for file in listed}
    packed = {name for name in contents if name.endswith(".xz")}
    unpacked = {name.removesuffix(".xz"): lzma.decompress(contents[name]) for name in packed}
    return {name: code for name, code in (contents | unpacked).items() if name.rpartition(".")[2] in KINDS}


def application(warm: bool = True) -> Starlette:
    """The app; `warm` loads the machine code of the first picture in the background."""
    page = assets()

    async def asset(request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        if name not in page:
            return refusal(404, "there is nothing at this address")
        return Response(page[name], media_type=KINDS[name.rpartition(".")[2]])

    async def refused(_request: Request, error: Exception) -> Response:
        status = error.status_code if isinstance(error, HTTPException) else 500
        sentences = {404: "there is nothing at this address", 405: "this address does not support this method"}
        return refusal(status, sentences.get(status, "the request cannot be answered"))

    @asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        app.state.jobs, app.state.workers = Jobs(), Workers(COUNT, ANSWER_S)
        app.state.later = Workers(1, ANSWER_S, background=True, patience=SOON)
        warming = asyncio.create_task(warm_up(app.state.workers)) if warm else None
        yield
        if warming is not None:
            warming.cancel()
        for service in (app.state.jobs, app.state.workers, app.state.later):
            await service.close()

    served = [Route("/", asset), Route("/static/{name:str}", asset), *routes]
    handlers = {HTTPException: refused}
    return Starlette(routes=served, middleware=[Middleware(Guard)], exception_handlers=handlers, lifespan=life)


async def warm_up(workers: Workers) -> None:
    """Start the processes, and load the machine code that the first picture needs."""
    with suppress(Refused, Unexpected, Died, TimeoutError):
        await workers.warm(OF_STATE, RESPONSE, State(gear=FIRST))


def taken(port: int) -> socket.socket | None:
    """A socket of this machine that listens at a port; None where the port is in use."""
    # asyncio sends head and body of an answer without a delay of 40 ms between them where a socket says that it is TCP
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
    except OSError:
        listener.close()
        return None
    return listener


def listening(port: int) -> tuple[socket.socket, int]:
    """The first free port from this one on (RuntimeError)."""
    for candidate in range(port, min(port + TRIES, 65536)):
        if (listener := taken(candidate)) is not None:
            return listener, int(listener.getsockname()[1])
    raise RuntimeError(f"the ports {port} to {port + TRIES - 1} are all in use; choose a free one with --port")


def serve(port: int, opened: Callable[[str, int], None]) -> None:
    """Serve until the process is interrupted; `opened(address, port)` is called once requests are answered."""
    sock, actual = listening(port)
    sock.listen(256)
    opened(f"http://{HOST}:{actual}/", actual)
    uvicorn.Server(configured(application())).run(sockets=[sock])


def configured(app: Starlette) -> uvicorn.Config:
    """Configuration of the server."""
    return uvicorn.Config(
        app, log_level="error", access_log=False, timeout_keep_alive=10, timeout_graceful_shutdown=2,
        h11_max_incomplete_event_size=64 * 1024, server_header=False, ws="none", http=Connection, loop="asyncio",
    )  # fmt: skip
