"""What fits of a system have in common: values and intervals of its free parameters by path."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...quantities import shown
from ...records import Result
from ...results import Floats
from ...tree import leaf_of, numbers, with_leaf
from .discrepancy import Discrepancy
from .identifiability import TOLERANCE, unidentifiable
from .intervals import Interval, interval


@dataclass(frozen=True, eq=False)
class Fitted(Result):
    """A system whose free parameters were found from a measurement.

    Attributes
    ----------
    system : Oscillator
        The system with the values found.
    names : tuple of str
        Paths of the free parameters.
    values : (p,) array
        Their values, in SI.
    covariance : (p, p) array
        Of the values; it allows for coloured residuals.
    freedom : (p,) array
        Degrees of freedom of its diagonal.
    discrepancy : Discrepancy
        What the system does not explain.
    """

    system: Any
    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    freedom: Floats
    discrepancy: Discrepancy

    def _place(self, path: str) -> int:
        if path not in self.names:
            raise ValueError(f"{shown(path)} was not fitted; the free parameters are {', '.join(self.names) or 'none'}")
        return self.names.index(path)

    def value(self, path: str) -> float:
        """Value of a free parameter, in SI."""
        return float(self.values[self._place(path)])

    def deviation(self, path: str) -> float:
        """Standard deviation of a free parameter, in SI."""
        at = self._place(path)
        return float(np.sqrt(self.covariance[at, at]))

    def interval(self, path: str, level: float = 0.95) -> Interval:
        """Interval in which a free parameter lies with a probability."""
        return interval(self.value(path), self.deviation(path), float(self.freedom[self._place(path)]), level)

    def lines(self) -> list[str]:
        """One line for each free parameter: value and 95 % interval."""
        bounds = [self.interval(name) for name in self.names]
        return [
            f"  {name} = {value:.6g} ({low:.6g} .. {high:.6g})"
            for name, value, (low, high) in zip(self.names, self.values, bounds, strict=True)
        ]


class ByName:
    """What fits with numbers of several origins have in common: value, deviation and interval by name."""

    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]

    def value(self, path: str) -> float:
        """Value of a number in SI, by its name or its path in the law: "K1", "second.yield_twist".

        Raises
        ------
        ValueError
            If there is no such number, or the measurement does not tell it.
        """
        return self.values[self._name(path)]

    def deviation(self, path: str) -> float:
        """Standard deviation of a number in SI; errors as `value`."""
        i = list(self.values).index(self._name(path))
        return float(np.sqrt(self.covariance[i, i]))

    def interval(self, path: str, level: float = 0.95) -> Interval:
        """Interval (low, high) in SI that holds a number with the probability `level`; errors as `value`."""
        freedom = float(self.freedom[list(self.values).index(self._name(path))])
        return interval(self.value(path), self.deviation(path), freedom, level)

    def _name(self, path: str) -> str:
        name = str(path).rpartition(".")[2]
        if name in self.unidentified:
            raise ValueError(self.unidentified[name])
        if name not in self.values:
            raise ValueError(f"the fit has no {path!r}; it has {', '.join(self.values)}")
        return name


def free_leaves(system: Any, free: Sequence[str]) -> list[int]:
    """Places of the free parameters among the leaves of a system.

    Raises
    ------
    ValueError
        If a path names no float of the system, or is there twice.
    """
    if isinstance(free, str):
        raise ValueError(f"free is {shown(free)}; write the paths of the free parameters as a tuple, ({shown(free)},)")
    if len(set(free)) < len(free):
        raise ValueError(f"free is {shown(tuple(free))}; name every parameter once")
    return [leaf_of(system, path) for path in free]


def with_values(system: Any, leaves: Sequence[int], values: Any) -> Any:
    """The system with other numbers at these leaves."""
    for leaf, value in zip(leaves, values, strict=True):
        system = with_leaf(system, leaf, float(value))
    return system


def scales(system: Any, free: Sequence[str]) -> Floats:
    """Sizes (p,) by which free parameters are measured: their start values, or 1 where these are 0."""
    start = {path: value for path, _, _, value in numbers(system)}
    return np.array([abs(start[path]) or 1.0 for path in free])


def bounds(system: Any, free: Sequence[str]) -> tuple[Floats, Floats]:
    """Least and largest free parameters: inertias, dampings and a law's numbers keep the sign of their start values.

    Amplitudes without phases are the same for B and for -B.
    """
    start = {path: value for path, _, _, value in numbers(system)}
    kept = [
        start[path] if path in start and (path.rpartition(".")[2] in ("J", "B") or path.startswith("law.")) else 0.0
        for path in free
    ]
    return np.where(np.greater(kept, 0.0), 0.0, -np.inf), np.where(np.less(kept, 0.0), 0.0, np.inf)


def refuse_unidentifiable(
    jacobian: Floats, names: Sequence[str], values: Floats, tolerance: float = TOLERANCE
) -> None:  # fmt: skip
    """Refuse free parameters that the data do not tell (ValueError)."""
    said = unidentifiable(jacobian, names, values, tolerance=tolerance)
    if said is not None:
        raise ValueError(said)
