"""Compiles exported C for the tests, where there is a compiler, and calls it through ctypes."""

import ctypes
import re
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


def parameters_of(header):
    """Names of the fields of the struct of parameters in the text of a header, in order."""
    return re.findall(r"double (\w+);", header.split("_parameters;")[0].rsplit("typedef struct {", 1)[1])


def exported_parameters(library, name, header, **changed):
    """Copy of the exported values, with others where they are given."""
    fields = parameters_of(header)
    values = dict(zip(fields, (ctypes.c_double * len(fields)).in_dll(library, f"{name}_default"), strict=True))
    assert changed.keys() <= values.keys(), f"no parameters {changed.keys() - values.keys()}"
    return doubles(*(values | changed).values())
