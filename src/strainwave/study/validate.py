"""Multiple scales against integration: one run of each from the same start, compared over one window."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..results import Floats, Trajectory
from ..theory.resonance import Resonance
from ..theory.slow_results import Evolution


@dataclass(frozen=True, eq=False)
class Comparison:
    """Multiple scales and integration side by side.

    Attributes
    ----------
    system, resonance
        What was compared.
    window : (float, float)
        Start and end [s].
    rms_difference : float
        Root mean square of the difference over that of the integrated solution.
    peak_theory, peak_integrated : float
        Largest |x| [rad] in the window.
    harmonics : dict
        Multiple of omega (Fraction) to (multiple scales, integration): amplitudes [rad, 0-to-peak] at the end of the window.
    theory : Evolution
        The transient of multiple scales.
    integrated : Trajectory
        The integrated solution at the same times.
    """

    system: Any
    resonance: Resonance
    window: tuple[float, float]
    rms_difference: float
    peak_theory: float
    peak_integrated: float
    harmonics: dict[Fraction, tuple[float, float]]
    theory: Evolution
    integrated: Trajectory

    @property
    def t(self) -> Floats:
        """Times [s] of both solutions."""
        return self.integrated.t


def compare(
    system: Any,
    resonance: Resonance,
    y0: tuple[float, float] = (0.0, 0.0),
    t_end: float | None = None,
    *,
    multiples: tuple[Fraction | int, ...] = (1, 3, Fraction(1, 3)),
) -> Comparison:
    """Compare first-order multiple scales with integration from the same start."""
    raise NotImplementedError
