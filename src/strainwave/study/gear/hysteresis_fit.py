"""`fit_hysteresis`: a law whose stiffness, hysteresis loss and lost motion are those of a datasheet."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import Law
from ...base.quantities import checked, mapped, number
from ...base.results import Floats, SolveError
from ...model.laws.hysteresis import BoucWen, Parallel
from ...model.laws.springs import PiecewiseLinear, Play
from ...numerics.operating_point import RTOL, operating_point
from .hysteresis_loop import SMALL_LOOP, hysteresis_loop

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
        return f"{law}\n  off the datasheet by: {parts}"


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
        raise SolveError(f"no such law meets the datasheet: {worst} is off by {100.0 * misfits[worst]:+.3g} %; {why}")
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
