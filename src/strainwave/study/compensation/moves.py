"""`compensate_move`: what controllers and input shaping make of a move from rest to rest."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.arguments import typed
from ...base.facts import Fact
from ...base.quantities import LARGEST, number, several, shown
from ...base.records import Along
from ...base.results import Floats, SolveError
from ...base.units import ARCSEC
from ...drive.project import Project
from ...model.controllers.closed_loop import Sampling
from ...model.controllers.feedforward import shaped
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import MOST_POINTS, SpeedProfile
from ...numerics.ensemble.linear_loops import loop_response
from ..move.mover import FORWARD
from ..move.profiles import path_of
from .bench import Bench, bench_of
from .compensate import compensator_of
from .result import OnTheWay

ON_MOVES = ("loop", "angle", "inverse", "nonlinear-inverse", "gandhi-ghorbel", "observer", "load-integral")
DECAY = 8.0  # time constants of the slowest motion that are run after the end
WINDOW = 60.0 * ARCSEC
SLOW = 1.0  # rad/s of the motor, at which a controller is designed that does not depend on the speed


@dataclass(frozen=True)
class MoveScore:
    """What one controller makes of a move.

    Attributes
    ----------
    name : str
        Of the controller, with the shaping of the reference.
    settling_time : float or None
        Time [s] after the end of the profile from which on the load stays within the window of where it rests; None if
        it does not within the run.
    rms, peak : float
        Of the distance of the load from the profile [rad], over the profile.
    rest_error : float
        Distance from the profile's end where the load rests [rad].
    torque : float
        Largest torque of the motor [N*m].
    limited : float
        Share of the samples at the limit of the torque.
    """

    name: str
    settling_time: float | None
    rms: float
    peak: float
    rest_error: float
    torque: float
    limited: float

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("controller", self.name, "controller"), Fact("settling_time_s", self.settling_time, "settling"),
            Fact("rms_arcsec", self.rms, "rms"), Fact("peak_arcsec", self.peak, "peak"),
            Fact("rest_arcsec", self.rest_error), Fact("motor_torque_peak_N_m", self.torque, "torque"),
            Fact("at_limit_share", self.limited),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class CompensatedMove(OnTheWay):
    """Controllers on a move.

    Attributes
    ----------
    time : (n,) array
        Times [s] of the samples.
    error : (controllers, n) array
        Angle of the load in the profile minus its angle [rad].
    torque : (controllers, n) array
        Torque of the motor [N*m].
    scores : tuple of MoveScore
        Of each controller.
    duration : float
        End of the profile [s].
    window : float
        Of settling [rad].
    remarks : tuple of str
        What was assumed, as sentences.
    """

    rows: ClassVar[str] = "time"
    places: ClassVar[Along] = {"time": {"time": "s"}}
    arrays: ClassVar[Along] = {("controller", "time"): {"error": "rad", "torque": "N*m"}}

    time: Floats
    error: Floats
    torque: Floats
    scores: tuple[MoveScore, ...]
    duration: float
    window: float
    remarks: tuple[str, ...]

    @property
    def names(self) -> list[str]:
        """Of the controllers."""
        return [score.name for score in self.scores]

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of the controllers, once."""
        limited = (
            f"{s.name}: the torque is at its limit in {100.0 * s.limited:.3g} % of the samples."
            for s in self.scores if s.limited > 0.0
        )  # fmt: skip
        return (
            Fact("duration_s", self.duration, "Compensated move of {}"),
            Fact("window_arcsec", self.window, "settled within {} of rest"),
            Fact("controllers", tuple(score.facts() for score in self.scores), "{}"),
            Fact("", tuple(limited), "{}"),
            Fact("remarks", self.remarks, "{}"),
        )


