"""Variables of MAT-files, read by a process of its own: a damaged file can end that of SciPy's reader."""

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

STOPPED = (-9, -15)  # codes of a process that the system or a user ended: the signals SIGKILL and SIGTERM
CHILD = """
import pickle, sys
from scipy.io import loadmat
try:
    answer = loadmat(sys.argv[1], appendmat=False, squeeze_me=True, struct_as_record=False)
except NotImplementedError:  # as SciPy says of MATLAB 7.3, which another reader takes
    answer = NotImplementedError()
except Exception as error:  # whatever a damaged file makes SciPy raise
    answer = ValueError(str(error))
pickle.dump(answer, sys.stdout.buffer)
"""


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
    RuntimeError
        If that process cannot be started, cannot import SciPy, or is ended from outside.
    """
    # -P: no module of the working folder stands in for one of these
    command = [sys.executable or "python", "-P", "-c", CHILD, os.fspath(path)]
    try:
        child = subprocess.run(command, capture_output=True, check=False)
        cause = child.stderr.decode(errors="replace").strip() if child.returncode == 1 else ""
    except OSError as error:
        cause = str(error)
    if cause:
        raise NoReader(
            f"{path} is read by a process of its own, {command[0]}, which does not run ({cause.splitlines()[-1]}); let "
            "this program start processes, or save the data as .npz"
        )
    if child.returncode in STOPPED:
        raise NoReader(
            f"{path} is read by a process of its own, which was ended from outside (signal {-child.returncode}), as a "
            "system does that has no memory left; read it with more memory, or save the data as .npz"
        )
    if child.returncode:
        raise ValueError(f"SciPy's reader ended with the code {child.returncode}")
    answer = pickle.loads(child.stdout)
    if isinstance(answer, Exception):
        raise answer
    return dict(answer)
