"""A few processes that take the work of the server in turn, started when they are needed."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import AsyncExitStack, nullcontext
from dataclasses import dataclass
from typing import Any

from ...base.above import thing
from ...base.terminal import Progress
from .requests import Refused
from .worker import Died, Worker

LATER = 4.0  # seconds: two processes that start beside the first picture would delay it
PATIENCE = 5.0  # seconds of processor time between two looks at whether work is still wanted
SHARED = 6.0  # times its processor time that work may last on a machine that has more to do
LOOK = 0.25  # seconds between two looks at whether a process has answered
SLOW_S = 0.1  # seconds of processor time of an answer after which the next one of its visitor leaves a process free


class Abandoned(Exception):
    """Nobody waits for the answer any more."""


@dataclass(frozen=True)
class Work:
    """A function of a module of the app, which a process imports when it is called.

    The server calls none, so it answers before the library is loaded.
    """

    module: str
    name: str

    def __call__(self, *args: Any, **options: Any) -> Any:
        """Call the function."""
        return thing(f"{__package__}.{self.module}", self.name)(*args, **options)


class Workers:
    """At most `count` processes. Work waits for a free one in the order in which it came.

    Visitors whose last answer was slow have all processes but one, so that the others do not wait for all of them.

    Parameters
    ----------
    count : int
        Processes.
    longest : float, optional
        Processor time [s], without that of compiling, after which a process that has not answered is killed; at the
        latest after `SHARED` times as long, where it waits or other programs have the processor.
    background : bool
        True to let other processes of the machine go first.
    patience : float
        Time [s], counted as `longest` is, between two looks at whether work is still wanted.
    """

    def __init__(
        self, count: int, longest: float = math.inf, background: bool = False, patience: float = PATIENCE
    ) -> None:  # fmt: skip
        self._turn, self._turn_of_slow = asyncio.Semaphore(count), asyncio.Semaphore(max(1, count - 1))
        self._slow: set[Any] = set()  # visitors
        self._longest, self._background, self._patience = longest, background, patience
        self._all: set[Worker] = set()
        self._ending: list[Worker] = []
        self._idle: list[Worker] = []
        self.count = count

    @property
    def compiling(self) -> str:
        """Sentence on the code that a process compiles now; "" if none does."""
        return next((worker.compiling for worker in self._all if worker.compiling), "")

    async def run(
        self, work: Callable[..., Any], *args: Any, waiting: Callable[[], Awaitable[bool]] | None = None,
        begun: Callable[[], None] | None = None, progress: Progress | None = None, visitor: Any = None,
    ) -> tuple[bytes, float]:  # fmt: skip
        """JSON of the result of `work(*args)`, and its processor time [s], as `Worker.ask`.

        `waiting` is asked when the turn has come, and of long work again and again (Abandoned); `begun` is told when it
        has come. Work that is cancelled or no longer wanted is killed with its process, and the next gets a new one.
        """
        async with self._turn_of_slow if visitor in self._slow else nullcontext(), self._turn:
            if waiting is not None and not await waiting():
                raise Abandoned
            while True:
                worker = await self._free()
                if begun is not None:
                    begun()
                try:
                    text, took = await self._answered(worker, worker.ask(work, *args, progress=progress), waiting)
                    (self._slow.add if took > SLOW_S else self._slow.discard)(visitor)
                    return text, took
                except TimeoutError:
                    raise Refused(
                        f"the computation takes longer than {self._longest:g} s of computing, or "
                        f"{SHARED * self._longest:g} s together with others; narrow the speed range, use fewer or "
                        "lower orders, a softer law, or the command line, which has no time limit"
                    ) from None
                except Died:
                    if not worker.interpreted:  # else `warm` has ended it, as another one has machine code now
                        raise Refused(
                            "the process that computed this has ended unexpectedly, perhaps because memory ran "
                            "out; try again, or compute less at once"
                        ) from None
                finally:
                    self._give_back(worker)

    async def _answered(
        self, worker: Worker, answer: Coroutine[Any, Any, tuple[bytes, float]],
        waiting: Callable[[], Awaitable[bool]] | None = None,
    ) -> tuple[bytes, float]:  # fmt: skip
        """The answer, within the time for it (TimeoutError) and as long as the visitor waits for it (Abandoned).

        Compiling goes on, as all answers need it, and so does what is interpreted until there is machine code.
        """
        asking, spent, looked = asyncio.create_task(answer), 0.0, 0.0
        try:
            while not (await asyncio.wait([asking], timeout=LOOK))[0]:
                if worker.compiling:
                    continue
                spent += LOOK
                taken = max(worker.computed, spent / SHARED)
                if taken >= self._longest and not worker.interpreted:
                    raise TimeoutError
                if waiting is not None and taken >= looked + self._patience:
                    looked = taken
                    if not await waiting():
                        raise Abandoned
            return asking.result()
        finally:
            asking.cancel()

    async def _free(self) -> Worker:
        """A process that has nothing to do (Refused)."""
        while self._idle:
            if (worker := self._idle.pop()).alive:
                return worker
            self._end(worker)
        return await self._started()

    async def _started(self, interpreted: bool = False) -> Worker:
        """A new process (Refused)."""
        try:
            worker = await Worker.start(self._background, interpreted)
        except OSError as error:
            raise Refused(f"no process can be started ({error.strerror}); close other programs") from None
        self._all.add(worker)
        return worker

    async def warm(self, work: Callable[..., Any], *args: Any, later: float = LATER) -> None:
        """Start all processes, one after another, and have each do a piece of work.

        What is asked meanwhile is for an interpreted one, until the first of the others has machine code: on a new
        machine it compiles this for about ten seconds. The rest are started `later` [s], after the first answers.
        """
        async with AsyncExitStack() as others:
            for _ in range(self.count - 1):
                await others.enter_async_context(self._turn)
            try:
                async with self._turn:
                    await self._warm_one(await self._started(interpreted=True), work, args)
                await self._warm_one(await self._started(), work, args)
            finally:
                for worker in [one for one in self._all if one.interpreted]:
                    self._end(worker)
            await asyncio.sleep(later)
        while len(self._all) < self.count:
            async with self._turn:
                await self._warm_one(await self._started(), work, args)

    async def _warm_one(self, worker: Worker, work: Callable[..., Any], args: tuple[Any, ...]) -> None:
        """Have a new process do a piece of work."""
        try:
            await self._answered(worker, worker.ask(work, *args))
        finally:
            self._give_back(worker)

    def _give_back(self, worker: Worker) -> None:
        if worker.idle:
            self._idle.append(worker)
        else:
            self._end(worker)

    def _end(self, worker: Worker) -> None:
        self._all.discard(worker)
        self._ending = [*(one for one in self._ending if one.alive), worker]
        worker.kill()

    async def close(self) -> None:
        """End all processes."""
        for worker in self._all:
            worker.kill()
        await asyncio.gather(*(worker.ended() for worker in [*self._all, *self._ending]))
