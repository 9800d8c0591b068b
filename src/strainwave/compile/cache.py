"""Machine code on disk: a file for each kernel and kinds of arguments, named by all that the compiler reads of them.

Numba's own cache does not notice an edit in another file, and takes a class of a script for another one in each
process. Here the name of a file holds the kernel, the kinds of its arguments, and the code of all functions, methods
and constants that the kernel reads (`cache_key`). What cannot be recognised in another process, such as a class that
reads an open file, stays in memory.

A released wheel brings LLVM code of kernels (`tools/release.py`), which makes machine code in a fifth of the time.

`compiling` lists what is compiled now, for progress; nothing is printed here.

Code that is on disk is loaded within a fraction of a second and is not listed.
"""

import hashlib
import io
import lzma
import os
import pickle
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, wraps
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from platformdirs import user_cache_path

from . import cache_key
from .numba_import import needless_modules_hidden

UNUSED_DAYS = 30  # after which code is removed
DAY = 86400.0  # s
DIGEST = 32  # bytes at the beginning of a file: the hash of the others
SHIPPED = Path(__file__).with_name("kernels.xz")
BAD_FILE = (OSError, EOFError, pickle.UnpicklingError, ImportError, AttributeError, LookupError, TypeError, ValueError)


class CodeCache:
    """Code of `function` on disk: a dispatcher of Numba reads it before it compiles, and writes it afterwards."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.cache_path = str(cache_folder())

    @needless_modules_hidden()
    def load_overload(self, kinds: Any, target: Any) -> Any:
        """Machine code for arguments of these kinds, None where there is none that fits."""
        import_module("numba.core.runtime").rtsys.initialize(target)
        classes, path, name = self.location(kinds, target.codegen())
        if path is None:
            return None
        try:
            written = path.read_bytes() if path.is_file() else b""
            if hashlib.sha256(written[DIGEST:]).digest() == written[:DIGEST]:  # damaged code would end the process
                parts = _Unpickler(io.BytesIO(written[DIGEST:]), classes).load()
                os.utime(path)
            elif name in (kernels := shipped(target.codegen().magic_tuple()[0])):
                library, described, *others = _Unpickler(io.BytesIO(kernels[name]), classes).load()
                parts = _machine_code(library, described, target.codegen()), described, *others
                write(path, classes, parts)
            else:
                return None
            return import_module("numba.core.compiler").CompileResult._rebuild(target, *parts)
        except BAD_FILE:  # written by a machine that stopped on the way, or by another version of a library
            return None

    def save_overload(self, kinds: Any, code: Any) -> None:
        """Numba calls this with what `compiled_once` has given, which is kept already."""

    def compiled_once(self, compile_: Callable[..., Any], kinds: Any, *result: Any) -> Any:
        """Machine code for arguments of these kinds: compiled and kept, or what another process has made meanwhile."""
        target = import_module("numba.core.registry").cpu_target.target_context
        classes, path, _ = self.location(kinds, target.codegen())
        with file_lock(path):
            code = self.load_overload(kinds, target)
            if code is not None:
                target.insert_user_function(code.entry_point, code.fndesc, [code.library])
                return code
            code = compile_(kinds, *result)
            if path is not None and not code.lifted and not code.library.has_dynamic_globals:
                write(path, classes, parts_of(code))
            return code

    def flush(self) -> None:
        """Numba calls this before it compiles all again, which nothing here does."""

    def location(self, kinds: Any, codegen: Any) -> tuple[list[type], Path | None, str]:
        """Model classes among the kinds, the file of the code (None: it stays in memory), and its name in `shipped`."""
        classes = list(dict.fromkeys(_classes(kinds)))
        if " at 0x" in repr(kinds):  # a compiled function among the arguments, which has no name of its own
            return classes, None, ""
        try:
            text = cache_key.key(self.function, tuple(classes))
        except TypeError:
            return classes, None, ""
        machine = codegen.magic_tuple()
        names = [
            hashlib.sha256(f"{text} {target!r}".encode()).hexdigest()[:32]
            for target in ((kinds, machine, sys.version_info[:2], stamp(machine[0])), kinds)
        ]
        return classes, cache_folder() / f"{self.function.__name__}-{names[0]}.code", names[1]


@contextmanager
def file_lock(path: Path | None) -> Iterator[None]:
    """Wait until no other process makes the code of a file, where the operating system has locks of files."""
    lock = None
    with suppress(OSError, ImportError):
        if path is not None:
            lock, system = path.with_suffix(".lock").open("w"), import_module("fcntl")
            system.flock(lock, system.LOCK_EX)
    try:
        yield
    finally:
        if lock is not None:
            lock.close()


def parts_of(code: Any) -> tuple[Any, ...]:
    """Parts of compiled code that its run needs: neither LLVM code to link nor the text of its types.

    Of environments it reads constants alone, and those of this package without any would load their modules. Those of
    a user's methods stay: a `print` of a number has no constant and ends only with its environment.
    """
    (name, kind, (machine, _)), described, *others, _, loaded, environments = code._reduce()
    package = __package__.partition(".")[0]
    read = [e for e in environments if e.consts or e.globals["__name__"].partition(".")[0] != package]
    return (name, kind, (machine, _empty_functions(described))), described, *others, "", loaded, read


def _empty_functions(described: Any) -> bytes:
    """LLVM code with the names of a function and nothing else: what is not defined there has no address."""
    names = described.llvm_func_name, described.llvm_cpython_wrapper_name
    text = "".join(f'define void @"{name}"() {{ ret void }}\n' for name in names)
    return bytes(import_module("llvmlite.binding").parse_assembly(text).as_bitcode())


def write(path: Path, classes: list[type], parts: tuple[Any, ...]) -> None:
    """Write parts of compiled code, with the model classes among its kinds as numbers, or nothing."""
    stream = io.BytesIO()
    pickler = _pickler()(stream, protocol=4)
    pickler.classes = classes
    draft = path.with_name(f"{path.name}.{os.getpid()}.part")
    with suppress(OSError, pickle.PicklingError, TypeError, AttributeError):
        pickler.dump(parts)
        draft.write_bytes(hashlib.sha256(stream.getvalue()).digest() + stream.getvalue())
        draft.replace(path)
    with suppress(OSError):  # of what could not be written to its end or put in its place
        draft.unlink()


@cache
def shipped(triple: str) -> dict[str, bytes]:
    """Kernels that a released wheel brings, by their names: none for other libraries and machines."""
    with suppress(OSError, lzma.LZMAError):
        mark, _, content = SHIPPED.read_bytes().partition(b"\n")
        if mark == stamp(triple).encode():
            kernels: dict[str, bytes] = pickle.loads(lzma.decompress(content))
            return kernels
    return {}


def stamp(triple: str) -> str:
    """Text that the code of all kernels depends on: this folder, the compiler and the machine."""
    versions = [f"{name} {import_module(name).__version__}" for name in ("numba", "llvmlite")]
    llvm = ".".join(map(str, import_module("llvmlite.binding").llvm_version_info))
    return ", ".join([cache_key.folder_hash(), *versions, f"LLVM {llvm}", triple])


def _machine_code(library: tuple[str, bytes], described: Any, codegen: Any) -> tuple[str, str, tuple[bytes, bytes]]:
    """Machine code of a library of LLVM code, as Numba keeps it."""
    name, code = library
    made = codegen.create_library(name)
    made._final_module = import_module("llvmlite.binding").parse_bitcode(code)
    made._optimize_final_module()
    return name, "object", (codegen._tm.emit_object(made._final_module), _empty_functions(described))


def _classes(kinds: Any) -> Iterator[type]:
    """Model classes of the compiler's types, at any depth, in their order."""
    for kind in kinds:
        if hasattr(kind, "instance_class"):
            yield kind.instance_class
        if hasattr(kind, "types") or isinstance(kind, tuple):
            yield from _classes(getattr(kind, "types", kind))
        elif hasattr(kind, "dtype"):  # a pointer
            yield from _classes((kind.dtype,))


