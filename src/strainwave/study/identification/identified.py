"""Result of `identify`, and its prediction of other records."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.quantities import joined, number_of, numbers
from ...base.records import Along, Labelled
from ...base.results import Floats, SolveError
from ...base.terminal import on_screen
from .channels import STEP_SCATTER, channels_of, even_step, input_row, refuse_lengths, refuse_missing, row_of
from .experiment import Experiment, Record
from .fitted import Fitted
from .input_signals import Between
from .intervals import Interval, interval
from .window_fit import fitted_start

START_SAMPLES = 50  # samples that a start is fitted to


@dataclass(frozen=True, eq=False)
class Identified(Fitted):
    """Result of `identify`: a `Fitted` system, its inputs as they were given, and its misfit to the signals.

    The discrepancy of several outputs is that of the residuals over the noise of each.

    Attributes
    ----------
    outputs : tuple of str
        Measured states.
    rms, size : (outputs,) arrays
        Root mean square of the residual, and of the output about its mean.
    residual : (outputs, n) array
        Measured less computed, records one after the other; NaN where nothing was measured.
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
    arrays: ClassVar[Along] = {("output", "sample"): {"residual": ""}}

    outputs: tuple[str, ...]
    rms: Floats
    size: Floats
    residual: Floats
    between: Between
    parts: int
    converged: bool
    notes: tuple[str, ...]
    step: float
    experiment: Experiment

    def interval_of(self, function: Callable[[Any], float], level: float = 0.95) -> Interval:
        """Interval of what follows from the system, such as the speed of a jump.

        Parameters
        ----------
        function : callable
            Number of a system; it is called for the system found, and once for each free number of it.
        level : float
            Probability of covering, to first order in the numbers (delta method).
        """
        text = "the system found, or one within its deviations"
        first, gradient = number_of(function, self.system, text), np.zeros(len(self.names))
        for i, (value, deviation) in enumerate(zip(self.values, self.deviations, strict=True)):
            changed = self.values.copy()
            changed[i] = value + 0.5 * deviation
            gradient[i] = (number_of(function, self.experiment.fitted(changed), text) - first) / (0.5 * deviation)
        spread = math.sqrt(float(gradient @ self.covariance @ gradient))
        return interval(first, spread, float(np.min(self.freedom)), level)

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

        Raises
        ------
        ValueError
            If the inputs or the start do not fit the system or the step of the log.
        SolveError
            If the motion leaves every bound.
        """
        setup, table = self.experiment, self._inputs(channels_of(inputs))
        samples, first = table.shape[1], self._start_state(start, table)
        unmeasured = np.full((len(setup.outputs), samples), np.nan)
        pieces = Record(table, unmeasured, self.step).pieces(setup, self.values, self.parts)
        lanes = setup.lanes([self.values], self.step, self.parts)
        outputs = lanes.run(first[:, None], pieces, setup.seen(), samples, self.parts, self.step)[:, :, 0]
        if not np.all(np.isfinite(outputs)):
            i = int(np.flatnonzero(~np.all(np.isfinite(outputs), axis=0))[0])
            raise SolveError(
                f"the simulated motion diverges before sample {i}, {i * self.step:.4g} s: use inputs of the size "
                "of those of the log, and a start on the motion"
            )
        given = setup.of_outputs(self.values)
        outputs = given["offset"][:, None] + given["gain"][:, None] * outputs
        return dict(zip(setup.outputs.values(), outputs, strict=True))

    def _inputs(self, channels: Mapping[str, Any]) -> Floats:
        """Rows (inputs, samples) of the inputs in their channels, whose step must be that of the log (ValueError)."""
        names = self.experiment.inputs.values()
        refuse_missing("inputs have", names, channels, f"they have {joined(channels) or 'none'}")
        rows = {name: input_row("inputs", name, channels[name]) for name in names}
        samples = len(next(iter(rows.values()), channels.get("time", ())))
        if samples < 2:
            raise ValueError(f"inputs have {samples} samples; give 2 at least")
        if "time" in channels:
            time = numbers("inputs: time", channels["time"])
            refuse_lengths("inputs", rows, len(time))
            dt, step = even_step("inputs", time), self.step
            if abs(dt - step) > STEP_SCATTER * step:
                raise ValueError(f"inputs have a step of {dt:g} s, the log had {step:g} s; resample them to that")
        refuse_lengths("inputs", rows, samples)
        return np.array(list(rows.values())).reshape(len(rows), samples)

    def _start_state(self, start: Any, table: Floats) -> Floats:
        """State at the first sample of inputs: as given, or fitted to the first measured samples (ValueError)."""
        setup, samples = self.experiment, table.shape[1]
        if isinstance(start, tuple | list | np.ndarray):
            return numbers("start", tuple(start), count=len(setup.states()))
        given, names = channels_of(start), setup.outputs.values()
        refuse_missing("start has", names, given, "give its first samples, or the state as a tuple")
        rows = [row_of("start", name, given[name])[:START_SAMPLES] for name in names]
        if not all(np.any(np.isfinite(row)) for row in rows):
            raise ValueError("start has no measured sample; give the first samples, or the state as a tuple")
        many = min(samples, *map(len, rows))
        measured = np.full((len(rows), samples), np.nan)
        measured[:, :many] = [row[:many] for row in rows]
        return fitted_start(setup, self.values, Record(table, measured, self.step), many, self.parts)

    def __str__(self) -> str:
        samples, width = self.residual.shape[1], max(map(len, self.names))
        lines = [f"Identified: {type(self.system).__name__}, {len(self.names)} numbers from {samples} samples"]
        for path in self.names:
            low, high = self.interval(path)
            lines.append(f"  {path:<{width}}  {self.value(path):.6g}  (95 %: {low:.6g} to {high:.6g})")
        return on_screen("\n".join([*lines, *(f"  {line}" for line in self.quality())]))

    def quality(self) -> list[str]:
        """Sentences on what the system leaves of each output, and how the inputs were taken."""
        rows = zip(self.outputs, self.rms, self.size, strict=True)
        left = [f"{name}: residual {rms:.4g} rms, {100.0 * rms / size:.3g} % of the motion" for name, rms, size in rows]
        return [*left, f"inputs {self.between} between samples; {self.discrepancy}", *self.notes]

    def coordinates(self) -> Labelled:
        """Paths of the numbers."""
        return {"number": ("number", np.array(self.names), "")}

    def variables(self) -> Labelled:
        """Values, deviations and residuals."""
        numbers = {"value": ("number", self.values, ""), "deviation": ("number", self.deviations, "")}
        return {**numbers, **super().variables()}