@typed
def compensate_move(
    project: Project | DriveTrain,
    profile: Any,
    controllers: Sequence[Any] = ("loop", "inverse", "nonlinear-inverse"),
    *,
    shaping: Sequence[str] = (),
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    window: float = WINDOW,
    tail: float | None = None,
) -> CompensatedMove:
    """Run a move in closed loop, from rest at angle 0, under each controller and with each shaping of its reference.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive.
    profile : Trapezoid, Dwell, or a list of them
        Angle of the load over time; its acceleration is constant from knot to knot. Where it jumps, the nonlinear
        inverse asks for a torque without limit: the load's torque, and with it the twist, would have to jump.
    controllers : sequence of str or controller
        Names of designs that do not depend on the speed (`ON_MOVES`), or controllers.
    shaping : sequence of str
        "ZV" or "ZVD": the plain loop is also run on a reference that leaves the slowest vibration at rest.
    sampling, loop, plant
        As of `compensate`.
    window : float
        Largest distance from where the load rests [rad], of one that has settled.
    tail : float, optional
        Time [s] that is run after the end. Default: until the slowest motion of the loop has decayed to 0.03 %.

    Returns
    -------
    CompensatedMove
        `error` [rad] and `torque` [N*m] of each controller over `time` [s]; `scores` have the largest error and
        the settling time.

    Raises
    ------
    ValueError
        If the acceleration is not constant from knot to knot, the profile is shorter than a sample, a controller
        depends on the speed, or a number is out of range.
    TypeError
        If an argument is of another kind.
    SolveError
        If a loop grows without end.
    """
    bench = bench_of(project, sampling, loop, plant)
    motion, duration = _motion(profile, bench.model.N)
    if duration < bench.sampling.period:
        raise ValueError(
            f"the profile lasts {duration:g} s and samples are taken every {bench.sampling.period:g} s; give more time"
        )
    window = number("window [rad]", window, positive=True)
    closed = bench.closed(bench.loop, SLOW, model=True)
    response = loop_response(closed, [SLOW], at=bench.start(SLOW, model=True))
    tail = DECAY * response.slowest if tail is None else number("tail [s]", tail, positive=True)
    references: list[tuple[str, Any, Any]] = [(*chosen, motion) for chosen in on_the_way(bench, controllers)]
    pole = response.poles[int(np.argmax(np.where(response.poles.imag != 0.0, np.abs(response.poles), 0.0)))]
    s = np.log(complex(pole)) / response.period
    references += [
        (f"loop, {kind}", bench.loop, shaped(motion, abs(s), -s.real / abs(s), kind=kind))
        for kind in several("shaping", shaping)
    ]
    runs = [bench.follow(controller, reference, duration + tail) for _, controller, reference in references]
    time = runs[0].time
    aside = [motion.value(time) - reference.value(time) for _, _, reference in references]
    error = np.array([run.error for run in runs]) + np.array(aside) / bench.model.N
    for (name, _, _), e in zip(references, error, strict=True):
        if not np.max(np.abs(e)) <= LARGEST:
            raise SolveError(f"the error grows beyond {LARGEST:g} rad under {name}; leave it out, or check the drive")
    scores = tuple(
        _score(name, time, e, run, duration, window)
        for (name, _, _), e, run in zip(references, error, runs, strict=True)
    )
    remarks = bench.remarks if bench.backward is None else (*bench.remarks, FORWARD)
    return CompensatedMove(time, error, np.array([run.torque for run in runs]), scores, duration, window, remarks)


def on_the_way(bench: Bench, controllers: Sequence[Any]) -> list[tuple[str, Any]]:
    """Names and controllers, of which none is designed for one speed (ValueError)."""
    controllers = several("controllers", controllers)
    for controller in controllers:
        if isinstance(controller, str) and controller not in ON_MOVES:
            raise ValueError(
                f"controller {shown(controller)} is designed for one speed, or is none; on a way through many there "
                f"are {', '.join(ON_MOVES)}"
            )
    designs = [compensator_of(controller) for controller in controllers]
    if not designs:
        raise ValueError("there is nothing to run; give at least one controller")
    return [(design.name, design.on(bench, SLOW)) for design in designs]


def _motion(profile: Any, N: float) -> tuple[SpeedProfile, float]:
    """Speed of the motor over time, and the end of the profile [s]."""
    path = path_of(profile, 0.0)
    if np.any(path.jerk != 0.0):
        raise ValueError("the profile has parts whose acceleration is not constant; give one Trapezoid or several")
    if len(path.knots) > MOST_POINTS:
        raise ValueError(
            f"the profile has {len(path.knots)} knots; a sampled loop takes up to {MOST_POINTS}: give fewer parts"
        )
    ends = np.append(path.speed, 0.0)
    jumps = np.abs(path.speed + path.acceleration * np.diff(path.knots) - ends[1:])
    if np.any(jumps > 1e-9 * np.max(np.abs(ends), initial=1e-300)):
        raise ValueError("the profile has a speed that jumps; give parts that begin and end at rest")
    return SpeedProfile(tuple(path.knots.tolist()), tuple((N * ends).tolist())), path.duration


def _score(name: str, time: Floats, error: Floats, run: Any, duration: float, window: float) -> MoveScore:
    moving, last = time <= duration, time >= time[-1] - 0.1 * max(time[-1] - duration, 0.0)
    remaining = float(np.mean(error[last]))
    outside = np.flatnonzero((np.abs(error - remaining) > window) & ~moving)
    settled: float | None = 0.0
    if len(outside):
        i = int(outside[-1])
        settled = None if i + 1 >= len(time) else float(time[i + 1] - duration)
    off = error[moving]
    return MoveScore(
        name, settled, float(np.sqrt(np.mean(off * off))), float(np.max(np.abs(off))), remaining,
        float(np.max(np.abs(run.torque))), float(run.memory.limited) / len(time),
    )  # fmt: skip
