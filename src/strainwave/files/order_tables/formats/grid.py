"""CSV over two turns, the motor's and the output's: for a controller that looks a correction up by both angles."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.quantities import positive_count, shown
from ....base.results import Floats
from ....model.excitation import Line
from ..content import OrderContent, merged
from ..format import Held, Motion, OrderFormat
from ..points import PER_PERIOD, ROUNDING, Side, Unfit, acting, float_in, of_sides, rows_of, said_by, ways

HEADS = ("motor_rad,output_rad,value", "motor_rad,output_rad,forward,backward")
COARSE, MOST = 8, 200_000  # points a turn at least, and of a file at most
EVEN = 1e-6  # of a step: how far an angle may be from its place
TURN = 2.0 * math.pi


@dataclass(frozen=True)
class CsvGrid(
    OrderFormat, name="grid", title="CSV over two turns", turn="output", own_sign=True,
    both_ways=True, width=8, begin=rf"\s*({'|'.join(HEADS)})",
):  # fmt: skip
    """CSV of points over the encoder angles of motor and output, each over a turn; straight lines along both.

    A line that repeats j times in a turn of the motor and k times in one of the output takes as many points as j and k
    need, not as j N + k does.

    Attributes
    ----------
    motor_points, output_points : int, optional
        Points a turn. Default: 32 a period of the highest j and k, at least 8.
    capacity : int
        Points that the controller holds.
    """

    motor_points: int | None = None
    output_points: int | None = None
    capacity: int = MOST

    def __post_init__(self) -> None:
        positive_count("capacity", self.capacity, MOST)
        for name in ("motor_points", "output_points"):
            if getattr(self, name) is not None:
                positive_count(name, getattr(self, name), MOST)

    def counts(self, table: OrderContent) -> tuple[int, int]:
        """Points of the motor's turn and of the output's for a table; too few or too many are refused (ValueError)."""
        if table.pairs is None:
            raise ValueError(f"{self.title} needs a whole ratio; give it to the table")
        counts = []
        for name, repeats in zip(("motor_points", "output_points"), np.abs(table.pairs).reshape(-1, 2).T, strict=True):
            highest = int(np.max(repeats, initial=0))
            counts.append(getattr(self, name) or max(COARSE, PER_PERIOD * highest))
            if counts[-1] <= 2 * highest:
                raise ValueError(f"{name} is {counts[-1]} and a line repeats {highest} times a turn; give more points")
        if math.prod(counts) * len(table.sides) > self.capacity:
            raise ValueError(
                f"a table of {counts[0]} by {counts[1]} points is more than the {self.capacity} that the controller "
                "holds; give motor_points and output_points, or take lines"
            )
        return counts[0], counts[1]

    def store(self, table: OrderContent) -> Held:
        """Sample the table, one grid or one for each direction of motion."""
        motor, output = [TURN * np.arange(count) / count for count in self.counts(table)]
        pairs = dict(zip(table.orders, table.pairs or (), strict=True))
        turns = {order: j * motor[:, None] + k * output + order * table.zero for order, (j, k) in pairs.items()}
        sets = {way: (mean, lines) for way, mean, lines in ways(table)}
        grids = []
        for act in acting(table)[: len(table.sides)]:
            mean, lines = (0.0, ()) if act is None else sets[act[0]]
            waves = (line.amplitude * np.cos(turns[line.order] + line.phase) for line in lines)
            grids.append(sum(waves, np.full((len(motor), len(output)), mean)))
        stored = _motion(grids, table.ratio or 1.0, table.zero)
        return Held(stored, stored, grids, points=grids[0].size)

    def text(self, table: OrderContent, held: Held, comments: list[str]) -> str:
        """Write a row a point, the output's angle first to change."""
        grids = held.numbers
        axes = np.meshgrid(*(TURN * np.arange(count) / count for count in grids[0].shape), indexing="ij")
        rows = np.column_stack([*(axis.ravel() for axis in axes), *(grid.ravel() for grid in grids)]).tolist()
        lines = [
            *(f"# {line}" for line in comments),
            HEADS[len(grids) - 1],
            *(",".join(map(repr, row)) for row in rows),
        ]
        return "\n".join(lines) + "\n"

    def parse(self, text: str) -> OrderContent:
        """Read the rows; points become lines by a Fourier series over both turns."""
        fields, _ = said_by(text)
        if not fields.get("ratio", 0.0) >= 1.0 or fields["ratio"] % 1:
            raise Unfit(1, "ratio", "is not in the remarks as a whole number; write '# ratio = 50.0'")
        rows = list(_rows(text))
        if len(rows) < 4 * 4:
            raise Unfit(1, "file", f"has {len(rows)} points; two turns need 16 at least, it may be cut off")
        table = np.array(rows)
        counts = [len(np.unique(column)) for column in table[:, :2].T]
        whole = len(table) == math.prod(counts) and min(counts) >= 4
        axes = np.indices(counts).reshape(2, -1) if whole else np.zeros((2, len(table)))
        steps = table[:, :2].T * np.array(counts)[:, None] / TURN - axes
        if not whole or np.max(np.abs(steps)) > EVEN:
            raise Unfit(1, "motor_rad", "and output_rad are not equidistant over a turn each; some rows may be missing")
        series = [_series(grid.reshape(counts), fields) for grid in table[:, 2:].T]
        return of_sides(series, {"turn": "output"} | fields)


