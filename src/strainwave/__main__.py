"""The command `strainwave`; `python -m strainwave` is the same."""

import gc
import signal
import sys

INTERRUPTED = 130


def main() -> None:
    """Run the command line. What asks the process to end (SIGTERM) is taken as Ctrl-C: it keeps what is finished."""
    gc.set_threshold(300_000)  # most of what a command makes lives to its end: what is loaded, and the results
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        from .app.commands.cli import main as run
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    run()


if __name__ == "__main__":
    main()
