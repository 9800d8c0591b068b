"""Workers of a sweep: an executor of `concurrent.futures`, of threads, processes or a `dask.distributed` cluster.

Threads serve compiled measures, processes all. On a cluster the workers compute and this process alone writes the
store: it needs no file system that they share. A worker that dies costs the chunks it had; the scheduler gives them to
others. When the scheduler dies, the store has what was finished.

One process at a time writes a store: a lock file beside it, which the system releases when its owner dies, however it
dies.
"""

import contextlib
import ctypes
import json
import logging
import multiprocessing
import os
import pickle
import signal
import socket
import sys
import threading
import time
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..base.results import Floats
from .points import Job, Part, compute

log = logging.getLogger(__name__)

PATIENCE = 60.0  # seconds without any worker before the sweep gives up: as long as a cluster may take to start one
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
        self.since: float | None = None
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
        return ProcessPoolExecutor(self.count, multiprocessing.get_context("spawn"), _begin)

    @property
    def room(self) -> int:
        """Count of chunks that the workers take at a time, one for every thread and one in reserve."""
        return 2 * max(1, self.count if self.client is None else sum(self.client.nthreads().values()))

    def submit(self, job: Job, first: int, values: Mapping[str, Floats]) -> "Future[Part]":
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
            self.since = None
        elif self.since is None:
            self.since = time.monotonic()
            log.warning("no worker is connected to the cluster; waiting for one")
        elif time.monotonic() - self.since > PATIENCE:
            raise ConnectionError(f"the cluster has had no worker for {PATIENCE:.0f} s")

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
                log.info("stopping as soon as the blocks of trajectories under way have come to their end")
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


def _begin() -> None:
    """Leave Ctrl-C to the process that started this one, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


if sys.platform == "win32":  # pragma: no cover
    import msvcrt
else:
    import fcntl


BEYOND = 1 << 20  # the byte that Windows locks; it lies behind the text, which others are to read


class StoreLock:
    """Exclusive right to write a store.

    Parameters
    ----------
    store : Path
        The store; the lock file is its sibling `<name>.lock`.

    Raises
    ------
    RuntimeError
        If a living process holds the lock, or a process on another machine, about which nothing is known.
    """

    def __init__(self, store: Path) -> None:
        self.path = store.with_name(store.name + ".lock")
        self.descriptor = -1
        self.path.parent.mkdir(parents=True, exist_ok=True)
        while self.descriptor < 0:
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                if not _locked(descriptor):
                    raise RuntimeError(self._refusal(_owner(descriptor)))
                if self._same_file(descriptor):
                    self._take(descriptor)
                    self.descriptor = descriptor
            finally:
                if self.descriptor < 0:
                    os.close(descriptor)

    def _same_file(self, descriptor: int) -> bool:
        """True if the locked file is the one of that name: its last owner may have removed it meanwhile."""
        with contextlib.suppress(FileNotFoundError):
            return os.path.samestat(os.fstat(descriptor), os.stat(self.path))
        return False

    def _take(self, descriptor: int) -> None:
        owner = _owner(descriptor)
        if owner and owner.get("host") != socket.gethostname():
            # Between machines the system's lock cannot be relied upon: network file systems differ.
            raise RuntimeError(self._refusal(owner))
        if owner:
            log.warning("the lock left by process %s, which is gone, is taken over", owner.get("pid"))
        text = json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode()
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, text, 0) if hasattr(os, "pwrite") else os.write(descriptor, text)

    def _refusal(self, owner: dict[str, Any]) -> str:
        who = f"process {owner.get('pid')} on {owner.get('host')}" if owner else "another process"
        return f"{who} is working on this store; wait for it, or if it is gone for certain, delete {self.path}"

    def release(self) -> None:
        """Give the store free; a second call does nothing."""
        if self.descriptor >= 0:
            with contextlib.suppress(OSError):
                self.path.unlink()
            os.close(self.descriptor)
            self.descriptor = -1


def _locked(descriptor: int) -> bool:
    try:
        if sys.platform == "win32":  # pragma: no cover
            os.lseek(descriptor, BEYOND, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
            os.lseek(descriptor, 0, os.SEEK_SET)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _owner(descriptor: int) -> dict[str, Any]:
    """Process and machine that the file names, {} when it is empty or says something else."""
    os.lseek(descriptor, 0, os.SEEK_SET)
    try:
        owner = json.loads(os.read(descriptor, 4096))
    except ValueError:
        return {}
    return owner if isinstance(owner, dict) else {}