def _motion(grids: list[Floats], ratio: float, zero: float) -> Motion:
    """Value by angle of the output [rad] and direction, with straight lines along both angles."""

    def value(angle: Floats, backward: bool) -> Floats:
        grid = grids[-1 if backward else 0]
        weights, corners = [], []
        for turn, count in zip((ratio, 1.0), grid.shape, strict=True):
            place = np.mod(turn * (angle - zero) / TURN, 1.0) * count
            low = np.floor(place)
            weights.append((1.0 - (place - low), place - low))
            corners.append([(low.astype(int) + i) % count for i in (0, 1)])
        terms = [weights[0][i] * weights[1][k] * grid[corners[0][i], corners[1][k]] for i in (0, 1) for k in (0, 1)]
        return np.asarray(np.sum(terms, axis=0))

    return value


def _rows(text: str) -> Iterator[list[float]]:
    """Numbers of the rows of a file."""
    rows = rows_of(text)
    number, head = next(rows, (1, ""))
    if head not in HEADS:
        raise Unfit(number, "file", f"has the columns {shown(head[:60])}; they must be {HEADS[0]}")
    for count, (number, line) in enumerate(rows):
        cells = line.split(",")
        if len(cells) != head.count(",") + 1 or count >= MOST:
            raise Unfit(number, "file", f"{shown(line[:60])} is no row of {head}, or beyond {MOST} of them; correct it")
        yield [float_in(number, "value", cell) for cell in cells]


def _series(grid: Floats, fields: dict[str, Any]) -> Side:
    """Mean and lines of a grid on the output's turn."""
    c = np.fft.fft2(grid) / grid.size
    least = ROUNDING * float(np.max(np.abs(grid), initial=0.0))
    lines, ratio = [], fields["ratio"]
    for j, k in np.argwhere(np.abs(c) > least).tolist():
        order = j * ratio + (k if 2 * k < grid.shape[1] else k - grid.shape[1])
        if 2 * j < grid.shape[0] and 2 * k != grid.shape[1] and order >= 1:
            phase = float(np.angle(c[j, k])) - order * fields.get("zero", 0.0)
            lines.append(Line(round(order), 2.0 * abs(c[j, k]), math.remainder(phase, TURN)))
    mean = float(c[0, 0].real)
    return mean if abs(mean) > least else 0.0, merged(lines)
