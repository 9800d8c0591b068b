"""Models and problems by their address, so that a kernel is compiled once for all of them.

`words` are the numbers of a NamedTuple in memory: floats, integers, and arrays as address and shape, at any depth.
`jit.entry` gives the address of a function whose first argument is such memory: there `at` makes the thing of it again.
A kernel runs it by `call` or `value`, and an exception in it is one of the kernel. Addresses are arguments and never
constants: nothing on disk holds one.
"""

from collections.abc import Callable
from importlib import import_module
from itertools import count as counting
from operator import index
from typing import Any

import numpy as np

from .tree import leaves, rebuilt, shown

RECENT_OBJECTS = 16  # things whose words are kept for the next kernel
_recent: tuple[tuple["ByAddress", Any], ...] = ()

VECTOR, MATRIX = "vector", "matrix"  # kinds of arguments of an entry: contiguous arrays of floats


class ByAddress:
    """A thing for `jit.run`: to a kernel run as Python it is `thing`, to machine code what `addressed` makes of it.

    `addressed` gets a function that gives the address of the words of a thing and keeps these as long as the result is
    used; of another `ByAddress` it gives the native form. With a name in `again` it is kept for the next kernels that
    get the same thing.
    """

    def __init__(self, thing: Any, addressed: Callable[[Callable[[Any], Any]], Any], again: str = "") -> None:
        self.thing, self.addressed, self.again = thing, addressed, again
        self.owners: list[Any] = []

    def native(self) -> Any:
        """Return the form for machine code; the memory that it needs is kept as long as this object."""
        global _recent
        for recent, made in _recent:
            if self.again and recent.thing is self.thing and recent.again == self.again:
                self.owners.append(recent)
                return made

        def words(thing: Any) -> Any:
            if isinstance(thing, ByAddress):
                self.owners.append(thing)
                return thing.native()
            memory = thing if isinstance(thing, np.ndarray) else words_of(thing)
            self.owners.append((thing, memory))
            return int(memory.__array_interface__["data"][0])

        made = self.addressed(words)
        if self.again:
            _recent = (self, made), *_recent[: RECENT_OBJECTS - 1]
        return made


def at(address: Any) -> Any:
    """Thing at an address."""
    return address


def put_at(address: Any, numbers: Any) -> None:
    """Write a tuple of floats, at any depth, to an address."""
    for i, number in enumerate(leaves(numbers)):
        address[i] = number


def pointer(array: Any) -> Any:
    """Address of the first entry of an array of floats, for a function that takes a pointer; or that pointer again."""
    return array


def beyond(address: Any, i: Any) -> Any:
    """Pointer to entry number i from a pointer."""
    return address[i:]


def call(address: Any, words: Any, arguments: Any) -> None:
    """Run the function at an address with the words of its first argument and the others, a tuple."""
    raise NotImplementedError("only machine code calls by address")


def value(address: Any, words: Any, arguments: Any) -> float:
    """Float that the function at an address returns."""
    raise NotImplementedError("only machine code calls by address")


def answer(address: Any, words: Any, phase: Any, y: Any) -> Any:
    """Tuple as long as y that the function at an address writes: its arguments are a number, y and where to write."""
    raise NotImplementedError("only machine code calls by address")


def kind_of(thing: Any) -> Any:
    """Key of what `words` do not tell: the classes of models, lengths of tuples, types of numbers and arrays."""
    kind = type(thing)
    if kind is float or kind is int:
        return kind
    if isinstance(thing, tuple):
        return kind, *map(kind_of, thing)
    return (thing.dtype.str, thing.ndim) if kind is np.ndarray else kind


