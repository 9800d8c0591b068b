"""The command `strainwave`; `python -m strainwave` is the same."""

import atexit
import gc
import os
import signal
import sys
import threading

INTERRUPTED, FAILED = 130, 1


def main() -> None:
    """Run the command line. What asks the process to end (SIGTERM) is taken as Ctrl-C: it keeps what is finished."""
    gc.set_threshold(300_000)  # most of what a command makes lives to its end: what is loaded, and the results
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        from .app.commands.cli import main as run
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    try:
        run()
    except SystemExit as end:
        _leave(end)


def _leave(end: SystemExit) -> None:
    """End the process at once where no thread and no child is left: to take modules apart takes up to half a second.

    A program that runs this module in its own process, as a profiler does, goes on.
    """
    children = sys.modules.get("multiprocessing.process")
    hosted = __name__ == "__main__" and vars(sys.modules["__main__"]) is not globals()
    if hosted or threading.active_count() > 1 or (children is not None and children.active_children()):
        raise end
    code = end.code if isinstance(end.code, int) else FAILED if end.code else 0
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError) as error:
        os.write(2, f"strainwave: standard output: {str(error).lower()}\n".encode())
        code = code or FAILED
    os._exit(code)


if __name__ == "__main__":
    main()
