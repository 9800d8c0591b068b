"""Numbers that record what is done to them: a model's methods, run once with these, give their operations in C.

The methods stay the only place where an equation is written. Arithmetic, `abs`, comparisons (0 or 1) and the functions
of `strainwave.maths` and NumPy record one line each, in order; equal lines are recorded once, and what a result does
not need is left out. Products with 0 and 1 and sums with 0 are not recorded. A branch on a value is refused. What
parameters alone decide is computed in a part of its own, and a branch on it fixes them (`parameters`).
"""

import math
import sys
from numbers import Real
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

FUNCTIONS = {
    "sin": "sin", "cos": "cos", "tan": "tan", "exp": "exp", "expm1": "expm1", "log": "log", "log1p": "log1p",
    "tanh": "tanh", "sinh": "sinh", "cosh": "cosh", "sqrt": "sqrt", "cbrt": "cbrt", "absolute": "fabs", "fabs": "fabs",
    "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "hypot": "hypot", "power": "pow",
    "floor": "floor", "ceil": "ceil", "rint": "rint", "trunc": "trunc", "copysign": "copysign", "fmod": "fmod",
}  # fmt: skip
FORMS = {
    "add": "{} + {}", "subtract": "{} - {}", "multiply": "{} * {}", "divide": "{} / {}", "negative": "-{}",
    "sign": "(double)(({0} > 0.0) - ({0} < 0.0))", "square": "{0} * {0}",
    "less": "(double)({} < {})", "less_equal": "(double)({} <= {})", "greater": "(double)({} > {})",
    "greater_equal": "(double)({} >= {})", "equal": "(double)({} == {})", "not_equal": "(double)({} != {})",
    "logical_and": "(double)({} != 0.0 && {} != 0.0)", "logical_or": "(double)({} != 0.0 || {} != 0.0)",
    "logical_not": "(double)({} == 0.0)", "isnan": "(double)({0} != {0})",
    "maximum": "({0} >= {1} || {0} != {0}) ? {0} : {1}", "minimum": "({0} <= {1} || {0} != {0}) ? {0} : {1}",
    "where": "({} != 0.0) ? {} : {}",
} | {name: f"{c}({{}}, {{}})" if name in ("arctan2", "hypot", "power", "copysign", "fmod") else f"{c}({{}})"
     for name, c in FUNCTIONS.items()}  # fmt: skip
FORMS |= {"bitwise_and": FORMS["logical_and"], "bitwise_or": FORMS["logical_or"], "invert": FORMS["logical_not"]}
BETWEEN = (__name__, NDArrayOperatorsMixin.__module__)  # modules between a model and what refuses its operation
REMEDY = (
    "it is run once to record its operations; write it without branches, with abs, comparisons times numbers and the "
    "functions of strainwave.maths"
)


class Unrecordable(TypeError):
    """An operation that cannot be recorded; the message says which and where."""


class Decided(Exception):
    """A branch on parameters alone: they cannot change in the code; `names` are theirs."""

    def __init__(self, names: frozenset[str]) -> None:
        super().__init__(names)
        self.names = names


class Line(NamedTuple):
    """A recorded line: C text with the name it defines, the names that it needs, and whether parameters decide it."""

    text: str
    needs: tuple[str, ...]
    early: bool = False


