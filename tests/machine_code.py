"""Machine code of compiled kernels, to count instructions in."""

import re

from strainwave.compile import jit, numba_import
from strainwave.compile.numba_import import target_cpu
from strainwave.compile.tree import classes


def assembly(function, *arguments):
    """Return the text of a kernel's machine code, made anew for the arguments.

    Code that comes from the cache on disk cannot be read.
    """
    jit.expose(*classes(arguments))
    dispatcher = numba_import.numba_module().njit(**jit.OPTIONS)(function)
    dispatcher(*arguments)
    return dispatcher.inspect_asm(dispatcher.signatures[-1])


def instructions(function, *arguments):
    """Return the instructions of a kernel, without those of the entry from Python."""
    text = assembly(function, *arguments)
    body = re.split(r"^(?!\.L)\S+:$", text, maxsplit=2, flags=re.MULTILINE)[1]  # after the first function's name
    return re.findall(r"^\t([a-z]\w+)", body, re.MULTILINE)


def has_fma():
    """Whether the code is of an x86 processor with FMA: without it a `power` calls the mathematical library."""
    return "fma" in target_cpu()[0]
