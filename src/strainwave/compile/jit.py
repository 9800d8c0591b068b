"""Kernels: functions that run as machine code by Numba, with the methods of the model objects inside them.

A kernel is a plain Python function marked `@kernel`. It may call other kernels, the functions of `maths`, and the
methods of any NamedTuple handed to it; `run(kernel, *args)` executes it as machine code, which is kept on disk
(`cache`). Numba is imported at the first `run`, so importing the package stays cheap, and with the environment
variable STRAINWAVE_JIT=0 (or NUMBA_DISABLE_JIT=1) the same functions run as Python.
"""

import inspect
import os
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial, wraps
from importlib import import_module
from itertools import count
from threading import RLock
from typing import Any, TypeVar

from . import calls, lanes, maths_kernels, tree
from .address import ByAddress, kind_of
from .cache import CodeCache, cache_writable, with_progress
from .inner import compilers
from .numba_import import needless_modules_hidden, numba_module
from .tree import classes as classes_of

F = TypeVar("F", bound=Callable[..., Any])

# "contract", "nsz" and "arcp" allow FMA and reciprocals; full fastmath assumes no NaN and would hide divergence.
OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp"},
    "nogil": True,
    "no_cfunc_wrapper": True,
}

NUMBA_COMPILES = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
LIGHT_RUNS = 12  # about three response curves
_light_runs = count()
_runs: Counter[Any] = Counter()
_all_light: ContextVar[bool] = ContextVar("_all_light", default=False)
_kernels: list[tuple[Callable[..., Any], Callable[..., Any], bool | None]] = []


def kernel(function: F) -> F:
    """Mark a function that compiled code inlines; as Python it stays what it is."""
    _kernels.append((function, function, True))
    return function


def routine(function: F) -> F:
    """Mark a function that compiled code calls: large ones would be compiled again at every place of use."""
    _kernels.append((function, function, False))
    return function


def kernel_as(loops: Callable[..., Any], inline: bool = False) -> Callable[[F], F]:
    """Mark a NumPy function that compiled code replaces by `loops`, with the same arguments and results."""

    def mark(function: F) -> F:
        _kernels.append((function, loops, inline))
        function.loops = loops  # type: ignore[attr-defined]
        return function

    return mark


def chosen(choose: Callable[..., Any]) -> Callable[..., Any]:
    """Make of a function that chooses a body by the classes of its arguments the function that runs this body.

    Compiled code chooses when it is made: `choose` then gets the compiler's types, which know the `instance_class`.
    """

    @wraps(choose)
    def function(*args: Any) -> Any:
        return choose(*args)(*args)

    _kernels.append((function, choose, None))
    return function


def borrowed(thing: Any) -> Any:
    """Return the same arrays (alone or in tuples) without reference counting, which costs more than small loops.

    Only for arguments of an entry kernel, which their caller keeps alive.
    """
    return thing


def enabled() -> bool:
    """True if kernels are compiled."""
    return NUMBA_COMPILES and os.environ.get("STRAINWAVE_JIT", "1") != "0"


@contextmanager
def light_as_python() -> Iterator[None]:
    """Run the kernels of curves inside as Python: for one curve, which NumPy finds sooner than Numba is loaded."""
    before = _all_light.set(True)
    try:
        yield
    finally:
        _all_light.reset(before)


def load() -> None:
    """Load Numba, so that kernels are machine code from the first: where many run, or no last bit may depend on before.

    Inside `light_as_python` nothing is loaded.
    """
    if enabled() and not _all_light.get():
        numba_module()


def run(function: Callable[..., Any], *args: Any, light: bool | None = None, after: int = 0) -> Any:
    """Execute a kernel as machine code, or as Python when compilation is off.

    A `light` job, which takes a fraction of a second in NumPy, runs as Python the first times in a process that has not
    loaded Numba: loading it takes longer. Where `light` is False it does so inside `light_as_python` alone. One that
    pays only where it is run often is Python there the first `after` times with models of these classes, and always
    where it cannot be compiled. The results agree to rounding. If a user's class uses something that compiled code does
    not know, the sentence of the TypeError says what.
    """
    loaded = "numba" in sys.modules
    as_light = not loaded and light is not None and _runs_light(light)
    if as_light or not enabled():
        return function(*_things(args))
    if after:
        key = function, classes_of(_things(args))
        if _runs[key] < (0 if loaded else after):
            _runs[key] += 1
            return function(*_things(args))
    try:
        given = tuple([arg.native() if isinstance(arg, ByAddress) else arg for arg in args])
        return dispatcher_of(function, classes_of(given))(*given)
    except Exception as error:
        errors = numba_module().core.errors
        if not isinstance(error, (errors.NumbaError, errors.UnsupportedBytecodeError)):
            raise
        if after:  # it has run as Python before
            _runs[key] = -sys.maxsize
            return function(*_things(args))
        raise TypeError(_explain(error, _things(args))) from error


