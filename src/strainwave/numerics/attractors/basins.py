"""Basins of attraction: where the motions from many initial states end, and what share of them ends where."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from ...base.law import repeating
from ...base.protocols import System, state_count, with_parts
from ...base.quantities import interval, positive_count, shown, whole
from ...base.results import Floats, Integers
from ..integration.methods import Method
from .attractors import Attractor, recognised
from .settle import SEEN, settled, stretching

DIVERGED, CHAOTIC, UNSETTLED = -1, -2, -3
MOST_LANES = 4_000_000
CERTAIN = 4.0  # standard errors that a Lyapunov exponent must be above 0 to be called so
OTHERS = {
    DIVERGED: "left every bound",
    CHAOTIC: "chaotic: neighbours drift apart exponentially",
    UNSETTLED: "neither settled nor chaotic: a slow transient, a period above 8 turns, or two frequencies",
}


@dataclass(frozen=True, eq=False)
class Basins:
    """Initial states and where they lead.

    Attributes
    ----------
    x, v : (lanes,) arrays
        Initial states [rad, rad/s] at base phase 0.
    label : (lanes,) int array
        Place in `attractors`; -1 diverged, -2 chaotic, -3 neither settled nor chaotic within the longest time.
    attractors : tuple of Attractor
        The largest basin first.
    shape : (int, int) or None
        Of the grid (v, x) that the lanes form; None for a random sample.
    spans : ((float, float), (float, float))
        Ranges of x and v.
    """

    x: Floats
    v: Floats
    label: Integers
    attractors: tuple[Attractor, ...]
    shape: tuple[int, int] | None
    spans: tuple[tuple[float, float], tuple[float, float]]

    def share(self, label: int) -> tuple[float, float]:
        """Fraction of the initial states with this label, and its binomial standard error."""
        n = len(self.label)
        p = float(np.count_nonzero(self.label == label)) / n
        return p, float(np.sqrt(p * (1.0 - p) / n))

    @property
    def fractions(self) -> Floats:
        """Fractions (attractors,) of the initial states in each basin; 1 less their sum is diverged or not settled."""
        return np.array([self.share(i)[0] for i in range(len(self.attractors))])

    @property
    def standard_errors(self) -> Floats:
        """Binomial standard errors (attractors,) of the fractions; on a grid they are larger than the true error."""
        return np.array([self.share(i)[1] for i in range(len(self.attractors))])

    def dataset(self) -> xr.Dataset:
        """Labels over the grid (v, x) or over "lane", and the attractors' numbers over "attractor"."""
        meaning = "; ".join(f"{k}: {text}" for k, text in OTHERS.items())
        attributes = {"meaning": f"0, 1, ...: place among the attractors; {meaning}"}
        if self.shape is None:
            data = xr.Dataset(
                {"label": ("lane", self.label, attributes)},
                {"x": ("lane", self.x, {"units": "rad"}), "v": ("lane", self.v, {"units": "rad/s"})},
            )
        else:
            x, v = self.x.reshape(self.shape)[0], self.v.reshape(self.shape)[:, 0]
            data = xr.Dataset(
                {"label": (("v", "x"), self.label.reshape(self.shape), attributes)},
                {"x": ("x", x, {"units": "rad"}), "v": ("v", v, {"units": "rad/s"})},
            )
        data["fraction"] = ("attractor", self.fractions)
        data["standard_error"] = ("attractor", self.standard_errors)
        for name, unit in (("period", "turn"), ("peak", "rad"), ("amplitude", "rad"), ("multiplier", "")):
            data[name] = ("attractor", np.array([getattr(a, name) for a in self.attractors]), {"units": unit})
        data["stable"] = ("attractor", np.array([a.stable for a in self.attractors], bool))
        return data

    def __str__(self) -> str:
        (x0, x1), (v0, v1) = self.spans
        lines = [f"Basins: {len(self.label)} initial states, x = {x0:g} .. {x1:g} rad, v = {v0:g} .. {v1:g} rad/s"]
        names = [(i, str(a)) for i, a in enumerate(self.attractors)] + list(OTHERS.items())
        for label, name in names:
            p, error = self.share(label)
            if p > 0.0:
                lines.append(f"  {p:.4f} +- {error:.4f}  {name}")
        return "\n".join(lines)

    __repr__ = __str__


