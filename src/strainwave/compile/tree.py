"""A model is a tree of numbers: a NamedTuple whose fields are numbers, other models, and tuples of these.

Its leaves are its floats, at any depth, in the order of the fields. An array in the place of a float stands for as many
variants of the model. Integers (orders, exponents) are no leaves: all variants share them. What counts, lists, changes
or rebuilds the numbers of a model does so here, so that all agree on their order; compiled code walks by `rebuilt`.

Tuples of numbers of any length: states, rates of states, and what is made of them. Compiled code has them number by
number: a loop or a recursion over a tuple, which comes to the same, would take the compiler many times as long.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import count as counting
from numbers import Integral
from typing import Any

LONGEST_VALUE = 60  # characters of a value in a sentence


def is_model(thing: Any) -> bool:
    """True for a model, that is, an instance of a NamedTuple class."""
    return isinstance(thing, tuple) and hasattr(thing, "_fields")


def made(template: Any, items: Iterable[Any]) -> Any:
    """Model or tuple of the kind of another one, from its items."""
    kind: Any = type(template)
    return kind(*items) if hasattr(template, "_fields") else tuple(items)


def leaves(thing: Any) -> list[Any]:
    """Floats, or arrays of them, of a number, a model or a tuple."""
    if isinstance(thing, tuple):
        return [leaf for item in thing for leaf in leaves(item)]
    return [] if isinstance(thing, Integral) else [thing]


def count(thing: Any) -> int:
    """Number of floats in a model or a tuple."""
    if isinstance(thing, tuple):
        return sum(map(count, thing))
    return int(isinstance(thing, float))


def mapped(function: Callable[..., Any], *things: Any) -> Any:
    """Model or tuple whose leaves are a function of the leaves of one or several; integers are those of the first."""
    first = things[0]
    if isinstance(first, tuple):
        return made(first, [mapped(function, *items) for items in zip(*things, strict=True)])
    return first if isinstance(first, Integral) else function(*things)


def classes(things: tuple[Any, ...]) -> tuple[type, ...]:
    """Classes of the models among things, at any depth, in the order in which they are met."""
    kinds: dict[type, None] = {}
    waiting = [things]
    while waiting:
        for item in waiting.pop():
            if isinstance(item, tuple):
                waiting.append(item)
                if type(item) is not tuple:
                    kinds[type(item)] = None
    return tuple(kinds)


def numbers(model: Any, prefix: str = "") -> Iterator[tuple[str, Any, str, Any]]:
    """Every number, integers too: its path ("law.alpha", "error.lines.0.amplitude"), its owner, its name, its value."""
    names = model._fields if is_model(model) else map(str, range(len(model)))
    for name, value in zip(names, model, strict=True):
        if isinstance(value, tuple):
            yield from numbers(value, f"{prefix}{name}.")
        elif isinstance(value, float | int):
            yield prefix + name, model, name, value


def leaf_of(model: Any, path: str) -> int:
    """Place of a float among the leaves of a model, from its path.

    Raises
    ------
    ValueError
        If the path names no float.
    """
    paths = [name for name, _, _, value in numbers(model) if isinstance(value, float)]
    if path not in paths:
        raise ValueError(f"{type(model).__name__} has no continuous parameter {shown(path)}; it has {', '.join(paths)}")
    return paths.index(path)


def with_leaf(model: Any, index: int, value: Any) -> Any:
    """The model with its leaf `index` replaced."""
    return _with_leaf(model, index, value)[0]


def _with_leaf(thing: Any, index: int, value: Any) -> tuple[Any, int]:
    if not isinstance(thing, tuple):
        return (value, -1) if isinstance(thing, float) and index == 0 else (thing, index - isinstance(thing, float))
    for i, item in enumerate(thing):
        if isinstance(item, float):
            index -= 1
            if index != -1:
                continue
            new = value
        elif isinstance(item, tuple):
            new, index = _with_leaf(item, index, value)
            if new is item:
                continue
        else:
            continue
        return made(thing, (*thing[:i], new, *thing[i + 1 :])), -1
    return thing, index


def part(model: Any, path: str) -> Any:
    """The number or the model at a path; a path that does not exist is a ValueError."""
    node = model
    for key in path.split("."):
        names = _names(node)
        if key not in names:
            raise ValueError(
                f"{type(model).__name__} is no model with a part {shown(path)}; its numbers are "
                f"{', '.join(name for name, *_ in numbers(model))}"
            )
        node = node[names.index(key)]
    return node


def _names(thing: Any) -> list[str]:
    if not isinstance(thing, tuple):
        return []
    return list(getattr(thing, "_fields", map(str, range(len(thing)))))


def replaced(model: Any, path: str, value: Any) -> Any:
    """The model with the number or the model at a path replaced; a path that does not exist is a ValueError."""
    return _replaced(model, path.split("."), value, path)


def _replaced(model: Any, keys: list[str], value: Any, path: str) -> Any:
    key, inner_keys = keys[0], keys[1:]
    names = _names(model)
    if key not in names:
        raise ValueError(
            f"{type(model).__name__} has no parameter {shown(key)} (in {shown(path)}); it has "
            f"{', '.join(names) or 'none'}"
        )
    index = names.index(key)
    old = model[index]
    if inner_keys and not isinstance(old, tuple):
        raise ValueError(f"{key!r} in {shown(path)} is a number and has no parameter {shown('.'.join(inner_keys))}")
    new = _replaced(old, inner_keys, value, path) if inner_keys else value
    return made(model, (*model[:index], new, *model[index + 1 :]))


def shown(value: Any) -> str:
    """Write a value for a sentence: its repr on one line, cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 2 * LONGEST_VALUE else f"{text[:LONGEST_VALUE]}... ({len(text)} characters)"


