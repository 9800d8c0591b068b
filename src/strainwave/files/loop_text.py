"""The author's project file with another loop of its motor: all else stays as it was written."""

from typing import Any

from ..base.quantities import is_model
from ..model.train.filters import apart
from .fields import groups
from .fields.entries import Loop
from .fields.kinds import Place
from .fields.rows import rows_of
from .variants.names import quantity

BY_BANDWIDTH = ("bandwidth", "damping")


def with_loop(text: str, control: Any) -> str | None:
    """Write a control into the loop of a project file; None where the file has no loop as a group of fields.

    Gains have the author's units. Those that a file gives by a bandwidth take its place.
    """
    from ruamel.yaml import YAML

    root = YAML(typ="safe", pure=True).compose(text)
    loop = _of(_of(root, "motor"), "loop")
    if loop is None or loop.id != "mapping":
        return None
    core, about = apart(control)
    kept = tuple(f"motor.loop.{name}" for name in about)
    sources = _of(root, "sources")
    changes = [
        (_span(value), groups.YOURS)
        for name, value in (sources.value if sources is not None and sources.id == "mapping" else ())
        if name.value.startswith("motor.loop") and not name.value.startswith(kept)
    ]
    if "filters" in about and _of(loop, "filters") is None:
        changes.append((_span(loop), Loop().text(control)))
    elif any(_of(loop, key) for key in BY_BANDWIDTH):
        changes += _gains(text, loop, core)
    else:
        kinds = _kinds(core)
        pairs = [(key.value, value) for key, value in loop.value if key.value in core._fields]
        changes += [(_span(value), _in_unit(kinds[n], getattr(core, n), value.value)) for n, value in pairs]
    for (begin, end), new in sorted(changes, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def _gains(text: str, loop: Any, core: Any) -> list[tuple[tuple[int, int], str]]:
    """Changes that put gains where a bandwidth and its damping are."""
    given = [pair for pair in loop.value if pair[0].value in BY_BANDWIDTH]
    newline = "\r\n" if "\r\n" in text else "\n"
    between = ", " if loop.flow_style else newline + " " * given[0][0].start_mark.column
    kinds = _kinds(core)
    gains = [f"{n}: {kinds[n].text(v)}" for n, v in core._asdict().items() if v and not is_model(v)]
    if _of(loop, "type") is None:
        gains.insert(0, Loop().text(core).lstrip("{").partition(",")[0])
    shares = [gains] if len(given) == 1 else [gains[:-1], gains[-1:]]
    spans = [(key.start_mark.index, value.end_mark.index) for key, value in given]
    return [(span, between.join(share)) for span, share in zip(spans, shares, strict=True)]


def _kinds(core: Any) -> dict[str, Any]:
    """How each gain of a loop is written."""
    cls: Any = type(core)
    return {name: row.kind for name, row in rows_of(cls).items()}


def _in_unit(kind: Any, value: Any, given: str) -> str:
    """A number in the unit that a text has, where it reads as the same number; else in SI."""
    unit = quantity(given)[1]
    scale: Any = unit and kind.read(f"1 {unit}", Place((), []))
    for digits in (12, 17) if scale else ():
        if kind.read(written := f"{value / scale:.{digits}g} {unit}", Place((), [])) == value:
            return written
    return str(kind.text(value))


def _of(node: Any, key: str) -> Any:
    """Value of a key of a mapping of YAML; None where there is none."""
    pairs = node.value if node is not None and node.id == "mapping" else ()
    return next((value for name, value in pairs if name.value == key), None)


def _span(node: Any) -> tuple[int, int]:
    return node.start_mark.index, node.end_mark.index
