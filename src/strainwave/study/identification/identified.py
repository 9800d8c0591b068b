"""What `identify` found, and what it says of other records."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...numerics.driven.signal import Between
from ...quantities import numbers, shown
from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen
from .channels import channels_of
from .discrepancy import Discrepancy
from .experiment import Experiment, Record
from .intervals import Interval, interval
from .windows import fitted_start

MOST_OF_START = 50  # samples that a start is fitted to


@dataclass(frozen=True, eq=False)
class Identified(Result):
    """What `identify` found.

    Attributes
    ----------
    system : NamedTuple
        The system with the numbers found, inputs as they were given.
    free : tuple of str
        Paths of the free numbers.
    values : (free,) array
        Their values, in the units of the model.
    covariance : (free, free) array
        Of the values, with coloured residuals.
    freedom : (free,) array
        Degrees of freedom of its diagonal.
    outputs : tuple of str
        Measured states.
    rms, size : (outputs,) arrays
        Root mean square of the residual, and of the output about its mean.
    residual : (outputs, n) array
        Measured less computed, records one after the other; NaN where nothing was measured.
    discrepancy : Discrepancy
        What the model does not explain: colour and lines of the residual, and terms that it lacks. Of several outputs
        the residuals are those over the noise of each.
    between : {"band-limited", "linear", "held"}
        What the inputs did between samples.
    parts : int
        Steps of the integration between two samples.
    converged : bool
        Whether the last steps were small beside the deviations.
    notes : tuple of str
        What to know before the numbers are used.
    step : float
        Of the samples [s].
    """

    rows: ClassVar[str] = "number"

    system: Any
    free: tuple[str, ...]
    values: Floats
    covariance: Floats
    freedom: Floats
    outputs: tuple[str, ...]
    rms: Floats
    size: Floats
    residual: Floats
    discrepancy: Discrepancy
    between: Between
    parts: int
    converged: bool
    notes: tuple[str, ...]
    step: float
    experiment: Experiment

    def value(self, path: str) -> float:
        """Value of a free number."""
        return float(self.values[self._place(path)])

    def deviation(self, path: str) -> float:
        """Its standard deviation."""
        i = self._place(path)
        return float(np.sqrt(self.covariance[i, i]))

    def interval(self, path: str, level: float = 0.95) -> Interval:
        """Interval that covers it with this probability, if the model is right."""
        return interval(self.value(path), self.deviation(path), float(self.freedom[self._place(path)]), level)

    def interval_of(self, function: Callable[[Any], float], level: float = 0.95) -> Interval:
        """Interval of what follows from the system, such as the speed of a jump.

        Parameters
        ----------
        function : callable
            Number of a system; it is called for the system found, and once for each free number of it.
        level : float
            Probability of covering, to first order in the numbers (delta method).
        """
        first, gradient = float(function(self.system)), np.zeros(len(self.free))
        for i, (value, deviation) in enumerate(zip(self.values, self.deviations, strict=True)):
            changed = self.values.copy()
            changed[i] = value + 0.5 * deviation
            gradient[i] = (float(function(self.experiment.found(changed))) - first) / (0.5 * deviation)
        spread = math.sqrt(float(gradient @ self.covariance @ gradient))
        return interval(first, spread, float(np.min(self.freedom)), level)

    def _place(self, path: str) -> int:
        if path not in self.free:
            raise ValueError(f"{shown(path)} was not free; found are {', '.join(self.free)}")
        return self.free.index(path)

    @property
    def deviations(self) -> Floats:
        """Standard deviations (free,)."""
        return np.sqrt(np.diag(self.covariance))

    def simulate(self, inputs: Mapping[str, Any] | Any, start: Any) -> dict[str, Floats]:
        """Run freely over other inputs.

        Parameters
        ----------
        inputs : Log, or dict of str to (n,) array
            Channels of the inputs, as in the log; a dictionary has "time" too, or the sample rate of the log is meant.
        start : tuple of float, or dict of str to (m,) array
            State at the first sample; or the first measured samples of the outputs' channels (or the log itself, of
            which the first 50 are taken), which the state is fitted to.

        Returns
        -------
        dict of str to (n,) array
            By channel of the outputs.
        """
        of, step = self.experiment, self.step
        channels = channels_of(inputs)
        missing = [name for name in of.inputs.values() if name not in channels]
        if missing:
            raise ValueError(f"inputs have no channel {missing[0]!r}; they have {', '.join(channels) or 'none'}")
        rows = np.array([numbers(name, channels[name]) for name in of.inputs.values()])
        first = self._first(start)
        samples = rows.shape[1] if len(rows) else len(channels["time"])
        nothing = np.full((len(of.outputs), samples), np.nan)
        if isinstance(first, tuple):
            y = numbers("start", first, count=len(of.states()))
        else:
            many = min(samples, *(len(values) for values in first))
            nothing[:, :many] = [values[:many] for values in first]
            y = fitted_start(of, self.values, Record(rows, nothing, step), many, self.parts)
        record = Record(rows, nothing, step)
        lanes = of.lanes([self.values], step, self.parts)
        pieces = record.pieces(of, self.values, self.parts)
        seen = lanes.run(y[:, None], pieces, of.seen(), samples, self.parts, step)[:, :, 0]
        given = of.of_outputs(self.values)
        seen = given["offset"][:, None] + given["gain"][:, None] * seen
        return {name: row for name, row in zip(of.outputs.values(), seen, strict=True)}

    def _first(self, start: Any) -> Any:
        if isinstance(start, tuple | list):
            return tuple(start)
        given = channels_of(start)
        missing = [name for name in self.experiment.outputs.values() if name not in given]
        if missing:
            raise ValueError(f"start has no channel {missing[0]!r}; give its first samples, or the state as a tuple")
        return [numbers(name, given[name])[:MOST_OF_START] for name in self.experiment.outputs.values()]

    def __str__(self) -> str:
        lines = [
            f"Identified: {type(self.system).__name__}, {len(self.free)} numbers from {self.residual.shape[1]} samples"
        ]
        width = max(map(len, self.free))
        for path in self.free:
            low, high = self.interval(path)
            lines.append(f"  {path:<{width}}  {self.value(path):.6g}  (95 %: {low:.6g} to {high:.6g})")
        for name, rms, size in zip(self.outputs, self.rms, self.size, strict=True):
            lines.append(f"  {name}: residual {rms:.4g} rms, {100.0 * rms / size:.3g} % of the motion")
        lines.append(f"  inputs {self.between} between samples; {self.discrepancy}")
        return on_screen("\n".join(lines + [f"  {note}" for note in self.notes]))

    __repr__ = __str__

    def coordinates(self) -> Labelled:
        """Paths of the numbers."""
        return {"number": ("number", np.array(self.free), "")}

    def variables(self) -> Labelled:
        """Values, deviations and residuals."""
        return {
            "value": ("number", self.values, ""),
            "deviation": ("number", self.deviations, ""),
            "residual": (("output", "sample"), self.residual, ""),
        }
