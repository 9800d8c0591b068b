"""Workers of a sweep on a cluster: the tasks of a `dask.distributed` client.

The workers compute, this process alone writes the store: it needs no file system that they share. A worker that dies
costs the chunks it had; the scheduler gives them to others. When the scheduler dies, the store has what was finished.
"""

import logging
from collections.abc import Mapping
from concurrent.futures import CancelledError
from time import monotonic
from typing import Any

from distributed import Client, KilledWorker

from ..base.quantities import shown
from ..base.results import Floats
from .points import Job, compute

log = logging.getLogger(__name__)

PATIENCE = 60.0  # seconds without any worker before the sweep gives up: as long as a cluster may take to start one
GONE = "the cluster's scheduler cannot be reached any more"


class ClusterPool:
    """The same interface as `ThreadPool`, over a client.

    Parameters
    ----------
    client : distributed.Client
        A client of a running cluster; it stays open.
    spec : str
        Hash of the sweep: with the number of the chunk, the key of a task.
    """

    def __init__(self, client: Any, spec: str) -> None:
        if not isinstance(client, Client):
            raise TypeError(f"client is {shown(client)}; it must be a dask.distributed.Client")
        if client.asynchronous:
            raise TypeError("the client is asynchronous; make it with Client(address), outside of a coroutine")
        self.client: Any = client  # distributed has annotations in some places only
        self.spec = spec
        self.futures: set[Any] = set()
        self.tried: dict[int, int] = {}
        self.since: float | None = None
        self.check()

    @property
    def room(self) -> int:
        """How many chunks the workers take at a time, one for every thread and one in reserve."""
        threads: int = sum(self.client.nthreads().values())
        return max(2, 2 * threads)

    def submit(self, job: Job, chunk: int, first: int, values: Mapping[str, Floats]) -> Any:
        """Begin to compute a chunk."""
        tries = self.tried[chunk] = self.tried.get(chunk, -1) + 1
        key = f"sweep-{self.spec}-{chunk}" + (f"-again-{tries}" if tries else "")
        future: Any = self.client.submit(compute, job, first, values, key=key, pure=True)
        self.futures.add(future)
        future.add_done_callback(self.futures.discard)
        return future

    def lost(self, error: BaseException) -> bool:
        """Whether workers died of this chunk, or of another one that they had at the same time."""
        if isinstance(error, CancelledError | OSError):  # what a client says of its tasks when it loses the scheduler
            raise ConnectionError(GONE) from error
        return isinstance(error, KilledWorker)

    def check(self) -> None:
        """Raise a ConnectionError if the scheduler is gone, or no worker has been there for a minute."""
        if self.client.status != "running":
            raise ConnectionError(GONE)
        if self.client.nthreads():
            self.since = None
        elif self.since is None:
            self.since = monotonic()
            log.warning("no worker is connected to the cluster; waiting for one")
        elif monotonic() - self.since > PATIENCE:
            raise ConnectionError(f"the cluster has had no worker for {PATIENCE:.0f} s")

    def close(self) -> None:
        """Give up the chunks under way; the client stays open."""
        if self.client.status == "running":
            self.client.cancel(list(self.futures), force=True)