def _runs_light(light: bool) -> bool:
    """True for a job that Python does sooner than Numba is loaded; counts the light ones."""
    return _all_light.get() or (light and next(_light_runs) < LIGHT_RUNS)


def _things(args: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple([arg.thing if isinstance(arg, ByAddress) else arg for arg in args])


_entries: dict[Any, dict[Any, int]] = defaultdict(dict)  # by kinds of things


def entry(function: Callable[..., Any], thing: Any, *kinds: Any) -> int:
    """Address of the machine code of a function whose first argument are the words of a thing (see `address`).

    Its other arguments are of these kinds: `float`, `int`, a number n for a pointer to n floats, VECTOR or MATRIX. A
    thing of the same kind, with other numbers, has the same address, and this process keeps it.
    """
    return entries(thing, (function, kinds))[0]


def entries(thing: Any, *functions: tuple[Any, tuple[Any, ...]]) -> list[int]:
    """Addresses of several functions of one thing, each with its kinds; 0 in the place of None."""
    known = _entries[kind_of(thing)]
    return [0 if function is None else _address_of(function, thing, known, kinds) for function, kinds in functions]


def _address_of(function: Callable[..., Any], thing: Any, known: dict[Any, int], kinds: tuple[Any, ...]) -> int:
    if (function, kinds) not in known:
        with _one_at_a_time:
            dispatcher, types = dispatcher_of(function, classes_of((thing,))), import_module("numba.core.types")
            signature = calls.signature(types, numba_module().typeof(thing), kinds)
            dispatcher.compile(signature)
            code = dispatcher.overloads[signature]
            known[function, kinds] = int(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))
    return known[function, kinds]


@cache
def methods_of(cls: type) -> tuple[str, ...]:
    """Names of the methods that compiled code may call on a model of this class."""
    return tuple(name for name in dir(cls) if name[0] != "_" and inspect.isfunction(getattr(cls, name)))


def _explain(error: Exception, things: tuple[Any, ...]) -> str:
    package = __package__.partition(".")[0]
    foreign = {cls.__name__ for cls in classes_of(things) if cls.__module__.partition(".")[0] != package}
    lines = [line.strip(" -") for line in str(error).splitlines() if line.strip() and "<locals>" not in line]
    signs = (
        "a method returns", "Unknown attribute", "Cannot unify", "Use of unsupported", "The use of", "Untyped global",
        "Exception matching", "Unsupported", "No implementation of",
    )  # fmt: skip
    facts = [line for sign in signs for line in lines if line.startswith(sign)] or lines or ["unknown reason"]
    return (
        f"{' / '.join(sorted(foreign)) or 'the model'} cannot be compiled: {facts[0].rstrip('.:')}; write its methods "
        "with arithmetic, abs and strainwave.maths, or set STRAINWAVE_JIT=0 to run it as Python"
    )


_one_at_a_time = RLock()


def dispatcher_of(function: Callable[..., Any], classes: tuple[type, ...]) -> Any:
    """Numba's dispatcher of a function for models of these classes, made once."""
    with _one_at_a_time:  # threads ask for their first kernels at once
        return _new_dispatcher(function, classes)


def expose(*classes: type) -> None:
    """Let code that is compiled, not read, know maths functions, kernels, and methods of models of these classes."""
    with import_module("numba.core.compiler_lock").global_compiler_lock:
        _expose_helpers()
        for cls in classes:
            _expose_methods(cls)
        while _kernels:  # those of modules imported since the last call
            _expose(*_kernels.pop())


