"""Odd polynomials instead of a datasheet's straight lines: least squares in the torque, with the error of the fit."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.law import KINDS, depends, has
from ...base.quantities import LARGEST, checked, number, shown
from ..laws.springs import Cubic, Polynomial

POINTS = 2001
HIGHEST = 15  # degree; beyond it the monomials cannot be told apart in double precision


@dataclass(frozen=True)
class LawFit:
    """An odd polynomial law fitted to another law.

    Attributes
    ----------
    law : Cubic or Polynomial
        The fit: a `Cubic` for degree 3.
    reach : float
        Largest torsion [rad] of the fit; beyond it the polynomial is an extrapolation.
    rms, largest : float
        Root mean square and largest error of the torque [N*m] up to there.
    relative : float
        `rms` over the torque at `reach`.
    """

    law: Cubic | Polynomial
    reach: float
    rms: float
    largest: float
    relative: float

    def __str__(self) -> str:
        numbers = self.law if isinstance(self.law, Cubic) else self.law.coefficients
        name = f"{type(self.law).__name__}({', '.join(f'{c:.4g}' for c in numbers)})"
        return f"{name}: rms error {100.0 * self.relative:.2g} % of the torque at {self.reach:.4g} rad"


def fit_odd(law: Any, reach: float, degree: int = 3) -> LawFit:
    """Fit k1 x + k3 x^3 and higher odd terms to a law by least squares in the torque, uniformly on 0 .. reach.

    Parameters
    ----------
    law : NamedTuple
        Any law `torque(x)` that is odd, or of which only positive torsions matter.
    reach : float
        Largest torsion [rad].
    degree : int
        Highest power, odd, 1 to 15.

    Raises
    ------
    ValueError
        If the degree is not odd or out of range, `reach` is not positive and finite, the law is wrong or without torque
        there, or the fit has no stiffness at rest.
    TypeError
        If `law` is no spring.
    """
    if degree not in range(1, HIGHEST + 1, 2):
        raise ValueError(f"degree is {shown(degree)}; an odd polynomial has one of 1, 3, 5 to {HIGHEST}")
    law = checked(law)
    if not has(law, "torque") or depends(law) != 1:
        kind = KINDS[depends(law) - 1] if has(law, "torque") else "no torque"
        raise TypeError(f"fit_odd takes a spring, torque(x); {type(law).__name__} has {kind}")
    reach = number("reach [rad]", reach, positive=True)
    s = np.linspace(0.0, 1.0, POINTS)
    torque = np.broadcast_to(np.asarray(law.torque(reach * s), float), s.shape)
    if not abs(torque[-1]) > 0.0:
        raise ValueError(
            f"{type(law).__name__} has no torque at the reach {reach:g} rad, to which errors are related; take another"
        )
    powers = np.arange(1, degree + 1, 2)
    scaled = np.linalg.lstsq(s[:, None] ** powers, torque, rcond=None)[0]
    with np.errstate(all="ignore"):
        sizes = reach**powers
        k = [float(c) for c in scaled / sizes]
    if not (max(abs(c) for c in k) <= LARGEST and np.all(np.isfinite(sizes))):  # nor nan
        raise ValueError(
            f"reach [rad] is {reach:g}, outside the supported range: the coefficients of degree {degree} exceed "
            f"{LARGEST:g} in SI units; give the largest torsion in rad"
        )
    if not k[0] > 0.0:
        raise ValueError(
            f"the fit of degree {degree} to {type(law).__name__} has the stiffness {k[0]:g} N*m/rad at rest; fit a law "
            "without backlash, over another reach or with another degree"
        )
    if degree == 3:
        fitted: Cubic | Polynomial = Cubic(k[0], k[1] / k[0])
    else:
        fitted = Polynomial(tuple(c for pair in zip([0.0] * len(k), k, strict=True) for c in pair))
    error = np.abs(fitted.torque(reach * s) - torque)
    rms = float(np.sqrt(np.mean(error * error)))
    return LawFit(fitted, float(reach), rms, float(np.max(error)), rms / float(abs(torque[-1])))
