"""The author's project file with another loop of its motor: all else stays as it was written."""

import re
from collections.abc import Collection, Iterator
from typing import Any

from ..base.quantities import is_model
from ..model.train.filters import apart
from .fields import groups
from .fields.entries import FILTERED, Loop
from .fields.kinds import Place
from .fields.rows import rows_of
from .variants.names import quantity

BY_BANDWIDTH = ("bandwidth", "damping")
Change = tuple[tuple[int, int], str]  # a span of the text, and what comes in its place


def with_loop(text: str, control: Any) -> str | None:
    """Write a control into the loop of a project file; None where the file has no loop as a group of fields.

    Gains have the author's units. Those that a file gives by a bandwidth take its place; its scatter goes with it. A
    filter more stands behind the others.
    """
    from ruamel.yaml import YAML

    root = YAML(typ="safe", pure=True).compose(text)
    loop = _of(_of(root, "motor"), "loop")
    if loop is None or loop.id != "mapping":
        return None
    core, about = apart(control)
    kept = tuple(f"motor.loop.{name}" for name in about)
    changes = [
        (_span(text, value), groups.YOURS)
        for name, value in _pairs(_of(root, "sources"))
        if name.value.startswith("motor.loop") and not name.value.startswith(kept)
    ]
    if any(_of(loop, key) for key in BY_BANDWIDTH):
        changes += [*_gains(text, loop, core), *_without_scatter(text, root)]
    else:
        pairs = [(_kinds(core)[key.value], getattr(core, key.value), value) for key, value in loop.value
                 if key.value in core._fields]  # fmt: skip
        changes += [
            (_span(text, value), _in_unit(kind, gain, value.value))
            for kind, gain, value in pairs
            if kind.read(value.value, Place((), [])) != gain
        ]
    changes += _more_filters(text, loop, about.get("filters", ()))
    for (begin, end), new in sorted(changes, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def _gains(text: str, loop: Any, core: Any) -> list[Change]:
    """Changes that put gains where a bandwidth and its damping are."""
    given = [pair for pair in loop.value if pair[0].value in BY_BANDWIDTH]
    between = ", " if loop.flow_style else _newline(text) + " " * given[0][0].start_mark.column
    kinds = _kinds(core)
    gains = [f"{n}: {kinds[n].text(v)}" for n, v in core._asdict().items() if v and not is_model(v)]
    if _of(loop, "type") is None:
        gains.insert(0, Loop().text(core).lstrip("{").partition(",")[0])
    shares = [gains] if len(given) == 1 else [gains[:-1], gains[-1:]]
    spans = [_span(text, *pair) for pair in given]
    return [(span, between.join(share)) for span, share in zip(spans, shares, strict=True)]


def _more_filters(text: str, loop: Any, filters: tuple[Any, ...]) -> Iterator[Change]:
    """The change that puts those of the filters that the file does not have behind the last of them, or of all."""
    there = _of(loop, "filters")
    more = [FILTERED.text((one,))[1:-1] for one in filters[len(there.value) if there else 0 :]]
    if not more:
        return
    beside = there or loop
    items = more if there else [f"filters: [{', '.join(more)}]"]
    at = _span(text, *_items(beside)[-1])[1]
    before = ", "
    if not beside.flow_style:
        at = re.compile(r"[^\r\n]*").match(text, at).end()  # type: ignore[union-attr]
        before = _newline(text) + " " * beside.start_mark.column + "- " * bool(there)
    yield (at, at), "".join(before + item for item in items)


def _without_scatter(text: str, root: Any) -> Iterator[Change]:
    """Changes that take the bandwidth and its damping out of the scatter and its correlation."""
    names = [name.value.removeprefix("motor.loop.").removeprefix("loop.") for name, _ in _pairs(_of(root, "scatter"))]
    gone = [i for i, name in enumerate(names) if name in BY_BANDWIDTH]
    if gone and len(gone) == len(names):
        top = [key.value for key, _ in root.value]
        yield from _without(text, root, [top.index(key) for key in ("scatter", "scatter_correlation") if key in top])
    elif gone:
        table = _of(root, "scatter_correlation")
        kept = [] if table is None else [row for i, row in enumerate(table.value) if i not in gone]
        for node in filter(None, (_of(root, "scatter"), table, *kept)):
            yield from _without(text, node, gone)


def _without(text: str, node: Any, gone: Collection[int]) -> Iterator[Change]:
    """Changes that take some items out of a list or a group, with the comments beside them."""
    spans = [_span(text, *item) for item in _items(node)]
    first = next(i for i in range(len(spans)) if i not in gone)
    for i in gone:
        begin, end = spans[i]
        if not node.flow_style:
            begin, end = text.rfind("\n", 0, begin) + 1, text.find("\n", end) + 1 or len(text)
        elif i < first:
            end = spans[i + 1][0]
        else:
            begin = spans[i - 1][1]
        yield (begin, end), ""


def _kinds(core: Any) -> dict[str, Any]:
    """How each gain of a loop is written."""
    cls: Any = type(core)
    return {name: row.kind for name, row in rows_of(cls).items()}


def _in_unit(kind: Any, value: float, given: str) -> str:
    """A number in the unit that a text has: to ten digits, and as it is where this unit is that of SI."""
    unit = quantity(given)[1]
    scale = kind.read(f"1 {unit}", Place((), []))
    written = f"{value / scale:.10g}"
    return f"{written if scale != 1.0 or float(written) == value else repr(value)} {unit}"


def _of(node: Any, key: str) -> Any:
    """Value of a key of a mapping of YAML; None where there is none."""
    return next((value for name, value in _pairs(node) if name.value == key), None)


def _pairs(node: Any) -> Any:
    return node.value if node is not None and node.id == "mapping" else ()


def _items(node: Any) -> list[Any]:
    """Items of a list or a group, each as its nodes in a row."""
    return [item if node.id == "mapping" else (item,) for item in node.value]


def _span(text: str, *nodes: Any) -> tuple[int, int]:
    """Where nodes that follow each other begin, and where the last line of the last has its last letter."""
    begin, last = nodes[0].start_mark.index, nodes[-1]
    while last.id != "scalar" and not last.flow_style:
        last = _items(last)[-1][-1]
    return begin, len(text[: last.end_mark.index].rstrip())


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
