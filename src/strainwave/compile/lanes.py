"""Many variants of one model side by side: their numbers as rows of one buffer, a lane each.

`lane(model, rows, first, j)` is the model of lane j: every float of it, at any depth, is read from its own row, the
first of which is row `first`; integers are shared. In compiled code this is a handful of loads with a constant stride,
so that a loop over lanes with the textbook's formulas becomes vector code. As Python, `j` may be `slice(None)`: the
floats are then arrays, and the same formulas serve all lanes at once.
"""

from itertools import count as counting
from typing import Any

from .tree import count, leaves, mapped, rebuilt

LANES = 256  # lanes of a block: their rows stay in the first-level cache, the cosines of a step cost next to nothing
VECTOR_LANES = 32  # a block has a multiple of them: the widest vector, four at a time, leaves no lane over


def lane(model: Any, rows: Any, first: int, j: Any) -> Any:
    """Model (or tuple) of lane j, with its first float in row `first`."""
    row = counting(first)
    return mapped(lambda _: rows[next(row), j].copy(), model)


def load(rows: Any, index: int, j: Any) -> Any:
    """Number of lane j in row `index`."""
    return rows[index, j].copy()


def store(values: Any, rows: Any, first: int, j: Any) -> None:
    """Write the floats of a number or a tuple, at any depth, into lane j of the rows from `first`."""
    for offset, value in enumerate(leaves(values)):
        rows[first + offset, j] = value


def _floats(types: Any, kind: Any) -> int:
    if isinstance(kind, types.BaseTuple):
        return sum(_floats(types, item) for item in kind)
    return int(isinstance(kind, types.Float))


def _address(types: Any, context: Any, builder: Any, kind: Any, rows: Any, row: Any, j: Any) -> Any:
    """Address in a block of lanes, whose strides are constants."""
    array = context.make_array(kind)(context, builder, rows)
    stride = context.get_constant(types.intp, LANES)
    return builder.gep(array.data, [builder.add(builder.mul(row, stride), j)])


def _at_leaves(types: Any, extending: Any, do: Any, result: Any) -> Any:
    """Intrinsic that calls `do(builder, address in the rows, value)` for each float of a model or tuple."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row = counting()

        def leaf(kind: Any, old: Any) -> Any:
            if not isinstance(kind, types.Float):
                return old
            index = builder.add(arguments[2], context.get_constant(types.intp, next(row)))
            address = _address(types, context, builder, signature.args[1], arguments[1], index, arguments[3])
            return do(builder, address, old)

        walked = rebuilt(types, context, builder, signature.args[0], arguments[0], leaf)
        return context.get_dummy_value() if signature.return_type == types.void else walked

    def typed(context: Any, model: Any, rows: Any, first: Any, j: Any) -> Any:
        return result(model)(model, rows, types.intp, types.intp), build

    return extending.intrinsic(typed)


def bodies(types: Any, extending: Any) -> dict[Any, Any]:
    """Bodies in compiled code of the functions above."""

    def counted(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_constant(types.intp, _floats(types, signature.args[0]))

    def typed_count(context: Any, model: Any) -> Any:
        return types.intp(model), counted

    def written(builder: Any, address: Any, value: Any) -> Any:
        builder.store(value, address)
        return value

    lane_of = _at_leaves(types, extending, lambda builder, address, _: builder.load(address), lambda kind: kind)
    store_into = _at_leaves(types, extending, written, lambda _: types.void)
    count_of = extending.intrinsic(typed_count)
    return {
        lane: lambda model, rows, first, j: lane_of(model, rows, first, j),
        store: lambda values, rows, first, j: store_into(values, rows, first, j),
        count: lambda model: count_of(model),
        load: lambda rows, index, j: lane_of(0.0, rows, index, j),
    }
