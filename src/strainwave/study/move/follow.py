"""A train on a path: segment after segment is integrated, with the energies and the means of what the move asks.

A segment is four numbers in the train, however many the path has: none costs arithmetic in another, and a step ends at
every knot, so that the order of the integration is kept there.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats, Integers, SolveError, Status, largest_between
from ...model.train.drive_train import DriveTrain, motor_motion
from ...model.train.motion import Segment
from ...model.train.train_forms import behind_gear
from ...numerics.integration.methods import Dopri5, Method
from ...numerics.integration.peaks import watched_ends
from ...numerics.integration.record import uninterrupted
from ...numerics.integration.simulate import simulate
from .path import Path

MOST_STEPS = 1_000_000  # steps in all: they take up to a GB of memory
MEANS = ("pointing^2", "motor torque^2", "gear torque^2", "gear torque^3 turns")


class WatchedTrain(NamedTuple):
    """A drive train whose state goes on with the energies [J] of `power_names()` and the integrals `MEANS`.

    These are of the squares of pointing error, motor torque and torque in the gear, and of the torque's cube times the
    speed of the motor's reference.
    """

    train: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state; the train takes its own states alone."""
        train = self.train
        error, motor, gear, _ = self.watched(phase, y)
        speed = abs(train.omega * train.reference.slope(phase))
        means = (error * error, motor * motor, gear * gear, abs(gear) * gear * gear * speed)
        return train.rhs(phase, y) + train.losses(phase, y) + means

    def torsion(self, phase: Any, y: Any) -> Any:
        """Torsion u = x - e(theta_m) of the gear [rad]."""
        return self.train.torsion(phase, y)

    def watched(self, phase: Any, y: Any) -> Any:
        """Pointing error [rad], torque of the motor and in the gear [N*m], speed of the motor [rad/s]."""
        train = self.train
        speed = motor_motion(train, phase, y)[1]
        return train.pointing_error(y), train.motor_torque(phase, y), train.torque(phase, y), speed

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where the gear's law is not smooth."""
        return tuple(self.train.breakpoints())

    def guards(self, phase: Any, y: Any) -> Any:
        """Guards, which stay positive while the shafts of the train slide as they do, or stick."""
        return self.train.guards(phase, y)

    def slipping(self, phase: float, y: Any) -> Any:
        """The same as its shafts slide or stick from a state on, and that state."""
        train, state = self.train.slipping(phase, y)
        return self._replace(train=train), state

    def state_names(self) -> tuple[str, ...]:
        """Names of the train's states, then of what is integrated."""
        return (*self.train.state_names(), *self.train.power_names(), *MEANS)


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A train on a path; a knot between two segments is in it twice, as the end of one and the begin of the next.

    Attributes
    ----------
    train : DriveTrain
        The train, its reference that of every sample.
    t : (n,) array
        Times [s].
    y, rate : (states, n) arrays
        States of the train and their rates.
    work : (powers, n) array
        Energies [J] since the begin, as `power_names` lists them.
    means : (4,) array
        Integrals `MEANS` over the path.
    segment : (n,) int array
        Number of the segment that a sample belongs to.
    """

    train: DriveTrain
    t: Floats
    y: Floats
    rate: Floats
    work: Floats
    means: Floats
    segment: Integers

    @property
    def steps(self) -> Integers:
        """Numbers of the samples from which a step leads to the next one."""
        return np.flatnonzero((np.diff(self.segment) == 0) & (np.diff(self.t) > 0.0))

    def seen(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Values of `WatchedTrain.watched` at the samples (n,)."""
        values = WatchedTrain(self.train).watched(self.t, tuple(self.y))
        error, motor, gear, speed = [np.broadcast_to(value, self.t.shape) for value in values]
        return error, motor, gear, speed

    def peaks(self) -> list[float]:
        """Largest size of what is watched, between the samples too."""
        i = self.steps
        fields: Any = self.train.reference
        system = WatchedTrain(self.train._replace(reference=Segment(*(field[i] for field in fields))))
        every = watched_ends(system, self, i)
        return [largest_between(np.diff(self.t)[i], *ends) for ends in every]

    def pointing(self) -> tuple[Floats, Floats, Floats]:
        """Pointing error [rad] at the samples (n,), its rate and the rate of that."""
        rates = tuple(self.rate)
        speed, acceleration = behind_gear(self.train, rates)
        return np.asarray(self.train.pointing_error(tuple(self.y))), rates[0] + speed, rates[1] + acceleration


def follow(train: DriveTrain, path: Path, y0: Floats, tail: float, method: Method) -> FollowedPath:
    """Integrate a train along a path from a state, and a time [s] of rest after its end.

    Raises
    ------
    SolveError
        If the integration stops before the end, with the reason, or has more steps than memory should hold.
    """
    standstill = Segment(path.duration, train.N * path.last, 0.0, 0.0, 0.0)
    segments = [Segment(*row) for row in np.array(path.segments(np.arange(len(path.angle)), train.N)).T.tolist()]
    knots, states = [*path.knots.tolist(), path.duration + tail], len(y0)
    y = np.append(y0, np.zeros(len(train.power_names()) + len(MEANS)))
    limit = min(MOST_STEPS, method.max_steps) if isinstance(method, Dopri5) else MOST_STEPS
    t, values, rates, means, left = [], [], [], y[-len(MEANS) :], limit
    for i, segment in enumerate([*segments, standstill]):
        system, span = WatchedTrain(train._replace(reference=segment)), (knots[i], knots[i + 1])
        run = uninterrupted(simulate(system, y, span, method=_within(method, left)))
        left -= len(run.t)
        if run.status is Status.TOO_MANY_STEPS or left < 1:
            raise SolveError(
                f"the move takes more than {limit:,} steps and reached {run.t[-1]:.4g} of {knots[-1]:.4g} s; "
                "give a shorter profile or tail, or a method of less accuracy, such as Dopri5(rtol=1e-6)"
            )
        if not run.status:
            raise SolveError(f"the motion cannot be computed: {run.message}")
        t.append(run.t)
        values.append(run.y[: -len(MEANS)])
        rates.append(run.rate[:states])
        means, y = y[-len(MEANS) :], run.y[:, -1]  # those before the rest at the end
    which = np.repeat(np.arange(len(t)), [len(part) for part in t])
    columns: Any = [np.array(field)[which] for field in zip(*segments, standstill, strict=True)]
    joined, every = train._replace(reference=Segment(*columns)), np.concatenate(values, axis=1)
    return FollowedPath(
        joined, np.concatenate(t), every[:states], np.concatenate(rates, axis=1), every[states:], means, which
    )  # fmt: skip


def _within(method: Method, steps: int) -> Method:
    """The method with so many steps at most, where it chooses them."""
    return replace(method, max_steps=steps) if isinstance(method, Dopri5) else method
