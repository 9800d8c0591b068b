"""Jobs of machine code shared by threads, with their results in order."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any


def results_of(job: Callable[[Any], Any], arguments: Sequence[Any], threads: int) -> Iterator[Any]:
    """Results of a job for each of its arguments, in their order; what has not begun is cancelled by an error."""
    if threads == 1 or len(arguments) == 1:
        yield from map(job, arguments)
        return
    yield job(arguments[0])  # compiles, where that is still to do, before the threads start
    with ThreadPoolExecutor(threads) as pool:
        try:
            yield from pool.map(job, arguments[1:])
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
