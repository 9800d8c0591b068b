"""JSON: the canonical file of an order table, equal to the bit when read back."""

import json
from dataclasses import dataclass
from typing import Any, ClassVar

from ....base.quantities import shown
from ....model.excitation import Line
from ..content import OrderContent
from ..format import Exact, Held
from ..points import MARK, Unfit

VERSION = 1
PLAIN = ("unit", "turn", "ratio", "zero", "sign", "direction", "mean", "mean_backward", "delay", "load", "source")


@dataclass(frozen=True)
class JsonFile(Exact):
    """JSON with every field of the table; amplitudes 0-to-peak, phases in rad."""

    name: ClassVar[str] = "json"
    title: ClassVar[str] = "JSON"
    own_sign: ClassVar[bool] = True
    both_ways: ClassVar[bool] = True
    with_delay: ClassVar[bool] = True
    begin: ClassVar[str] = r"\s*\{"

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write the fields, lines last."""
        data: dict[str, Any] = {"format": MARK, "version": VERSION}
        data |= {name: getattr(table, name) for name in PLAIN}
        data["speeds"] = None if table.speeds is None else list(table.speeds)
        for name, lines in (("lines", table.lines), ("backward", table.backward)):
            data[name] = None if lines is None else [line._asdict() for line in lines]
        return json.dumps(data, indent=2, allow_nan=False) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the fields."""
        try:
            data = json.loads(text, parse_constant=_refused)
        except json.JSONDecodeError as error:
            raise Unfit(error.lineno, "file", f"is no whole JSON ({error.msg}); save the table again") from None
        except (ValueError, RecursionError) as error:
            raise Unfit(1, "file", f"is no order table ({' '.join(str(error).split())[:100]}); save it again") from None
        if not isinstance(data, dict) or data.get("format") != MARK:
            raise Unfit(1, "format", f"is not {MARK!r}; save an order table with write(path, format='json')")
        if data.get("version") != VERSION:
            raise Unfit(1, "version", f"is {shown(data.get('version'))}; this version of strainwave reads {VERSION}")
        known = {"format", "version", "speeds", "lines", "backward", *PLAIN}
        if strange := sorted(set(data) - known):
            raise Unfit(1, strange[0][:40], f"is not a field of an order table; it has {', '.join(sorted(known))}")
        fields = {name: data[name] for name in PLAIN if name in data}
        speeds = data.get("speeds")
        return OrderContent(
            lines=_lines(data.get("lines"), "lines"),
            backward=None if data.get("backward") is None else _lines(data["backward"], "backward"),
            speeds=tuple(speeds) if isinstance(speeds, list) else speeds,
            **fields,
        )


def _refused(constant: str) -> None:
    raise ValueError(f"{constant} is no finite number")


def _lines(data: object, name: str) -> tuple[Line, ...]:
    if not isinstance(data, list):
        raise Unfit(1, name, f"are {shown(data)}; write a list of {{'order', 'amplitude', 'phase'}}")
    for line in data:
        if not isinstance(line, dict) or set(line) != {"order", "amplitude", "phase"}:
            raise Unfit(1, name, f"hold {shown(line)}; write order, amplitude and phase of every line")
    return tuple(Line(**line) for line in data)
