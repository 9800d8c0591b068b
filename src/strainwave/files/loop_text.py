"""The author's project file with another loop of its motor: all else stays as it was written."""

import re
from collections.abc import Collection, Iterator
from typing import Any

from ..base.quantities import is_model
from ..model.train.filters import apart
from .fields import groups
from .fields.entries import FILTERED, Loop
from .fields.kinds import Entry
from .fields.rows import rows_of
from .variants.names import quantity

BY_BANDWIDTH = ("bandwidth", "damping")
Change = tuple[tuple[int, int], str]  # a span of the text, and what comes in its place


def with_loop(text: str, control: Any) -> str | None:
    """Write a control into the loop of a project file; None where the file has no loop as a group of fields.

    Gains keep the author's units. Where the file gives bandwidth and damping, the gains replace these, and the scatter
    of these is deleted. Further filters are appended.
    """
    from ruamel.yaml import YAML

    root = YAML(typ="safe", pure=True).compose(text)
    loop = _of(_of(root, "motor"), "loop")
    if loop is None or loop.id != "mapping":
        return None
    core, about = apart(control)
    kept, kinds = tuple(f"motor.loop.{name}" for name in about), {n: r.kind for n, r in rows_of(core.__class__).items()}
    named = [(name.value, value) for name, value in _pairs(_of(root, "sources")) if not name.value.startswith(kept)]
    changes = [(_span(text, value), groups.YOURS) for name, value in named if name.startswith("motor.loop")]
    if any(_of(loop, key) for key in BY_BANDWIDTH):
        changes += [*_gains(text, loop, core, kinds), *_without_scatter(text, root)]
    else:
        for key, value in loop.value:
            gain = getattr(core, key.value, None)
            if gain is not None and kinds[key.value].read(value.value, Entry((), [])) != gain:
                changes.append((_span(text, value), _in_unit(kinds[key.value], gain, value.value)))
    changes += _more_filters(text, loop, about.get("filters", ()))
    for (begin, end), new in sorted(changes, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def by_bandwidth(name: str) -> bool:
    """True for the bandwidth of a loop and its damping, by the name of the number."""
    return name.rpartition("loop.")[1:] in [("loop.", key) for key in BY_BANDWIDTH]


def _gains(text: str, loop: Any, core: Any, kinds: dict[str, Any]) -> list[Change]:
    """Changes that put gains where a bandwidth and its damping are."""
    given = [pair for pair in loop.value if pair[0].value in BY_BANDWIDTH]
    between = ", " if loop.flow_style else _newline(text) + " " * given[0][0].start_mark.column
    gains = [f"{n}: {kinds[n].text(v)}" for n, v in core._asdict().items() if v and not is_model(v)]
    if _of(loop, "type") is None:
        gains.insert(0, Loop().text(core).lstrip("{").partition(",")[0])
    shares = [gains] if len(given) == 1 else [gains[:-1], gains[-1:]]
    spans = [_span(text, *pair) for pair in given]
    return [(span, between.join(share)) for span, share in zip(spans, shares, strict=True)]


def _more_filters(text: str, loop: Any, filters: tuple[Any, ...]) -> Iterator[Change]:
    """The change that puts those of the filters that the file does not have behind the last of them, or of all."""
    present = _of(loop, "filters")
    more = [FILTERED.text((one,))[1:-1] for one in filters[len(present.value) if present else 0 :]]
    if not more:
        return
    beside, items = (present, more) if present else (loop, [f"filters: [{', '.join(more)}]"])
    end, before = _span(text, *_items(beside)[-1])[1], ", "
    if not beside.flow_style:
        end = re.compile(r"[^\r\n]*").match(text, end).end()  # type: ignore[union-attr]
        before = _newline(text) + " " * beside.start_mark.column + "- " * bool(present)
    yield (end, end), "".join(before + item for item in items)


def _without_scatter(text: str, root: Any) -> Iterator[Change]:
    """Changes that take the bandwidth and its damping out of the scatter and its correlation."""
    scatter, table = _of(root, "scatter"), _of(root, "scatter_correlation")
    gone = [i for i, (name, _) in enumerate(_pairs(scatter)) if by_bandwidth(name.value)]
    if gone and len(gone) == len(scatter.value):
        yield from _without(text, root, [i for i, (_, value) in enumerate(root.value) if value in (scatter, table)])
    elif gone:
        rows = [row for i, row in enumerate(table.value) if i not in gone] if table else []
        for node in filter(None, (scatter, table, *rows)):
            yield from _without(text, node, gone)


def _without(text: str, node: Any, gone: Collection[int]) -> Iterator[Change]:
    """Changes that take some items out of a list or a group, with the comments beside them."""
    spans = [_span(text, *item) for item in _items(node)]
    first = next(i for i in range(len(spans)) if i not in gone)
    for i in gone:
        begin, end = spans[i]
        if node.flow_style:
            begin, end = (begin, spans[i + 1][0]) if i < first else (spans[i - 1][1], end)
        else:
            begin, end = text.rfind("\n", 0, begin) + 1, text.find("\n", end) + 1 or len(text)
        yield (begin, end), ""


def _in_unit(kind: Any, value: float, given: str) -> str:
    """A number in the unit that a text has: to ten digits, and as it is where this unit is that of SI."""
    unit = quantity(given)[1]
    scale = kind.read(f"1 {unit}", Entry((), []))
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
    """Begin of the first of consecutive nodes, and end of the last letter of the last one, as indices of the text."""
    last = nodes[-1]
    while last.id != "scalar" and not last.flow_style:
        last = _items(last)[-1][-1]
    return nodes[0].start_mark.index, len(text[: last.end_mark.index].rstrip())


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
