"""A system's numbers by output error in windows that grow to whole records, and the terms that its law may lack."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import System, with_parts
from ...base.quantities import Ratio, checked, positive_count
from ...base.results import Floats, SolveError
from ...base.terminal import silent
from ...model.laws.friction import Coulomb, QuadraticDamping
from ...model.laws.hysteresis import Parallel
from ...model.laws.springs import Polynomial
from ...numerics.integration.methods import MOST_STEPS
from .channels import channels_of, record_of
from .discrepancy import discrepancy
from .experiment import Experiment, Record, change_of, experiment, start_states
from .fitted import refuse_unidentifiable
from .identified import Identified
from .input_signals import Between
from .intervals import Spread, spread
from .lane_march import lanes_of
from .window_fit import DAMPING, EFFECT, LeastSquares, Point, Window, finite, reweighted, small, solve, windows_of

FIRST_WINDOW = 48  # samples of the first windows
GROWTH = 6  # of the windows from one round to the next
SAMPLES, PARTS = 4_000, 4  # samples that the early rounds look at, and in how many parts of a record they are
EARLY_STEPS, WHOLE_STEPS, LATE_STEPS = 6, 3, 40
EARLY_DAMPING = 0.1  # Levenberg's first factor in the early rounds
STEP_ERROR = 1e-4  # of the outputs' size: what halving the steps may change
MOST_PARTS = 64
CHECKED_SAMPLES = 16_000  # samples of a record that finer steps are tried on
MOST_MOVE = 0.2  # of a number's standard deviation: what halving the steps may change at the end
POOR_SHARE = 0.9  # of the motion's size: a residual that explains next to nothing
LATE_SAMPLES = 1.5  # samples: a delay that shifting the channel shortens
TRIAL_SAMPLES = 400  # samples that the number of steps is chosen on


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of motions that leave every bound; they are refused
def identify(
    system: Any,
    log: Any,
    free: Sequence[str],
    *,
    inputs: Mapping[str, str] | None = None,
    outputs: Mapping[str, str] | None = None,
    between: Between = "band-limited",
    steps: int | None = None,
    progress: Callable[[str, float], None] = silent,
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
        `system` with the numbers found [SI], `value(path)`, `interval(path)`; `notes` to read first.

    Raises
    ------
    ValueError
        If a path, a state or a channel does not exist, or some numbers cannot be told apart: which is said.
    SolveError
        If the motion leaves every bound from the given numbers.

    References
    ----------
    Ljung 1999, System Identification, 2nd ed., ch. 7 (output error); Bock 1983, in
    Numerical Treatment of Inverse Problems, Birkhäuser, 95-121 (multiple shooting); Schoukens & Ljung
    2019, IEEE Control Syst. Mag. 39(6), 28-99 (simulation error; what an input does between samples).
    """
    system = with_parts("identify", system, "rhs")
    logs = [channels_of(one) for one in (log if isinstance(log, list | tuple) else [log])]
    if not logs:
        raise ValueError("log is empty; give one record at least")
    if inputs is None:
        inputs = {"excitation": "input"} if "input" in logs[0] else {}
    first_state = (list(getattr(system, "state_names", tuple)()) or ["x"])[0]
    setup = experiment(system, inputs, {first_state: "output"} if outputs is None else outputs, free, between)
    records = [record_of(setup, channels, i if len(logs) > 1 else None) for i, channels in enumerate(logs)]
    if len({round(record.step, 12) for record in records}) > 1:
        steps_of = ", ".join(f"{record.step:g} s" for record in records)
        raise ValueError(f"the records have different steps, {steps_of}; resample them to one")
    noise = _spread_of(records)
    values = _first_values(setup, records, noise)
    _refuse_common_delay(setup, records[0], values)
    if steps is not None:
        parts = positive_count("steps", steps, max(MOST_STEPS // sum(map(len, records)), 1))
    else:
        parts = _steps_between_samples(setup, records, values, noise)
    most_parts = parts if steps is not None else MOST_PARTS
    length, longest = FIRST_WINDOW, max(len(record) for record in records)
    early = [
        part for record in records for part in record.parted(max(SAMPLES // len(records), PARTS * FIRST_WINDOW), PARTS)
    ]
    while length < min(longest, SAMPLES):
        progress(f"windows of {length} samples", 0.5 * length / SAMPLES)
        problem = LeastSquares(setup, windows_of(early, length), noise, parts)
        problem, point = _solved(problem, values, EARLY_STEPS, EARLY_DAMPING, most_parts)
        values, parts, length = point.values, problem.parts, length * GROWTH
    progress("whole records", 0.5)
    problem = LeastSquares(setup, [Window(record, 0, len(record)) for record in records], noise, parts)
    problem, point = _solved(problem, values, WHOLE_STEPS, DAMPING, most_parts)
    if len(noise) > 1:
        problem = reweighted(problem, point)
        point = problem.point_at(point.values, point.starts)
    point, converged = solve(
        problem, point, LATE_STEPS, DAMPING, lambda i, _c: progress("whole records", 0.8 + 0.01 * i)
    )
    if steps is None:
        problem, point, converged = _finer(problem, point, converged, progress)
    progress("identified", 1.0)
    return _result(setup, problem, point, converged, records)


def _solved(
    problem: LeastSquares, values: Floats, steps: int, damping: float, most_parts: int
) -> tuple[LeastSquares, Point]:  # fmt: skip
    """Solve from starts that were measured; with finer steps of the integration where the motion leaves every bound."""
    while True:
        try:
            return problem, solve(problem, finite(problem.begin(values)), steps, damping, keep_signs=True)[0]
        except SolveError:
            if problem.parts >= most_parts:
                raise
            problem = replace(problem, parts=2 * problem.parts, prepared={})


def _finer(
    problem: LeastSquares, point: Point, converged: bool, progress: Callable[[str, float], None]
) -> tuple[LeastSquares, Point, bool]:  # fmt: skip
    """The same with steps of the integration so fine that halving them moves no number by much of its deviation."""
    while problem.parts < MOST_PARTS:
        progress(f"{2 * problem.parts} steps a sample", 0.95)
        finer = replace(problem, parts=2 * problem.parts, prepared={})
        if _moves_little(finer, point):
            break
        point, converged = solve(finer, finer.point_at(point.values, point.starts), LATE_STEPS)
        problem = finer
    return problem, point, converged


def _moves_little(finer: LeastSquares, point: Point) -> bool:
    """True if finer steps of the integration would move the numbers by little.

    It is one Gauss-Newton step with the residuals of the finer steps over the begin of every window.
    """
    count = CHECKED_SAMPLES if len(finer.noise) == 1 else max(len(w.record) for w in finer.windows)  # outputs in turn
    windows = [Window(w.record.parted(count, 1)[0], w.first, min(w.stop, count)) for w in finer.windows]
    rows = [int(np.sum(np.isfinite(w.record.outputs[:, w.first : w.stop]))) for w in windows]
    parts: dict[str, Any] = {
        name: [part[:n] for part, n in zip(getattr(point, name), rows, strict=True)]
        for name in ("residuals", "by_value", "by_start")
    }
    some, residuals = replace(point, **parts), replace(finer, windows=windows).residuals(point.values, point.starts)
    columns, residual = replace(some, residuals=residuals).reduced()
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    change = np.linalg.lstsq(columns / size, some.reduced()[1] - residual, rcond=None)[0] / size
    total = sum(len(r) for r in point.residuals)
    return small(columns, residual, change, MOST_MOVE * np.sqrt(len(residual) / total))


def _first_values(setup: Experiment, records: Sequence[Record], size: Floats) -> Floats:
    """First values (free,); an offset that is larger than the motion begins at the mean of its output."""
    values = setup.first()
    means = [float(np.nanmean(row)) for row in np.concatenate([record.outputs for record in records], axis=1)]
    for name, mean, scatter in zip(setup.outputs, means, size, strict=True):
        if abs(mean) > scatter and f"{name}.offset" in setup.free:
            values[setup.free.index(f"{name}.offset")] = mean
    return values


def _refuse_common_delay(setup: Experiment, record: Record, values: Floats) -> None:
    """Refuse delays of all signals of a system that does not depend on the time otherwise (ValueError)."""
    if not all(f"{signal}.delay" in setup.free for signal in (*setup.inputs, *setup.outputs)):
        return
    part = record.parted(TRIAL_SAMPLES, 1)[0]
    start, lanes = start_states(setup, part.outputs, 0, part.step), setup.lanes([values], part.step, 1)
    inputs = part.pieces(setup, values, 1), setup.seen(), len(part), 1, part.step
    first = lanes.run(start[:, None], *inputs, begin=0)
    later = lanes.run(start[:, None], *inputs, begin=7 * len(part) + 1)
    if np.allclose(first, later, rtol=0.0, atol=STEP_ERROR * float(np.max(np.abs(first))), equal_nan=True):
        raise ValueError(
            "the delays of all inputs and outputs are free, and a common delay changes nothing; fix one of them"
        )


def _spread_of(records: Sequence[Record]) -> Floats:
    """Standard deviation (outputs,) of each output over all records."""
    outputs = np.concatenate([record.outputs for record in records], axis=1)
    return np.asarray(np.nanstd(outputs, axis=1))


def _steps_between_samples(of: Experiment, records: Sequence[Record], values: Floats, noise: Floats) -> int:
    """Steps between two samples: twice as many change the outputs by less than `STEP_ERROR` of their size."""
    window = _liveliest(records, noise)
    before, parts = None, 1
    while parts <= MOST_PARTS:
        now = LeastSquares(of, [window], noise, parts).begin(values).residuals[0]
        if before is not None and len(now) == len(before) and np.sqrt(np.mean((now - before) ** 2)) < STEP_ERROR:
            return parts // 2
        before, parts = now, 2 * parts
    return MOST_PARTS


def _liveliest(records: Sequence[Record], noise: Floats) -> Window:
    """The window of `TRIAL_SAMPLES` in which the outputs change most: the one that asks for the finest steps."""

    def change(window: Window) -> float:
        seen = window.record.outputs[:, window.first : window.stop]
        return float(np.sum(np.array([change_of(row) for row in seen]) / noise))

    window = max(windows_of(records, TRIAL_SAMPLES), key=change)
    return Window(window.record.part(window.first, window.stop), 0, len(window))


def _result(
    setup: Experiment, problem: LeastSquares, point: Point, converged: bool, records: Sequence[Record]
) -> Identified:  # fmt: skip
    phases = [path.rpartition(".")[2] == "phase" for path in setup.free]
    turned = np.remainder(point.values + np.pi, 2.0 * np.pi) - np.pi
    point = replace(point, values=np.where(phases, turned, point.values))
    columns, left_over = point.reduced()
    size = np.linalg.norm(columns, axis=0)
    refuse_unidentifiable(columns, setup.free, point.values, tolerance=20.0 * EFFECT)
    many = [len(r) for r in point.residuals]
    scatter: Spread = spread(columns / size, left_over, many)
    unit = float(problem.noise[0]) if len(problem.noise) == 1 else 1.0
    lacking = {name: unit * column for name, column in term_columns(problem, point).items()}
    unexplained = discrepancy(-unit * left_over, unit * columns / size, lacking, records=many, interval=records[0].step)
    residual = []
    for w, r in zip(problem.windows, point.residuals, strict=True):
        every = np.full(w.record.outputs.shape, np.nan)
        every[np.isfinite(w.record.outputs)] = -r
        residual.append(every * problem.noise[:, None])
    left, system, size_of_outputs = np.concatenate(residual, axis=1), setup.fitted(point.values), _spread_of(records)
    rms = np.sqrt(np.nanmean(left**2, axis=1))
    poor = [name for name, share in zip(setup.outputs, rms / size_of_outputs, strict=True) if share > POOR_SHARE]
    return Identified(
        system=system,
        names=setup.free,
        values=point.values,
        covariance=scatter.covariance / np.outer(size, size),
        freedom=np.broadcast_to(scatter.freedom, len(size)).copy(),
        outputs=tuple(setup.outputs),
        rms=rms,
        size=size_of_outputs,
        residual=left,
        discrepancy=unexplained,
        between=setup.between,
        parts=problem.parts,
        converged=converged,
        notes=(
            *_notes(system, converged),
            *_late_inputs(setup, point.values, records[0].step),
            *(f"the system explains almost nothing of {name}: use other start values" for name in poor),
        ),
        step=records[0].step,
        experiment=setup,
    )


def _late_inputs(of: Experiment, values: Floats, step: float) -> list[str]:
    """Inputs with a delay of samples, before which the log does not say what they did."""
    return [
        f"{path}.delay is {delay:.3g} samples, and the log does not say what {channel} did that long before: shift "
        f"the channel by {round(delay)} samples and cut the log"
        for (path, channel), delay in zip(of.inputs.items(), of.delays(values) / step, strict=True)
        if abs(delay) > LATE_SAMPLES
    ]


def _notes(system: System, converged: bool) -> tuple[str, ...]:
    """Sentences on an iteration that has not converged, and on a system that none can be."""
    notes = [] if converged else ["the iteration has not converged: restart from these numbers, or fix some of them"]
    try:
        checked(system)
    except (TypeError, ValueError) as error:
        notes.append(f"the identified system is impossible: {error}")
    return tuple(notes)


TERMS = ("x^2", "x^3", "x^5", "|v| v", "v^3", "sign v")
SIGN_WIDTH = 0.02  # of the rate's size: over which the dry friction that is looked for changes its sign


class CubicDamping(NamedTuple):
    """Torque c v^3."""

    c: Ratio

    def torque(self, _x: Any, v: Any) -> Any:
        """Torque at the rate v."""
        return self.c * v * v * v

    def stiffness(self, x: Any) -> Any:
        """No stiffness: 0."""
        return 0.0 * x


def term_columns(problem: LeastSquares, point: Point) -> dict[str, Floats]:
    """Derivative of the residuals (n,) by each term, the starts taken out; none without a law on top."""
    system = problem.experiment.driven
    if not hasattr(system, "law"):
        return {}
    first = problem.windows[0].record
    sizes = problem.sizes(first)
    x, v = float(sizes[0]), float(sizes[min(1, len(sizes) - 1)])
    stiffness = float(system.law.stiffness(x)) if hasattr(system.law, "stiffness") else 0.0
    torque, width = abs(stiffness) * x or 1.0, SIGN_WIDTH * v
    amounts = [torque / x**2, torque / x**3, torque / x**5, torque / (v * v), torque / v**3, torque]
    model = problem.experiment.model(point.values, first.step, problem.parts, problem.experiment.delays(point.values))

    def with_terms(on: int) -> Any:
        c = [EFFECT * amount if i == on else 0.0 for i, amount in enumerate(amounts)]
        springs = Polynomial((0.0, 0.0, c[0], c[1], 0.0, c[2]))
        drags = Parallel(QuadraticDamping(c[3]), Parallel(CubicDamping(c[4]), Coulomb(c[5], width)))
        return model._replace(law=Parallel(model.law, Parallel(springs, drags)))

    lanes = lanes_of([with_terms(i) for i in (-1, *range(len(amounts)))])
    columns: list[list[Floats]] = [[] for _ in TERMS]
    for w, start, by_start in zip(problem.windows, point.starts, point.by_start, strict=True):
        for i, column in enumerate(problem.differences(w, point.values, lanes, start, by_start).T):
            columns[i].append(column / EFFECT)
    stacked = {name: np.concatenate(parts) for name, parts in zip(TERMS, columns, strict=True)}
    return {name: column for name, column in stacked.items() if np.all(np.isfinite(column)) and np.any(column)}
