"""A system's numbers from measured signals: output error in windows that grow until whole records run freely."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...numerics.driven.signal import Between
from ...quantities import checked, numbers, positive_count, shown
from ...records import Labelled, Result
from ...results import Floats, SolveError
from ...sentences import on_screen
from .candidates import candidate_columns
from .discrepancy import Discrepancy, discrepancy
from .experiment import Experiment, Record, experiment
from .identifiability import unidentifiable
from .intervals import Interval, Spread, interval, spread
from .windows import LeastSquares, Point, Window, reweighted, solve, windows_of

FIRST_WINDOW = 48  # samples of the first windows
GROWTH = 6  # of the windows from one round to the next
EARLY = 6_000  # samples that the early rounds look at
EARLY_STEPS, LATE_STEPS = 5, 40
ACCURATE = 1e-4  # of the outputs' size: what halving the steps may change
MOST_PARTS = 64
LOOKED_AT = 400  # samples that the number of steps is chosen on
FEWEST = 16  # samples of a record
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


def identify(
    system: Any,
    log: Any,
    free: Sequence[str],
    *,
    inputs: Mapping[str, str] | None = None,
    outputs: Mapping[str, str] | None = None,
    between: Between = "band-limited",
    steps: int | None = None,
    progress: Callable[[str, float], None] = lambda _what, _share: None,
) -> Identified:
    """Find numbers of a system from measured signals.

    The system runs with the measured inputs, and its numbers and its start are changed until the measured states are
    met (output error). Short windows with starts of their own come first, then longer ones, then whole records that run
    freely: rough first numbers do. Inputs are what the log says at the samples; what they do between is assumed, and
    decides the result where the sample rate is a few times the resonance.

    Parameters
    ----------
    system : NamedTuple
        Any system with states; its numbers are the first guess.
    log : Log, dict of str to array, or sequence of these
        Channels "time" [s], at equal steps, and others by name; several are separate records.
    free : sequence of str
        Paths of the numbers to find, for example "law.K"; "excitation.gain", "excitation.offset" or
        "excitation.delay" [s] of an input; "x.gain", "x.offset" or "x.delay" of a measured state.
    inputs : dict of str to str, optional
        For each part of the system that was measured, its path and the channel: ``{"excitation": "input"}``, which is
        the default where there is such a channel. A torque or a motion may stand there.
    outputs : dict of str to str, optional
        For each measured state its name and the channel. Default: the first state, channel "output".
    between : {"band-limited", "linear", "held"}
        What inputs do between samples: a controller's torque is held, an analogue signal behind a filter band-limited.
    steps : int, optional
        Steps of the integration between two samples. Default: as many as the outputs need.
    progress : callable
        Told what is done, and which share of all.

    Returns
    -------
    Identified

    Raises
    ------
    ValueError
        If a path, a state or a channel does not exist, or some numbers cannot be told apart: which is said.
    SolveError
        If the motion leaves every bound from the given numbers.

    References
    ----------
    Ljung 1999, System Identification, 2nd ed., ch. 7 (output error); Bock 1983 (multiple shooting); Schoukens & Ljung
    2019, IEEE Control Syst. Mag. 39(6), 28-99 (simulation error; what an input does between samples).
    """
    logs = [channels_of(one) for one in (log if isinstance(log, list | tuple) else [log])]
    if not logs:
        raise ValueError("log is empty; give one record at least")
    if inputs is None:
        inputs = {"excitation": "input"} if "input" in logs[0] else {}
    first_state = (list(getattr(system, "state_names", tuple)()) or ["x"])[0]
    of = experiment(system, inputs, {first_state: "output"} if outputs is None else outputs, free, between)
    records = [record_of(of, channels, i if len(logs) > 1 else None) for i, channels in enumerate(logs)]
    if len({round(record.step, 12) for record in records}) > 1:
        steps_of = ", ".join(f"{record.step:g} s" for record in records)
        raise ValueError(f"the records have different steps, {steps_of}; resample them to one")
    values, noise = of.first(), _spread_of(records)
    parts = positive_count("steps", steps) if steps is not None else _parts(of, records, values, noise)
    point: Point | None = None
    length, longest = FIRST_WINDOW, max(len(record) for record in records)
    early = [record.first(max(EARLY // len(records), FIRST_WINDOW)) for record in records]
    while length < min(longest, EARLY):
        progress(f"windows of {length} samples", 0.5 * length / EARLY)
        problem = LeastSquares(of, windows_of(early, length), noise, parts)
        point, _ = solve(problem, _finite(problem.begin(values)), EARLY_STEPS)
        values, length = point.values, length * GROWTH
    whole = [Window(record, 0, len(record)) for record in records]
    problem = LeastSquares(of, whole, noise, parts)
    point = _finite(problem.begin(values))
    point, _ = solve(problem, point, 3, lambda i, _c: progress("whole records", 0.5 + 0.1 * i))
    if len(noise) > 1:
        problem = reweighted(problem, point)
        point = problem.at(point.values, point.starts)
    point, converged = solve(problem, point, LATE_STEPS, lambda i, _c: progress("whole records", 0.8 + 0.01 * i))
    progress("identified", 1.0)
    return _result(of, problem, point, converged, records)


def _finite(point: Point) -> Point:
    if not np.isfinite(point.cost()):
        raise SolveError(
            "the motion left every bound from the numbers given; start from others, for example with more damping"
        )
    return point


def _spread_of(records: Sequence[Record]) -> Floats:
    outputs = np.concatenate([record.outputs for record in records], axis=1)
    return np.asarray(np.nanstd(outputs, axis=1))


def _parts(of: Experiment, records: Sequence[Record], values: Floats, noise: Floats) -> int:
    """Steps between two samples: twice as many change the outputs by less than `ACCURATE` of their size."""
    window = windows_of([records[0].first(LOOKED_AT)], LOOKED_AT)[0]
    before, parts = None, 1
    while parts <= MOST_PARTS:
        problem = LeastSquares(of, [window], noise, parts)
        now = problem.begin(values).residuals[0]
        if before is not None and len(now) == len(before) and np.sqrt(np.mean((now - before) ** 2)) < ACCURATE:
            return parts // 2
        before, parts = now, 2 * parts
    return MOST_PARTS


def _result(
    of: Experiment, problem: LeastSquares, point: Point, converged: bool, records: Sequence[Record]
) -> Identified:  # fmt: skip
    columns, rest = point.reduced()
    size = np.linalg.norm(columns, axis=0)
    if (lost := unidentifiable(columns, of.free, point.values)) is not None:
        raise ValueError(lost)
    many = [len(r) for r in point.residuals]
    found: Spread = spread(columns / size, rest, many)
    unit = float(problem.noise[0]) if len(problem.noise) == 1 else 1.0
    lacking = {name: unit * column for name, column in candidate_columns(problem, point).items()}
    told = discrepancy(-unit * rest, unit * columns / size, lacking, records=many, interval=records[0].step)
    residual = []
    for w, r in zip(problem.windows, point.residuals, strict=True):
        every = np.full(w.record.outputs.shape, np.nan)
        every[np.isfinite(w.record.outputs)] = -r
        residual.append(every * problem.noise[:, None])
    left = np.concatenate(residual, axis=1)
    return Identified(
        system=of.found(point.values),
        free=of.free,
        values=point.values,
        covariance=found.covariance / np.outer(size, size),
        freedom=np.broadcast_to(found.freedom, len(size)).copy(),
        outputs=tuple(of.outputs),
        rms=np.sqrt(np.nanmean(left**2, axis=1)),
        size=_spread_of(records),
        residual=left,
        discrepancy=told,
        between=of.between,
        parts=problem.parts,
        converged=converged,
        notes=_notes(of.found(point.values), converged),
        step=records[0].step,
        experiment=of,
    )


def _notes(system: Any, converged: bool) -> tuple[str, ...]:
    notes = []
    if not converged:
        notes.append("the iteration has not converged: start from the numbers found, or fix some of them")
    try:
        checked(system)
    except (TypeError, ValueError) as error:
        notes.append(f"the system found is none that can be: {error}")
    return tuple(notes)


def channels_of(log: Any) -> dict[str, Any]:
    """Time and channels of a log, or of a dictionary of arrays."""
    if isinstance(log, Mapping):
        return dict(log)
    if not hasattr(log, "channels"):
        raise TypeError(f"log is {shown(log)}; give a Log (see read_log) or a dictionary of arrays by channel")
    return {"time": log.time, **log.channels}


def record_of(of: Experiment, channels: Mapping[str, Any], number_of: int | None) -> Record:
    """Record of the channels that an experiment needs."""
    where = "log" if number_of is None else f"log {number_of}"
    for name in ("time", *of.inputs.values(), *of.outputs.values()):
        if name not in channels:
            raise ValueError(f"{where} has no channel {name!r}; it has {', '.join(channels)}")
    time = numbers(f"{where}: time", channels["time"])
    if len(time) < FEWEST:
        raise ValueError(f"{where} has {len(time)} samples; give {FEWEST} at least")
    steps = np.diff(time)
    step = float(np.median(steps))
    if not np.all(steps > 0.0):
        i = int(np.flatnonzero(steps <= 0.0)[0])
        raise ValueError(f"{where}: time {time[i + 1]:g} s of sample {i + 1} stands after {time[i]:g} s; let it ascend")
    if np.max(np.abs(time - time[0] - step_of(time) * np.arange(len(time)))) > 0.05 * step:
        raise ValueError(
            f"{where}: time has steps from {np.min(steps):g} to {np.max(steps):g} s; resample to equal steps"
        )
    rows = {}
    for name in (*of.inputs.values(), *of.outputs.values()):
        rows[name] = np.asarray(channels[name], float)
        if rows[name].shape != time.shape:
            raise ValueError(f"{where}: {name} has {len(rows[name])} samples and time {len(time)}; give equally many")
    for name in of.inputs.values():
        if not np.all(np.isfinite(rows[name])):
            i = int(np.flatnonzero(~np.isfinite(rows[name]))[0])
            raise ValueError(f"{where}: {name} is {rows[name][i]} at sample {i}; an input must be known at all samples")
    for name in of.outputs.values():
        if not np.nanstd(rows[name]) > 0.0:
            raise ValueError(
                f"{where}: {name} is {rows[name][0]:g} throughout; nothing moves: give a record with motion"
            )
    inputs = np.array([rows[name] for name in of.inputs.values()]).reshape(len(of.inputs), len(time))
    outputs = np.array([rows[name] for name in of.outputs.values()])
    outputs[~np.isfinite(outputs)] = np.nan
    return Record(inputs, outputs, step_of(time))


def step_of(time: Floats) -> float:
    """Mean step [s]."""
    return float(time[-1] - time[0]) / (len(time) - 1)


def fitted_start(of: Experiment, values: Floats, record: Record, samples: int, parts: int) -> Floats:
    """State at the first sample from so many measured ones."""
    noise = np.nanstd(record.outputs, axis=1)
    noise = np.where(noise > 0.0, noise, 1.0)
    problem = LeastSquares(of, [Window(record, 0, samples)], noise, parts)
    point = _finite(problem.begin(values))
    for _ in range(10):
        size = np.maximum(np.linalg.norm(point.by_start[0], axis=0), 1e-300)
        change = np.linalg.lstsq(point.by_start[0] / size, point.residuals[0], rcond=1e-8)[0] / size
        trial = problem.at(values, [point.starts[0] - change])
        if not trial.cost() < point.cost():
            break
        point = trial
    return point.starts[0]
