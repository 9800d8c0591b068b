"""A connection of the server: what is no HTTP, or does not come to its end, gets a sentence as well."""

import asyncio
import json
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

PATIENCE = 15.0  # seconds for the head of a request
MOST = 512  # connections


class Connection(H11Protocol):
    """A connection with a limit for the time that the head of a request takes."""

    late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Wait for the head of a request, unless there are too many connections."""
        super().connection_made(transport)
        if len(self.connections) > MOST:
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
        """Answer what is no HTTP; `msg` is the server's own sentence."""
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
        headers = [
            ("content-type", "application/json"), ("content-length", str(len(body))), ("connection", "close")
        ]  # fmt: skip
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            for event in (h11.Response(status_code=status, headers=headers), h11.Data(body), h11.EndOfMessage()):
                self.transport.write(self.conn.send(event) or b"")
        self.transport.close()
