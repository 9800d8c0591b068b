"""The processor that machine code is made for: this machine's, unless NUMBA_CPU_NAME and NUMBA_CPU_FEATURES are set."""

import re
from functools import cache
from importlib import import_module

from .jit import _numba

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
def target_cpu() -> tuple[tuple[str, ...], str]:
    """Vector units and name of the processor that machine code is made for."""
    _numba()
    binding = import_module("llvmlite.binding")
    codegen = import_module("numba.core.registry").cpu_target.target_context.codegen()
    triple, name, features = codegen.magic_tuple()
    machine = binding.Target.from_triple(triple).create_target_machine(cpu=name, features=features)
    assembly = machine.emit_assembly(binding.parse_assembly(PROBE))
    return tuple(unit for unit, sign in SIGNS.items() if re.search(sign, assembly)), name
