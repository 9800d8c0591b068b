"""What `sw.ensemble(..., device="gpu")` would give a graphics processor, seen without one.

Its launches are caught: their code is compiled to PTX, or run thread after thread on the processor, from the LLVM form
in which numba-cuda hands it to NVVM. That form names types of pointers for NVVM, which the LLVM of llvmlite no longer
reads: set LLVMLITE_ENABLE_IR_LAYER_TYPED_POINTERS=0 before llvmlite is imported to run it, and leave it for PTX.
"""

import ctypes
import re
import shutil
import subprocess
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

import strainwave as sw
from strainwave.compile import cuda

REGISTERS = ("tid", "ntid", "ctaid", "nctaid")  # that tell a thread its place
ARITHMETIC = {"__nv_fabs": "llvm.fabs.f64", "__nv_sqrt": "llvm.sqrt.f64"}


class HostArray(np.ndarray):
    """An array in the place of one on the device."""

    def copy_to_host(self):
        return np.array(self)


HOST = SimpleNamespace(
    to_device=lambda array: np.ascontiguousarray(array).view(HostArray),
    device_array=lambda shape: np.full(shape, np.nan).view(HostArray),
)


class CaughtError(Exception):
    """Carries a launch out of the ensemble that made it."""


def ensemble_by(launch, *args, **options):
    """`sw.ensemble(..., device="gpu")` whose launches a function does."""
    cuda.load()
    with (
        mock.patch.object(cuda, "missing", return_value=""),
        mock.patch.object(cuda, "load", return_value=HOST),
        mock.patch.object(cuda, "launch", launch),
    ):
        return sw.ensemble(*args, device="gpu", **options)


def types_of(arguments):
    """Types of the compiler of a kernel's arguments."""
    from numba.cuda.typing.typeof import typeof

    return tuple(typeof(np.asarray(a) if isinstance(a, np.ndarray) else a) for a in arguments)


def library(parts, rows, lanes, types, capability):
    """The kernel's code for arguments of these types, for a device of this compute capability."""
    from numba.cuda import compiler, dispatcher

    device = SimpleNamespace(compute_capability=capability)
    thread = cuda.kernel(*parts, rows, lanes).py_func
    with mock.patch.object(dispatcher, "get_current_device", return_value=device):
        return compiler._compile_pyfunc_with_fixup(
            thread, types, device=False, abi="numba", cc=capability, launch_bounds=cuda.THREADS
        )[0]


def code(system, method, capabilities):
    """PTX of the kernel for a system and a method, for every compute capability, and the lanes of a thread."""

    def catch(*launch):
        raise CaughtError(*launch)

    states = len(system.state_names()) if hasattr(system, "state_names") else 2
    try:
        ensemble_by(catch, system, {}, (0.1,) * states, periods=1, method=method)
    except CaughtError as caught:
        parts, rows, lanes, _, arguments = caught.args
    made = library(parts, rows, lanes, types_of(arguments), capabilities[0])
    return {capability: "\n".join(made.get_asm_strs(cc=capability)) for capability in capabilities}, lanes


def registers(ptx, capability):
    """Registers, bytes of stack and bytes of spill stores of a kernel; None where there is no ptxas."""
    packages = find_spec("nvidia")
    homes = packages.submodule_search_locations if packages else []
    programs = [shutil.which("ptxas"), *(path for home in homes for path in Path(home).glob("*/bin/ptxas*"))]
    program = next(filter(None, programs), None)
    if program is None:
        return None
    arch = f"-arch=sm_{capability[0]}{capability[1]}"
    run = subprocess.run(
        [program, arch, "-v", "-o", "/dev/null", "/dev/stdin"],
        input=ptx,
        capture_output=True,
        text=True,
        check=True,
    )
    patterns = r"Used (\d+) registers", r"(\d+) bytes stack frame", r"(\d+) bytes spill stores"
    return tuple(int(re.search(pattern, run.stdout + run.stderr)[1]) for pattern in patterns)


def numbers_of(thing):
    """Numbers that an argument of a kernel becomes, in order."""
    if isinstance(thing, np.ndarray):
        return [0, 0, thing.size, 8, thing.ctypes.data, *thing.shape, *thing.strides]
    return [number for item in thing for number in numbers_of(item)] if isinstance(thing, tuple) else [thing]


@cache
def engine_of(parts, rows, lanes, types):
    """Machine code of this processor for a kernel of the device, and the address of its function."""
    from llvmlite import binding

    made = library(parts, rows, lanes, types, (9, 0))

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    counters = [
        f"@{r} = global i32 0\ndefine i32 @read_{r}() {{\n  %v = load i32, ptr @{r}\n  ret i32 %v\n}}"
        for r in REGISTERS
    ]
    module = binding.parse_assembly("\n".join(counters))
    names = {f"llvm.nvvm.read.ptx.sreg.{r}.x": f"read_{r}" for r in REGISTERS} | ARITHMETIC
    for text in made.llvm_strs:
        for name, here in names.items():
            text = text.replace(name, here)
        module.link_in(binding.parse_assembly(re.sub(r"(?m)^(target|!nvvm|@.?llvm\.used).*$", "", text)))
    module.verify()
    engine = binding.create_mcjit_compiler(module, binding.Target.from_default_triple().create_target_machine(opt=2))
    engine.finalize_object()
    (name,) = (f.name for f in module.functions if "thread" in f.name and not f.is_declaration)
    return engine, engine.get_function_address(name)


def run_on_processor(parts, rows, lanes, grid, arguments):
    """Run the kernel's code for the device on the processor, one thread after the other."""
    values = [number for argument in arguments for number in numbers_of(argument)]
    kinds = tuple(ctypes.c_double if isinstance(number, float) else ctypes.c_int64 for number in values)
    engine, address = engine_of(parts, rows, lanes, types_of(arguments))
    place = {r: ctypes.c_int32.from_address(engine.get_global_value_address(r)) for r in REGISTERS}
    place["nctaid"].value, place["ntid"].value = grid
    for place["ctaid"].value in range(grid[0]):
        for place["tid"].value in range(grid[1]):
            ctypes.CFUNCTYPE(None, *kinds)(address)(*values)
