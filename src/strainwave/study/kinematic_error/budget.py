"""Static sources of the kinematic error as named contributors: worst case, root sum square, Monte Carlo over phases.

Sums of lines with unknown phases: random draws of them, and the peak-to-peak of each.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import reduce
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.quantities import LARGEST, numbers, positive_count, shown
from ...base.results import Floats
from ...base.sentences import on_screen
from ...model.excitation import HIGHEST, KinematicError, Line
from ...model.orders import KINDS, Source, Turn, order_map

MOST_DRAWS = 1_000_000

OVERSAMPLING = 32
CHUNK = 2_000_000  # values evaluated at a time


class Phasors(NamedTuple):
    """Sources on one base turn: distinct orders, which of them each source has, amplitudes, phases (nan: unknown)."""

    orders: NDArray[np.int64]
    place: NDArray[np.int64]
    amplitudes: Floats
    phases: Floats


def draw(phasors: Phasors, draws: int, seed: int) -> NDArray[np.complex128]:
    """Complex amplitudes (draws, orders) with unknown phases drawn uniformly."""
    drawn = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (draws, len(phasors.phases)))
    phases = np.where(np.isnan(phasors.phases), drawn, phasors.phases)
    total = np.zeros((draws, len(phasors.orders)), complex)
    for i, place in enumerate(phasors.place):
        total[:, place] += phasors.amplitudes[i] * np.exp(1j * phases[:, i])
    return total


def span(orders: NDArray[np.int64], amplitudes: NDArray[np.complex128]) -> Floats:
    """Peak-to-peak (draws,) of the sums of Re(amplitudes exp(i orders t)).

    Extremes of a grid, refined by Newton's method: exact but where two extremes differ by less than 0.5 % of the whole,
    and then to that.

    Parameters
    ----------
    orders : (m,) int array
        Ascending.
    amplitudes : (draws, m) complex array
        Amplitudes and phases.
    """
    k = orders // reduce(math.gcd, (int(order) for order in orders))
    n = OVERSAMPLING * int(k[-1])
    size = max(1, CHUNK // n)
    spans = [_span(k, amplitudes[i : i + size], n) for i in range(0, len(amplitudes), size)]
    return np.concatenate(spans)


def _span(k: NDArray[np.int64], c: NDArray[np.complex128], n: int) -> Floats:
    series = np.zeros((len(c), n // 2 + 1), complex)
    series[:, k] = 0.5 * n * c
    values = np.fft.irfft(series, n, axis=1)
    ends = []
    for sign, tops in ((1.0, np.argmax(values, axis=1)), (-1.0, np.argmin(values, axis=1))):
        start = 2.0 * np.pi / n * tops[:, None]
        t = start
        for _ in range(3):
            turned = sign * c * np.exp(1j * k * t)
            slope = -(turned.imag * k).sum(1, keepdims=True)
            bend = -(turned.real * k * k).sum(1, keepdims=True)
            step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend < 0.0)
            t = np.clip(t - step, start - 2.0 * np.pi / n, start + 2.0 * np.pi / n)
        refined = (sign * c * np.exp(1j * k * t)).real.sum(1)
        ends.append(np.maximum(refined, sign * values[np.arange(len(c)), tops]))
    return np.asarray(ends[0] + ends[1])


@dataclass(frozen=True)
class BudgetRow:
    """One source in a budget.

    Attributes
    ----------
    name, kind : str
        As given.
    order : int
        Repeats per turn of `turn`.
    turn : {"motor", "output"}
        Shaft that the order counts on.
    amplitude : float
        0-to-peak [rad].
    phase : float or None
        Phase [rad], None where unknown.
    share : float
        Of the worst case.
    square_share : float
        Of the sum of squares.
    compensable : bool
        Whether it repeats with the wave generator, so that a table over the motor angle removes it; what deforms under
        load is removed at that load only. The rest needs the angle of the output.
    """

    name: str
    kind: str
    order: int
    turn: Turn
    amplitude: float
    phase: float | None
    share: float
    square_share: float
    compensable: bool


@dataclass(frozen=True)
class BudgetTotal:
    """Peak-to-peak errors [rad] of several sources together.

    Attributes
    ----------
    worst_case : float
        Twice the sum of the amplitudes; no phases give more.
    root_sum_square : float
        Twice the root of the sum of squares: what to expect of many sources of one order; lines of different orders
        give more, because somewhere in the turn they meet.
    quantiles : tuple of (float, float)
        Probability, and the peak-to-peak that is not exceeded with it when unknown phases are equally likely.
    """

    worst_case: float
    root_sum_square: float
    quantiles: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class ErrorBudget:
    """Error budget of static sources; `str()` prints it as a table, `as_dict()` is for JSON.

    Attributes
    ----------
    rows : tuple of BudgetRow
        Largest first.
    total : BudgetTotal
        All sources together.
    rest : BudgetTotal
        Those left when all that can be compensated over the motor angle is.
    turn : {"motor", "output"}
        Base turn of `error`: the output's as soon as one source repeats with it.
    draws, seed : int
        Of the Monte Carlo simulation; 1 draw where all phases are known.
    """

    rows: tuple[BudgetRow, ...]
    total: BudgetTotal
    rest: BudgetTotal
    turn: Turn
    draws: int
    seed: int
    phasors: Phasors

    def error(self, quantile: float = 0.95) -> KinematicError:
        """Kinematic error of the draw whose peak-to-peak is at the quantile; the true one where all phases are known.

        Raises
        ------
        ValueError
            If the quantile is not between 0 and 1.
        """
        _check_quantile(quantile)
        drawn = draw(self.phasors, self.draws, self.seed)
        spans = span(self.phasors.orders, drawn)
        c = drawn[np.argsort(spans)[min(int(quantile * len(spans)), len(spans) - 1)]]
        orders = (int(k) for k in self.phasors.orders)
        lines = (Line(k, float(abs(z)), float(np.angle(z))) for k, z in zip(orders, c, strict=True) if z != 0.0)
        return KinematicError(tuple(lines))

    def as_dict(self) -> dict[str, Any]:
        """Everything as dicts, lists and numbers, in SI and radians."""
        totals = {
            name: {
                "worst_case": total.worst_case,
                "root_sum_square": total.root_sum_square,
                "quantiles": [{"probability": q, "peak_to_peak": value} for q, value in total.quantiles],
            }
            for name, total in (("total", self.total), ("rest", self.rest))
        }
        rows = [asdict(row) for row in self.rows]
        return {"sources": rows, **totals, "turn": self.turn, "draws": self.draws, "seed": self.seed}

    def __str__(self) -> str:
        def row(name: str, kind: str, order: str, size: str, share: str, square: str, remedy: str) -> str:
            return on_screen(f"{name:<42}{kind:<13}{order:>12}{size:>12}{share:>8}{square:>9}  {remedy}")

        lines = [row("source", "kind", "order", "rad 0-peak", "share", "square", "compensable")]
        lines += [
            row(
                r.name, r.kind, f"{r.order}/{r.turn}", f"{r.amplitude:.3g}", f"{100 * r.share:.1f} %",
                f"{100 * r.square_share:.1f} %", "yes" if r.compensable else "no",
            )
            for r in self.rows
        ]  # fmt: skip
        for name, total in (("all, peak-to-peak (rad)", self.total), ("without the compensable ones", self.rest)):
            said = ", ".join(f"{100 * q:g} % below {value:.3g}" for q, value in total.quantiles)
            lines.append(f"{name}: worst case {total.worst_case:.3g}, rss {total.root_sum_square:.3g}, {said}")
        return "\n".join(lines)


def error_budget(
    sources: Sequence[Source],
    *,
    N: float | None = None,
    quantiles: Sequence[float] = (0.5, 0.95, 0.99),
    draws: int = 4000,
    seed: int = 0,
) -> ErrorBudget:
    """Put static sources together: worst case, root sum square, and the spread over unknown phases.

    Parameters
    ----------
    sources : sequence of Source
        The contributors; names must differ.
    N : float, optional
        Ratio; needed where a source repeats with the output.
    quantiles : sequence of float
        Probabilities between 0 and 1.
    draws, seed : int
        Monte Carlo: unknown phases are independent and equally likely. The probability that belongs to a quantile q is
        known to sqrt(q (1 - q)/draws).

    Returns
    -------
    ErrorBudget
        With `.error(quantile)`, a kinematic error of that size.

    Raises
    ------
    ValueError
        If there is no source with an amplitude, one is wrong, or N is missing.
    """
    listed = _checked(sources)
    output = any(source.turn == "output" for source in listed)
    ratio = None if N is None else order_map(N).N
    if output and ratio is None:
        name = next(source.name for source in listed if source.turn == "output")
        raise ValueError(f"{name!r} repeats with the output; give the ratio N, so that all orders share one turn")
    chosen = tuple(numbers("quantiles", quantiles).tolist())
    for q in chosen:
        _check_quantile(q)
    draws = positive_count("draws", draws, MOST_DRAWS)
    if not isinstance(seed, Integral) or isinstance(seed, bool) or seed < 0:
        raise ValueError(f"seed is {shown(seed)}; it must be a whole number from 0")
    whole = sum(s.amplitude for s in listed)
    squares = sum(s.amplitude**2 for s in listed)
    rows = tuple(
        BudgetRow(
            s.name, s.kind, s.order, s.turn, s.amplitude, s.phase, s.amplitude / whole, s.amplitude**2 / squares,
            s.turn == "motor" or s.order % (ratio or 1) == 0,
        )
        for s in sorted(listed, key=lambda s: (-s.amplitude, s.name))
    )  # fmt: skip
    factor = {"motor": ratio or 1 if output else 1, "output": 1}
    for s in listed:
        if s.order * factor[s.turn] > HIGHEST:
            raise ValueError(
                f"{s.name!r} repeats {s.order * factor[s.turn]} times on the output turn that all share; orders go up "
                f"to {HIGHEST}, leave the source out or budget motor and output apart"
            )
    phasors = _phasors(rows, factor)
    draws = draws if np.any(np.isnan(phasors.phases)) else 1
    rest = [row for row in rows if not row.compensable]
    return ErrorBudget(
        rows,
        _total(rows, phasors, chosen, draws, seed),
        _total(rest, _phasors(rest, factor), chosen, draws, seed),
        "output" if output else "motor",
        draws,
        seed,
        phasors,
    )


def _checked(sources: Sequence[Source]) -> list[Source]:
    if not isinstance(sources, Iterable):
        raise TypeError(f"the sources are {shown(sources)}; write [Source(name, kind, order, amplitude), ...]")
    listed = list(sources)
    for s in listed:
        if not isinstance(s, Source):
            raise TypeError(f"{shown(s)} is no source; write Source(name, kind, order, amplitude)")
        if not isinstance(s.name, str):
            raise TypeError(f"a source has the name {shown(s.name)}; write it as text")
        if s.kind not in KINDS or s.turn not in ("motor", "output"):
            kinds, turns = ", ".join(KINDS), "motor or output"
            raise ValueError(f"{s.name!r} has the kind {s.kind!r} and the turn {s.turn!r}; known are {kinds}; {turns}")
        positive_count(f"the order of {s.name!r}", s.order, HIGHEST)
        size = s.amplitude
        if not (isinstance(size, int | float) and (size == 0.0 or 1.0 / LARGEST <= size <= LARGEST)):
            raise ValueError(f"the amplitude of {s.name!r} is {shown(size)}; it must be an angle in rad, not negative")
        if s.phase is not None and not (isinstance(s.phase, int | float) and math.isfinite(s.phase)):
            raise ValueError(
                f"the phase of {s.name!r} is {shown(s.phase)}; it must be an angle in rad, or None if unknown"
            )
    names = [s.name for s in listed]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"{sorted(twice)[0]!r} is the name of two sources; give each its own")
    if not any(s.amplitude for s in listed):
        raise ValueError("no source has an amplitude; give at least one, in rad 0-to-peak on the output side")
    return listed


def _check_quantile(q: float) -> None:
    if not (isinstance(q, int | float) and 0.0 < q < 1.0):
        raise ValueError(f"the quantile is {shown(q)}; it is a probability between 0 and 1, for example 0.95")


def _phasors(rows: Sequence[BudgetRow], factor: Mapping[str, int]) -> Phasors:
    orders, place = np.unique([row.order * factor[row.turn] for row in rows], return_inverse=True)
    phases = [math.nan if row.phase is None else row.phase for row in rows]
    return Phasors(
        orders.astype(np.int64), place.astype(np.int64), np.array([row.amplitude for row in rows]), np.array(phases)
    )


def _total(
    rows: Sequence[BudgetRow], phasors: Phasors, quantiles: tuple[float, ...], draws: int, seed: int
) -> BudgetTotal:
    if not rows:
        return BudgetTotal(0.0, 0.0, tuple((q, 0.0) for q in quantiles))
    spans = span(phasors.orders, draw(phasors, draws, seed))
    found = zip(quantiles, (float(v) for v in np.quantile(spans, quantiles)), strict=True)
    amplitudes = phasors.amplitudes
    return BudgetTotal(2.0 * float(np.sum(amplitudes)), 2.0 * float(np.sqrt(amplitudes @ amplitudes)), tuple(found))
