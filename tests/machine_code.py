"""Machine code of compiled kernels, to count instructions in."""

import platform
import re

from strainwave.compile import jit
from strainwave.tree import classes


def instructions(function, *arguments):
    """Return the instructions of a kernel made anew for the arguments, without those of the entry from Python.

    Code that comes from the cache on disk cannot be read.
    """
    jit._dispatcher(function, classes(arguments))  # lets compiled code know the models
    dispatcher = jit._numba().njit(**jit.OPTIONS)(function)
    dispatcher(*arguments)
    assembly = dispatcher.inspect_asm(dispatcher.signatures[-1])
    body = re.split(r"^(?!\.L)\S+:$", assembly, maxsplit=2, flags=re.MULTILINE)[1]  # after the first function's name
    return re.findall(r"^\t([a-z]\w+)", body, re.MULTILINE)


def has_fma():
    return platform.machine().lower() in ("x86_64", "amd64") and jit.host_cpu()[0].get("fma")
