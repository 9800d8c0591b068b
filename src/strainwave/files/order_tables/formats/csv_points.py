"""CSV of points: angle, value and, where it differs, the value in backward motion, for anything that reads columns."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....base.quantities import positive_count, shown
from ..content import OrderContent
from ..format import Held, WithPoints, marked
from ..points import MOST_POINTS, Points, Unfit, content_of, float_in, motion, said_by, sampled

COLUMNS = ("angle_rad,value", "angle_rad,forward,backward")
EVEN = 1e-6  # of a step: how far an angle may be from its place


@dataclass(frozen=True)
class CsvPoints(WithPoints):
    """CSV of points at equidistant angles of the encoder over one turn of the table's shaft.

    Attributes
    ----------
    points : int, optional
        Points a turn. Default: 32 a period of the highest order, at least 64.
    """

    points: int | None = None
    name: ClassVar[str] = "points"
    title: ClassVar[str] = "CSV of points"
    own_sign: ClassVar[bool] = True
    both_ways: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.points is not None:
            positive_count("points", self.points, MOST_POINTS)

    def store(self, table: OrderContent) -> Held:
        """Sample the table; nothing is rounded."""
        points = sampled(table, self.count(table))
        held = motion(points, table.zero)
        return Held(held, held, points, points=len(points.forward))

    def text(self, table: OrderContent, held: Held, said: list[str]) -> str:
        """Write a row a point."""
        points = held.numbers
        assert isinstance(points, Points)
        columns = [points.angles(), points.forward] + ([] if points.backward is None else [points.backward])
        rows = [",".join(map(repr, row)) for row in np.column_stack(columns).tolist()]
        return "\n".join([*(f"# {line}" for line in said), COLUMNS[len(columns) - 2], *rows]) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows."""
        fields, _ = said_by(text)
        rows: list[list[float]] = []
        width = 0
        for number, line in enumerate(text.splitlines(), start=1):
            if not line.strip() or line.startswith("#"):
                continue
            if not width:
                if line.strip() not in COLUMNS:
                    raise Unfit(number, "file", f"has the columns {shown(line[:60])}; they must be {COLUMNS[0]}")
                width = line.count(",") + 1
                continue
            cells = line.split(",")
            if len(cells) != width:
                raise Unfit(number, "file", f"has {len(cells)} cells where the head names {width}; correct it")
            rows.append([float_in(number, "value", cell) for cell in cells])
            if len(rows) > MOST_POINTS:
                raise Unfit(number, "file", f"has more than {MOST_POINTS} points; take fewer")
        if len(rows) < 4:
            raise Unfit(1, "file", f"has {len(rows)} points; a turn needs 4 at least, it may be cut off")
        table = np.array(rows)
        step = 2.0 * math.pi / len(table)
        if np.max(np.abs(table[:, 0] - step * np.arange(len(table)))) > EVEN * step:
            raise Unfit(
                1, "angle_rad", f"the {len(table)} angles are not equidistant from 0 over one turn; some may be missing"
            )
        return content_of(Points(table[:, 1], table[:, 2] if width > 2 else None), fields)

    @classmethod
    def recognises(cls, text: str) -> bool:
        """Whether its mark or its columns stand at the head."""
        return marked(text, cls.name) or text.lstrip().startswith(COLUMNS)
