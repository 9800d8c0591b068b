"""`run_loop` and `loop_ensemble`: one sampled loop in time, and thousands with what is measured of each."""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.protocols import System, lacking, need
from ...base.quantities import States, checked, number, numbers, positive_count, reals, samples_of, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats
from ...base.terminal import on_screen
from ...base.units import ARCSEC
from ...compile.jit import run
from ...compile.lanes import LANES, lane
from ...compile.tree import leaf_of, leaves, mapped
from . import loop_march as row
from .loop_march import BLOCK, NO_SUMS, ROWS, SUMS, Sums, begun, march, native_of, spread, sums_by_address
from .threads import results_of

FINE_STEP = 0.15  # a step times the fastest rate: its error is below 1e-6 of what moves so fast
MOST_STEPS, MOST_SAMPLES = 1000, 100_000_000  # of a sample; of a loop: minutes
LANES_OF_JOB = 32
GROWTH = 1.5  # of the rms from one half of what is measured to the other
SMALL_ERROR = 0.05  # of the largest error of a run: what is below has decayed
LARGEST_ERROR = 1e3  # rad: a larger error is none of a drive's


@dataclass(frozen=True, eq=False)
class LoopRun(Result):
    """One sampled loop in time.

    Attributes
    ----------
    time : (n,) array
        Times [s] of the samples that were kept.
    error : (n,) array
        First watched value of the loop [rad]: of a drive the pointing error of the load.
    torque : (n,) array
        Torque [N*m] that the sample asked for, after its limit; it acts a delay later.
    gear_torque : (n,) array
        Second watched value of the loop [N*m].
    states : (states, n) array
        States of the plant.
    memory : NamedTuple
        Memory of the loop at the end.
    steps : int
        Steps of the integration between two samples.
    """

    rows: ClassVar[str] = "time"
    places: ClassVar[Along] = {"time": {"time": "s"}}
    arrays: ClassVar[Along] = {
        "time": {"error": "rad", "torque": "N*m", "gear_torque": "N*m"}, ("state", "time"): {"states": ""},
    }  # fmt: skip

    time: Floats
    error: Floats
    torque: Floats
    gear_torque: Floats
    states: Floats
    memory: Any
    steps: int

    def rms(self, settle: float = 0.0) -> float:
        """Root mean square of the error [rad] from a time [s] on, its mean taken away."""
        late = self.time >= settle
        if not np.any(late):
            raise ValueError(f"settle is {shown(settle)} s; the run ends at {self.time[-1]:g} s: give an earlier time")
        return spread(self.error[late])

    def __str__(self) -> str:
        late = self.error[len(self.error) // 2 :]
        with np.errstate(all="ignore"):
            mean = float(np.mean(late / ARCSEC))
        return on_screen(
            f"LoopRun: {len(self.time)} samples to {self.time[-1]:.4g} s; in the second half the error has an rms of "
            f"{spread(late) / ARCSEC:.4g} arcsec about {mean:.4g}, torque up to {np.max(np.abs(self.torque)):.4g} N*m"
        )


@dataclass(frozen=True, eq=False)
class LoopEnsemble(Result):
    """Measures of many sampled loops, of each over the samples after `settle`.

    Attributes
    ----------
    mean, rms, peak : (lanes,) arrays
        Mean of the error [rad], root mean square about it and about its trend, a straight line, and largest size.
    torque_rms, torque_peak : (lanes,) arrays
        Of the controller's torque [N*m] after its limit.
    gear_torque : (lanes,) array
        Largest torque in the gear [N*m].
    limited, lost : (lanes,) arrays
        Shares of all samples whose torque was limited, and whose angle of the motor was lost.
    amplitude, phase : (orders, lanes) arrays
        0-to-peak [rad] and phase [rad] of the error at each order of the reference angle: amplitude cos(order angle +
        phase).
    orders : (orders,) array
        The orders.
    stable : (lanes,) array of bool
        True where the error stayed bounded and its root mean square did not grow by half from the first half of what is
        measured to the second, decayed errors and those below a step of the encoders apart. What grew beyond all floats
        is infinite, and its phase 0.
    steps : int
        Steps of the integration between two samples.
    """

    rows: ClassVar[str] = "lane"
    arrays: ClassVar[Along] = {
        "lane": {
            "mean": "rad", "rms": "rad", "peak": "rad", "torque_rms": "N*m", "torque_peak": "N*m",
            "gear_torque": "N*m", "limited": "", "lost": "", "stable": "",
        },
        ("order", "lane"): {"amplitude": "rad", "phase": "rad"},
    }  # fmt: skip

    mean: Floats
    rms: Floats
    peak: Floats
    torque_rms: Floats
    torque_peak: Floats
    gear_torque: Floats
    limited: Floats
    lost: Floats
    amplitude: Floats
    phase: Floats
    orders: Floats
    stable: Any
    steps: int

    def coordinates(self) -> Labelled:
        """Orders of the amplitudes."""
        return {"order": ("order", self.orders, "")}

    def __str__(self) -> str:
        loops = f"LoopEnsemble: {len(self.rms)} loops, {int(np.sum(~self.stable))} of them unstable"
        if np.any(self.stable):
            low, middle, high = np.quantile(self.rms[self.stable], (0.05, 0.5, 0.95)) / ARCSEC
            loops += f"; stable ones: rms of the error {middle:.4g} arcsec (5 to 95 %: {low:.4g} to {high:.4g})"
        return on_screen(loops)


def run_loop(
    loop: Any, duration: float, *, y0: ArrayLike | None = None, every: int = 1, steps: int | None = None, unit: int = 0
) -> LoopRun:
    """Run one sampled loop.

    Between two samples its plant is integrated by steps of fourth order, which end at every sample and wherever the
    torque changes.

    Parameters
    ----------
    loop : ClosedLoop
        A plant with a sampled controller.
    duration : float
        Time [s].
    y0 : (states,) array_like, optional
        State of the plant at time 0. Default: zeros.
    every : int
        Keep one in so many samples.
    steps : int, optional
        Steps of each part between two samples. Default: enough for the fastest motion of the plant.
    unit : int
        Number of the unit, which its noise belongs to.

    Returns
    -------
    LoopRun
        `error` [rad] and `torque` [N*m] over `time` [s].

    Raises
    ------
    TypeError
        If it is no loop.
    ValueError
        If a number is out of range, or the samples are too slow for the loop (`steps`).
    """
    loop, y, steps = ready(loop, y0, steps)
    samples, every = _samples(loop, duration), positive_count("every", every)
    columns = -(-samples // every)
    states, traces = np.full((len(y), columns), np.nan), np.full((row.ANGLE, columns), np.nan)
    _, memory = marched(loop, y, begun(loop, y), samples, steps, states, traces, unit=unit, stride=every)
    t, torque, error, gear_torque = traces
    return LoopRun(t, error, torque, gear_torque, states, mapped(float, memory), steps)


def marched(
    loop: Any, y: States, memory: object, samples: int, steps: int, states: Floats, traces: Floats, *, unit: int = 0,
    stride: int = 1,
) -> Any:  # fmt: skip
    """State and memory of one loop so many samples after a state and a memory; `states` and `traces` are filled."""
    native, held, table, restored = native_of(loop, [loop], [y], [memory])
    rows = np.empty((len(table), LANES))
    rows[:, :1] = table
    with np.errstate(all="ignore"):
        y, memory = run(march, native, y, held, rows, unit, 1, samples, stride, steps, states, traces, NO_SUMS)
    return y, restored(memory) if restored else memory


def loop_ensemble(
    loop: Any,
    varied: Mapping[str, ArrayLike] | Sequence[Any],
    duration: float,
    *,
    settle: float,
    orders: ArrayLike = (),
    y0: ArrayLike | None = None,
    steps: int | None = None,
    threads: int | None = None,
    progress: Callable[[str, float], None] = lambda _what, _share: None,
) -> LoopEnsemble:
    """Run many sampled loops that differ in some of their numbers.

    Parameters
    ----------
    loop : ClosedLoop
        The loop that they are variants of.
    varied : dict of str to (lanes,) array_like, or sequence of loops
        Differences, by their paths: ``{"train.law.K1": ...}``; or the variants themselves, of the same classes.
    duration, settle : float
        Time [s] of each, and the time before anything is measured.
    orders : (orders,) array_like
        Orders of the reference angle that amplitudes of the error are taken of.
    y0 : (states,) or (states, lanes) array_like, optional
        States at time 0. Default: zeros.
    steps : int, optional
        Steps of each part between two samples. Default: enough for the fastest motion of the first lane's plant.
    threads : int, optional
        Default: as many as there are processors.
    progress : callable
        Told what is done, and which share of all.

    Returns
    -------
    LoopEnsemble
        `mean`, `rms` and `peak` of the error [rad], `torque_rms` and `torque_peak` [N*m] and `stable`, (lanes,)
        arrays; `amplitude` [rad, 0-to-peak] and `phase` [rad] of the error, (orders, lanes).

    Raises
    ------
    TypeError
        If it is no loop.
    ValueError
        If a path names no number, arrays differ in length, or a number is out of range.
    """
    starts_of = None if y0 is None else reals(y0)
    first = starts_of[:, 0] if starts_of is not None and starts_of.ndim == 2 and starts_of.size else y0
    loop, y, steps = ready(loop, first, steps)
    samples, before = _samples(loop, duration), round(number("settle [s]", settle) / loop.period())
    if not 0 <= before < samples:
        raise ValueError(f"settle is {settle:g} s; it must be from 0 to below the duration, {duration:g} s")
    table = _table(loop, varied)
    lanes = table.shape[1]
    starts = np.broadcast_to(np.array(y if starts_of is None else starts_of).reshape(len(y), -1), (len(y), lanes))
    members = [lane(loop, table, 0, j) for j in range(lanes)]
    memories = [begun(each, starts[:, j]) for j, each in enumerate(members)]
    native, held, table, _ = native_of(loop, members, list(map(tuple, starts.T.tolist())), memories)
    lines = numbers("orders", orders) if samples_of("orders", orders).size else np.zeros(0)
    jobs = [(i, min(i + LANES_OF_JOB, lanes)) for i in range(0, lanes, LANES_OF_JOB)]
    sums = np.zeros((SUMS + 2 * len(lines), lanes))

    def job(span: tuple[int, int]) -> None:
        low, high = span
        rows, totals, traces = np.zeros((len(table), LANES)), np.zeros((len(sums), high - low)), np.empty((ROWS, BLOCK))
        rows[:, : high - low] = table[:, low:high]
        summed = sums_by_address(Sums(before, samples, lines, traces, totals))
        with np.errstate(all="ignore"):
            run(march, native, y, held, rows, low, high - low, samples, 1, steps, np.empty((0, 0)), traces, summed)
        sums[:, low:high] = totals

    workers = positive_count("threads", os.cpu_count() or 1 if threads is None else threads)
    for (_, ready_lanes), _ in zip(jobs, results_of(job, jobs, workers), strict=True):
        progress(f"{ready_lanes} of {lanes} loops", ready_lanes / lanes)
    return _measured(sums, lines, samples, steps, 0.0 if lacking(loop, "finest") else loop.finest())


def _table(loop: Any, varied: Any) -> Floats:
    """Numbers (floats, lanes) of all variants of a loop."""
    if not isinstance(varied, Mapping):
        members = [leaves(checked(member)) for member in varied]
        if not members or any(len(member) != len(leaves(loop)) for member in members):
            raise ValueError("varied has loops that differ in more than their numbers; give variants of one loop")
        return np.array(members, float).T
    columns = {path: numbers(path, values) for path, values in varied.items()}
    lengths = {len(values) for values in columns.values()} or {1}
    if len(lengths) > 1:
        raise ValueError(
            "the arrays of varied have "
            + ", ".join(f"{len(values)} ({path})" for path, values in columns.items())
            + " numbers; give each the same number of loops"
        )
    table = np.repeat(np.array(leaves(loop), float)[:, None], lengths.pop(), axis=1)
    for path, values in columns.items():
        table[leaf_of(loop, path)] = values
    return table


def _measured(sums: Floats, orders: Floats, samples: int, steps: int, finest: float) -> LoopEnsemble:
    with np.errstate(all="ignore"):
        n, total, squares, moment = sums[row.COUNT], sums[row.TOTAL], sums[row.SQUARES], sums[row.MOMENT]
        mean = total / n
        trend = 12.0 * moment / (n * np.maximum(n * n - 1.0, 1.0))  # of a sample; the samples have (n^2 - 1)/12
        rms = np.sqrt(np.maximum(squares / n - mean * mean - trend * moment / n, 0.0))
        cosine, sine = 2.0 * sums[SUMS::2] / n, 2.0 * sums[SUMS + 1 :: 2] / n
        sizes = mean, rms, np.sqrt(sums[row.TORQUE_SQUARES] / n), np.hypot(cosine, sine)
        second, late_total, late_squares = sums[row.LATE_COUNT], sums[row.LATE_TOTAL], sums[row.LATE_SQUARES]
        first = n - second
        early = (squares - late_squares) / first - ((total - late_total) / first) ** 2
        late = late_squares / second - (late_total / second) ** 2
        least = np.maximum(SMALL_ERROR * sums[row.PEAK_OF_RUN], finest)
        small = np.isfinite(squares) & (sums[row.PEAK] < LARGEST_ERROR)
        stable = small & ~((late > GROWTH**2 * early) & (late > least**2))
    mean, rms, torque_rms, amplitude = [np.where(np.isnan(size), np.inf, size) for size in sizes]
    return LoopEnsemble(
        mean=mean,
        rms=rms,
        peak=sums[row.PEAK],
        torque_rms=torque_rms,
        torque_peak=sums[row.TORQUE_PEAK],
        gear_torque=sums[row.WATCHED_PEAK],
        limited=sums[row.LIMITED] / samples,
        lost=sums[row.LOST] / samples,
        amplitude=amplitude,
        phase=np.nan_to_num(np.arctan2(-sine, cosine)),
        orders=orders,
        stable=stable,
        steps=steps,
    )


def ready(loop: Any, y0: ArrayLike | None, steps: int | None) -> tuple[Any, tuple[float, ...], int]:
    """The loop with floats in its fields, its first state, and the steps between two samples."""
    need("loop", loop, "plant", "update", "commanded", "watched")
    loop = checked(loop)
    names = loop.plant().state_names()
    y = np.zeros(len(names)) if y0 is None else numbers("y0", y0)
    if len(y) != len(names):
        raise ValueError(f"y0 has {len(y)} numbers; the plant has {len(names)} states: {', '.join(names)}")
    if steps is not None:
        return loop, tuple(y.tolist()), positive_count("steps", steps, MOST_STEPS)
    return loop, tuple(y.tolist()), steps_of(loop, y)


def steps_of(loop: Any, y: Floats) -> int:
    """Steps between two samples that the fastest motion of a plant needs near a state; too many are refused."""
    needed: int = math.ceil(loop.period() * fastest(loop.plant(), y) / FINE_STEP)
    if needed > MOST_STEPS:
        raise ValueError(
            f"samples every {loop.period():g} s are too slow for the plant, which needs {needed} steps between two: "
            "sample faster, or give the steps"
        )
    return max(1, needed)


def fastest(plant: System, y: Floats) -> float:
    """Largest eigenvalue [1/s] of a plant's motion near a state, by differences."""
    step = 1e-7
    with np.errstate(all="ignore"):
        columns = [
            np.subtract(plant.rhs(0.0, tuple(y + d)), plant.rhs(0.0, tuple(y - d))) / (2.0 * step)
            for d in step * np.eye(len(y))
        ]
    eigenvalues = np.linalg.eigvals(np.nan_to_num(np.array(columns, float).T))
    return float(np.max(np.abs(eigenvalues)))


def _samples(loop: Any, duration: float) -> int:
    """Samples in a time [s]; more than can be run are refused (ValueError)."""
    length, period = number("duration [s]", duration, positive=True), loop.period()
    if length > MOST_SAMPLES * period:
        raise ValueError(
            f"duration is {length:g} s, {length / period:.3g} samples every {period:g} s; a loop is run for at most "
            f"{MOST_SAMPLES:g}: run it for at most {MOST_SAMPLES * period:g} s, or sample more slowly"
        )
    samples: int = max(1, round(length / period))
    return samples
