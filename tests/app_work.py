"""Work for the processes of the app, which import it by its name: without end, with a fault, on a full disk."""

import os
import resource
import signal
import tempfile
import time

from strainwave.compile.cache import with_progress


def endless(progress):
    """Tell of the progress once, and then compute without end."""
    progress("endless", 0.5)
    while True:
        pass


def pid(**_):
    return os.getpid()


def full(size):
    """Write a file on a disk that has room for 4 KiB."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with tempfile.TemporaryFile() as file:
            file.write(b"x" * size)
            file.flush()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def compiled(progress):
    """Take a second for a kernel of the name of a slow one."""
    progress("begun", 0.1)
    with_progress(lambda _kinds: time.sleep(1.0), "follow", lambda: None)(())
    progress("compiled", 0.5)


def mode():
    """Whether this process compiles, as the environment says."""
    return os.environ.get("STRAINWAVE_JIT", "1")


def until_there(path):
    """Wait for a file, but in an interpreted process."""
    while mode() == "1" and not path.exists():
        time.sleep(0.02)


def never_interpreted():
    """Compute without end in an interpreted process."""
    while mode() == "0":
        time.sleep(0.02)
    return mode()


def dying():
    os._exit(3)


def faulty():
    raise ZeroDivisionError


def without_progress(work, progress):
    progress("begun", 0.1)
    return work()
