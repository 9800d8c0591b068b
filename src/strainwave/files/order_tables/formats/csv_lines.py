"""CSV of lines: the canonical table, one row an order, equal to the bit when read back; order 0 is the constant."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ....base.quantities import shown
from ....model.excitation import HIGHEST, Line
from ..content import OrderContent
from ..format import Exact, Held
from ..points import MARK, Unfit, float_in, said_by, whole_in

COLUMNS = "direction,order,amplitude,phase"
END = "# end"


@dataclass(frozen=True)
class CsvLines(Exact):
    """CSV of lines with the other fields in remarks."""

    name: ClassVar[str] = "csv"
    title: ClassVar[str] = "CSV of lines"
    own_sign: ClassVar[bool] = True
    both_ways: ClassVar[bool] = True
    with_delay: ClassVar[bool] = True

    def text(self, table: OrderContent, held: Held, said: list[str]) -> str:
        """Write a row an order; amplitude in the unit of the table, phase in rad."""
        rows = [f"# {line}" for line in said]
        rows.append(COLUMNS)
        first = table.direction if table.backward is None else "forward"
        for name, mean, lines in ((first, table.mean, table.lines), ("backward", table.mean_backward, table.backward)):
            if lines is not None:
                rows.append(f"{name},0,{mean!r},0.0")
                rows += [f"{name},{line.order},{line.amplitude!r},{line.phase!r}" for line in lines]
        return "\n".join([*rows, END]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows."""
        fields, _ = said_by(text)
        sets: dict[str, list[Line]] = {}
        means: dict[str, float] = {}
        begun = False
        for number, line in enumerate(text.splitlines(), start=1):
            if not line.strip() or line.startswith("#"):
                continue
            if not begun:
                if line.strip() != COLUMNS:
                    raise Unfit(number, "file", f"has the columns {shown(line[:60])}; they must be {COLUMNS}")
                begun = True
                continue
            cells = line.split(",")
            if len(cells) != 4 or cells[0] not in ("both", "forward", "backward"):
                raise Unfit(number, "file", f"{shown(line[:60])} is no row of {COLUMNS}; correct it")
            order = whole_in(number, "order", cells[1], 0, HIGHEST)
            size, phase = float_in(number, "amplitude", cells[2]), float_in(number, "phase", cells[3])
            lines = sets.setdefault(cells[0], [])
            if order == 0:
                means[cells[0]] = size
            else:
                lines.append(Line(order, size, phase))
        if f"{MARK}: {self.name}\n" in text and not text.rstrip().endswith(END):
            raise Unfit(text.count("\n") + 1, "file", f"does not end with {END!r}; it is cut off, save the table again")
        if not sets:
            raise Unfit(1, "file", "has no rows; it may be cut off, save the table again")
        return _content(fields, sets, means)

    @classmethod
    def recognises(cls, text: str) -> bool:
        """Whether its mark or its columns stand at the head."""
        return f"{MARK}: {cls.name}\n" in text[:4000] or f"\n{COLUMNS}\n" in f"\n{text[:4000]}"


def _content(fields: dict[str, Any], sets: dict[str, list[Line]], means: dict[str, float]) -> OrderContent:
    """Table of rows by direction: "both", one direction alone, or forward and backward."""
    if set(sets) == {"forward", "backward"}:
        return OrderContent(
            **fields | {"direction": "both"}, lines=tuple(sets["forward"]), backward=tuple(sets["backward"]),
            mean=means.get("forward", 0.0), mean_backward=means.get("backward", 0.0),
        )  # fmt: skip
    if len(sets) > 1:
        raise Unfit(1, "direction", f"has rows of {' and '.join(sets)}; write both, or forward and backward")
    (direction,) = sets
    if fields.get("direction", direction) != direction:
        raise Unfit(1, "direction", f"is {fields['direction']} in the remarks and {direction} in the rows; correct it")
    return OrderContent(
        **fields | {"direction": direction}, lines=tuple(sets[direction]), mean=means.get(direction, 0.0)
    )