@cache
def _pickler() -> Any:
    """Class of picklers that write the number of a model class in place of the class."""

    class Pickler(import_module("numba.core.serialize").NumbaPickler):  # type: ignore[misc]
        classes: tuple[type, ...] = ()

        def persistent_id(self, thing: Any) -> int | None:
            return self.classes.index(thing) if isinstance(thing, type) and thing in self.classes else None

    return Pickler


class _Unpickler(pickle.Unpickler):
    """Reads what `_pickler` has written: the classes are those of this process."""

    def __init__(self, stream: io.BytesIO, classes: list[type]) -> None:
        super().__init__(stream)
        self.classes = classes

    def persistent_load(self, number: int) -> type:
        return self.classes[number]


@cache
def cache_folder() -> Path:
    """Folder of compiled code: STRAINWAVE_CACHE_DIR, or the user's cache folder of the operating system.

    A user without a home, as in some containers, has none: a folder in which nothing can be kept.
    """
    stated = os.environ.get("STRAINWAVE_CACHE_DIR")
    try:
        folder = Path(stated) if stated else user_cache_path("strainwave", appauthor=False)
    except RuntimeError:
        folder = Path(os.devnull)
    return folder / cache_key.folder_hash()


@cache
def cache_writable() -> bool:
    """True if compiled code can be kept on disk; otherwise it is kept in memory.

    The first call makes the folder, and removes code beside it that no process has used for long.
    """
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "used").touch()
    except OSError:
        return False
    _remove_unused(folder)
    return True


def is_empty() -> bool:
    """True if no code is on disk, that of a release included."""
    return not SHIPPED.exists() and not any(cache_folder().glob("*.code"))


def _remove_unused(folder: Path) -> None:
    """Remove code that no process has used for long, and nothing else."""
    for sibling in folder.parent.iterdir():
        if not re.fullmatch("[0-9a-f]{16}", sibling.name):
            continue
        for path in [*sibling.glob("*.code"), *sibling.glob("*.part"), *sibling.glob("*.lock"), sibling / "used"]:
            with suppress(OSError):
                if time.time() - path.stat().st_mtime > UNUSED_DAYS * DAY:
                    path.unlink()
        with suppress(OSError):  # there is something in it
            sibling.rmdir()


class Compilation(NamedTuple):
    """A kernel that is being compiled.

    `kept` says whether the code is kept on disk, so that no later process compiles it again.
    """

    kernel: str
    kept: bool

    def __str__(self) -> str:
        often = "once per machine" if self.kept else "again at every start, as the cache cannot be written"
        return f"preparing machine code, {often}"


_under_way: dict[int, Compilation] = {}
_numbers = count()


def compiling() -> tuple[Compilation, ...]:
    """Kernels that the threads of this process compile now, the first begun first; usually none."""
    return tuple(_under_way.values())


def with_progress(compile_: Callable[..., Any], kernel: str, prepare: Callable[[], None]) -> Callable[..., Any]:
    """Numba's `compile` of a kernel, after what prepares it, listed in `compiling` while they run."""

    @wraps(compile_)
    def listed(*arguments: Any) -> Any:
        number = next(_numbers)
        _under_way[number] = Compilation(kernel, cache_writable())
        try:
            prepare()
            return compile_(*arguments)
        finally:
            del _under_way[number]

    return listed
