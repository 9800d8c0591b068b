"""Hysteresis fitted to a datasheet: a law whose stiffness, hysteresis loss and lost motion are the datasheet's."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model.hysteresis import BoucWen, Parallel
from ..model.laws import PiecewiseLinear
from ..numerics.loading import RTOL
from ..quantities import checked, number, shown
from ..results import Floats, SolveError
from .hysteresis import SMALL_LOOP, hysteresis_loop

RTOL_OF_FIT = 1e-7
INSIDE = 0.8  # of full load: up to there the two branches of a loop are apart


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
        Relative differences from the datasheet: "hysteresis loss", "lost motion", and the torsion midway between
        unloading and loading at T1, T2 and half load (as far as they are below 80 % of full load).
    """

    law: Any
    loss: float
    lost_motion: float
    misfit: dict[str, float]

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {100.0 * value:+.2g} %" for name, value in self.misfit.items())
        return f"{self.law}\n  off the datasheet by: {parts}"


def fit_hysteresis(
    spring: PiecewiseLinear, hysteresis_loss: float, lost_motion: float, *, rated_torque: float,
    load: float | None = None, replace_spring: bool = False, n: int = 1, tolerance: float = 0.05,
) -> HysteresisFit:  # fmt: skip
    """Fit Bouc-Wen hysteresis to a datasheet: stiffness, hysteresis loss and lost motion.

    In parallel with the gear's spring (whose slopes stay) an element with ratio = 0, A = 1, beta = gamma = 1/2 carries
    at most the torque T_h; its two unknowns, T_h and the yield twist, are set by hysteresis loss and lost motion.
    Replacing the spring, a `BoucWen` of unknown K, ratio and yield twist meets the torsions too; it can only soften, so
    that gears whose K3 is well above K1 are refused.

    Parameters
    ----------
    spring : PiecewiseLinear
        K1, K2, K3, T1, T2 of the datasheet.
    hysteresis_loss, lost_motion : float
        Of the datasheet [rad].
    rated_torque : float
        Of the datasheet [N*m]; lost motion is taken at +-4 % of it.
    load : float, optional
        Full load [N*m] of the hysteresis loop. Default: the rated torque.
    replace_spring : bool
        Whether the law replaces the spring.
    n : int
        Exponent of Bouc-Wen: the larger, the sharper the yield.
    tolerance : float
        Largest relative misfit that is accepted.

    Returns
    -------
    HysteresisFit

    Raises
    ------
    ValueError
        If a number is not positive.
    TypeError
        If the spring is no `PiecewiseLinear`.
    SolveError
        If the values cannot be met; the sentence says by how much.
    """
    if not isinstance(spring, PiecewiseLinear):
        raise TypeError(
            f"the spring is {shown(spring)}; it must be the datasheet's PiecewiseLinear(K1, K2, K3, T1, T2), for "
            "example catalogue.gear('CSG-40-50').law"
        )
    spring = checked(spring)
    names = ("hysteresis_loss [rad]", "lost_motion [rad]", "rated_torque [N*m]", "tolerance")
    values = (hysteresis_loss, lost_motion, rated_torque, tolerance)
    wanted_loss, wanted_motion, rated, tolerance = (
        number(name, value, positive=True) for name, value in zip(names, values, strict=True)
    )
    full = rated if load is None else number("load [N*m]", load, positive=True)
    small = SMALL_LOOP * rated
    places = sorted({t for t in (spring.T1, spring.T2, 0.5 * full) if t <= INSIDE * full})
    labels = ["hysteresis loss", "lost motion", *(f"torsion at {t:g} N*m" for t in places)]

    def law_of(p: Floats) -> Any:
        if replace_spring:
            K, twist = (float(value) for value in np.exp(p[:2]))
            return BoucWen(K, float(1.0 / (1.0 + np.exp(-p[2]))), twist, 1.0, 0.5, 0.5, n)
        limit, twist = (float(value) for value in np.exp(p[:2]))
        return Parallel(spring, BoucWen(limit / twist, 0.0, twist, 1.0, 0.5, 0.5, n))

    def misfit(p: Floats, rtol: float = RTOL_OF_FIT) -> Floats:
        law = law_of(p)
        loop = hysteresis_loop(law, full, rtol=rtol)
        measured = [loop.loss / wanted_loss, hysteresis_loop(law, small, rtol=rtol).span / wanted_motion]
        return np.array([*measured, *(loop.middle(t) / _torsion(spring, t) for t in places)]) - 1.0

    start = [spring.K1, wanted_loss] if replace_spring else [0.5 * spring.K1 * wanted_loss, 0.25 * wanted_loss]
    p0 = np.log(start + ([1.0] if replace_spring else []))
    weights = np.ones(len(labels)) if replace_spring else np.array([1.0, 1.0, *[1e-4] * len(places)])
    from scipy.optimize import least_squares

    found = least_squares(lambda p: weights * misfit(p), p0, bounds=(p0 - 12.0, p0 + 12.0), xtol=1e-6, diff_step=1e-3)
    off = dict(zip(labels, (float(value) for value in misfit(found.x, RTOL)), strict=True))
    law = law_of(found.x)
    worst = max(off, key=lambda name: abs(off[name]))
    if abs(off[worst]) > tolerance:
        elastic = 2.0 * small / spring.K1
        raise SolveError(
            f"no such law meets the datasheet: {worst} is off by {100.0 * off[worst]:+.3g} %; with this spring the "
            f"lost motion is below {elastic:.3g} rad (the spring alone) and falls as the hysteresis loss grows: a "
            "datasheet's 'less than' is a limit and not a value, give smaller ones, a softer spring, or Play"
        )
    return HysteresisFit(law, wanted_loss * (1.0 + off[labels[0]]), wanted_motion * (1.0 + off[labels[1]]), off)


def _torsion(spring: PiecewiseLinear, torque: float) -> float:
    """Torsion [rad] of the datasheet's curve at a torque [N*m] >= 0."""
    first = min(torque, spring.T1) / spring.K1
    second = max(0.0, min(torque, spring.T2) - spring.T1) / spring.K2
    return first + second + max(0.0, torque - spring.T2) / spring.K3