def words_of(thing: Any) -> Any:
    """Words (int64) of a thing; what its arrays hold is not copied: they must be contiguous and outlive it.

    Raises
    ------
    TypeError
        If it holds what is no number, array or model.
    """
    items: list[Any] = []
    _collect(thing, items)
    words = np.zeros(len(items) + 1, np.int64)
    floats = words.view(np.float64)
    for i, item in enumerate(items):
        if isinstance(item, (float, np.floating)):
            floats[i] = item
            continue
        try:
            words[i] = int(item) if isinstance(item, np.bool_) else index(item)
        except (TypeError, OverflowError):
            raise TypeError(
                f"a model holds {shown(item)}, and compiled code takes floats, whole numbers up to 2^63, tuples, "
                "models and arrays; give it as one of these, or set STRAINWAVE_JIT=0"
            ) from None
    return words


def word_of_leaf(thing: Any, leaf: int) -> int:
    """Place of a leaf of a model among its words."""
    items: list[Any] = []
    _collect(thing, items)
    return [i for i, item in enumerate(items) if isinstance(item, (float, np.floating))][leaf]


def _collect(thing: Any, items: list[Any]) -> None:
    if isinstance(thing, tuple):
        for item in thing:
            _collect(item, items)
    elif isinstance(thing, np.ndarray):
        if not thing.flags.c_contiguous:
            raise TypeError(
                f"a model holds an array of shape {thing.shape} whose numbers do not follow each other in memory, "
                "which compiled code does not take; give np.ascontiguousarray of it, or set STRAINWAVE_JIT=0"
            )
        items += [thing.__array_interface__["data"][0], *thing.shape]
    elif thing is not None:
        items.append(thing)


def signature(types: Any, thing: Any, kinds: tuple[Any, ...]) -> tuple[Any, ...]:
    """Types of the compiler for an entry's arguments: its thing (a type), and what `jit.entry` takes as kinds."""
    real = types.float64
    by_kind = {float: real, int: types.int64, VECTOR: types.Array(real, 1, "C"), MATRIX: types.Array(real, 2, "C")}
    pointers = (types.CPointer(types.UniTuple(real, kind)) if type(kind) is int else by_kind[kind] for kind in kinds)
    return types.CPointer(thing), *pointers


