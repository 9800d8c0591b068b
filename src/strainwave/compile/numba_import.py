"""Import of Numba, at its first use, and the processor that it makes machine code for.

The processor is that of this machine, unless NUMBA_CPU_NAME and NUMBA_CPU_FEATURES are set.
"""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from itertools import count
from typing import Any

# A name like x86-64-v3 implies features that no list has: what the compiler makes of two operations shows them.
PROBE = """
declare <8 x double> @llvm.fma.v8f64(<8 x double>, <8 x double>, <8 x double>)
define <8 x double> @floats(<8 x double> %a, <8 x double> %b, <8 x double> %c) {
  %d = call <8 x double> @llvm.fma.v8f64(<8 x double> %a, <8 x double> %b, <8 x double> %c)
  ret <8 x double> %d
}
define <4 x i64> @integers(<4 x i64> %a, <4 x i64> %b) {
  %c = add <4 x i64> %a, %b
  ret <4 x i64> %c
}
"""
SIGNS = {
    "sse2": r"%[xyz]mm",
    "avx": r"%[yz]mm",
    "avx2": r"vpaddq\s.*%ymm",
    "fma": r"vfmadd",
    "avx512f": r"%zmm",
    "neon": r"\bfmla",
}


@cache
def numba_module() -> Any:
    """Numba, imported and set at the first call."""
    with needless_modules_hidden():
        numba, types = import_module("numba"), import_module("numba.core.types")
    _prefer_wide_vectors(numba.config)
    # Names of compiled functions hold a number, which code of another process must not have too.
    import_module("numba.core.bytecode").FunctionIdentity._unique_ids = count(int.from_bytes(os.urandom(6)))
    # Numba asks `if receiver:` before it passes self; the type of a model without fields must not be falsy.
    types.NamedTuple.__bool__ = lambda self: True
    return numba


@contextmanager
def needless_modules_hidden() -> Iterator[None]:
    """Hide two modules that Numba imports where it finds them and that no kernel needs; a loaded one stays.

    A compiled np.dot of a user finds BLAS later; coverage that measures is loaded before.
    """
    absent = [name for name in ("scipy.linalg.cython_blas", "coverage") if name not in sys.modules]
    sys.modules.update(dict.fromkeys(absent))  # type: ignore[arg-type]
    try:
        yield
    finally:
        for name in absent:
            sys.modules.pop(name, None)


def _prefer_wide_vectors(config: Any) -> None:
    """Let the compiler use 512-bit vectors where the processor has them; for Intel's it keeps to 256 bits otherwise."""
    host = import_module("llvmlite.binding")
    features = host.get_host_cpu_features()
    if config.CPU_NAME is None and config.CPU_FEATURES is None and features.get("avx512f"):
        config.CPU_NAME, config.CPU_FEATURES = host.get_host_cpu_name(), features.flatten() + ",-prefer-256-bit"


@cache
def target_cpu() -> tuple[tuple[str, ...], str]:
    """Vector units and name of the processor that machine code is made for."""
    numba_module()
    binding = import_module("llvmlite.binding")
    codegen = import_module("numba.core.registry").cpu_target.target_context.codegen()
    triple, name, features = codegen.magic_tuple()
    machine = binding.Target.from_triple(triple).create_target_machine(cpu=name, features=features)
    assembly = machine.emit_assembly(binding.parse_assembly(PROBE))
    return tuple(unit for unit, sign in SIGNS.items() if re.search(sign, assembly)), name
