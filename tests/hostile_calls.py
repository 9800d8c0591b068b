# ruff: noqa: E501
"""Calls of public functions with arguments that make no sense: the same ones for the same seed, and what they answer."""

import signal
import traceback
import types
import warnings
from collections.abc import Mapping
from contextlib import contextmanager
from decimal import Decimal
from fractions import Fraction
from opcode import opmap
from pathlib import Path
from random import Random

import numpy as np
from canonical import MODELS
from valid_calls import CALLS, GEAR, LIGHT

import strainwave as sw
from strainwave.base.records import Result
from strainwave.compile.tree import is_model, numbers, replaced, shown

NUMBERS = (
    float("nan"), float("inf"), float("-inf"), -1, -1.0, 0, 0.0, -0.0, 1, 2, 2.5, 1e300, -1e300, 1e-300, 5e-324, 1e16,
    10**400, -(10**400), True, 1j, complex("nan"), Decimal("1.5"), Decimal("nan"), Fraction(1, 3), Fraction(10**400, 3),
    np.float32(1.5), np.float64("nan"), np.int64(4), np.uint8(3), np.bool_(True), np.array(1.5), np.longdouble("1e4000"),
    np.datetime64("2026-01-01"), np.ma.masked,
)  # fmt: skip
TEXTS = (
    "",
    "x",
    "5",
    "nan",
    "5 parsec",
    "5 N*m",
    "1e400 s",
    "\0",
    "\ud800",
    "x" * 5000,
    "é½",
    "a\nb",
    "-",
    b"",
    b"5",
    b"\xff",
)
ARRAYS = (
    [], (), [[]], np.array([]), np.ones((2, 2)), np.ones((0, 3)), np.ones((2, 1, 2)), np.array([1.0, float("nan")]),
    [1.0], [1, 2, 3], [3.0, 1.0], [1.0, 1.0], [1.0, float("inf")], [10**400, 1], [1, [2, 3]], [None], [None, 1.0],
    ["a", "b"], ["1", "2"], [b"1", b"2"], np.array(["1", "2"]), np.array([object()]), np.array([1j, 2.0]), [True, False],
    np.array([1, 2], "M8[s]"), range(3), {1.0, 2.0}, frozenset(), bytearray(b"ab"), memoryview(b"ab"), [{}], [()],
    np.ma.array([1.0, 2.0], mask=[True, False]), [float("nan")] * 3, np.zeros(3, [("a", float)]), [[1.0, 2.0], [3.0]],
    np.array([1e300, -1e300]), np.arange(3, dtype=np.uint8), [1e-300, 2e-300],
)  # fmt: skip
WRONG = (None, "x", float("nan"), float("inf"), np.ones(2), [], object(), 10**400, b"x", 3, -1)

OTHERS = (
    None, object(), ..., {}, {"B": [1.0]}, {"x": None}, {1: 2}, {"time": [0.0, 1.0]}, sw.Cubic, sw.Project, sw.Oscillator,
    dict, int, lambda: 1.0, lambda *_, **__: None, len, types.SimpleNamespace(omega=1.0, law=3), sw, Path("x"),
    Path("no/such/folder/x.c"), sw.Status.OK, ValueError("x"), sw.Trapezoid(0.1, 0.1), sw.SUBHARMONIC, sw.Uniform(1.0, 2.0),
    LIGHT, sw.HDC_40_050, GEAR, sw.Peak(), sw.Dopri5(1e-3), sw.Cubic(1.0, 0.1), (1.0, "a"), sw.NoError(), slice(1, 2),
)  # fmt: skip


def values_in(kind, value, rng):
    """A value with something hostile in the place of a part of it; None where it has no parts."""
    if is_model(value):
        return model(value, rng)
    if isinstance(value, Mapping) and value:
        name = rng.choice(list(value))
        if rng.random() < 0.4:
            return {(rng.choice((*TEXTS, *NUMBERS[:14], None)) if k == name else k): v for k, v in value.items()}
        return {k: (hostile(v, rng) if k == name else v) for k, v in value.items()}
    if isinstance(value, np.ndarray) and value.ndim:
        return array(value, rng)
    if isinstance(value, list | tuple) and value:
        if rng.random() < 0.4 and all(isinstance(item, float | int) for item in value):
            return array(np.array(value, float), rng)
        at = rng.randrange(len(value))
        items = [*value]
        items[at] = hostile(value[at], rng)
        return kind(items)
    if isinstance(value, float | int) and not isinstance(value, bool):
        return rng.choice((-value, value * 1e12, value * 1e-12, [value], np.full(3, value), f"{value}", f"{value} rpm"))
    return None


def array(value, rng):
    """An array of numbers that is spoilt."""
    one = value.copy()
    one.flat[rng.randrange(one.size)] = rng.choice((float("nan"), float("inf"), -1.0, 0.0, 1e300, -1e-300))
    return rng.choice(
        (one, one, value[::-1], value[:1], value[:0], value[:-1], np.tile(value, 2), value[None], value[:, None],
         value * 1e300, value * 0.0, value + float("nan"), value.astype(complex), value.astype(str),
         value.astype(object), value * 1e-300, np.full_like(value, value.flat[0]), -value, list(value), value * 1e9)
    )  # fmt: skip


