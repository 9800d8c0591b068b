"""A datasheet's measurements of hysteresis: what a law would show in them, and the law that has those of a datasheet.

The input is locked and the torque at the output goes slowly 0 -> +T -> -T -> +T. `hysteresis loss` is the width of that
loop at zero torque after full load; `lost motion` is the difference of torsion between the ends of a small loop, at
+-4 % of the rated torque (Harmonic Drive catalogues, "hysteresis loss" and "lost motion").
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.law import check_law, depends, states_of
from ...base.protocols import Law, lacking
from ...base.quantities import checked, mapped, number, parameters
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence
from ...model.laws.hysteresis import BoucWen, Parallel
from ...model.laws.springs import PiecewiseLinear, Play
from ...numerics.operating_point import RTOL, SPEED, operating_point, slow_path

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


RTOL_OF_FIT = 1e-7
YIELD_SHARE = 0.25  # of the hysteresis loss: the yield twist where no lost motion is given
INSIDE_SHARE = 0.8  # of full load: up to there the two branches of a loop are apart
FARTHEST_LOG = 12.0  # logarithm of the factor that an unknown may be off from its start


@dataclass(frozen=True)
class HysteresisFit:
    """A law with hysteresis that meets a datasheet.

    Attributes
    ----------
    law : Parallel or BoucWen
        The law.
    loss, lost_motion : float
        Its hysteresis loss and lost motion [rad], measured as the datasheet does.
    misfit : dict of str to float
        Relative differences from the datasheet: "hysteresis loss", "lost motion" where it was given, and the torsion
        midway between unloading and loading at T1, T2 and half load (as far as they are below 80 % of full load).
    """

    law: Any
    loss: float
    lost_motion: float
    misfit: dict[str, float]

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {100.0 * value:+.2g} %" for name, value in self.misfit.items())
        law = mapped(lambda value: float(f"{value:.6g}"), self.law)
        return f"{law}\n  deviation from the datasheet: {parts}"


def fit_hysteresis(
    spring: PiecewiseLinear, hysteresis_loss: float, lost_motion: float | None = None, *, rated_torque: float,
    load: float | None = None, replace_spring: bool = False, n: int = 1, tolerance: float = 0.05,
) -> HysteresisFit:  # fmt: skip
    """Fit Bouc-Wen hysteresis to a datasheet: stiffness, hysteresis loss and lost motion.

    In parallel with the gear's spring (whose slopes stay) an element with ratio = 0, A = 1, beta = gamma = 1/2 carries
    at most the torque T_h; its two unknowns, T_h and the yield twist, are set by hysteresis loss and lost motion. The
    torsions between are those of the spring but near its corners T1 and T2, which the element rounds: `misfit` tells by
    how much. An element beside the spring only lowers the lost motion: a larger one is met with a gap in series with
    the spring (`Play`), then the unknowns are T_h and the gap, and the torsions grow by half of it. Replacing the
    spring, a `BoucWen` of unknown K, ratio and yield twist meets the torsions too; it can only soften, so that gears
    whose K3 is well above K1 are refused.

    Parameters
    ----------
    spring : PiecewiseLinear
        K1, K2, K3, T1, T2 of the datasheet.
    hysteresis_loss : float
        Of the datasheet [rad].
    lost_motion : float, optional
        Of the gear [rad], as a value. A catalogue's "less than" is none: the spring alone may stay well below it.
        Default: unknown, and the element yields over a quarter of the hysteresis loss.
    rated_torque : float
        Of the datasheet [N*m]; lost motion is taken at +-4 % of it.
    load : float, optional
        Full load [N*m] of the hysteresis loop. Default: the rated torque.
    replace_spring : bool
        True for a law that replaces the spring.
    n : int
        Exponent of Bouc-Wen: the larger, the sharper the yield.
    tolerance : float
        Largest relative misfit that is accepted: of hysteresis loss and lost motion, and where the law replaces the
        spring of the torsions too.

    Returns
    -------
    HysteresisFit
        `law` with its `loss` and `lost_motion` [rad], and the `misfit` from the datasheet (relative).

    Raises
    ------
    ValueError
        If a number is not positive.
    SolveError
        If the values cannot be met; the sentence gives the misfit and the reason.
    """
    from scipy.optimize import least_squares  # half a second that a loop without a fit need not wait

    spring = checked(spring)
    datasheet = {"hysteresis loss": number("hysteresis_loss [rad]", hysteresis_loss, positive=True)}
    if lost_motion is not None:
        datasheet["lost motion"] = number("lost_motion [rad]", lost_motion, positive=True)
    rated = number("rated_torque [N*m]", rated_torque, positive=True)
    tolerance = number("tolerance", tolerance, positive=True)
    full = rated if load is None else number("load [N*m]", load, positive=True)
    loss, target = datasheet["hysteresis loss"], _Target(spring, datasheet, full, SMALL_LOOP * rated)

    def fitted(gap: bool) -> tuple[Any, dict[str, float], str]:
        """Best law with or without a gap, its misfit, and the name of the worst number."""
        p0, counted, law_of = target.unknowns(replace_spring, gap, n)

        def misfit(p: Floats) -> Floats:
            return np.array([*target.misfit(law_of(p), RTOL_OF_FIT).values()][:counted])

        law = law_of(
            least_squares(misfit, p0, bounds=(p0 - FARTHEST_LOG, p0 + FARTHEST_LOG), xtol=1e-6, diff_step=1e-3).x
        )
        misfits = target.misfit(law, RTOL)
        return law, misfits, max([*misfits][:counted], key=lambda name: abs(misfits[name]))

    # more lost motion than that of the spring, which hysteresis beside it can only lower
    gap = not replace_spring and datasheet.get("lost motion", 0.0) >= target.elastic()
    law, misfits, worst = fitted(gap)
    if abs(misfits[worst]) > tolerance and not gap and not replace_spring and misfits.get("lost motion", 0.0) < 0.0:
        law, misfits, worst = fitted(True)
    if abs(misfits[worst]) > tolerance:
        why = target.why(replace_spring)
        raise SolveError(f"no such law fits the datasheet: {worst} differs by {100.0 * misfits[worst]:+.3g} %; {why}")
    motion = hysteresis_loop(law, target.small).span
    return HysteresisFit(law, loss * (1.0 + misfits["hysteresis loss"]), motion, misfits)


class _Target(NamedTuple):
    """Datasheet that a law is to meet: values [rad] by their name, at full load and in the small loop [N*m]."""

    spring: PiecewiseLinear
    wanted: dict[str, float]
    full: float
    small: float

    def misfit(self, law: Law, rtol: float) -> dict[str, float]:
        """Relative differences: first those of the values wanted, then those of the torsions."""
        loop = hysteresis_loop(law, self.full, rtol=rtol)
        differences = {"hysteresis loss": loop.loss / self.wanted["hysteresis loss"] - 1.0}
        if "lost motion" in self.wanted:
            motion = hysteresis_loop(law, self.small, rtol=rtol).span
            differences["lost motion"] = motion / self.wanted["lost motion"] - 1.0
        for T in sorted({self.spring.T1, self.spring.T2, 0.5 * self.full}):
            if self.full * INSIDE_SHARE >= T:
                differences[f"torsion at {T:g} N*m"] = loop.middle(T) / operating_point(self.spring, T) - 1.0
        return differences

    def unknowns(self, replace_spring: bool, gap: bool, n: int) -> tuple[Floats, int | None, Callable[[Floats], Any]]:
        """Start values (logarithms), the count of numbers to meet (None: all), and the law of the unknowns."""
        spring, loss = self.spring, self.wanted["hysteresis loss"]

        def alone(p: Floats) -> Any:
            K, twist = np.exp(p[:2]).tolist()
            return BoucWen(K, float(1.0 / (1.0 + np.exp(-p[2]))), twist, 1.0, 0.5, 0.5, n)

        def with_element(spring: Any, limit: float, twist: float) -> Any:
            return Parallel(spring, BoucWen(limit / twist, 0.0, twist, 1.0, 0.5, 0.5, n))

        def beside(p: Floats) -> Any:
            return with_element(spring, *[*np.exp(p).tolist(), YIELD_SHARE * loss][:2])

        def behind_gap(p: Floats) -> Any:  # the element yields over a quarter of the loss, as without a lost motion
            limit, half_gap = np.exp(p).tolist()
            return with_element(Play(half_gap, spring), limit, YIELD_SHARE * loss)

        if replace_spring:
            return np.array([np.log(spring.K1), np.log(loss), 1.0]), None, alone
        if gap:
            missing = max(self.wanted["lost motion"] - self.elastic(), 0.0)
            return np.log([0.5 * self.small, 0.5 * missing + YIELD_SHARE * loss]), 2, behind_gap
        count = len(self.wanted)
        return np.log([float(spring.torque(0.5 * loss)), YIELD_SHARE * loss][:count]), count, beside

    def elastic(self) -> float:
        """Lost motion [rad] of the spring alone."""
        return 2.0 * operating_point(self.spring, self.small)

    def why(self, replace_spring: bool) -> str:
        """Reason why a law may not exist, and the remedy."""
        if replace_spring:
            return (
                "one Bouc-Wen law can only soften with the torque; put it beside the spring, replace_spring=False, or "
                "raise the tolerance"
            )
        largest = 2.0 * operating_point(self.spring, self.full)
        if self.wanted["hysteresis loss"] > largest:
            return (
                f"a loop to {self.full:g} N*m and back is {largest:.3g} rad wide with the spring alone, and the "
                "hysteresis loss is wider; give more load or less loss"
            )
        return (
            f"the spring alone has a lost motion of {self.elastic():.3g} rad, hysteresis beside it lowers that, and a "
            "gap raises the hysteresis loss as well: a datasheet's 'less than' is a limit and not a value, leave "
            "lost_motion out or give one that is nearer to the hysteresis loss"
        )