def bodies(types: Any, extending: Any) -> dict[Any, Any]:
    """Bodies in compiled code of the functions above."""

    def typed_at(context: Any, address: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return _Memory(context, types, builder, arguments[0]).thing(address.dtype)

        return address.dtype(address), build

    def typed_put(context: Any, address: Any, numbers: Any) -> Any:
        if not isinstance(numbers, types.BaseTuple):
            errors = import_module("numba.core.errors")
            raise errors.TypingError(f"a method returns {numbers} in place of a tuple of numbers")

        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            first = builder.bitcast(arguments[0], context.get_value_type(types.float64).as_pointer())
            index = counting()

            def put(kind: Any, number: Any) -> Any:
                slot = builder.gep(first, [context.get_constant(types.intp, next(index))])
                builder.store(context.cast(builder, number, kind, types.float64), slot)
                return number

            rebuilt(types, context, builder, numbers, arguments[1], put)
            return context.get_dummy_value()

        return types.none(address, numbers), build

    def typed_pointer(context: Any, array: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            if isinstance(array, types.CPointer):
                return arguments[0]
            if array.layout != "C":
                raise TypeError("an array is not contiguous")
            return context.make_array(array)(context, builder, arguments[0]).data

        return types.CPointer(array.dtype)(array), build

    def typed_beyond(context: Any, address: Any, i: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.gep(arguments[0], [arguments[1]])

        return address(address, types.intp), build

    take, write, first, after = map(extending.intrinsic, (typed_at, typed_put, typed_pointer, typed_beyond))
    return {
        at: lambda address: take(address),
        put_at: lambda address, numbers: write(address, numbers),
        pointer: lambda array: first(array),
        beyond: lambda address, i: after(address, i),
        **_calls(types, extending),
    }


def _calls(types: Any, extending: Any) -> dict[Any, Any]:
    """The same for the functions that call."""

    def caller(result: Any) -> Any:
        def typed(context: Any, address: Any, words: Any, arguments: Any) -> Any:
            def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                return _call(types, context, builder, result, arguments, *values)

            return result(types.intp, types.intp, arguments), build

        return extending.intrinsic(typed)

    def typed_answer(context: Any, address: Any, words: Any, phase: Any, y: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            cgutils = import_module("numba.core.cgutils")
            real, void = context.get_value_type(types.float64), context.get_value_type(types.voidptr)
            before, after = [cgutils.alloca_once(builder, real, size=len(y)) for _ in range(2)]
            entries = [builder.gep(after, [context.get_constant(types.intp, i)]) for i in range(len(y))]
            for i in range(len(y)):
                slot = builder.gep(before, [context.get_constant(types.intp, i)])
                builder.store(builder.extract_value(values[3], i), slot)
            kinds = types.Tuple((types.float64, types.voidptr, types.voidptr))
            pointers = [builder.bitcast(x, void) for x in (before, after)]
            arguments = context.make_tuple(builder, kinds, [values[2], *pointers])
            _call(types, context, builder, types.none, kinds, values[0], values[1], arguments)
            return context.make_tuple(builder, y, [builder.load(entry) for entry in entries])

        return y(types.intp, types.intp, types.float64, y), build

    send, ask, get = caller(types.none), caller(types.float64), extending.intrinsic(typed_answer)
    return {
        call: lambda address, words, arguments: send(address, words, arguments),
        value: lambda address, words, arguments: ask(address, words, arguments),
        answer: lambda address, words, phase, y: get(address, words, phase, y),
    }


def _call(
    types: Any, context: Any, builder: Any, result: Any, kinds: Any, address: Any, words: Any, arguments: Any
) -> Any:  # fmt: skip
    """Code of a call in the compiler's own convention: a slot for the result and one for an exception come first."""
    cgutils, convention = import_module("numba.core.cgutils"), context.call_conv
    kinds = (types.voidptr, *kinds)
    function = convention.get_function_type(result, kinds)
    given = [builder.inttoptr(words, context.get_value_type(types.voidptr))]
    given += [builder.extract_value(arguments, i) for i in range(len(kinds) - 1)]
    slots = [cgutils.alloca_once(builder, kind.pointee) for kind in function.args[:2]]
    flat = convention._get_arg_packer(kinds).as_arguments(builder, given)
    code = builder.call(builder.inttoptr(address, function.as_pointer()), [*slots, *flat])
    outcome = convention._get_return_status(builder, code, builder.load(slots[1]))
    with cgutils.if_unlikely(builder, outcome.is_error):
        convention.return_status_propagate(builder, outcome)
    return context.get_dummy_value() if result is types.none else builder.load(slots[0])


class _Memory:
    """Reads words one after the other."""

    def __init__(self, context: Any, types: Any, builder: Any, pointer: Any) -> None:
        self.context, self.types, self.builder, self.next = context, types, builder, 0
        self.words = builder.bitcast(pointer, context.get_value_type(types.int64).as_pointer())

    def word(self) -> Any:
        index = self.context.get_constant(self.types.intp, self.next)
        self.next += 1
        return self.builder.load(self.builder.gep(self.words, [index]))

    def thing(self, kind: Any) -> Any:
        context, builder, types = self.context, self.builder, self.types
        if isinstance(kind, types.BaseTuple):
            return context.make_tuple(builder, kind, [self.thing(item) for item in kind])
        if isinstance(kind, types.Array):
            return self.array(kind)
        if kind == types.none:
            return context.get_dummy_value()
        word = self.word()
        if isinstance(kind, types.Float):
            real = builder.bitcast(word, context.get_value_type(types.float64))
            return context.cast(builder, real, types.float64, kind)
        return context.cast(builder, word, types.int64, kind)

    def array(self, kind: Any) -> Any:
        context, builder, types = self.context, self.builder, self.types
        array = context.make_array(kind)(context, builder)
        data = builder.inttoptr(self.word(), array.data.type)
        shape = [self.word() for _ in range(kind.ndim)]
        size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        strides = [context.get_constant(types.intp, size)]
        for length in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        populate = import_module("numba.np.arrayobj").populate_array
        populate(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
        return array._getvalue()