def model(value, rng):
    """A model with another number or another part, or of another class."""
    if rng.random() < 0.25 or not value._fields:
        return rng.choice((type(value), tuple(value), list(value), value._asdict(), rng.choice(list(MODELS.values()))))
    if rng.random() < 0.5 and (paths := [path for path, *_ in numbers(value)]):
        return replaced(value, rng.choice(paths), rng.choice((*NUMBERS, *TEXTS, *ARRAYS, None)))
    name = rng.choice(value._fields)
    return value._replace(**{name: hostile(getattr(value, name), rng)})


def hostile(value, rng):
    """Something else in the place of a valid value."""
    draw = rng.random()
    if draw < 0.45 and (spoilt := values_in(type(value), value, rng)) is not None:
        return spoilt
    if draw < 0.65:
        return rng.choice(NUMBERS)
    return rng.choice(rng.choice((TEXTS, ARRAYS, ARRAYS, OTHERS, OTHERS)))


def hostile_call(name, seed):
    """The function of a name, and its arguments with one or two that make no sense, which are given too."""
    rng = Random(f"{name} {seed}")
    function, arguments = CALLS[name]()
    names = rng.sample(list(arguments), min(len(arguments), rng.choice((1, 1, 1, 2))))
    spoilt = {name: hostile(arguments[name], rng) for name in names}
    return function, arguments | spoilt, spoilt


class Late(BaseException):
    """A call took longer than it may."""


@contextmanager
def within(seconds):
    """Stop what takes longer (`Late`): so many seconds of the processor, or thirty times as many of waiting."""

    def late(*_):
        raise Late

    timers = {signal.SIGPROF: (signal.ITIMER_PROF, seconds), signal.SIGALRM: (signal.ITIMER_REAL, 30.0 * seconds)}
    before = {sign: signal.signal(sign, late) for sign in timers}
    for timer, time in timers.values():
        signal.setitimer(timer, time, 1.0)  # again, as Python drops what is raised in a `__del__`
    try:
        yield
    finally:
        for sign, (timer, _) in timers.items():
            signal.setitimer(timer, 0.0)
            signal.signal(sign, before[sign])


SENTENCES = (ValueError, TypeError, sw.SolveError, RuntimeError, FileNotFoundError, ModuleNotFoundError)
ROOT = str(Path(sw.__file__).parent)
LONGEST = 900  # letters of a sentence


def inner(error):
    """Last line of the package that an error came through."""
    lines = [
        f"{Path(f.filename).name}:{f.lineno}"
        for f in traceback.extract_tb(error.__traceback__)
        if f.filename.startswith(ROOT)
    ]
    return lines[-1] if lines else ""


def fault(error):
    """What is unsound about an error; "" for nothing: a statement of the package raised it, with words."""
    place = error.__traceback__
    while place.tb_next is not None:
        place = place.tb_next
    code = place.tb_frame.f_code
    said = f"{type(error).__name__}: {shown(str(error))} @ {Path(code.co_filename).name}:{place.tb_lineno}"
    if not isinstance(error, SENTENCES):
        return said
    raised = code.co_code[place.tb_lasti] == opmap["RAISE_VARARGS"]
    if not (raised and code.co_filename.startswith(ROOT)):
        return f"{said} < {inner(error)}"
    return "" if len(str(error).split()) > 3 and len(str(error)) <= LONGEST else f"no sentence: {said}"


NONE = {
    "Standstill": ("period", "size"),
    "MeasuredBode": ("deviation", "amplitude"),
    "Identified": ("residual",),
    "ProjectComparison": ("limit",),
    "Exceedance": ("low", "high"),
    "ResponseFit": ("folds", "fold_deviation"),
}  # where it is not known


def nan_in(result, depth=0, place="result"):
    """Places of a result that have NaN."""
    if isinstance(result, float | complex):
        return {place} if result != result else set()
    if isinstance(result, np.ndarray):
        return {place} if result.dtype.kind in "fc" and bool(np.isnan(result).any()) else set()
    if hasattr(type(result), "_asdict"):
        items = result._asdict()
    elif isinstance(result, tuple) and result and isinstance(result[-1], str) and result[-1]:
        items = {}  # the last item says why there is none
    elif isinstance(result, list | tuple):
        items = dict(enumerate(result))
    elif isinstance(result, sw.results.LoopRun):
        items = {}  # a loop that grows has no number from some sample on
    elif isinstance(result, Result):
        items = {
            k: v
            for k, v in vars(result).items()
            if not k.startswith("jump_") and k not in NONE.get(type(result).__name__, ())
        }  # none where the curve has none
    else:
        items = result if isinstance(result, Mapping) else {}
    return (
        set().union(*(nan_in(item, depth + 1, f"{place}.{name}") for name, item in items.items()))
        if depth < 4
        else set()
    )


def answer(function, arguments, seconds):
    """What a call answers ("result", "sentence" or "late"), and what is unsound about it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("error", np.exceptions.ComplexWarning)
        try:
            with within(seconds):
                result = function(**arguments)
                text = str(result)
        except Late:
            return "late", ""
        except Exception as error:
            return "sentence", fault(error)
    return "result", "no text" if not text else ", ".join(sorted(f"NaN in {place}" for place in nan_in(result))[:3])
