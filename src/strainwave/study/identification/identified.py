"""Result of `identify`, and its prediction of other records.

Channels of a log, or of a dictionary, as the records that an experiment needs.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.quantities import joined, number_of, numbers, shown
from ...base.records import Along, Labelled
from ...base.results import Floats, SolveError
from ...base.sentences import counted, on_screen
from .driven import Between
from .experiment import Experiment, Record
from .fitted import Fitted
from .intervals import Interval, interval
from .run import refuse_descending
from .window_fit import fitted_start

TWIST_SHARE, TWIST_RAD = 0.1, 0.02  # of the load's turn, and rad: what a gear may twist

START_SAMPLES = 50  # samples that a start is fitted to

FEWEST_SAMPLES = 16  # samples of a record
STEP_SCATTER = 0.05  # of a step: what a time may be off by
LEAST_SIGNAL, LARGEST_SIGNAL = 1e-30, 1e30  # of a signal, in any unit


def channels_of(log: Any) -> dict[str, Any]:
    """Time and channels of a log, or of a dictionary of arrays."""
    return dict(log) if isinstance(log, Mapping) else {"time": log.time, **log.channels}


def record_of(setup: Experiment, channels: Mapping[str, Any], number_of: int | None) -> Record:
    """Record of the channels that an experiment needs."""
    label = "log" if number_of is None else f"log {number_of}"
    for name in ("time", *setup.inputs.values(), *setup.outputs.values()):
        if name not in channels:
            raise ValueError(f"{label} has no channel {name!r}; it has {joined(channels)}")
    time = numbers(f"{label}: time", channels["time"])
    if len(time) < FEWEST_SAMPLES:
        raise ValueError(f"{label} has {len(time)} samples; give {FEWEST_SAMPLES} at least")
    step = even_step(label, time)
    rows = {name: input_row(label, name, channels[name]) for name in setup.inputs.values()}
    rows |= {name: row_of(label, name, channels[name]) for name in setup.outputs.values()}
    refuse_lengths(label, rows, len(time))
    for state, name in setup.outputs.items():
        measured = rows[name][np.isfinite(rows[name])]
        if len(measured) < FEWEST_SAMPLES:
            raise ValueError(f"{label}: {name} has {len(measured)} values; give {FEWEST_SAMPLES} at least")
        if not np.ptp(measured) > LEAST_SIGNAL:
            raise ValueError(f"{label}: {name} is {measured[0]:g} throughout; nothing moves: give a record with motion")
        if f"{state}.delay" in setup.free and len(measured) < len(time):
            gaps = counted(len(time) - len(measured), "gap")
            raise ValueError(f"{label}: {name} has {gaps}, and a delay of it is free: fill or cut them")
    inputs = np.array([rows[name] for name in setup.inputs.values()]).reshape(len(setup.inputs), len(time))
    outputs = np.array([rows[name] for name in setup.outputs.values()])
    outputs[~np.isfinite(outputs)] = np.nan
    return Record(inputs, outputs, step)


def row_of(label: str, name: str, values: Any) -> Floats:
    """One channel (n,) of real numbers, NaN where nothing was measured (ValueError)."""
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        array = np.array([None])
    if array.ndim != 1 or array.dtype.kind not in "iufb":
        raise ValueError(
            f"{label}: {name} has the shape {array.shape} and values such as {shown(values)[:40]}; give one row of "
            "real numbers"
        )
    with np.errstate(over="ignore"):
        row = array.astype(float)
    if np.any(np.abs(row[np.isfinite(row)]) > LARGEST_SIGNAL):
        raise ValueError(f"{label}: {name} has values beyond {LARGEST_SIGNAL:g}; give it in SI")
    return row


def with_torsion(channels: Mapping[str, Any], N: float) -> dict[str, Any]:
    """Channels with the torsion theta_m/N - theta_l [rad]; a load that turns against the motor is counted with it.

    Raises
    ------
    ValueError
        If an angle is missing, or the angles are not those of a gear of this ratio.
    """
    for name in ("motor_angle", "load_angle"):
        if name not in channels:
            raise ValueError(f"log has no channel {name!r}; it has {joined(channels)}: name the column of it")
    motor, load = [row_of("log", name, channels[name]) for name in ("motor_angle", "load_angle")]
    if motor.shape != load.shape:
        raise ValueError(f"log: motor_angle has {len(motor)} samples and load_angle {len(load)}; give equally many")
    finite = np.isfinite(motor) & np.isfinite(load)
    if np.count_nonzero(finite) < 2:
        raise ValueError("log: motor_angle and load_angle have no two samples in common; give both at the same times")
    sense = -1.0 if np.cov(motor[finite], load[finite])[0, 1] < 0.0 else 1.0
    torsion = motor / N - sense * load
    turned, twisted = float(np.ptp(load[finite])), float(np.ptp(torsion[finite]))
    if twisted > max(TWIST_SHARE * turned, TWIST_RAD):
        raise ValueError(
            f"log: motor_angle turns {np.ptp(motor[finite]):.4g} rad and load_angle {turned:.4g} rad, which is no gear "
            f"of ratio {N:g}; take the gear of the log, or give both angles on their own shafts"
        )
    return {**channels, "torsion": torsion}


def input_row(where: str, name: str, values: Any) -> Floats:
    """One channel (n,) that is known at all samples (ValueError)."""
    row = row_of(where, name, values)
    if not np.all(np.isfinite(row)):
        i = int(np.flatnonzero(~np.isfinite(row))[0])
        raise ValueError(f"{where}: {name} is {row[i]} at sample {i}; an input must be known at all samples")
    return row


def refuse_lengths(where: str, rows: Mapping[str, Floats], samples: int) -> None:
    """Refuse channels that have not as many samples as the time (ValueError)."""
    for name, row in rows.items():
        if len(row) != samples:
            raise ValueError(f"{where}: {name} has {len(row)} samples and time {samples}; give equally many")


def even_step(label: str, time: Floats) -> float:
    """Mean step [s] of two times or more, which must ascend by equal steps (ValueError)."""
    refuse_descending(time, f"{label}: time")
    steps = np.diff(time)
    step = float(time[-1] - time[0]) / (len(time) - 1)
    if np.max(np.abs(time - time[0] - step * np.arange(len(time)))) > STEP_SCATTER * float(np.median(steps)):
        raise ValueError(
            f"{label}: time has steps from {np.min(steps):g} to {np.max(steps):g} s; resample to equal steps"
        )
    return step


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
        setup, step = self.experiment, self.step
        channels = channels_of(inputs)
        missing = [name for name in setup.inputs.values() if name not in channels]
        if missing:
            raise ValueError(f"inputs have no channel {missing[0]!r}; they have {joined(channels) or 'none'}")
        rows = {name: input_row("inputs", name, channels[name]) for name in setup.inputs.values()}
        samples = len(next(iter(rows.values()), channels.get("time", ())))
        if samples < 2:
            raise ValueError(f"inputs have {samples} samples; give 2 at least")
        if "time" in channels:
            time = numbers("inputs: time", channels["time"])
            refuse_lengths("inputs", rows, len(time))
            dt = even_step("inputs", time)
            if abs(dt - step) > STEP_SCATTER * step:
                raise ValueError(f"inputs have a step of {dt:g} s, the log had {step:g} s; resample them to that")
        refuse_lengths("inputs", rows, samples)
        first = self._first(start)
        table = np.array(list(rows.values())).reshape(len(rows), samples)
        nothing = np.full((len(setup.outputs), samples), np.nan)
        if isinstance(first, tuple):
            y = numbers("start", first, count=len(setup.states()))
        else:
            many = min(samples, *(len(values) for values in first))
            nothing[:, :many] = [values[:many] for values in first]
            y = fitted_start(setup, self.values, Record(table, nothing, step), many, self.parts)
        pieces = Record(table, nothing, step).pieces(setup, self.values, self.parts)
        lanes = setup.lanes([self.values], step, self.parts)
        outputs = lanes.run(y[:, None], pieces, setup.seen(), samples, self.parts, step)[:, :, 0]
        if not np.all(np.isfinite(outputs)):
            i = int(np.flatnonzero(~np.all(np.isfinite(outputs), axis=0))[0])
            raise SolveError(
                f"the motion leaves every bound before sample {i}, {i * step:.4g} s: give inputs as large as those "
                "of the log, and a start on the motion"
            )
        given = setup.of_outputs(self.values)
        outputs = given["offset"][:, None] + given["gain"][:, None] * outputs
        return dict(zip(setup.outputs.values(), outputs, strict=True))

    def _first(self, start: Any) -> Any:
        if isinstance(start, tuple | list | np.ndarray):
            return tuple(start)
        given = channels_of(start)
        missing = [name for name in self.experiment.outputs.values() if name not in given]
        if missing:
            raise ValueError(f"start has no channel {missing[0]!r}; give its first samples, or the state as a tuple")
        rows = [row_of("start", name, given[name])[:START_SAMPLES] for name in self.experiment.outputs.values()]
        if not all(np.any(np.isfinite(row)) for row in rows):
            raise ValueError("start has no measured sample; give the first samples, or the state as a tuple")
        return rows

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
