"""Kernels as WebAssembly, for pages that compute without Python.

LLVM, which comes with Numba, makes the same functions for a 32-bit machine of a browser. `compiled` does so in another
process, where Numba leaves what it compiles unoptimised: there is nothing of this processor in it. `linked` makes a
module of that with the linker of the package `ziglang`. An address is there an index into the table of functions that
all modules of a page share: `beside` makes a module that another one calls by its table, such as a law, without a
linker.

What this takes from inside Numba (the text of its code, the order of arguments) was tried with the versions in `TRIED`.
"""

import ast
import hashlib
import importlib
import inspect
import os
import pickle
import re
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from . import address, jit
from .inner import compilers
from .tree import classes

TRIED = (0, 61), (0, 68)  # first and last minor version of Numba
TRIPLE, FEATURES = "wasm32-unknown-unknown", "+simd128,+bulk-memory,+sign-ext,+nontrapping-fptoint,+mutable-globals"
PLAIN = {"NUMBA_OPT": "0", "NUMBA_LOOP_VECTORIZE": "0", "NUMBA_SLP_VECTORIZE": "0"}
CHILD = (
    "import pickle, sys; given, out = sys.stdin.buffer, sys.stdout.buffer; sys.stdout = sys.stderr; "
    "sys.path[:] = pickle.load(given); wanted = pickle.load(given); "
    "from strainwave.compile.wasm import made; out.write(pickle.dumps(made(*wanted)))"
)
SHARED = (  # with what is beside a module
    "__stack_pointer", "NRT_MemInfo_call_dtor", "cos", "sin", "tan", "atan", "atan2", "exp", "log", "pow", "sinh",
    "cosh", "tanh", "fmod",
)  # fmt: skip
STACK = 2**20  # bytes at the beginning of the memory, of which no kernel takes a tenth; data beside a module come first
SECTIONS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 10, 11)  # of a module, in their order
EXPORTS, NAMES, FUNCTION, UNDEFINED, LONG_NAME = 7, 8, 0, 16, 64
RUNTIME = """\
#include <stdlib.h>
typedef long long i64;
typedef struct { i64 count; void *destroy, *info, *data; i64 size; } owner;
void *NRT_MemInfo_alloc_aligned(i64 size, int align) {
  char *place = malloc(sizeof(owner) + size + 64);
  owner *of = (owner *)place;
  of->count = 1; of->destroy = 0; of->size = size;
  of->data = (void *)(((size_t)place + sizeof(owner) + 63) & ~(size_t)63);
  return place;
}
void *NRT_MemInfo_alloc(i64 size) { return NRT_MemInfo_alloc_aligned(size, 16); }
void NRT_MemInfo_call_dtor(void *of) { free(of); }
void *PyExc_RuntimeError; // of texts about shapes that never differ
void PyErr_SetString(void *kind, const char *text) {}
void *NRT_Allocate(i64 size) { return malloc(size); }
void NRT_Free(void *place) { free(place); }
int numba_attempt_nocopy_reshape(
    i64 axes, i64 *shape, i64 *strides, i64 count, i64 *wanted, i64 *steps, i64 size, int columns) {
  i64 step = size;
  for (i64 i = axes - 1; i >= 0; step *= shape[i--]) if (shape[i] != 1 && strides[i] != step) return 0;
  step = size;
  for (i64 i = count - 1; i >= 0; step *= wanted[i--]) steps[i] = step;
  return !columns;
}
__attribute__((export_name("take"))) void *take(int size) { return malloc(size); }
__attribute__((export_name("give"))) void give(void *place) { free(place); }
"""


