"""What a kernel does with addresses: read a model from its words, write numbers, call a function by its address.

`jit.entry` gives the address of a function whose first argument is the address of the words of a model (`address`); in
that function `at` makes the model of them again. An exception in a called function is one of the kernel. The bodies in
compiled code are definitions of intrinsics of Numba: `typed_...` gives the types of a call, and its `build` writes the
code.
"""

from importlib import import_module
from itertools import count as counting
from typing import Any

from .tree import leaves, rebuilt

VECTOR, MATRIX, POINTER = "vector", "matrix", "pointer"  # arguments of an entry: contiguous arrays of floats


def at(address: Any) -> Any:
    """Model, array or tuple whose words are at an address."""
    return address


def put_at(address: Any, numbers: Any) -> None:
    """Write a tuple of floats, at any depth, to an address."""
    for i, number in enumerate(leaves(numbers)):
        address[i] = number


def pointer(array: Any) -> Any:
    """Address of the first entry of an array of floats, for a function that takes a pointer; of a pointer itself."""
    return array


def beyond(address: Any, i: Any) -> Any:
    """Pointer to entry number i from a pointer."""
    return address[i:]


def call(address: Any, words: Any, arguments: Any) -> None:
    """Run the function at an address with the address of the words of its first argument, and a tuple of the others."""
    raise NotImplementedError("only machine code calls by address")


def value(address: Any, words: Any, arguments: Any) -> float:
    """Return the float of the function at an address; arguments as of `call`."""
    raise NotImplementedError("only machine code calls by address")


def answer(address: Any, words: Any, phase: Any, y: Any) -> Any:
    """Return the tuple, as long as y, that the function at an address writes to its last argument, a pointer.

    Its arguments are the address of the words, a number, and pointers to y and to the tuple.
    """
    raise NotImplementedError("only machine code calls by address")


def signature(types: Any, thing: Any, kinds: tuple[Any, ...]) -> tuple[Any, ...]:
    """Types of the compiler for the arguments of an entry: its model (a type), and what `jit.entry` takes as kinds."""
    real = types.float64
    by_kind = {float: real, int: types.int64, VECTOR: types.Array(real, 1, "C"), MATRIX: types.Array(real, 2, "C")}
    by_kind |= {POINTER: types.CPointer(real)}
    pointers = (types.CPointer(types.UniTuple(real, kind)) if type(kind) is int else by_kind[kind] for kind in kinds)
    return types.CPointer(thing), *pointers


def bodies(types: Any) -> dict[Any, Any]:
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

    return {at: typed_at, put_at: typed_put, pointer: typed_pointer, beyond: typed_beyond, **_calls(types)}


def _calls(types: Any) -> dict[Any, Any]:
    """Bodies in compiled code of `call`, `value` and `answer`."""

    def caller(result: Any) -> Any:
        def typed(context: Any, address: Any, words: Any, arguments: Any) -> Any:
            def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                return _call(types, context, builder, result, arguments, *values)

            return result(types.intp, types.intp, arguments), build

        return typed

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

    return {call: caller(types.none), value: caller(types.float64), answer: typed_answer}


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
    """Code that reads words one after the other, from a pointer to the first."""

    def __init__(self, context: Any, types: Any, builder: Any, pointer: Any) -> None:
        self.context, self.types, self.builder, self.next = context, types, builder, 0
        self.words = builder.bitcast(pointer, context.get_value_type(types.int64).as_pointer())

    def word(self) -> Any:
        """The next word, an integer of 64 bits."""
        index = self.context.get_constant(self.types.intp, self.next)
        self.next += 1
        return self.builder.load(self.builder.gep(self.words, [index]))

    def thing(self, kind: Any) -> Any:
        """What the next words hold, of a type of the compiler."""
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
        """Array of the next words: its address, then its shape."""
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
