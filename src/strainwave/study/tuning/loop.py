"""`Loop`: the loop of a project's motor with its gains by name; their logarithms, and the gains of a classical rule."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.quantities import numbers, shown
from ...base.results import Floats
from ...drive.project import Project
from ...model.train.controls import CascadeLoop, PositionLoop, SpeedLoop
from ...model.train.filters import apart, around

STEP = 0.05  # of a gain, of its sensitivity


def rule(core: Any, inertia: float, time: float) -> Any:
    """Gains of the symmetric optimum for an inertia [kg*m^2] and the sum of lags and delays [s] of its loop.

    With the sum T of small times the speed loop has K_p = J/(2 T), T_n = 4 T; closed it is about a lag of 4 T, behind
    which the position gain K_v = 1/(16 T) gives the damping ratio 1. Without the position loop K_i = K_p/T_n. A PD loop
    of the position is the same loop with other names.
    """
    K_p = (inertia + getattr(core, "inertia", lambda: 0.0)()) / (2.0 * time)
    if isinstance(core, CascadeLoop):
        return CascadeLoop(1.0 / (16.0 * time), K_p, 4.0 * time)
    if isinstance(core, SpeedLoop):
        return core._replace(K_p=K_p, K_i=K_p / (4.0 * time))
    return PositionLoop(K_p / (4.0 * time), K_p)


class Loop:
    """The loop of a project: its gains by name, and the control with others."""

    def __init__(self, project: Project, names: Sequence[str] | None) -> None:
        self.core, self.about = apart(None if project.whole is None else project.whole.motor.control)
        if not project.motor_named or not isinstance(self.core, CascadeLoop | SpeedLoop | PositionLoop):
            raise ValueError(
                "the motor of this project has no loop to tune (motor held, free or not given); write for example "
                "'motor: {loop: {type: cascade, bandwidth: 30 Hz, lag: 0.5 ms}}'"
            )
        self.inertia, self.lag = project.loop_inertia, self.about.get("lag", 0.0)
        tunable = [name for name, gain in rule(self.core, self.inertia, 1.0)._asdict().items()
                   if gain != getattr(self.core, name) > 0.0]  # fmt: skip
        self.names = tuple(tunable if names is None else dict.fromkeys(map(str, names)))
        if wrong := [name for name in self.names if name not in tunable]:
            raise ValueError(f"there is no gain {shown(wrong[0])} to tune in this loop; it has {', '.join(tunable)}")

    def logs(self, core: Any) -> Floats:
        """Logarithms of the gains of a loop."""
        return np.log([getattr(core, name) for name in self.names])

    def powers(self) -> Floats:
        """Powers of the frequency of the loop that its gains go with."""
        rules = [self.logs(rule(self.core, self.inertia, time)) for time in (1.0, np.e)]
        return np.round(rules[0] - rules[1])

    def control(self, x: Floats, *more: Any) -> Any:
        """The control with gains of these logarithms, and with more filters."""
        core = self.core._replace(**dict(zip(self.names, gains_of(x), strict=True)))
        return around(core, **self.about | {"filters": (*self.about.get("filters", ()), *more)})


def gains_of(x: Floats) -> tuple[float, ...]:
    """Gains of these logarithms, as numbers of seven digits that a file can hold."""
    return tuple(float(f"{gain:.7g}") for gain in np.exp(x))


def small_steps(x: Floats) -> list[tuple[int, float, Floats]]:
    """Gains by their numbers, with a change up and down, and its step of logarithms."""
    return [(i, change, np.log1p(change) * row) for i, row in enumerate(np.eye(len(x))) for change in (STEP, -STEP)]


def loads_of(drive: Project, loads: Sequence[float] | None) -> list[Project]:
    """A drive under each of some loads; by default the ends and the middle of its range, or as it is."""
    low, high = drive.other_loads
    if loads is None and low == high:
        return [drive]
    torques = np.linspace(low, high, 3) if loads is None else numbers("loads [N*m]", loads)
    return [drive.under(float(torque)) for torque in torques]


def with_control(drive: Project, control: Any) -> Project:
    """A drive with another loop of its motor."""
    return replace(drive, subject=drive.subject.with_motor(control=control))
