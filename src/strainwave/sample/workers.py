"""Workers of a sweep: an executor of `concurrent.futures`, of threads, processes or a `dask.distributed` cluster.

Threads serve compiled measures, processes all. On a cluster the workers compute and this process alone writes the
store: it needs no file system that they share. A worker that dies costs the chunks it had; the scheduler gives them to
others. When the scheduler dies, the store has what was finished.
"""

import ctypes
import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

from ..base.results import Floats
from .measuring import ChunkResult, Job, compute

log = logging.getLogger(__name__)

PATIENCE_S = 60.0  # without any worker before the sweep gives up: as long as a cluster may take to start one
GONE = "the cluster's scheduler cannot be reached any more"
RETRIES = 3  # of a task on a cluster whose worker died


class Workers:
    """An executor, which is started again when its processes have died.

    Parameters
    ----------
    job : Job
        What is to be computed.
    client : distributed.Client or None
        A client of a running cluster; it stays open. None takes this machine.
    count : int
        Threads or processes of this machine.
    processes : bool
        Whether these are processes, started afresh, not forked, so that threads and compilers survive.
    """

    def __init__(self, job: Job, client: Any, count: int, processes: bool) -> None:
        self.client, self.count, self.processes = client, count, processes  # distributed has some annotations only
        self.idle_since: float | None = None
        if client is not None and client.asynchronous:
            raise TypeError("the client is asynchronous; make it with Client(address), outside of a coroutine")
        if client is not None:
            self.check()
        elif processes:
            _refuse_local(job)
        self.executor = self._started()

    def _started(self) -> Executor:
        if self.client is not None:
            executor: Executor = self.client.get_executor(pure=False, retries=RETRIES)
            return executor
        if not self.processes:
            return Threads(self.count, thread_name_prefix="sweep")
        return ProcessPoolExecutor(self.count, multiprocessing.get_context("spawn"), _begin_process)

    @property
    def room(self) -> int:
        """Number of chunks that the workers take at a time: one for every thread, and one in reserve."""
        return 2 * max(1, self.count if self.client is None else sum(self.client.nthreads().values()))

    def submit(self, job: Job, first: int, values: Mapping[str, Floats]) -> "Future[ChunkResult]":
        """Begin to compute a chunk."""
        try:
            return self.executor.submit(compute, job, first, values)
        except BrokenExecutor:
            self.executor.shutdown(wait=False, cancel_futures=True)
            self.executor = self._started()
            return self.executor.submit(compute, job, first, values)

    def lost(self, error: BaseException) -> bool:
        """True if a worker died of this chunk, or of another one that it had at the same time."""
        if self.client is None:
            return isinstance(error, BrokenExecutor)
        from distributed import KilledWorker

        if isinstance(error, CancelledError | OSError):  # what a client says of its tasks when it loses the scheduler
            raise ConnectionError(GONE) from error
        return isinstance(error, KilledWorker)

    def check(self) -> None:
        """Raise a ConnectionError if the scheduler is gone, or no worker has been there for a minute."""
        if self.client is None:
            return
        if self.client.status != "running":
            raise ConnectionError(GONE)
        if self.client.nthreads():
            self.idle_since = None
        elif self.idle_since is None:
            self.idle_since = time.monotonic()
            log.warning("no worker is connected to the cluster; waiting for one")
        elif time.monotonic() - self.idle_since > PATIENCE_S:
            raise ConnectionError(f"the cluster has had no worker for {PATIENCE_S:.0f} s")

    def close(self) -> None:
        """Give up the chunks under way; a client stays open."""
        processes = list((getattr(self.executor, "_processes", None) or {}).values())
        if self.client is None or self.client.status == "running":
            self.executor.shutdown(wait=False)
        for process in processes:
            process.terminate()
        for process in processes:
            process.join(5.0)


class Threads(ThreadPoolExecutor):
    """Threads whose work is given up at `shutdown`, as soon as compiled code returns: after a block of lanes.

    A measure knows no flag that it could look at, and Python sends an interrupt to the main thread alone: the threads
    that compute are interrupted one by one.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self.busy: set[int] = set()
        self.guard, self.stop = threading.Lock(), False

    def submit(self, function: Any, /, *arguments: Any, **named: Any) -> "Future[Any]":
        """Begin a call."""
        return super().submit(self._called, function, *arguments, **named)

    def _called(self, function: Any, *arguments: Any, **named: Any) -> Any:
        thread = threading.get_ident()
        with self.guard:
            self.busy.add(thread)
        try:
            return function(*arguments, **named)
        finally:
            with self.guard:
                self.busy.discard(thread)
            if self.stop:
                _bytecode()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop the threads."""
        self.stop = True
        super().shutdown(wait=False, cancel_futures=True)
        since, logged = time.monotonic(), False
        while self._interrupted():
            time.sleep(0.05)
            if not logged and time.monotonic() - since > 1.0:
                logged = True
                log.info("stopping after the running blocks of trajectories")
        super().shutdown(wait=True)

    def _interrupted(self) -> bool:
        """Raise KeyboardInterrupt in the threads that compute; whether there were any."""
        raising = ctypes.pythonapi.PyThreadState_SetAsyncExc
        with self.guard:
            for thread in self.busy:
                raising(ctypes.c_ulong(thread), ctypes.py_object(KeyboardInterrupt))
            return bool(self.busy)


def _bytecode() -> None:
    """Be a call: an interrupt that came at the last moment is raised here and not in the thread's own loop."""


def _refuse_local(job: Job) -> None:
    """Refuse a measure or a system that another process cannot have (TypeError)."""
    script = getattr(sys.modules["__main__"], "__file__", None)
    try:
        at_prompt = b"__main__" in pickle.dumps(job) and script is None
        why = "it is defined at the prompt or in a notebook cell" if at_prompt else ""
        if script is not None and not os.path.exists(script):  # each process runs it again
            why = f"this program is no file that a process can read: {script}"
    except Exception as error:
        why = " ".join(str(error).split())
    if why:
        raise TypeError(
            f"the measure or the system cannot be sent to another process ({why}); define it at the top level of a "
            "module, or leave out processes=True"
        )


def _begin_process() -> None:
    """Leave Ctrl-C to the process that started this one, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
