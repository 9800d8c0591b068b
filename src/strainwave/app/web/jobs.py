"""Work in the background: a few jobs at a time, each with its progress, its end and a flag that stops it."""

import secrets
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from ...results import SolveError

MOST, AT_ONCE, KEPT = 16, 1, 900.0  # jobs that are held, that run, and seconds for which a finished one is kept


class Full(Exception):
    """There are as many jobs as the server takes."""


class Stopped(Exception):
    """The visitor has cancelled the job."""


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
    cancelled: threading.Event = field(default_factory=threading.Event)

    def progress(self, stage: str, share: float) -> None:
        """Take note of the progress, or stop where the visitor has cancelled (Stopped)."""
        if self.cancelled.is_set():
            raise Stopped
        self.stage, self.share = stage, max(self.share, min(1.0, float(share)))

    def as_dict(self) -> dict[str, Any]:
        """What the visitor is told."""
        took = monotonic() - self.begun
        left = took * (1.0 / self.share - 1.0) if self.state == "running" and self.share > 0.02 else None
        told = {"kind": self.kind, "state": self.state, "stage": self.stage, "share": self.share, "seconds_left": left}
        return told | {"result": self.result, "error": self.error or None}


class Jobs:
    """The jobs of one server."""

    def __init__(self) -> None:
        self._jobs: dict[str, Job] = {}
        self._lock = threading.Lock()
        self._pool = ThreadPoolExecutor(AT_ONCE, "strainwave-job")

    def begin(self, kind: str, work: Callable[[Callable[[str, float], None]], Any]) -> str:
        """Start a job and return its name (Full)."""
        job = Job(kind)
        with self._lock:
            self._expire()
            if len(self._jobs) >= MOST:
                raise Full(f"{MOST} jobs are held already; cancel one, or wait until one has finished and expired")
            name = secrets.token_hex(8)
            self._jobs[name] = job
        self._pool.submit(self._run, job, work)
        return name

    def find(self, name: str) -> Job | None:
        """Job of a name, which stays for a while longer; None where there is none."""
        with self._lock:
            self._expire()
            job = self._jobs.get(name)
            if job is not None:
                job.seen = monotonic()
            return job

    def cancel(self, name: str) -> Job | None:
        """Stop a job and forget it; None where there is none."""
        with self._lock:
            job = self._jobs.pop(name, None)
        if job is not None:
            job.cancelled.set()
            if job.state in ("waiting", "running"):
                job.state = "cancelled"
        return job

    def close(self) -> None:
        """Stop all jobs."""
        for name in list(self._jobs):
            self.cancel(name)
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _expire(self) -> None:
        """Forget what nobody has asked for in a while; a job whose page has gone is stopped."""
        now = monotonic()
        for name in [name for name, job in self._jobs.items() if now - job.seen > KEPT]:
            self._jobs.pop(name).cancelled.set()

    def _run(self, job: Job, work: Callable[[Callable[[str, float], None]], Any]) -> None:
        if job.cancelled.is_set():
            return
        job.state, job.begun = "running", monotonic()
        try:
            job.result = work(job.progress)
            job.state, job.stage, job.share = "done", "done", 1.0
        except Stopped:
            job.state = "cancelled"
        except (ValueError, TypeError, SolveError, RuntimeError) as error:
            job.state, job.error = "failed", " ".join(str(error).split())
        except Exception as error:  # whatever it is, a visitor gets one sentence
            job.state, job.error = "failed", f"the job failed unexpectedly ({type(error).__name__})"
