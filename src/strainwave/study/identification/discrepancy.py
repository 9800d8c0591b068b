"""Misfit of a model: colour of its residual, a line in it, missing terms."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import gammaincc

from ...base.quantities import SMALLEST, array_of, number
from ...base.results import Floats
from ...base.sentences import listed
from .intervals import backwards, fitting, long_run, orthogonal, slices, whitened, whitener

LAGS = 20  # of the portmanteau test
CHANCE = 0.05  # probability up to which chance is not believed
NEIGHBOURS = 101  # frequencies whose median is the noise around a line
LEAST_PART = 1e-3  # of a candidate's size: what the parameters leave of it when they can stand for it


@dataclass(frozen=True)
class MissingTerm:
    """A term that the model does not have.

    Attributes
    ----------
    coefficient, deviation : float
        Of the term, estimated beside the model's parameters, and its standard deviation.
    probability : float
        Of a coefficient as far from 0 by chance.
    share : float
        Fraction of the residual's power that the term takes away.
    """

    coefficient: float
    deviation: float
    probability: float
    share: float


@dataclass(frozen=True)
class Discrepancy:
    """Residual of a model against the measurement.

    Attributes
    ----------
    rms : float
        Of the residual, in its unit.
    white : float
        Probability that neighbours of white noise are as correlated (Ljung & Box 1978, Biometrika 65, 20 lags).
    coloured : float
        Fraction of the residual's power that its own past predicts.
    line, line_amplitude, line_probability : float
        Frequency [Hz] of the residual's strongest line above the noise around it, its amplitude
        0-to-peak, and the probability that noise with a smooth spectrum has one as strong.
    missing : dict of str to MissingTerm
        Candidates that were tried, by name.
    """

    rms: float
    white: float
    coloured: float
    line: float
    line_amplitude: float
    line_probability: float
    missing: Mapping[str, MissingTerm]

    @property
    def flagged(self) -> tuple[str, ...]:
        """Candidates that the model lacks: chance has them less than once in 20 measurements, all tried together."""
        return tuple(name for name, term in self.missing.items() if term.probability * len(self.missing) < CHANCE)

    def __str__(self) -> str:
        colour = "white" if self.white >= CHANCE else f"coloured: {100.0 * self.coloured:.3g} % predictable"
        parts = [f"residual {self.rms:.4g} rms, {colour}"]
        if self.line_probability < CHANCE:
            parts.append(f"a line of {self.line_amplitude:.4g} at {self.line:.6g} Hz")
        if self.flagged:
            terms = [f"{name} (explains {100.0 * self.missing[name].share:.3g} % of the rest)" for name in self.flagged]
            parts.append(f"missing in the model: {listed(terms)}")
        elif self.missing:
            parts.append(f"no sign of {listed(self.missing, ' or ')}")
        return "; ".join(parts)


def discrepancy(
    residual: Floats,
    jacobian: Floats,
    candidates: Mapping[str, Floats] | None = None,
    *,
    records: Any = None,
    interval: float = 1.0,
) -> Discrepancy:
    """Name what a fitted model does not explain.

    A candidate is what a missing term would add to the computed values, to first order and times any constant. What
    the parameters can stand for is taken from it; then its score is tested with the residual's own colour (Lagrange
    multiplier test, Breusch & Pagan 1980, Rev. Econ. Stud. 47, with the sandwich of `spread`).

    Parameters
    ----------
    residual : (n,) array
        Measured less computed.
    jacobian : (n, p) array
        Derivatives of the computed values by the parameters.
    candidates : dict of str to (n,) array, optional
        Terms by name.
    records : sequence of int or of slice, optional
        As for `spread`.
    interval : float
        Between neighbouring rows [s].

    Returns
    -------
    Discrepancy
        `rms` of the residual in its unit; `coloured`, the share of its power that its past predicts (0 to 1); its
        strongest `line` [Hz]; `missing`, terms that the residual has and the model has not, by name, each with its
        size and its probability by chance: none where nothing is found.
    """
    jacobian, residual = fitting(jacobian, residual)
    interval = number("interval [s]", interval, positive=True)
    parts = slices(records, len(residual))
    a = whitener(residual, parts)
    left = whitened(residual, a, parts)
    power = float(residual @ residual)
    coloured = max(0.0, 1.0 - float(left @ left) / power) if power > 0.0 else 0.0
    line = _line(residual[max(parts, key=lambda part: part.stop - part.start)], interval)
    missing = _missing(candidates or {}, jacobian, residual, a, parts)
    rms = float(np.sqrt(power / len(residual)))
    return Discrepancy(rms, white(residual, parts), coloured, *line, missing)


def white(residual: Floats, parts: list[slice]) -> float:
    """Probability of Ljung and Box."""
    power, n = float(residual @ residual), len(residual)
    lags = range(1, min(LAGS, n // 5) + 1)
    if not (power > 0.0 and lags):
        return 1.0
    rho = [sum(float(residual[p][lag:] @ residual[p][: -lag or None]) for p in parts) / power for lag in lags]
    total = n * (n + 2) * sum(r * r / (n - lag) for r, lag in zip(rho, lags, strict=True))
    return float(gammaincc(0.5 * len(lags), 0.5 * total))


def _line(residual: Floats, interval: float) -> tuple[float, float, float]:
    """Frequency [1/s], amplitude and probability of the line that stands highest above its neighbours' median."""
    n = len(residual)
    powers: Floats = np.abs(np.fft.rfft(residual - np.mean(residual)))[1 : (n + 1) // 2] ** 2
    if not (len(powers) and np.sum(powers) > 0.0):
        return 0.0, 0.0, 1.0
    floor = median_filter(powers, min(NEIGHBOURS, len(powers)), mode="nearest") / np.log(2.0)
    ratio: Floats = powers / np.maximum(floor, np.mean(powers) * 1e-12)
    k = int(np.argmax(ratio))
    amplitude = 2.0 / n * abs(np.exp(-2j * np.pi * (k + 1) / n * np.arange(n)) @ residual)
    chance = -np.expm1(len(powers) * np.log1p(-np.exp(-min(ratio[k], 700.0))))
    return (k + 1) / (n * interval), float(amplitude), float(chance)


def _missing(
    candidates: Mapping[str, Any], jacobian: Floats, residual: Floats, a: Floats, parts: list[slice]
) -> dict[str, MissingTerm]:  # fmt: skip
    """Score tests of all candidates, each beside the parameters alone, with the filter of the residual."""
    given = [array_of(f"candidate {name}", v, len(residual)) for name, v in candidates.items()]
    columns = np.array(given).reshape(len(given), len(residual)).T
    sizes = np.linalg.norm(columns, axis=0)
    columns = columns / np.where(sizes > 0.0, sizes, 1.0)
    lengths = np.linalg.norm(jacobian, axis=0)
    moving = lengths > SMALLEST  # a parameter that moves nothing stands for no candidate
    cleared = orthogonal(np.linalg.qr(jacobian[:, moving] / lengths[moving])[0], columns)
    lengths = np.linalg.norm(cleared, axis=0)
    coefficients = residual @ cleared / np.where(lengths > LEAST_PART, lengths, 1.0) ** 2
    left = np.array([whitened(residual - c * one, a, parts) for c, one in zip(coefficients, cleared.T, strict=True)]).T
    scores = backwards(cleared, a, parts) * left
    power, terms = float(residual @ residual), {}
    for i, name in enumerate(candidates):
        if not (lengths[i] > LEAST_PART and power > 0.0):
            terms[name] = MissingTerm(0.0, np.inf, 1.0, 0.0)
            continue
        coefficient, size = float(coefficients[i]), float(sizes[i])
        deviation = math.sqrt(float(long_run(scores[:, i : i + 1], parts)[0, 0])) / float(lengths[i]) ** 2
        chance = math.erfc(abs(coefficient) / deviation / math.sqrt(2.0)) if deviation > 0.0 else 0.0
        share = float((coefficient * lengths[i]) ** 2 / power)
        terms[name] = MissingTerm(coefficient / size, deviation / size, chance, share)
    return terms
