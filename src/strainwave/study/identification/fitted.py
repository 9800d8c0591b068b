"""Common part of fits: values and intervals of their numbers by path.

Which parameters data do not tell, and what they tell instead.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import array_of, number, shown
from ...base.records import Result
from ...base.results import Floats
from ...base.sentences import listed
from ...compile.tree import numbers
from .discrepancy import Discrepancy
from .intervals import Interval, interval

TOLERANCE = 1e-6  # of the largest singular value, columns of length 1; differences have errors of about 1e-8
SMALL_ENTRY = 1e-3  # of the largest entry: a parameter that does not take part
EQUAL_CHANGE = 0.02  # how well relative changes are known to be equal


def unidentifiable(
    jacobian: Floats, names: Sequence[str], values: ArrayLike | None = None, *, tolerance: float = TOLERANCE
) -> str | None:
    """Name the combination of parameters that data do not tell.

    Parameters
    ----------
    jacobian : (n, p) array
        Derivatives of the residual by the parameters.
    names : sequence of str
        Names of the p parameters.
    values : (p,) array_like, optional
        Their values: changes are then told relative to them, and a common factor is known as one. Values of 0 and
        none: in units of the parameters.
    tolerance : float
        Singular value, of columns of length 1 and the largest, up to which there is none.

    Returns
    -------
    str or None
        One sentence, or None where the data tell every parameter.
    """
    table = array_of("jacobian", jacobian, None, len(names))
    scale = np.ones(len(names)) if values is None else np.abs(array_of("values", values, len(names)))
    tolerance = number("tolerance", tolerance)
    scale = np.where(scale > 0.0, scale, 1.0)
    sizes = np.linalg.norm(table, axis=0)
    idle = [name for name, size in zip(names, sizes, strict=True) if not size > 0.0]
    if idle:
        is_are = "it changes" if len(idle) == 1 else "they change"
        return f"the data do not determine {listed(idle)}: {is_are} nothing at these points; fix or excite it"
    _, singular, right = np.linalg.svd(table / sizes, full_matrices=False)
    lost = right[singular <= tolerance * singular[0]]
    if not len(lost):
        return None
    change = _simplest(lost / (sizes * scale))
    part = np.abs(change) > SMALL_ENTRY * np.max(np.abs(change))
    involved = [name for name, on in zip(names, part, strict=True) if on]
    sizes_of_change = change[part] * np.sign(change[part][0])
    if values is not None and np.all(np.abs(sizes_of_change / sizes_of_change[0] - 1.0) < EQUAL_CHANGE):
        return f"the data determine {listed(involved)} up to a common factor only: fix one of them"
    largest = np.max(np.abs(sizes_of_change))
    unit = " %" if values is not None else ""
    changes = [f"{name} by {value / largest:+.3g}{unit}" for name, value in zip(involved, sizes_of_change, strict=True)]
    return f"the data do not separate {listed(involved)}: changing {listed(changes)} changes nothing; fix one of them"


def _simplest(lost: Floats) -> Floats:
    """A change (p,) among those that are lost (k, p) with as few parameters as elimination leaves."""
    rows = lost / np.max(np.abs(lost), axis=1, keepdims=True)
    for i in range(len(rows)):
        pivot = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, pivot]
        for j in range(len(rows)):
            if j != i:
                rows[j] -= rows[j, pivot] * rows[i]
    return np.asarray(min(rows, key=lambda row: int(np.sum(np.abs(row) > SMALL_ENTRY * np.max(np.abs(row))))))


class Fit(Result):
    """A fit: value, deviation and interval of its numbers by path.

    `values` are by name, or in the order of `names`; `covariance` and `freedom` go with them.
    """

    values: Any
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    by_logarithm: ClassVar[tuple[str, ...]] = ()  # scales, whose interval is one of the logarithm

    def _by_name(self) -> dict[str, float]:
        """Values by name."""
        values: dict[str, float] = self.values
        return values

    def _name(self, path: str) -> str:
        name = str(path).rpartition(".")[2]
        if name in self.unidentified:
            raise ValueError(self.unidentified[name])
        if name not in self._by_name():
            raise ValueError(f"the fit has no {path!r}; it has {', '.join(self._by_name())}")
        return name

    def _index(self, path: str) -> int:
        return list(self._by_name()).index(self._name(path))

    def value(self, path: str) -> float:
        """Value of a number in SI, by its name or its path in the law: "K1", "second.yield_twist".

        Raises
        ------
        ValueError
            If there is no such number, or the measurement does not tell it.
        """
        return self._by_name()[self._name(path)]

    def deviation(self, path: str) -> float:
        """Standard deviation of a number in SI; errors as `value`."""
        index = self._index(path)
        return float(np.sqrt(self.covariance[index, index]))

    def interval(self, path: str, level: float = 0.95) -> Interval:
        """Interval (low, high) in SI that holds a number with the probability `level`; errors as `value`."""
        value, freedom = self.value(path), float(self.freedom[self._index(path)])
        if self._name(path) not in self.by_logarithm:
            return interval(value, self.deviation(path), freedom, level)
        low, high = interval(math.log(value), self.deviation(path) / value, freedom, level)
        return Interval(math.exp(max(low, -600.0)), math.exp(min(high, 600.0)))

    def numbers(self) -> dict[str, dict[str, float]]:
        """Every number by name, with the ends of its interval of 95 %, in SI."""
        return {name: {"value": value} | self.interval(name)._asdict() for name, value in self._by_name().items()}


@dataclass(frozen=True, eq=False)
class Fitted(Fit):
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

    def _by_name(self) -> dict[str, float]:
        return dict(zip(self.names, self.values.tolist(), strict=True))

    def _name(self, path: str) -> str:
        if path not in self.names:
            raise ValueError(f"{shown(path)} was not fitted; the free parameters are {', '.join(self.names) or 'none'}")
        return path

    def lines(self) -> list[str]:
        """One line for each free parameter: value and 95 % interval."""
        bounds = [self.interval(name) for name in self.names]
        return [
            f"  {name} = {value:.6g} ({low:.6g} .. {high:.6g})"
            for name, value, (low, high) in zip(self.names, self.values, bounds, strict=True)
        ]


def bounds(system: Any, free: Sequence[str]) -> tuple[Floats, Floats]:
    """Least and largest free parameters: inertias, dampings and a law's numbers keep the sign of their start values.

    Amplitudes without phases are the same for B and for -B.
    """
    start = {path: value for path, _, name, value in numbers(system) if name in ("J", "B") or path.startswith("law.")}
    kept = [start.get(path, 0.0) for path in free]
    return np.where(np.greater(kept, 0.0), 0.0, -np.inf), np.where(np.less(kept, 0.0), 0.0, np.inf)


def derivatives(function: Callable[[Floats], Floats], x: Floats, steps: Floats) -> Floats:
    """Derivatives (n, p) of a function of numbers (p,) by central differences; 0 by a number without a step."""
    turned = zip(np.diag(steps), steps, strict=True)
    return np.stack([(function(x + d) - function(x - d)) / (2.0 * (step or 1.0)) for d, step in turned], axis=1)


def refuse_unidentifiable(
    jacobian: Floats, names: Sequence[str], values: Floats, tolerance: float = TOLERANCE
) -> None:  # fmt: skip
    """Refuse free parameters that the data do not tell (ValueError)."""
    reason = unidentifiable(jacobian, names, values, tolerance=tolerance)
    if reason is not None:
        raise ValueError(reason)
