"""Points of a sweep: a grid over parameters, or a sample of their distributions, made chunk by chunk.

A chunk's points follow from its place and the seed alone. Both samples are those of SciPy; of a Latin hypercube all
points are in memory, of a Sobol sample those of a chunk.

Source: A. B. Owen, Monte Carlo theory, methods and examples, chapters 10 and 17.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import qmc

from ..base.quantities import number, numbers, parameters, positive_count, shown, whole
from ..base.results import Floats

SOBOL_BITS = 30  # of SciPy's points: 2**30 of them are distinct
LARGEST_SAMPLE = 2**24  # of a Latin hypercube, which is in memory
TOGETHER = " & "  # between the paths of parameters that share a factor, in the name of that factor


class Uniform(NamedTuple):
    """Every value between low and high is as likely as another (SI units)."""

    low: float
    high: float

    def check(self) -> None:
        """Raise a ValueError if the bounds are none."""
        if not number("Uniform.low", self.low) < number("Uniform.high", self.high):
            raise ValueError(f"Uniform is {shown(self.low)} .. {shown(self.high)}; low must be below high")

    def quantile(self, p: Any) -> Any:
        """Value below which the share p (0 < p < 1) of the distribution lies."""
        return self.low + (self.high - self.low) * p


class LogUniform(NamedTuple):
    """The logarithm is uniform between those of low and high, both positive (SI units)."""

    low: float
    high: float

    def check(self) -> None:
        """Raise a ValueError if the bounds are none."""
        if not number("LogUniform.low", self.low, positive=True) < number("LogUniform.high", self.high):
            raise ValueError(f"LogUniform is {shown(self.low)} .. {shown(self.high)}; low must be below high")

    def quantile(self, p: Any) -> Any:
        """Value below which the share p (0 < p < 1) of the distribution lies."""
        return self.low * (self.high / self.low) ** p


class Normal(NamedTuple):
    """Normal distribution with this mean and standard deviation (SI units), cut off at low and high."""

    mean: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf

    def check(self) -> None:
        """Raise a ValueError if the deviation is not positive or nothing lies between the bounds."""
        number("Normal.mean", self.mean)
        number("Normal.deviation", self.deviation, positive=True)
        for name, bound in (("low", self.low), ("high", self.high)):
            if abs(bound) != math.inf:
                number(f"Normal.{name}", bound)
        below, above = self._shares()
        if not below < above:
            raise ValueError(f"{self} has no probability between its bounds; widen them")

    def _shares(self) -> tuple[float, float]:
        return tuple(float(ndtr((bound - self.mean) / self.deviation)) for bound in (self.low, self.high))  # type: ignore[return-value]

    def quantile(self, p: Any) -> Any:
        """Value below which the share p (0 < p < 1) of the distribution lies."""
        below, above = self._shares()
        value = self.mean + self.deviation * ndtri(below + (above - below) * p)
        return np.clip(value, self.low, self.high)


Distribution = Uniform | LogUniform | Normal


@dataclass(frozen=True)
class LatinHypercube:
    """A Latin hypercube sample: each of `count` slices of equal probability of every parameter has one point.

    Parameters
    ----------
    count : int
        Number of points.
    distributions : dict of str to Uniform, LogUniform or Normal
        Path of a parameter to its distribution, as in ``{"law.K": sw.Normal(1e5, 5e3)}``; or a tuple of paths to that
        of a factor which scales them together, as in ``{("law.K1", "law.K2", "law.K3"): sw.Normal(1.0, 0.05)}``.
    seed : int
        Another seed gives another sample.
    """

    count: int
    distributions: Mapping[str, Distribution]
    seed: int = 0


@dataclass(frozen=True)
class Sobol:
    """A scrambled Sobol sample, which fills the space evenly; the count must be a power of two.

    Parameters
    ----------
    count : int
        Number of points, a power of two up to 2**30.
    distributions : dict of str to Uniform, LogUniform or Normal
        As of `LatinHypercube`.
    seed : int
        Another seed gives another scrambling, with which the error of a mean can be estimated.
    """

    count: int
    distributions: Mapping[str, Distribution]
    seed: int = 0


@dataclass(frozen=True)
class Table:
    """Points that are given one by one: values (n,) of every parameter by its path."""

    columns: Mapping[str, Floats]


Grid = Mapping[Any, Any] | LatinHypercube | Sobol | Table


def named(key: Any) -> str:
    """Name of a key of a grid or of distributions: a path, or several (a tuple of them) that share one factor."""
    paths = key if isinstance(key, tuple) else (key,)
    if isinstance(key, tuple) and len(paths) < 2:
        raise ValueError(
            f"{shown(key)} is not a parameter; give a path such as 'law.K', or a tuple of several, which one "
            "factor scales"
        )
    return TOGETHER.join(paths)


def check_names(system: Any, names: Iterable[str]) -> dict[str, str]:
    """Units of the parameters by name ("" of a factor), or one sentence on the first that cannot vary (ValueError)."""
    leaves = {parameter.path: parameter for parameter in parameters(system)}
    units: dict[str, str] = {}
    varied: set[str] = set()
    for name in names:
        paths = name.split(TOGETHER)
        for path in paths:
            if path not in leaves:
                raise ValueError(f"{type(system).__name__} has no parameter {shown(path)}; it has {', '.join(leaves)}")
            if path in varied:
                raise ValueError(f"{path} is given twice; give it once")
            if len(paths) > 1 and not isinstance(leaves[path].value, float):
                raise ValueError(f"{path} is a whole number and cannot be scaled by a factor; vary it separately")
            varied.add(path)
        units[name] = leaves[name].unit if len(paths) == 1 else ""
    return units


def by_path(system: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of every path: a factor of several paths becomes the values of each, in relation to the system's own."""
    nominal = {parameter.path: parameter.value for parameter in parameters(system)}
    apart: dict[str, Any] = {}
    for name, factor in values.items():
        paths = name.split(TOGETHER)
        apart |= {name: factor} if len(paths) == 1 else {path: nominal[path] * factor for path in paths}
    return apart