@cache
def _new_dispatcher(function: Callable[..., Any], classes: tuple[type, ...]) -> Any:
    """Dispatcher that keeps its code on disk; one for each tuple of classes, as Numba takes two of one name for one."""
    body = getattr(function, "loops", function)
    dispatcher = numba_module().njit(pipeline_class=compilers()[0], **OPTIONS)(body)
    cache_writable()  # makes the folder
    code = CodeCache(body)
    compile_ = partial(code.compiled_once, dispatcher._compiler.compile)
    dispatcher._compiler.compile = with_progress(compile_, function.__name__, partial(expose, *classes))
    dispatcher._cache = code
    return dispatcher


# Inner functions need no entry from Python. Without forceinline every law larger than Cubic falls out of vector code.
CALLED = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
INNER = CALLED | {"forceinline": True}


def _expose(function: Callable[..., Any], body: Callable[..., Any], inline: bool | None = True) -> None:
    """Let compiled code call `function`, with `body` as its implementation (or what chooses it: inline is None)."""
    _overload(function, body if inline is None else _typed(body), CALLED if inline is False else INNER)


def _overload(function: Callable[..., Any], typed: Callable[..., Any], options: dict[str, Any]) -> None:
    """Let compiled code call `function`, with the implementation that `typed` gives for the types of its arguments."""
    types, templates = import_module("numba.core.types"), import_module("numba.core.typing.templates")
    options = options | {"pipeline_class": compilers()[1]}
    strict = False  # it would compare annotations too, which an implementation writes more narrowly
    made = templates.make_overload_template(function, typed, options, strict, "never")
    made._impl_cache = ForAllCallers()
    templates.infer(made)
    templates.infer_global(function, types.Function(made))


class ForAllCallers(dict[Any, Any]):
    """Functions of a template, which Numba compiles once more for each kind of caller; these are the same for all."""

    def __getitem__(self, key: Any) -> Any:
        return super().__getitem__(key[:-1])

    def __setitem__(self, key: Any, function: Any) -> None:
        super().__setitem__(key[:-1], function)


@cache
def _expose_helpers() -> None:
    """Let compiled code know the maths functions and the primitives of this room."""
    with needless_modules_hidden():
        import_module("numba.np.arraymath")
    types, templates = import_module("numba.core.types"), import_module("numba.core.typing.templates")
    for made in (bodies, calls.bodies, lanes.bodies, tree.bodies, maths_kernels.bodies):
        for function, typed in made(types).items():  # as parts of their own they would take the compiler as long as any
            template = templates.make_intrinsic_template(function, typed, function.__name__)
            templates.infer(template)
            templates.infer_global(function, types.Function(template))
    for function, body in maths_kernels.functions().items():
        _expose(function, body)


@cache
def _expose_methods(cls: type) -> None:
    """Let compiled code call the methods of models of this class."""
    types, templates = import_module("numba.core.types"), import_module("numba.core.typing.templates")
    for name in methods_of(cls):
        numba_name = f"{name} of {cls.__module__}.{cls.__qualname__} {id(cls)}"
        typed = _typed(getattr(cls, name))
        template = templates.make_overload_method_template(types.BaseNamedTuple, numba_name, typed, "never")
        template._resolve = _of_class(cls, name, numba_name, template._resolve)
        templates.infer_getattr(template)
        _overload(typed, typed, INNER)


def _typed(body: Callable[..., Any]) -> Any:
    """Function that gives Numba the body of a function: always this one."""

    def typed(*args: Any) -> Any:
        return body

    typed.__signature__ = inspect.signature(body)  # type: ignore[attr-defined]
    return typed


def _of_class(cls: type, name: str, numba_name: str, resolve: Callable[..., Any]) -> Callable[..., Any]:
    """Let a method, to Numba `numba_name`, be found by its name in models of this class."""

    def resolved(self: Any, kind: Any, attribute: str) -> Any:
        return resolve(self, kind, numba_name) if attribute == name and kind.instance_class is cls else None

    return resolved


def bodies(types: Any) -> dict[Any, Any]:
    """Body in compiled code of `borrowed`: its argument with the memory owner of every array cleared.

    Numba then counts no references.
    """

    def typed(context: Any, thing: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            def unowned(kind: Any, old: Any) -> Any:
                if not isinstance(kind, types.Array):
                    return old
                array = context.make_array(kind)(context, builder, old)
                array.meminfo = array.meminfo.type(None)
                return array._getvalue()

            return tree.rebuilt(types, context, builder, thing, arguments[0], unowned)

        return thing(thing), build

    return {borrowed: typed}
