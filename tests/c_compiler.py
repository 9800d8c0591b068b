"""Compiles exported C for the tests, where there is a compiler, and calls it through ctypes."""

import ctypes
import shutil
import subprocess

import pytest

CC = shutil.which("cc")
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler `cc` on this machine")


def compiled(source):
    """Shared library of a C file, which must compile without a warning."""
    library = source.with_suffix(".so")
    run = subprocess.run(
        [CC, *FLAGS, "-shared", "-fPIC", str(source), "-lm", "-o", str(library)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return ctypes.CDLL(str(library))


def doubles(*values):
    """Array of doubles, which a C struct of doubles is too."""
    return (ctypes.c_double * len(values))(*values)