class GridPoints:
    """All combinations of the values of the parameters."""

    def __init__(self, axes: Mapping[str, Any]) -> None:
        if not axes:
            fault = f"the grid is {shown(axes)}; it must be a dict of path to values, as in {{'law.K': [1, 2]}}"
            raise ValueError(fault)
        self.axes = {named(key): numbers(f"grid[{key!r}]", values, largest=inf) for key, values in axes.items()}
        self.dims = self.paths = tuple(self.axes)
        self.shape = tuple(len(axis) for axis in self.axes.values())

    def values(self, first: int, count: int) -> dict[str, Floats]:
        """Values (count,) of every parameter from point `first` on."""
        indices = np.unravel_index(np.arange(first, first + count), self.shape)
        return {path: axis[index] for (path, axis), index in zip(self.axes.items(), indices, strict=True)}


class TablePoints:
    """Points that are given one by one."""

    def __init__(self, table: Table) -> None:
        self.columns, self.dims, self.paths = table.columns, ("point",), tuple(table.columns)
        self.shape: tuple[int, ...] = (len(next(iter(table.columns.values()))),)

    def values(self, first: int, count: int) -> dict[str, Floats]:
        """Values (count,) of every parameter from point `first` on."""
        return {path: values[first : first + count] for path, values in self.columns.items()}


class SamplePoints:
    """A sample of distributions; point i depends on the seed and on i."""

    def __init__(self, sample: LatinHypercube | Sobol) -> None:
        kind = type(sample).__name__
        sobol = isinstance(sample, Sobol)
        count = positive_count(f"{kind}.count", sample.count, 2**SOBOL_BITS if sobol else LARGEST_SAMPLE)
        if sobol and count & (count - 1):
            power = 1 << count.bit_length()
            raise ValueError(f"Sobol.count is {count}; it must be a power of two, such as {power // 2} or {power}")
        if not sample.distributions:
            raise ValueError(f"{kind}.distributions is empty; give a distribution by path")
        for law in sample.distributions.values():
            law.check()
        seed = whole(f"{kind}.seed", sample.seed)
        self.laws = {named(key): law for key, law in sample.distributions.items()}
        self.dims: tuple[str, ...] = ("point",)
        self.shape: tuple[int, ...] = (count,)
        self.paths = tuple(self.laws)
        n = len(self.laws)
        self.shares = _SobolShares(n, seed) if sobol else _LatinShares(count, n, seed)

    def values(self, first: int, count: int) -> dict[str, Floats]:
        """Values (count,) of every parameter from point `first` on."""
        shares = self.shares.stretch(first, count)
        return {p: np.asarray(law.quantile(shares[i]), float) for i, (p, law) in enumerate(self.laws.items())}


# Points of a sweep: names and lengths of the dimensions, values of a stretch of points.
Points = GridPoints | SamplePoints | TablePoints


class _SobolShares:
    """Scrambled Sobol points, drawn in order; going back draws again from the start."""

    def __init__(self, dimensions: int, seed: int) -> None:
        self.engine = qmc.Sobol(dimensions, scramble=True, bits=SOBOL_BITS, rng=np.random.default_rng(seed))

    def stretch(self, first: int, count: int) -> Floats:
        """Shares (dimensions, count) from point `first` on, strictly between 0 and 1."""
        if first < self.engine.num_generated:
            self.engine.reset()
        if first > self.engine.num_generated:
            self.engine.fast_forward(first - self.engine.num_generated)
        # SciPy warns when the first draw is no power of two: the point at the start is drawn on its own.
        start = [self.engine.random(1)] if first == 0 else []
        drawn = np.concatenate([*start, self.engine.random(count - len(start))])
        return np.asarray(drawn.T + 0.5 ** (SOBOL_BITS + 1))


class _LatinShares:
    """A Latin hypercube of SciPy, made when its first points are asked for."""

    def __init__(self, count: int, dimensions: int, seed: int) -> None:
        self.count, self.engine = count, qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed))

    @cached_property
    def shares(self) -> Floats:
        """Shares (dimensions, count), strictly between 0 and 1."""
        return np.asarray(np.clip(self.engine.random(self.count).T, 0.5**53, 1.0 - 0.5**53))

    def stretch(self, first: int, count: int) -> Floats:
        """Shares (dimensions, count) from point `first` on."""
        return self.shares[:, first : first + count]


def points_of(grid: Grid) -> Points:
    """Points of a grid or sample, or one sentence on what is wrong with it (ValueError)."""
    if isinstance(grid, Table):
        return TablePoints(grid)
    return SamplePoints(grid) if isinstance(grid, LatinHypercube | Sobol) else GridPoints(grid)
