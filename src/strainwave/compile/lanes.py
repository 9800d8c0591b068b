"""Lanes: many variants of one model in the columns of one array, whose rows are the numbers of the model.

Row `first` has the first float of the model in every lane, the next row the next one; integers are the same for all
lanes. In compiled code a number of a lane is one load with a constant stride, so that a loop over lanes with the
textbook's formulas becomes vector code. As Python the index j of a lane may be `slice(None)`: numbers are then arrays,
and the same formulas serve all lanes at once.
"""

from itertools import count as counting
from typing import Any

from .tree import count, leaves, mapped, rebuilt

LANES = 256  # lanes of a block: their rows stay in the first-level cache, the cosines of a step cost next to nothing
VECTOR_LANES = 32  # a block has a multiple of them: the widest vector, four at a time, leaves no lane over


def lane(model: Any, rows: Any, first: int, j: Any) -> Any:
    """Model (or tuple) of lane j, whose floats stand in the rows (numbers, lanes) from `first` on."""
    row = counting(first)
    return mapped(lambda _: rows[next(row), j].copy(), model)


def load(rows: Any, index: int, j: Any) -> Any:
    """Number of lane j in row `index` of rows (numbers, lanes)."""
    return rows[index, j].copy()


def store(values: Any, rows: Any, first: int, j: Any) -> None:
    """Write the floats of a number or a tuple, at any depth, to lane j of the rows (numbers, lanes) from `first` on."""
    for offset, value in enumerate(leaves(values)):
        rows[first + offset, j] = value


def _float_count(types: Any, kind: Any) -> int:
    """Number of floats in a type of the compiler."""
    if isinstance(kind, types.BaseTuple):
        return sum(_float_count(types, item) for item in kind)
    return int(isinstance(kind, types.Float))


def _address(types: Any, context: Any, builder: Any, kind: Any, rows: Any, row: Any, j: Any) -> Any:
    """Code of the address of a number in rows (numbers, LANES), whose strides are constants."""
    array = context.make_array(kind)(context, builder, rows)
    stride = context.get_constant(types.intp, LANES)
    return builder.gep(array.data, [builder.add(builder.mul(row, stride), j)])


def _for_each_float(types: Any, code: Any, result: Any) -> Any:
    """Body with the code of `code(builder, address in the rows, value)` for each float of a model or a tuple.

    `result` gives its type from that of the model: the model with what `code` returns as its floats, or nothing.
    """

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row = counting()

        def leaf(kind: Any, old: Any) -> Any:
            if not isinstance(kind, types.Float):
                return old
            index = builder.add(arguments[2], context.get_constant(types.intp, next(row)))
            address = _address(types, context, builder, signature.args[1], arguments[1], index, arguments[3])
            return code(builder, address, old)

        walked = rebuilt(types, context, builder, signature.args[0], arguments[0], leaf)
        return context.get_dummy_value() if signature.return_type == types.void else walked

    def typed(context: Any, model: Any, rows: Any, first: Any, j: Any) -> Any:
        return result(model)(model, rows, types.intp, types.intp), build

    return typed


def bodies(types: Any) -> dict[Any, Any]:
    """Bodies in compiled code of the functions above."""

    def counted(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_constant(types.intp, _float_count(types, signature.args[0]))

    def typed_count(context: Any, model: Any) -> Any:
        return types.intp(model), counted

    def written(builder: Any, address: Any, value: Any) -> Any:
        builder.store(value, address)
        return value

    def typed_load(context: Any, rows: Any, index: Any, j: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.load(_address(types, context, builder, rows, *arguments))

        return types.float64(rows, types.intp, types.intp), build

    lane_of = _for_each_float(types, lambda builder, address, _: builder.load(address), lambda kind: kind)
    store_into = _for_each_float(types, written, lambda _: types.void)
    return {lane: lane_of, store: store_into, count: typed_count, load: typed_load}
