"""Lock of a store: one process at a time writes it.

The lock is a file beside the store, which the system releases when its owner dies, however it dies.
"""

import contextlib
import json
import logging
import os
import socket
import sys
from pathlib import Path
from typing import Any

log = logging.getLogger(__name__)

if sys.platform == "win32":  # pragma: no cover
    import msvcrt
else:
    import fcntl


LOCKED_BYTE = 1 << 20  # the byte that Windows locks; it lies behind the text, which others are to read


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
            log.warning("the lock of process %s, which no longer runs, is taken over", owner.get("pid"))
        text = json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode()
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, text, 0) if hasattr(os, "pwrite") else os.write(descriptor, text)

    def _refusal(self, owner: dict[str, Any]) -> str:
        who = f"process {owner.get('pid')} on {owner.get('host')}" if owner else "another process"
        return f"{who} is working on this store; wait for it, or delete {self.path} if it certainly no longer runs"

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
            os.lseek(descriptor, LOCKED_BYTE, os.SEEK_SET)
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
