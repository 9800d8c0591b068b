"""`compensate_run_up`: controllers through a range of speeds, up and down, and whether a jump is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ...base.arguments import typed
from ...base.facts import Fact
from ...base.quantities import interval
from ...base.quantities import number as checked
from ...base.records import Along
from ...base.results import Floats
from ...base.sentences import number
from ...base.units import RPM
from ...drive.project import Project
from ...model.controllers.closed_loop import Sampling
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import SpeedProfile
from .bench import Bench, bench_of, steady_bench_of
from .moves import DECAY, on_the_way
from .result import OnTheWay

CELLS = 200  # of the range of speeds
APART = 1.2  # times the error of the other way at one speed: motions of their own, if they stay
CALM = 0.05  # of the largest error of the plain loop: differences below are no jump
TRIED = 5  # speeds at which a run stops and waits, spread over those where both ways differ
SAME, LONGER = 0.02, 7  # rms of a settled run, and how often the wait is doubled for it
LONGEST_LEAD = 10.0  # s at the first speed
WAITS = 12.0  # time constants of the loop's slowest motion
MOST_SAMPLES = 5_000_000  # of a run: some seconds


@dataclass(frozen=True, eq=False)
class CompensatedRunup(OnTheWay):
    """Controllers on a run-up and the run-down after it.

    Attributes
    ----------
    speed : (n,) array
        Speeds of the motor [rad/s], middles of the cells of the range.
    up, down : (controllers, n) arrays
        Largest pointing error [rad] about its mean in each cell, or in a period of the lowest order where that is
        longer, on the way up and down.
    names : tuple of str
        Of the controllers.
    jump : (controllers,) array
        Speed [rad/s] at which a run-up and a run-down that stop there stay on motions of their own; NaN where none
        was found.
    acceleration : float
        Of the motor [rad/s^2].
    remarks : tuple of str
        What was assumed, as sentences.
    """

    rows: ClassVar[str] = "speed"
    places: ClassVar[Along] = {"speed": {"speed": "rad/s"}}
    arrays: ClassVar[Along] = {("controller", "speed"): {"up": "rad", "down": "rad"}}

    speed: Floats
    up: Floats
    down: Floats
    names: tuple[str, ...]
    jump: Floats
    acceleration: float
    remarks: tuple[str, ...]

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of the controllers, once."""
        low, high = number(float(self.speed[0]) / RPM), number(float(self.speed[-1]) / RPM)
        return (
            Fact("", f"{low} to {high} rpm and back", "Compensated run-up: {}"),
            Fact("acceleration_rpm_per_s", self.acceleration, "acceleration {}"),
            Fact("controllers", tuple(map(_row, self.names, self.up, self.down, self.jump.tolist())), "{}"),
            Fact("remarks", self.remarks, "{}"),
        )


def _row(name: str, up: Floats, down: Floats, jump: float) -> tuple[Fact, ...]:
    """Facts of a controller: its largest errors, and the speed at which two motions stay apart."""
    apart = None if np.isnan(jump) else jump
    how = "no jump" if apart is None else f"two motions at {number(apart / RPM)} rpm: it jumps"
    return (
        Fact("controller", name, "controller"), Fact("largest_up_arcsec", float(np.max(up)), "largest error, up"),
        Fact("largest_down_arcsec", float(np.max(down)), "down"), Fact("jumps", apart is not None),
        Fact("two_motions_at_rpm", apart), Fact("", how, "run-up and run-down"),
    )  # fmt: skip


@typed
def compensate_run_up(
    project: Project | DriveTrain,
    speeds: tuple[float, float],
    time: float,
    controllers: Sequence[Any] = ("loop", "inverse"),
    *,
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    load_angle: float | None = None,
) -> CompensatedRunup:
    """Run a drive through a range of speeds, up and then down, under each controller.

    Both ways differ also where a resonance is passed quickly. Where they do, runs of both ways stop at a few of these
    speeds and wait: what then still differs are two motions, between which the drive jumps.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive.
    speeds : (low, high)
        Speeds of the motor [rad/s].
    time : float
        Time [s] of each of the two runs.
    controllers : sequence of str or controller
        Names of designs that do not depend on the speed, or controllers.
    sampling, loop, plant
        As of `compensate`.
    load_angle : float, optional
        Angle of the load [rad] at which gravity is held while jumps are looked for: else runs that wait at one speed
        would differ by where the load stands. Default: 0.

    Returns
    -------
    CompensatedRunup
        Largest pointing errors [rad] `up` and `down` over the motor's `speed` [rad/s] for each controller, and
        the speed of the `jump` that is left, NaN without one.

    Raises
    ------
    ValueError
        If a number is out of range, a controller is designed for one speed, or `time` is shorter than a period of the
        lowest order at the lowest speed.
    TypeError
        If an argument is of another kind.
    """
    bench = bench_of(project, sampling, loop, plant)
    low, high = interval("speeds [rad/s]", speeds, positive=True)
    time = checked("time [s]", time, positive=True)
    if bench.repeat > 1.0:
        raise ValueError(
            "a run-up beats with lines of the output's turn, so that both ways differ without a jump; take "
            "sw.compensate at single speeds"
        )
    chosen = on_the_way(bench, controllers)
    lowest = min(bench.orders)
    if time < 2.0 * np.pi / (lowest * low):
        raise ValueError(
            f"time is {time:g} s and a period of order {lowest} lasts {2.0 * np.pi / (lowest * low):.3g} s at "
            f"{low / RPM:.4g} rpm; give a longer time"
        )
    edges = np.linspace(low, high, CELLS + 1)
    up, down = [
        np.array([_cells(_run(bench, c, ends, time), ends, time, edges, lowest) for _, c in chosen])
        for ends in ((low, high), (high, low))
    ]
    calm = CALM * float(np.max(np.maximum(up, down)))
    angle = None if load_angle is None else checked("load_angle [rad]", load_angle)
    held = steady_bench_of(project, sampling, loop, plant, angle)
    jumps = [_jump(held, c, edges, time, a, b, calm) for (_, c), a, b in zip(chosen, up, down, strict=True)]
    middles, names = 0.5 * (edges[1:] + edges[:-1]), tuple(name for name, _ in chosen)
    remarks = tuple(text if text in bench.remarks else f"While jumps are looked for: {text}" for text in held.remarks)
    return CompensatedRunup(middles, up, down, names, np.array(jumps), (high - low) / time, remarks)