def basins(
    system: System,
    x_span: tuple[float, float],
    v_span: tuple[float, float],
    *,
    resolution: int | tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int = 0,
    settle: int = 50,
    longest: int = 4000,
    method: Method | None = None,
    threads: int | None = None,
) -> Basins:
    """Integrate many initial states until they settle, and tell the attractors that they end on apart.

    Every lane runs until its stroboscopic states repeat after 1 to 8 turns; those that do not are continued, up to
    `longest` turns, and then asked whether their neighbours drift apart (chaos). An attractor is what `find_orbit`
    finds from a settled motion, with its Floquet multipliers; all lanes that end near its stroboscopic points are its
    basin. No lane is dropped: what diverged, is chaotic or did not settle is counted as such.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)` and `omega`
        The system; internal states of a law with memory start at 0.
    x_span, v_span : (float, float)
        Ranges of the initial x [rad] and x' [rad/s], at base phase 0.
    resolution : int or (int, int), optional
        A grid of cells (along x, along v), each started from its middle. Default, without `samples`: 100.
    samples : int, optional
        In place of a grid: so many random initial states, uniform over the ranges.
    seed : int
        Of the random states.
    settle, longest : int
        Turns before the first look, and in all.
    method, threads
        As in `ensemble`.

    Returns
    -------
    Basins
        `label` (lanes,): the place in `attractors` of each initial state, with the `fractions` of them that
        each attracts (numbers from 0 to 1).

    Raises
    ------
    ValueError, TypeError
        If a range, a count or a parameter is out of range, or both a grid and samples are asked for.

    References
    ----------
    Menck, Heitzig, Marwan & Kurths 2013, Nature Physics 9, 89 (share of random states, binomial standard error).
    """
    system = repeating("basins", with_parts("basins", system, "rhs"))
    spans = interval("x_span", x_span), interval("v_span", v_span)
    positive_count("settle", settle)
    if positive_count("longest", longest) < settle + SEEN:
        raise ValueError(f"longest is {longest} turns; it must be at least settle + {SEEN} = {settle + SEEN}")
    shape = _shape(resolution, samples)
    x, v = _grid(spans, shape) if shape else _random(spans, positive_count("samples", samples, MOST_LANES), seed)
    states = state_count(system)
    start = np.zeros((states, len(x)))
    start[0], start[1] = x, v
    ends = settled(system, {}, start, settle=settle, longest=longest, method=method, threads=threads)
    label, attractors = recognised(system, ends)
    label[ends.diverged] = DIVERGED
    left = np.flatnonzero(label == UNSETTLED)
    if len(left):
        rates = stretching(system, ends.state[:, left])
        error = np.std(rates, axis=0, ddof=1) / np.sqrt(len(rates))
        label[left[np.mean(rates, axis=0) > CERTAIN * error]] = CHAOTIC
    return Basins(x, v, label, attractors, shape, spans)


def _shape(resolution: Any, samples: Any) -> tuple[int, int] | None:
    """Cells along v and along x; None for samples."""
    if samples is not None:
        if resolution is not None:
            raise ValueError(f"resolution is {shown(resolution)} and samples {shown(samples)}; give one of them")
        return None
    pair = (100, 100) if resolution is None else resolution
    pair = pair if isinstance(pair, tuple) else (pair, pair)
    if len(pair) != 2:
        raise ValueError(f"resolution is {shown(resolution)}; it must be one number of cells or (along x, along v)")
    along_x, along_v = positive_count("resolution", pair[0], 10_000), positive_count("resolution", pair[1], 10_000)
    if along_x * along_v > MOST_LANES:
        raise ValueError(f"resolution asks for {along_x * along_v} states; at most {MOST_LANES} fit, or take samples")
    return along_v, along_x


def _grid(spans: Any, shape: tuple[int, int]) -> tuple[Floats, Floats]:
    (x0, x1), (v0, v1) = spans
    middles_x = x0 + (x1 - x0) * (np.arange(shape[1]) + 0.5) / shape[1]
    middles_v = v0 + (v1 - v0) * (np.arange(shape[0]) + 0.5) / shape[0]
    v, x = np.meshgrid(middles_v, middles_x, indexing="ij")
    return x.ravel(), v.ravel()


def _random(spans: Any, samples: int, seed: Any) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(whole("seed", seed))
    (x0, x1), (v0, v1) = spans
    return rng.uniform(x0, x1, samples), rng.uniform(v0, v1, samples)