class Recording:
    """Operations in order, each by the name of its result."""

    def __init__(self) -> None:
        self.lines: dict[str, Line] = {}
        self._known: dict[str, Traced] = {}

    def given(self, text: str) -> "Traced":
        """Number that the C code has under a name, or as an expression, already."""
        return Traced(self, text, "")

    def parameter(self, name: str) -> "Traced":
        """Parameter of this name."""
        return Traced(self, f"p->{name}", "", frozenset({name}))

    def value(self, form: str, *arguments: Any) -> "Traced":
        """Number that a C expression of others gives; the same one for the same expression."""
        expression = form.format(*map(literal, arguments))
        if expression not in self._known:
            name = f"a{len(self.lines)}"
            deciding = _deciding(arguments)
            self.lines[name] = Line(f"const double {name} = {expression};", _names(arguments), bool(deciding))
            self._known[expression] = Traced(self, name, name, deciding)
        return self._known[expression]

    def array(self, items: tuple[Any, ...]) -> "Traced":
        """C array of these numbers, defined once for equal ones."""
        values = ", ".join(map(literal, items))
        if values not in self._known:
            name = f"t{len(self.lines)}"
            self.lines[name] = Line(f"const double {name}[] = {{{values}}};", _names(items))
            self._known[values] = Traced(self, name, name)
        return self._known[values]

    def called(self, function: str, arguments: tuple[Any, ...], count: int) -> tuple["Traced", ...]:
        """As many numbers as a C function gives: its text has a {0} for the arguments and a {1} for the results."""
        name = f"k{len(self.lines)}"
        values = f"(const double[]){{{', '.join(map(literal, arguments))}}}"
        text = f"double {name}[{count}];\n{function.format(values, name)};"
        self.lines[name] = Line(text, _names(arguments))
        return tuple(Traced(self, f"{name}[{i}]", name) for i in range(count))

    def code(self, results: tuple[Any, ...]) -> list[str]:
        """Lines of C that the results need, in order."""
        return [part for line in self._needed(results).values() for part in line.text.split("\n")]

    def early_and_late(self, results: tuple[Any, ...]) -> tuple[list[str], list[str]]:
        """Lines that the results need: those that parameters decide, which fill an array c, and those that read it."""
        needed = self._needed(results)
        late = {name: line for name, line in needed.items() if not line.early}
        taken = {*_names(results), *(name for line in late.values() for name in line.needs)} - late.keys()
        kept = [name for name in needed if name in taken]
        filled = [line.text for line in needed.values() if line.early]
        filled += [f"c[{i}] = {name};" for i, name in enumerate(kept)]
        read = [f"const double {name} = c[{i}];" for i, name in enumerate(kept)]
        return filled, read + [part for line in late.values() for part in line.text.split("\n")]

    def _needed(self, results: tuple[Any, ...]) -> dict[str, Line]:
        """Lines that the results need, by the names that they define, in order."""
        needed, waiting = set[str](), list(_names(results))
        while waiting:
            name = waiting.pop()
            if name not in needed:
                needed.add(name)
                waiting += self.lines[name].needs
        return {name: line for name, line in self.lines.items() if name in needed}

    @staticmethod
    def stored(targets: list[str], values: tuple[Any, ...]) -> list[str]:
        """Lines of C that store values in variables."""
        return [f"{target} = {literal(value)};" for target, value in zip(targets, values, strict=True)]


