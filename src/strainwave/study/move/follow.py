"""A train on a path: segment after segment is integrated, with the energies and the means of what the move asks.

A segment is four numbers in the train, however many the path has: none costs arithmetic in another, and a step ends at
every knot, so that the order of the integration is kept there.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...model.train.drive_train import DriveTrain, motor_motion
from ...model.train.motion import Segment
from ...model.train.train_forms import behind_gear
from ...numerics.integration.extremes import ends_of
from ...numerics.integration.methods import Method
from ...numerics.integration.simulate import simulate
from ...results import Floats, SolveError, largest_between
from ..response.steady import finished_or_interrupted
from .path import Path

MEANS = ("pointing^2", "motor torque^2", "gear torque^2", "gear torque^3 turns")


class Watched(NamedTuple):
    """A drive train whose state goes on with the energies [J] of `power_names()` and the integrals `MEANS`.

    These are of the squares of pointing error, motor torque and torque in the gear, and of the torque's cube times the
    speed of the motor's reference.
    """

    train: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state; the train looks at its own states alone."""
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

    def state_names(self) -> tuple[str, ...]:
        """Names of the train's states, then of what is integrated."""
        return (*self.train.state_names(), *self.train.power_names(), *MEANS)


@dataclass(frozen=True, eq=False)
class Followed:
    """A train on a path; a knot between two segments is in it twice, as the end of one and the begin of the next.

    Attributes
    ----------
    train : DriveTrain
        The train, its reference that of every sample.
    t : (n,) array
        Times [s].
    y, rate : (states, n) arrays
        States of `Watched` and their rates.
    segment : (n,) int array
        Number of the segment that a sample belongs to.
    """

    train: DriveTrain
    t: Floats
    y: Floats
    rate: Floats
    segment: NDArray[np.int64]

    @property
    def steps(self) -> NDArray[np.int64]:
        """Numbers of the samples from which a step leads to the next one."""
        return np.flatnonzero(np.diff(self.segment) == 0)

    @property
    def states(self) -> tuple[Floats, ...]:
        """States of the train itself."""
        return tuple(self.y[: len(self.train.state_names())])

    def seen(self) -> tuple[Floats, Floats, Floats, Floats]:
        """What `Watched` watches, at the samples (n,)."""
        values = Watched(self.train).watched(self.t, self.states)
        error, motor, gear, speed = (np.broadcast_to(value, self.t.shape) for value in values)
        return error, motor, gear, speed

    def peaks(self) -> list[float]:
        """Largest size of what is watched, between the samples too."""
        i = self.steps
        fields: Any = self.train.reference
        reference = Segment(*(field[i] for field in fields))
        system = Watched(self.train._replace(reference=reference))
        early, late = ((self.t[k], tuple(self.y[:, k]), tuple(self.rate[:, k])) for k in (i, i + 1))
        ends = ends_of(system, 1.0, *early, *late)
        return [largest_between(np.diff(self.t)[i], *end) for end in zip(*ends, strict=True)]

    def pointing(self) -> tuple[Floats, Floats, Floats]:
        """Pointing error [rad] at the samples (n,), its rate and the rate of that."""
        rates = tuple(self.rate[: len(self.states)])
        speed, acceleration = behind_gear(self.train, rates)
        return self.seen()[0], rates[0] + speed, rates[1] + acceleration


def follow(train: DriveTrain, path: Path, y0: Floats, tail: float, method: Method) -> Followed:
    """Integrate a train along a path from a state, and a time [s] of rest after its end.

    Raises
    ------
    SolveError
        If the integration stops before the end, with the reason.
    """
    rest = Segment(path.duration, train.N * path.last, 0.0, 0.0, 0.0)
    segments = [Segment(*row) for row in np.array(path.segments(np.arange(len(path.angle)), train.N)).T.tolist()]
    knots = [*path.knots.tolist(), path.duration + tail]
    names = Watched(train).state_names()
    y = np.append(y0, np.zeros(len(names) - len(y0)))
    runs = []
    for i, segment in enumerate([*segments, rest]):
        system = Watched(train._replace(reference=segment))
        run = finished_or_interrupted(simulate(system, y, (knots[i], knots[i + 1]), method=method))
        if not run.status:
            raise SolveError(f"the motion cannot be followed: {run.message}")
        y = run.y[:, -1]
        runs.append(run)
    which = np.repeat(np.arange(len(runs)), [len(run.t) for run in runs])
    columns: Any = [np.array(field)[which] for field in zip(*segments, rest, strict=True)]
    joined = train._replace(reference=Segment(*columns))
    return Followed(
        joined, np.concatenate([run.t for run in runs]), np.concatenate([run.y for run in runs], axis=1),
        np.concatenate([run.rate for run in runs], axis=1), which,
    )  # fmt: skip