class Wanted(NamedTuple):
    """A function to be exported by its name: a kernel with arguments of the kinds of these, or one of `jit.entry`.

    `kinds` are those of an entry whose only argument here is its thing; None for a kernel.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    kinds: tuple[Any, ...] | None = None


class Object(NamedTuple):
    """Machine code to be linked, the kinds of the arguments of every function in it, and what it was made of."""

    code: bytes
    arguments: dict[str, list[Any]]
    sources: tuple[str, ...]


def compiled(*functions: Wanted) -> Object:
    """Code of some functions for a browser.

    Raises
    ------
    TypeError
        If a user's class uses something that compiled code does not know.
    """
    request = pickle.dumps(sys.path) + pickle.dumps(functions)
    environment = os.environ | PLAIN
    done = subprocess.run([sys.executable, "-c", CHILD], input=request, capture_output=True, env=environment)
    if done.returncode:
        texts = done.stderr.decode(errors="replace").strip().splitlines()
        last = texts[-1] if texts else f"the compiler ended with {done.returncode}"
        raise TypeError(last.partition(": ")[2] or last)
    made_there: Object = pickle.loads(done.stdout)
    return made_there


def made(*functions: Wanted) -> Object:
    """The same in this process, which must have begun with the environment `PLAIN`."""
    jit.load()
    binding, types = map(importlib.import_module, ("llvmlite.binding", "numba.core.types"))
    read = _sources()
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine = binding.Target.from_triple(TRIPLE).create_target_machine(features=FEATURES, opt=3, reloc="static")
    whole, names, arguments = None, {}, {}
    for one in functions:
        text, symbol, kinds = _plain_code(one, types)
        text = re.sub("target datalayout = .*", f'target datalayout = "{machine.target_data}"', text)
        text = re.sub("target triple = .*", f'target triple = "{TRIPLE}"', text)
        module = binding.parse_assembly(text.replace(" = common ", " = linkonce_odr "))  # it knows no common data
        names[symbol], arguments[one.name] = one.name, [_described(kind, types) for kind in kinds]
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    _only(whole, names)
    return Object(machine.emit_object(_optimised(whole, machine, binding)), arguments, tuple(sorted(read)))


def _optimised(module: Any, machine: Any, binding: Any) -> Any:
    """The module after LLVM's passes, with few counts of references."""
    for _ in range(2):
        passes = binding.create_pass_builder(machine, binding.create_pipeline_tuning_options(speed_level=3))
        manager = passes.getModulePassManager()
        manager.add_refprune_pass()
        manager.run(module, passes)
        module = binding.parse_assembly(str(module).replace(" noinline", " inlinehint"))  # counts that stay
    return module


def _plain_code(item: Wanted, types: Any) -> tuple[str, str, tuple[Any, ...]]:
    """Numba's code of a function, the name of the function in it, and the kinds of its arguments."""
    numba = importlib.import_module("numba")
    jit._dispatcher(item.function, classes(item.arguments))
    if item.kinds is None:
        kinds = tuple(map(numba.typeof, item.arguments))
    else:
        kinds = address.signature(types, numba.typeof(item.arguments[0]), item.kinds)
    body = getattr(item.function, "loops", item.function)
    dispatcher = numba.njit(pipeline_class=compilers()[0], **jit.OPTIONS)(body)  # not the one whose code is on disk
    errors = importlib.import_module("numba.core.errors")
    try:
        dispatcher.compile(kinds)
    except (errors.NumbaError, errors.UnsupportedBytecodeError) as error:
        raise TypeError(jit._explain(error, jit.foreign_names(item.arguments))) from None
    code = dispatcher.overloads[kinds]
    return code.library.get_llvm_str(), code.fndesc.llvm_func_name, kinds


def _only(module: Any, names: dict[str, str]) -> None:
    """Leave of a module what these functions need, under their new names."""
    for thing in [*module.functions, *module.global_variables]:
        if thing.is_declaration:
            continue
        if thing.name in names:
            thing.name = names[thing.name]
        else:
            thing.linkage = "internal"


def _described(kind: Any, types: Any) -> Any:
    """Kind of an argument for the page: "f64", "i64", "address", "array" with its axes, or a list of the parts."""
    if isinstance(kind, types.BaseTuple):
        return [_described(item, types) for item in kind]
    if isinstance(kind, types.Array):
        return f"array{kind.ndim}"
    if isinstance(kind, types.RawPointer | types.CPointer):
        return "address"
    return {"float64": "f64", "int64": "i64"}[str(kind)]