class Traced(NDArrayOperatorsMixin):
    """A recorded number: its name in C, the line that defines it, and the parameters that alone decide it, if any."""

    __slots__ = ("line", "parameters", "recording", "text")
    __hash__ = object.__hash__

    def __init__(self, recording: Recording, text: str, line: str, parameters: frozenset[str] = frozenset()) -> None:
        self.recording, self.text, self.line, self.parameters = recording, text, line, parameters

    def _recorded(self, name: str, *arguments: Any) -> Any:
        if any(isinstance(argument, np.ndarray) and argument.ndim for argument in arguments):
            _refuse("puts a value into an array", *arguments)
        if not all(isinstance(argument, Traced | Real | np.bool_) for argument in arguments):
            return NotImplemented
        simple = _simplified(name, arguments)
        return self.recording.value(FORMS[name], *arguments) if simple is None else simple

    def __array_ufunc__(self, ufunc: Any, method: str, *arguments: Any, **options: Any) -> Any:
        """Record a function of NumPy."""
        arguments = tuple(a.item() if isinstance(a, np.ndarray) and a.ndim == 0 else a for a in arguments)
        kept = isinstance(options.pop("out", (self,))[0], Traced)  # of x += y, not of an array
        if method != "__call__" or options or not kept or ufunc.__name__ not in FORMS:
            _refuse(f"calls numpy.{ufunc.__name__}, which C code does not have", *arguments)
        return self._recorded(ufunc.__name__, *arguments)

    def __array_function__(self, function: Any, _types: object, arguments: Any, options: Any) -> Any:
        """Record the choice of `numpy.where`."""
        if function is not np.where or len(arguments) != 3 or options:
            _refuse(f"calls numpy.{function.__name__}, which C code does not have", *arguments)
        condition, a, b = arguments
        return self._recorded("where", *arguments) if isinstance(condition, Traced) else (a if condition else b)

    def entry(self, items: tuple[Any, ...]) -> Any:
        """Number at this place in a tuple."""
        return self.recording.value("{}[(int){}]", self.recording.array(items), self)

    def with_entry(self, items: tuple[Any, ...], value: object) -> tuple[Any, ...]:
        """The tuple with another number at this place."""
        return tuple(self._recorded("where", self == float(k), value, item) for k, item in enumerate(items))

    def __pos__(self) -> Any:
        return self

    def __eq__(self, other: object) -> Any:  # unlike NumPy's, it answers for what is no number, too
        return self._recorded("equal", self, other)

    def __ne__(self, other: object) -> Any:
        return self._recorded("not_equal", self, other)

    def __bool__(self) -> bool:
        _refuse("branches on a value (if, and, or, min or max)", self)

    def __float__(self) -> float:
        _refuse("turns a value into a float (float or the module math)", self)

    def __mod__(self, other: Any) -> Any:
        _refuse("takes a remainder", self, other)

    __rmod__ = __floordiv__ = __rfloordiv__ = __mod__

    def __index__(self) -> int:
        _refuse("takes a value as a whole number", self)

    def __repr__(self) -> str:
        return f"Traced({self.text})"


def _refuse(action: str, *values: Any) -> NoReturn:
    """Refuse an operation of the function that called this module; one on parameters alone decides them."""
    names = _deciding(values)
    if names:
        raise Decided(names)
    frame = sys._getframe(1)
    while frame.f_globals.get("__name__") in BETWEEN and frame.f_back is not None:
        frame = frame.f_back
    raise Unrecordable(f"{frame.f_code.co_qualname} {action} in line {frame.f_lineno}: {REMEDY}")


def _simplified(name: str, arguments: tuple[Any, ...]) -> Any:
    """Result of an operation with 0 or 1 that leaves nothing to compute, or None."""
    a, b = arguments[0], arguments[-1]
    zeros, by_one = [not isinstance(n, Traced) and n == 0.0 for n in (a, b)], not isinstance(b, Traced) and b == 1.0
    if name == "multiply":
        if any(zeros):
            return 0.0
        return b if not isinstance(a, Traced) and a == 1.0 else (a if by_one else None)
    if name == "add" and any(zeros):
        return b if zeros[0] else a
    if name == "subtract" and zeros[1]:
        return a
    if name == "divide" and (by_one or zeros[0]):
        return a if by_one else 0.0
    return None


def _deciding(values: tuple[Any, ...]) -> frozenset[str]:
    """Parameters that alone decide values; none if something else does too, or nothing recorded."""
    deciding = [value.parameters for value in _recorded_in(values)]
    return frozenset().union(*deciding) if all(deciding) else frozenset()


def _recorded_in(values: tuple[Any, ...]) -> list[Traced]:
    """Recorded numbers among values, those in arrays too."""
    items = (item for value in values for item in (value.flat if isinstance(value, np.ndarray) else (value,)))
    return [item for item in items if isinstance(item, Traced)]


def _names(arguments: tuple[Any, ...]) -> tuple[str, ...]:
    """Names of the lines that define recorded numbers."""
    return tuple(a.line for a in arguments if isinstance(a, Traced) and a.line)


def literal(value: Any) -> str:
    """C text of a number, equal to the bit."""
    if isinstance(value, Traced):
        return value.text
    number = float(value)
    if not math.isfinite(number):
        return "NAN" if math.isnan(number) else f"{'-' if number < 0.0 else ''}INFINITY"
    return repr(number) if math.copysign(1.0, number) > 0.0 else f"({number!r})"
