"""Work in the background: a few jobs at a time, each with its progress and its end, in a process that can be killed."""

import asyncio
import json
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from .requests import Refused
from .worker import Unexpected
from .workers import Workers

MOST, AT_ONCE = 16, 1  # jobs that are held, and that run
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
        """Take note that the work begins."""
        self.state, self.begun = "running", monotonic()

    def progress(self, stage: str, share: float) -> None:
        """Take note of the progress."""
        self.stage, self.share = stage, max(self.share, min(1.0, float(share)))

    def cancel(self) -> None:
        """Stop the work, unless it has ended."""
        if self.state in ("waiting", "running"):
            self.state = "cancelled"
        if self.task is not None:
            self.task.cancel()

    def as_dict(self) -> dict[str, Any]:
        """What the visitor is told."""
        took = monotonic() - self.begun
        left = took * (1.0 / self.share - 1.0) if self.state == "running" and self.share > 0.02 else None
        told = {"kind": self.kind, "state": self.state, "stage": self.stage, "share": self.share, "seconds_left": left}
        return told | {"result": self.result, "error": self.error or None}


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
        if len(self._jobs) >= MOST:
            raise Full(f"{MOST} jobs are held already; cancel one, or wait until one has finished and expired")
        name, job = secrets.token_hex(8), Job(kind)
        self._jobs[name] = job
        job.task = asyncio.create_task(self._run(job, work, args))
        return name

    def find(self, name: str) -> Job | None:
        """Job of a name, which stays for a while longer; None where there is none."""
        job = self._jobs.get(name)
        if job is not None:
            job.seen = monotonic()
        return job

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
        """Forget what nobody has asked for in a while; a job whose page has gone is stopped."""
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
        except Refused as error:
            job.state, job.error = "failed", str(error)
        except Unexpected as error:  # whatever it is, a visitor gets one sentence
            job.state, job.error = "failed", f"the job failed unexpectedly ({error})"
