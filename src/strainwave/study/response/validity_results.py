"""Maps of where multiple scales hold: over speed and excitation of a drive, and over bend and damping in general."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...quantities import number
from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen

ORDERS = (1, 2)
LEVELS = (1.0, 5.0, 20.0)  # percent


class Holds(Result):
    """What both maps can say: where an order holds to some percent."""

    error: Floats

    def holds(self, percent: float) -> NDArray[np.bool_]:
        """Whether each order holds to so many percent: the shape of `error`.

        Parameters
        ----------
        percent : float
            Between 0 and 100.
        """
        limit = number("percent", percent, positive=True)
        if not limit < 100.0:
            raise ValueError(f"percent is {limit:g}; it must be below 100, where no order holds")
        return self.error <= 0.01 * limit

    def _shares(self) -> list[str]:
        shares = [[f"{np.mean(part):.0%}" for part in self.holds(level)] for level in LEVELS]
        return [
            f"  order {order} holds to {', '.join(f'{level:g} %' for level in LEVELS)} in "
            f"{', '.join(share[i] for share in shares)} of the cells"
            for i, order in enumerate(ORDERS)
        ]


@dataclass(frozen=True, eq=False)
class ValidityMap(Holds):
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Attributes
    ----------
    regime : str
        The resonance treated.
    speeds : (n,) array
        Speeds of the base angle [rad/s].
    amplitudes : (m,) array
        Factors of every line of the excitation.
    error : (2, n, m) array
        Relative error of first and second order in the amplitude of the component near omega_0, of the stable state of
        largest amplitude against the stable true motion of largest amplitude at that speed; where the component is
        absent, of the whole motion. At most 1, which is also where either of the two is absent.
    motion : (n, m) array
        Amplitude [rad, 0-to-peak] of that component of the true motion; 0 where it is absent.
    """

    regime: str
    speeds: Floats
    amplitudes: Floats
    error: Floats
    motion: Floats

    def coordinates(self) -> Labelled:
        """Orders, speeds, and factors of the excitation."""
        return {
            "order": ("order", np.array(ORDERS), ""),
            "omega": ("omega", self.speeds, "rad/s"),
            "amplitude": ("amplitude", self.amplitudes, ""),
        }

    def variables(self) -> Labelled:
        """Errors of both orders, and the true amplitude."""
        return {
            "error": (("order", "omega", "amplitude"), self.error, ""),
            "motion": (("omega", "amplitude"), self.motion, "rad"),
        }

    def __str__(self) -> str:
        head = (
            f"Validity of multiple scales ({self.regime}): {len(self.speeds)} speeds, {self.speeds[0]:.6g} .. "
            f"{self.speeds[-1]:.6g} rad/s, {len(self.amplitudes)} strengths of the excitation, "
            f"{self.amplitudes[0]:.6g} .. {self.amplitudes[-1]:.6g} times the system's"
        )
        return on_screen("\n".join([head, *self._shares()]))

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class GeneralValidity(Holds):
    """Where each order holds at the peak of the primary resonance of a cubic law, whatever the drive.

    Attributes
    ----------
    bend : (n,) array
        alpha a^2 with the amplitude a of the component near omega_0 of the true motion at the peak, where it lags the
        torque by 90 degrees.
    damping_ratio : (m,) array
        zeta = B/(2 sqrt(J K)).
    amplitude_error, speed_error : (2, n, m) arrays
        Relative errors of first and second order in the amplitude and in the speed of the peak; at most 1, which is
        also where an order has no peak.
    """

    bend: Floats
    damping_ratio: Floats
    amplitude_error: Floats
    speed_error: Floats

    @property
    def error(self) -> Floats:  # type: ignore[override]
        """The larger one of both errors (2, n, m)."""
        return np.maximum(self.amplitude_error, self.speed_error)

    def coordinates(self) -> Labelled:
        """Orders, alpha a^2 and damping ratios."""
        return {
            "order": ("order", np.array(ORDERS), ""),
            "bend": ("bend", self.bend, ""),
            "damping_ratio": ("damping_ratio", self.damping_ratio, ""),
        }

    def variables(self) -> Labelled:
        """Errors of both orders."""
        dims = ("order", "bend", "damping_ratio")
        names: Any = ("amplitude_error", "speed_error", "error")
        return {name: (dims, getattr(self, name), "") for name in names}

    def __str__(self) -> str:
        head = (
            f"Validity of multiple scales at the peak of a cubic law: alpha a^2 = {self.bend[0]:.3g} .. "
            f"{self.bend[-1]:.3g}, damping ratio {self.damping_ratio[0]:.3g} .. {self.damping_ratio[-1]:.3g}"
        )
        return on_screen("\n".join([head, *self._shares()]))

    __repr__ = __str__