def joined(names: Iterable[Any]) -> str:
    """Write names that a user chose for a sentence: one after the other, cut where they are long."""
    text = ", ".join(map(str, names))
    return text if len(text) <= 6 * LONGEST_VALUE else f"{text[: 6 * LONGEST_VALUE]}... ({len(text)} characters)"


def axpy(y: Any, h: Any, k: Any) -> Any:
    """Return y + h k for tuples y and k of equal length and a number h."""
    if len(y) == 2:  # the usual case, four times faster than the general one
        return y[0] + h * k[0], y[1] + h * k[1]
    return tuple(a + h * b for a, b in zip(y, k, strict=True))


def times(h: Any, k: Any) -> Any:
    """Tuple of h times the numbers of a tuple."""
    return tuple([h * b for b in k])


def alike(y: Any, value: Any) -> Any:
    """Tuple as long as y of equal values."""
    return (value,) * len(y)


def rebuilt(types: Any, context: Any, builder: Any, kind: Any, old: Any, leaf: Callable[[Any, Any], Any]) -> Any:
    """Code of the value `old` of a kind with `leaf(kind, value)` in the place of all that is no tuple."""
    if not isinstance(kind, types.BaseTuple):
        return leaf(kind, old)
    items = [rebuilt(types, context, builder, each, builder.extract_value(old, i), leaf) for i, each in enumerate(kind)]
    return context.make_tuple(builder, kind, items)


def bodies(types: Any) -> dict[Any, Any]:
    """Bodies in compiled code of functions of tuples and of `with_leaf`."""
    real = types.float64

    def made_of(like: Any, given: Any, values: Callable[..., list[Any]]) -> Any:
        """Types and code of the tuple, as long as another one, of the `values` of what is given."""

        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            def floats(kind: Any, thing: Any) -> Any:
                if isinstance(kind, types.BaseTuple):
                    return [floats(k, builder.extract_value(thing, i)) for i, k in enumerate(kind)]
                return context.cast(builder, thing, kind, real)

            numbers = values(builder, *map(floats, signature.args, arguments))
            return context.make_tuple(builder, signature.return_type, numbers)

        return types.BaseTuple.from_types([real] * len(like))(*given), build

    def typed_sums(context: Any, y: Any, h: Any, k: Any) -> Any:
        def sums(builder: Any, y: Any, h: Any, k: Any) -> list[Any]:
            return [builder.fadd(a, builder.fmul(h, b)) for a, b in zip(y, k, strict=True)]

        return made_of(y, (y, h, k), sums)

    def typed_products(context: Any, h: Any, k: Any) -> Any:
        return made_of(k, (h, k), lambda builder, h, k: [builder.fmul(h, b) for b in k])

    def typed_copies(context: Any, y: Any, value: Any) -> Any:
        return made_of(y, (y, value), lambda builder, y, value: [value] * len(y))

    def typed_set(context: Any, model: Any, index: Any, value: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            places = counting()

            def leaf(kind: Any, old: Any) -> Any:
                if not isinstance(kind, types.Float):
                    return old
                chosen = builder.icmp_signed("==", arguments[1], context.get_constant(types.intp, next(places)))
                return builder.select(chosen, arguments[2], old)

            return rebuilt(types, context, builder, model, arguments[0], leaf)

        return model(model, types.intp, real), build

    return {with_leaf: typed_set, axpy: typed_sums, times: typed_products, alike: typed_copies}
