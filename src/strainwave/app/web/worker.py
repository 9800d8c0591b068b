"""A process that computes for the server: it takes one piece of work after another from its standard input.

Every message is a length of 8 bytes and a pickle of that length. Work is (function, arguments); the answers are
("progress", (stage, share)) as often as the work tells it, ("compiling", sentence) when a
compilation begins and with "" when it ends, ("computed", seconds of processor time without compiling since the last
one), and then ("done", (JSON, seconds of processor time)), ("refused", sentence) or ("failed", name of the error). The
process ends with its input: no server leaves one behind.
"""

import asyncio
import contextlib
import gc
import json
import os
import pickle
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from itertools import count
from queue import SimpleQueue
from threading import Event, Lock, Thread
from time import process_time, sleep, thread_time
from typing import Any, BinaryIO

from ...base.results import SolveError
from ...base.terminal import Progress
from ...compile.cache import compiling
from ...compile.jit import load
from ..console import plain
from ..console.library_words import without_calls
from .requests import Refused

LENGTH = 8  # bytes of the length of a message
LOOK = 0.25  # seconds between two looks at what is compiled
YOUNG = 50_000  # new objects between two garbage collections: an answer makes fewer
NICE = 10  # of a background process: a view goes before it
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class Died(Exception):
    """The process has ended before its answer."""


class Unexpected(Exception):
    """The work has raised an undocumented exception."""


class Worker:
    """A process that computes; `start` makes one."""

    def __init__(self, process: asyncio.subprocess.Process, folder: str, interpreted: bool) -> None:
        self._process, self._folder = process, folder
        self.interpreted, self.idle = interpreted, True
        self.compiling = ""  # the sentence on what is compiled now
        self.computed = 0.0  # processor time [s] of the work so far, without that of compiling

    @property
    def alive(self) -> bool:
        """True while the process runs."""
        return self._process.returncode is None

    @classmethod
    async def start(cls, background: bool = False, interpreted: bool = False) -> "Worker":
        """Start a process, with less priority where it works in the background; `interpreted` compiles nothing."""
        folder = tempfile.mkdtemp(prefix="strainwave-app-")  # its temporary files, which go when it is killed
        same = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "TMPDIR": folder}
        variables = same | {"STRAINWAVE_JIT": "0"} if interpreted else same
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-P", "-m", __name__, *(["background"] if background else []),
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, env=os.environ | ONE_THREAD | variables,
        )  # fmt: skip
        return cls(process, folder, interpreted)

    async def ask(self, work: Callable[..., Any], *args: Any, progress: Progress | None = None) -> tuple[bytes, float]:
        """JSON of the result of `work(*args)`, and the processor time [s] that it took.

        With `progress` the work has `progress=` as one more argument.

        Raises
        ------
        Refused
            If the work cannot be done; the sentence says why.
        Died, Unexpected
            If the process has ended, or the work has a fault.
        """
        self.idle, self.computed = False, 0.0
        pipe, answers = self._process.stdin, self._process.stdout
        assert pipe is not None
        assert answers is not None
        try:
            message = pickle.dumps((work, args, progress is not None))
            pipe.write(len(message).to_bytes(LENGTH) + message)
            await pipe.drain()
            while True:
                length = int.from_bytes(await answers.readexactly(LENGTH))
                kind, content = pickle.loads(await answers.readexactly(length))
                if kind == "compiling":
                    self.compiling = content
                    if progress is not None and content:
                        progress(content, 0.0)
                elif kind == "computed":
                    self.computed += content
                elif kind == "progress" and progress is not None:
                    progress(*content)
                else:
                    break
        except (asyncio.IncompleteReadError, OSError):
            raise Died from None
        self.idle, self.compiling = True, ""
        if kind == "done":
            text, took = content
            return text, took
        raise Refused(content) if kind == "refused" else Unexpected(content)

    async def ended(self) -> None:
        """Wait for the end of the process."""
        await self._process.wait()

    def kill(self) -> None:
        """End the process now, whatever it does."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        if self._process.stdin is not None:
            self._process.stdin.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def done(work: Callable[..., Any], args: tuple[Any, ...], options: dict[str, Any]) -> tuple[str, Any]:
    """Do a piece of work, and return its outcome."""
    begun = thread_time()
    try:
        text = json.dumps(plain(work(*args, **options)), ensure_ascii=False, separators=(",", ":"))
        return "done", (text.encode(), thread_time() - begun)
    except BrokenPipeError:
        raise
    except OSError as error:
        return "refused", f"a temporary file cannot be written ({error.strerror}); make room in {tempfile.gettempdir()}"
    except (ValueError, TypeError, SolveError, RuntimeError, ModuleNotFoundError) as error:
        return "refused", without_calls(" ".join(str(error).split()))
    except MemoryError:
        return "refused", "the computation needs more memory than is available; use fewer points"
    except Exception as error:  # whatever it is, a visitor gets one sentence
        return "failed", type(error).__name__


def work_on(source: BinaryIO, sink: BinaryIO) -> None:
    """Answer messages as long as there is a server."""
    lock, working = Lock(), Event()

    def send(kind: str, content: object) -> None:
        message = pickle.dumps((kind, content))
        with lock:
            sink.write(len(message).to_bytes(LENGTH) + message)
            sink.flush()

    def announce() -> None:
        previous, counted = "", process_time()
        with contextlib.suppress(OSError, ValueError):  # the server has gone
            while True:
                sleep(LOOK)
                sentence, now = next(map(str, compiling()), ""), process_time()
                if working.is_set() and not sentence:
                    send("computed", now - counted)
                counted = now
                if sentence != previous:
                    send("compiling", sentence)
                    previous = sentence

    def progress(stage: str, share: float) -> None:
        send("progress", (stage, share))

    messages: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=announce, daemon=True).start()
    Thread(target=listen, args=(source, messages), daemon=True).start()
    load()
    try:
        for number in count():
            work, args, wants = pickle.loads(messages.get())
            working.set()
            outcome = done(work, args, {"progress": progress} if wants else {})
            working.clear()
            send(*outcome)
            if number == 0:
                gc.freeze()  # the modules stay: looking at them again and again took a tenth of the time
                gc.set_threshold(YOUNG)
    except BrokenPipeError:
        leave()


def listen(source: BinaryIO, messages: SimpleQueue[bytes]) -> None:
    """Take messages until there are no more: the server has gone, and the process ends in the middle of its work."""
    while head := source.read(LENGTH):
        messages.put(source.read(int.from_bytes(head)))
    leave()


def leave() -> None:
    """End the process, and take its temporary files along."""
    shutil.rmtree(os.environ.get("TMPDIR", ""), ignore_errors=True)
    os._exit(0)


def main() -> None:
    """Work for the server at the other end of the standard input and output."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server
    if "background" in sys.argv[1:] and hasattr(os, "nice"):
        os.nice(NICE)
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the work prints is no answer
    work_on(sys.stdin.buffer, sink)


if __name__ == "__main__":
    main()