def _run(bench: Bench, controller: Any, ends: tuple[float, float], time: float, waits: float = 0.0) -> Any:
    """Run from one speed to another, and wait there; before it transients of the start decay at the first speed."""
    lead = max(0.1 * time, min(DECAY * bench.response(ends[0]).slowest, LONGEST_LEAD))
    if lead + time + waits > MOST_SAMPLES * bench.sampling.period:
        raise ValueError(
            f"a run of {lead + time + waits:.4g} s has more than {MOST_SAMPLES:,} samples every "
            f"{bench.sampling.period:.4g} s; give a shorter time, or sample more slowly"
        )
    motion = SpeedProfile((0.0, lead, lead + time), (ends[0], *ends))
    run = bench.follow(controller, motion, lead + time + waits, ends[0])
    return replace(run, time=run.time - lead)


def _cells(run: Any, ends: tuple[float, float], time: float, edges: Floats, order: float) -> Floats:
    """Largest error (n,) about its mean in each cell of speeds, or in a longer period of the lowest order there."""
    speeds = 0.5 * (edges[1:] + edges[:-1])
    span = np.maximum(time / len(speeds), 2.0 * np.pi / (order * speeds))
    first = np.clip(time * (speeds - ends[0]) / (ends[1] - ends[0]) - 0.5 * span, 0.0, time - span)
    begin, end = np.searchsorted(run.time, first), np.searchsorted(run.time, first + span, side="right")
    parts = [run.error[i : max(j, i + 1)] for i, j in zip(begin, end, strict=True)]
    return np.array([0.5 * np.ptp(part) for part in parts])


def _jump(bench: Bench, controller: Any, edges: Floats, time: float, up: Floats, down: Floats, calm: float) -> float:
    """Speed at which runs of both ways that stop there stay apart; NaN where none does."""
    differ = np.flatnonzero(np.maximum(up, down) > APART * np.maximum(np.minimum(up, down), calm))
    if not len(differ):
        return float("nan")
    speeds = 0.5 * (edges[1:] + edges[:-1])
    ratio = np.maximum(up, down) / np.maximum(np.minimum(up, down), calm)
    tried = {
        int(differ[np.argmax(ratio[differ])]),
        *differ[np.linspace(0, len(differ) - 1, TRIED).astype(int)].tolist(),
    }
    for i in sorted(tried, key=lambda i: -ratio[i]):
        speed, left = float(speeds[i]), []
        waits = WAITS * bench.response(speed).slowest
        for end in (edges[0], edges[-1]):
            part = time * abs(speed - end) / (edges[-1] - edges[0])
            left.append(_at_last(bench, controller, (float(end), speed), part, waits))
        if max(left) > APART * min(left) and max(left) > calm:
            return speed
    return float("nan")


def _at_last(bench: Bench, controller: Any, ends: tuple[float, float], time: float, waits: float) -> float:
    """Rms [rad] of the error about its mean where a run that waits has settled: near a fold that takes long."""
    for _ in range(LONGER):
        run = _run(bench, controller, ends, time, waits)
        before_end = run.time[-1] - run.time
        early = float(np.std(run.error[np.abs(before_end - 0.3 * waits) < 0.1 * waits]))
        late = float(np.std(run.error[np.abs(before_end - 0.1 * waits) < 0.1 * waits]))
        if abs(late - early) <= SAME * late or time + 2.0 * waits > 0.5 * MOST_SAMPLES * bench.sampling.period:
            break
        waits *= 2.0
    return late