def _sources() -> set[str]:
    """Names of the package's functions that Numba reads from now on."""
    identity, read = importlib.import_module("numba.core.bytecode").FunctionIdentity, set[str]()
    own = identity.from_function.__func__

    def from_function(cls: Any, function: Any) -> Any:
        if (function.__module__ or "").partition(".")[0] == __package__.partition(".")[0]:
            read.add(f"{function.__module__}:{function.__qualname__.partition('.<locals>')[0]}")
        return own(cls, function)

    identity.from_function = classmethod(from_function)
    return read


def stamp(sources: Iterable[str]) -> str:
    """Hash of the code of functions by their names, without comments and docstrings."""
    digest = hashlib.sha256()
    for name in sorted(sources):
        module, _, path = name.partition(":")
        thing: Any = importlib.import_module(module)
        for part in path.split("."):
            thing = getattr(thing, part, thing)
        tree = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(thing))))
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module) and ast.get_docstring(node) is not None:
                node.body = node.body[1:] or [ast.Pass()]
        digest.update(f"{name}\n{ast.unparse(tree)}\n".encode())
    return digest.hexdigest()


def linked(code: bytes, exports: Iterable[str]) -> bytes:
    """Module with memory and a table of its own, which exports these functions, `take` and `give` of memory.

    Raises
    ------
    RuntimeError
        If the package `ziglang` is not installed, or does not link the code.
    """
    if find_spec("ziglang") is None:
        raise RuntimeError("the numerical kernels are linked by the package ziglang; pip install ziglang")
    options = "strip-all", "export-table", "growable-table"
    flags = [f"export={name}" for name in (*exports, *SHARED)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "runtime.c").write_text(RUNTIME, encoding="utf-8")
        (folder / "code.o").write_bytes(code)
        command = [sys.executable, "-m", "ziglang", "cc", "--target=wasm32-wasi", "-mexec-model=reactor", "-O3"]
        command += ["-msimd128", "runtime.c", "code.o", "-o", "page.wasm"]
        command += [f"-Wl,-z,stack-size={STACK}", *(f"-Wl,--{option}" for option in (*options, *flags))]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"ziglang does not link the module: {done.stderr.strip()[-500:]}")
        return (folder / "page.wasm").read_bytes()


def beside(code: bytes) -> bytes:
    """Module of functions that takes memory and table of one of `linked`, and exports all that has a name.

    An object of LLVM is a module already, whose exports are in the list of its symbols and whose data begin at 0.
    """
    sections, place, names = [], 8, b""
    while place < len(code):
        kind, (size, start) = code[place], _number(code, place + 1)
        place = start + size
        if kind:
            sections.append((kind, code[start:place]))
        elif code[start + 1 : start + 8] == b"linking":
            names = code[start + 9 : place]  # after the version
    sections = [section for section in sections if section[0] != EXPORTS]
    sections.append((EXPORTS, _exports(names)))
    sections.sort(key=lambda section: SECTIONS.index(section[0]))
    return code[:8] + b"".join(bytes([kind]) + _leb(len(content)) + content for kind, content in sections)


def _exports(names: bytes) -> bytes:
    """Section of exports: the functions of a list of symbols that are defined there and known outside."""
    entries, place = [], 0
    while place < len(names):
        kind, (size, start) = names[place], _number(names, place + 1)
        place = start + size
        if kind != NAMES:
            continue
        count, cursor = _number(names, start)
        for _ in range(count):
            what = names[cursor]
            flags, cursor = _number(names, cursor + 1)
            if what != FUNCTION:  # data, which follows: what is exported comes first
                break
            number, cursor = _number(names, cursor)
            if not flags & UNDEFINED or flags & LONG_NAME:
                length, cursor = _number(names, cursor)
                name, cursor = names[cursor : cursor + length], cursor + length
                if not flags & (UNDEFINED | 7):
                    entries.append(_leb(len(name)) + name + b"\0" + _leb(number))
    return _leb(len(entries)) + b"".join(entries)


def _number(code: bytes, place: int) -> tuple[int, int]:
    """Whole number in LEB128 at a place, and the place after it."""
    value, shift = 0, 0
    while True:
        value |= (code[place] & 127) << shift
        place, shift = place + 1, shift + 7
        if code[place - 1] < 128:
            return value, place


def _leb(value: int) -> bytes:
    """Whole number in LEB128."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes([*out, value])
