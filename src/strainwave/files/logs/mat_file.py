"""Variables of MAT-files, read by a process of its own: a damaged file can end that of SciPy's reader."""

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

STOPPED = (-9, -15)  # codes of a process that the system or a user ended: the signals SIGKILL and SIGTERM
CHILD = Path(__file__).with_name("mat_child.py")


class NoReader(RuntimeError):
    """No process can read a MAT-file: it does not start, or is ended from outside."""


def mat_variables(path: Path) -> dict[str, Any]:
    """Variables of a MAT-file by name, without dimensions of length 1.

    Raises
    ------
    NotImplementedError
        If the file is of version 7.3.
    ValueError
        If it is damaged.
    NoReader
        If that process cannot be started, cannot import SciPy, or is ended from outside.
    """
    # -P: no module of the working folder, or of this one, stands in for one of these
    command = [sys.executable or "python", "-P", os.fspath(CHILD), os.fspath(path)]
    try:
        child = subprocess.run(command, capture_output=True, check=False)
        cause = child.stderr.decode(errors="replace").strip() if child.returncode == 1 else ""
    except OSError as error:
        cause = str(error)
    if cause:
        fate = f"{command[0]}, which does not run ({cause.splitlines()[-1]})"
        raise _no_reader(path, fate, "let this program start processes")
    if child.returncode in STOPPED:
        fate = f"which was ended from outside (signal {-child.returncode}), as a system does that has no memory left"
        raise _no_reader(path, fate, "read it with more memory")
    if child.returncode:
        raise ValueError(f"SciPy's reader ended with the code {child.returncode}")
    answer = pickle.loads(child.stdout)
    if isinstance(answer, Exception):
        raise answer
    return dict(answer)


def _no_reader(path: Path, fate: str, remedy: str) -> NoReader:
    """Error that says what became of the process, and what helps."""
    return NoReader(f"{path} is read by a process of its own, {fate}; {remedy}, or save the data as .npz")
