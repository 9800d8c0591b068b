"""A datasheet's measurements of hysteresis on a law.

The input is locked and the torque at the output goes slowly 0 -> +T -> -T -> +T. `hysteresis loss` is the width of that
loop at zero torque after full load; `lost motion` is the difference of torsion between the ends of a small loop, at
+-4 % of the rated torque (Harmonic Drive catalogues, "hysteresis loss" and "lost motion").
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.law import check_law, depends, states_of
from ...base.protocols import Law, lacking
from ...base.quantities import checked, number, parameters
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence
from ...numerics.operating_point import RTOL, SPEED, slow_path

SMALL_LOOP = 0.04  # of the rated torque
LEAST_RTOL = 1e-13  # tolerance where rounding begins
FRICTION_WIDTHS = 30.0  # widths of a smoothed friction: at that speed it is 99.9 % of the dry one


@dataclass(frozen=True)
class HysteresisLoop:
    """Torsion against torque, 0 -> +T -> -T -> +T, with the input locked.

    Attributes
    ----------
    torque, torsion : (n,) arrays
        The path [N*m], [rad]; the three branches one after the other, equally long.
    loss : float
        Hysteresis loss [rad]: width of the loop at zero torque.
    span : float
        Torsion [rad] from -T to +T.
    energy : float
        Area of the loop [J]: what one cycle dissipates.
    """

    torque: Floats
    torsion: Floats
    loss: float
    span: float
    energy: float

    def __str__(self) -> str:
        return (
            f"Hysteresis loop: {np.max(self.torque):.6g} N*m to {np.min(self.torque):.6g} N*m and back\n"
            f"  hysteresis loss {self.loss:.4g} rad of {self.span:.4g} rad from end to end\n"
            f"  {self.energy:.4g} J dissipated in a cycle"
        )

    __repr__ = __str__

    def middle(self, torque: float) -> float:
        """Torsion [rad] midway between unloading and loading at a torque [N*m] inside the loop."""
        torque, n = number("torque [N*m]", torque), len(self.torque) // 3
        down, up = slice(n, 2 * n), slice(2 * n, None)
        on_the_way_down = np.interp(-torque, -self.torque[down], self.torsion[down])
        return float(0.5 * (on_the_way_down + np.interp(torque, self.torque[up], self.torsion[up])))


def hysteresis_loop(law: Law, torque: float, *, speed: float = SPEED, rtol: float = RTOL) -> HysteresisLoop:
    """Twist a law slowly through 0 -> +T -> -T -> +T and measure the loop.

    Parameters
    ----------
    law : NamedTuple
        Any law; at rest and without torque at the start.
    torque : float
        Full load T [N*m].
    speed : float
        Torsion rate [rad/s]. It does not matter for a rate-independent law (springs, `BoucWen`); dry friction smoothed
        over a width shows only well above that width, viscous friction only at a speed.
    rtol : float
        Tolerance of the integration along the loop.

    Returns
    -------
    HysteresisLoop
        The path `torsion` [rad] over `torque` [N*m], `loss` [rad] at zero torque and `energy` [J] of a cycle.

    Raises
    ------
    ValueError
        If the torque or speed is not positive, or the law does not carry the torque.
    TypeError
        If `law` is no law.
    SolveError
        If the law is so rough that the integration does not end.
    """
    law = _twistable(law)
    torque, speed = number("torque [N*m]", torque, positive=True), number("speed [rad/s]", speed, positive=True)
    if not LEAST_RTOL <= (rtol := number("rtol", rtol)) < 1.0:
        raise ValueError(f"rtol is {rtol:g}; it must be from {LEAST_RTOL:g}, where rounding begins, to below 1")
    state = np.zeros(2 + states_of(law))  # torsion, internal states, work
    branches, at_zero, work, ends = [], [], [], []
    for target in (torque, -torque, torque):
        x, t, state, zero = slow_path(law, state, target, speed, rtol)
        branches.append((t, x))
        at_zero.append(zero)
        work.append(float(state[-1]))
        ends.append(float(state[0]))
    torques = np.concatenate([t for t, _ in branches])
    torsions = np.concatenate([x for _, x in branches])
    return HysteresisLoop(torques, torsions, at_zero[1] - at_zero[2], ends[2] - ends[1], work[2] - work[0])


def _twistable(law: Law) -> Any:
    """Checked law that has a torque and a stiffness."""
    law = checked(law)
    if missing := lacking(law, "torque", "stiffness"):
        raise TypeError(f"{type(law).__name__} has no {missing[0]}; give a law such as Parallel(spring, BoucWen(...))")
    check_law("the law", law)
    return law


def lost_motion(law: Law, rated_torque: float, *, share: float = SMALL_LOOP, speed: float = SPEED) -> float:
    """Lost motion [rad]: torsion from end to end of a slow loop between minus and plus a share of the rated torque.

    Parameters
    ----------
    law : torsion law
        The law; without memory its lost motion is that of its spring.
    rated_torque : float
        Rated torque [N*m].
    share : float
        Share of it; 4 % is that of the catalogues.
    speed : float
        Of the loop, as `hysteresis_loop` takes it.
    """
    rated = number("rated_torque [N*m]", rated_torque, positive=True)
    return hysteresis_loop(law, number("share", share, positive=True) * rated, speed=speed).span


@dataclass(frozen=True, eq=False)
class GearLoop:
    """The datasheet's measurements on the law: input locked, the torque slowly 0, +T, -T, +T.

    Attributes
    ----------
    full, small : HysteresisLoop
        Loops at full load and at 4 % of it; `full.loss` is the hysteresis loss, `small.span` the lost motion [rad].
    torque : float
        Full load [N*m].
    rated : bool
        Whether that is the gear's rated torque; else it is the largest torque of the steady motions.
    """

    full: HysteresisLoop
    small: HysteresisLoop
    torque: float
    rated: bool


def loop_of(law: Any, largest: float, rated: float | None) -> tuple[GearLoop | None, list[str]]:
    """Loop of a law with friction or memory, or why it has none.

    It is at the rated torque [N*m], or without one at the largest of the steady motions.
    """
    if depends(law) < 2:
        return None, []
    try:
        return gear_loop(law, largest if rated is None else rated, rated is not None), []
    except (ValueError, SolveError) as error:
        return None, [Sentence("There is no hysteresis loop to measure: {}.", error)]


def gear_loop(law: Any, torque: float, rated: bool) -> GearLoop:
    """Measure a law at full load [N*m] and at 4 % of it, at a speed well above the widths of smoothed friction.

    Raises
    ------
    ValueError
        If the law does not carry the torque.
    """
    widths = [p.value for p in parameters(law) if p.path.endswith("width") and p.unit == "rad/s"]
    speed = max([SPEED, *(FRICTION_WIDTHS * width for width in widths)])
    full = hysteresis_loop(law, torque, speed=speed)
    return GearLoop(full, hysteresis_loop(law, SMALL_LOOP * torque, speed=speed), torque, rated)
