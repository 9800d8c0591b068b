"""Checks of every request: host, origin, size and time of its body; and the headers of every answer.

A page of another site may send requests to a server on this machine. It cannot read the answers, but it must not be
able to start anything either: requests that change something need the app's own origin, and a name of this machine.
"""

import asyncio
import re
from typing import Any

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

BODY, LOG = 1024 * 1024, 20 * 1024 * 1024  # bytes of a body, and of a log
LOG_PATHS = ("/api/log", "/api/identify")
PATIENCE = 15.0  # seconds for a whole body
HOST = re.compile(r"(127\.0\.0\.1|localhost)(:[0-9]{1,5})?")
# Styles that plotly.js writes as text: none at all, and image-rendering of the pixels of a map.
EMPTY = "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
PIXELS = "'sha256-AR/cKIZjWPcPmBUPDA6oti9XBiTbJvz0Cro2J1VzzS8='"
SECURITY = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; connect-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
        f"style-src-elem 'self' {EMPTY}; style-src-attr 'unsafe-hashes' {EMPTY} {PIXELS}; "
        "form-action 'none'; base-uri 'none'; "
        "frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}


def refusal(status: int, sentence: str) -> JSONResponse:
    """An answer with one sentence about an error."""
    return JSONResponse({"error": sentence}, status)


class Unread(Exception):
    """A body is longer than its path takes, or does not come to its end: the status of the answer, and a sentence."""


class Guard:
    """The outermost layer of the app."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        begun = False

        async def answer(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                extra = [(name.encode(), value.encode()) for name, value in SECURITY.items()]
                message["headers"] = [*message.get("headers", ()), *extra]
            await send(message)

        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        wrong = _wrong(scope, headers)
        if wrong is not None:
            await wrong(scope, receive, answer)
            return
        try:
            await self.app(scope, _limited(receive, LOG if scope["path"] in LOG_PATHS else BODY), answer)
        except Unread as error:
            await refusal(*error.args)(scope, receive, answer)
        except Exception as error:  # whatever it is, a visitor gets one sentence
            if begun:
                raise
            await refusal(500, f"the request failed unexpectedly ({type(error).__name__})")(scope, receive, answer)


def _wrong(scope: Scope, headers: dict[str, str]) -> JSONResponse | None:
    """The answer to a request of a wrong host, a wrong origin, or a body that is too large by its own account."""
    host = headers.get("host", "")
    if not HOST.fullmatch(host):
        return refusal(400, "the host of the request is not this machine; open the app at the address that it printed")
    if scope["method"] not in ("GET", "HEAD"):
        origin, site = headers.get("origin"), headers.get("sec-fetch-site", "same-origin")
        if (origin is not None and origin != f"http://{host}") or site not in ("same-origin", "none"):
            return refusal(403, "the request comes from a page of another site; use the page of this app")
    limit = LOG if scope["path"] in LOG_PATHS else BODY
    length = headers.get("content-length", "0")
    if not length.isdecimal() or int(length[:20]) > limit:
        return refusal(413, _too_large(limit))
    return None


def _too_large(limit: int) -> str:
    return f"the body of the request is larger than {limit // 1024} KiB; send less"


def _limited(receive: Receive, limit: int) -> Receive:
    """Messages of a body until it is too large or too slow."""
    got, end = 0, asyncio.get_running_loop().time() + PATIENCE
    complete = False

    async def limited() -> Any:
        nonlocal got, complete
        if complete:
            return await receive()
        try:
            async with asyncio.timeout_at(end):
                message = await receive()
        except TimeoutError:
            raise Unread(408, f"the body of the request took longer than {PATIENCE:g} s; send it again") from None
        got += len(message.get("body", b""))
        if got > limit:
            raise Unread(413, _too_large(limit))
        complete = not message.get("more_body", False)
        return message

    return limited
