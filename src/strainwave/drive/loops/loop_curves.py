"""The motor's loop of a drive in frequency and in time: open and closed loop, steps of its reference and of a torque.

All is linear, about the state of the mean torques. A step of the reference is one of its speed, at the begin of which
motor and load stand still and the states of the control are zero; a step of its angle answers with the same curve where
the control acts on angle and speed of the deviation.
"""

from typing import NamedTuple

import numpy as np

from ...base.results import Complexes, Floats
from ..operating_point import mean_state
from .margins import HALF_WIDTHS, Margins, MotorLoop, loop_of
from .sampled_loop import SampledLoop, held
from .worst_margins import WorstMargins

POINTS, STEPS = 600, 600  # frequencies and times of the curves
LONGEST_TIMES = 8.0  # time constants of the slowest pole: later, everything has settled
UNSETTLED_SHARE, LATER = 0.02, 1.3  # of the largest deviation; and how many settling times are shown
SPEED = "motor deviation'"
OUTPUTS = ("motor speed", "load speed", "motor deviation", "error")


class LoopCurves(NamedTuple):
    """Curves of a motor's loop under one load.

    Attributes
    ----------
    margins : Margins
        Margins of the loop.
    omega, open : (n,) arrays
        Frequencies [rad/s], of a sampled loop up to half its rate, and the complex open loop L there.
    time : (m,) array
        Times [s] after a step; none of an unstable loop.
    speeds : (2, m) array
        Speeds of motor and load after a step of the reference, over their last values.
    angles : (2, m) array
        Angles [rad/(N*m)] of motor and load, at the load's side, after a step of torque on the load, over that torque.
    """

    margins: Margins
    omega: Floats
    open: Complexes
    time: Floats
    speeds: Floats
    angles: Floats

    @property
    def closed(self) -> Complexes:
        """Closed loop L/(1 + L): speed of the motor over its reference."""
        return np.asarray(self.open / (1.0 + self.open))


def loop_curves(worst: WorstMargins) -> LoopCurves:
    """Compute the loop of a drive under the load with its worst margins; an unstable one has no steps."""
    loaded, margins = worst.worst
    train = loaded.train
    loop = loop_of(train, mean_state(train), train.omega, worst.sampling)
    omega = loop.frequencies(POINTS, HALF_WIDTHS[::8])
    time, curves = _steps(loop) if margins.stable else (np.empty(0), np.empty((4, 0)))
    return LoopCurves(margins, omega, loop(omega), time, curves[:2], curves[2:])


def _steps(loop: MotorLoop | SampledLoop) -> tuple[Floats, Floats]:
    """Times until all has settled, and the four curves."""
    longest = LONGEST_TIMES / float(np.min(np.abs(loop.growing.real)))
    time, curves = _motions(loop, longest)
    off = np.abs(curves - curves[:, -1:])
    late = np.flatnonzero(np.any(off > UNSETTLED_SHARE * np.max(off, axis=1, keepdims=True), axis=0))
    return _motions(loop, min(longest, LATER * time[late[-1] + 1]))


def _motions(loop: MotorLoop | SampledLoop, longest: float) -> tuple[Floats, Floats]:
    """Times (m,) [s] and curves (4, m); those of a sampled loop at its samples."""
    plain = loop if isinstance(loop, MotorLoop) else loop.plant.loop
    plant, linear = plain.plant, plain.closed
    if isinstance(loop, SampledLoop):
        linear, step, moved, pushed = plant, loop.period, loop.closed(), loop.plant.of_load
    else:
        step = longest / STEPS
        moved, pushed = held(linear.A, linear.B[:, linear.inputs.index("load torque")], step, 0.0)
    count = max(1, round(longest / (STEPS * step)))
    whole = np.eye(len(moved) + 1)
    whole[:-1, :-1], whole[: len(pushed), -1] = moved, pushed
    whole = np.linalg.matrix_power(whole, count)
    states = np.zeros((2, len(whole)))
    states[0, [linear.states.index(name) for name in plant.states]] = _begin(plain)
    states[1, -1] = 1.0
    rows = [states]
    while len(rows) <= longest / (count * step):
        rows.append(rows[-1] @ whole.T)
    of_reference, of_torque = (np.array(rows)[:, i, : linear.C.shape[1]] @ linear.C.T for i in (0, 1))
    motor, load, angle, error = (linear.outputs.index(name) for name in OUTPUTS)
    ratio = plain.train.N
    speeds = 1.0 + of_reference[:, motor], 1.0 + ratio * of_reference[:, load]
    turned = of_torque[:, angle] / ratio
    return np.asarray(count * step * np.arange(len(rows))), np.array([*speeds, turned, turned - of_torque[:, error]])


def _begin(plain: MotorLoop) -> Floats:
    """States of the plant behind a step of the reference speed to 1, of which the control's inertia takes a part."""
    plant, inertia = plain.plant, plain.control.inertia
    begin = -1.0 * np.array([name == SPEED for name in plant.states])
    torque = plant.B[:, plant.inputs.index("motor torque")]
    return np.asarray(begin + torque * inertia / (1.0 - inertia * float(begin @ torque)))
