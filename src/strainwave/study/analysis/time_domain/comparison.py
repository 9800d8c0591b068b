"""Multiple scales against integration: one run of each from the same start, compared over one window."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ....base.law import springs_only
from ....base.protocols import orders_of
from ....base.results import Floats, SolveError, Status, Trajectory
from ....numerics.integration.methods import Dopri5
from ....numerics.integration.simulate import simulate
from ....theory.resonance import Resonance
from ....theory.slow_flow.flow import slow_flow
from ....theory.slow_flow.results import Evolution

SAMPLES = 32  # per period of the fastest component
CEILING = 10_000_000  # samples in all, 0.1 GB a row
FEWEST_PERIODS, MOST_PERIODS = 12, 60
BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)  # Harris 1978, Proc. IEEE 66, 51-83, table I (-92 dB)


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
        Multiple of omega (Fraction) to (multiple scales, integration): amplitudes [rad, 0-to-peak] at the end of the
        window.
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

    def __str__(self) -> str:
        first, last = self.window
        parts = ", ".join(f"{k} omega: {a:.4g} and {b:.4g}" for k, (a, b) in self.harmonics.items())
        return (
            f"Comparison of multiple scales and integration, {self.resonance}, {first:g} .. {last:.6g} s\n"
            f"  rms of the difference {self.rms_difference:.3g} of the integrated solution\n"
            f"  largest |x| {self.peak_theory:.6g} rad and {self.peak_integrated:.6g} rad\n"
            f"  amplitudes [rad] {parts or 'none'}"
        )

    __repr__ = __str__

    @property
    def t(self) -> Floats:
        """Times [s] of both solutions."""
        return self.integrated.t


def compare_with_integration(
    system: Any,
    resonance: Resonance,
    y0: tuple[float, float] = (0.0, 0.0),
    t_end: float | None = None,
    *,
    multiples: tuple[Fraction | int, ...] = (1, 3, Fraction(1, 3)),
) -> Comparison:
    """Compare first-order multiple scales with integration from the same start over the window 0..t_end.

    Parameters
    ----------
    system : Oscillator
        The system at its omega [rad/s].
    resonance : Resonance
        Regime in which multiple scales treat it.
    y0 : (float, float)
        Start: x [rad], x' [rad/s].
    t_end : float, optional
        End of the window [s]; default 5/mu.
    multiples : tuple of Fraction or int
        Multiples of omega whose amplitudes are read at the end of the window, under a Blackman-Harris window over as
        many whole periods as fit into its last fifth (at most 60): a free vibration left there, at some other multiple,
        leaks less than 1e-4 of itself.

    Returns
    -------
    Comparison
        `harmonics` is empty where fewer than 12 periods fit.

    Raises
    ------
    ValueError
        If mu = 0 and no t_end is given, t_end is not positive, or multiple scales refuse the system.
    SolveError
        If the integration does not reach the end.
    """
    springs_only("compare", system)
    flow = slow_flow(system, resonance)
    if t_end is None:
        if flow.mu <= 0.0:
            raise ValueError(
                f"mu = {flow.mu:.6g} 1/s gives no window 5/mu; name the end of the window, t_end, in seconds"
            )
        t_end = 5.0 / flow.mu
    if not 0.0 < t_end < math.inf:
        raise ValueError(f"t_end = {t_end!r} s must be positive and finite")
    fastest = max(flow.omega_0, system.omega * max([1, *orders_of(system)]))
    samples = 2 + math.ceil(SAMPLES * t_end * fastest / (2.0 * np.pi))
    if samples > CEILING:
        raise ValueError(f"t_end = {t_end:g} s takes {samples:.3g} samples, above {CEILING:,}; give an earlier end")
    t = np.linspace(0.0, t_end, samples)
    integrated = simulate(system, y0, t, method=Dopri5(rtol=1e-11, atol=1e-15))
    if not integrated.status:
        raise SolveError(f"the integration beside multiple scales {integrated.message}")
    theory = flow.evolve(y0, t)
    size = math.sqrt(float(np.mean(integrated.y[0] ** 2)))
    difference = math.sqrt(float(np.mean((theory.x - integrated.y[0]) ** 2)))
    return Comparison(
        system=system,
        resonance=resonance,
        window=(0.0, float(t_end)),
        rms_difference=difference / size if size > 0.0 else 0.0,
        peak_theory=Trajectory(t, theory.x[None], theory.rate[None], Status.OK, "", 0, 0, 0).peak(),
        peak_integrated=integrated.peak(),
        harmonics=_harmonics(system.omega, t, theory.x, integrated.y[0], multiples),
        theory=theory,
        integrated=integrated,
    )


def _harmonics(
    omega: float, t: Floats, theory: Floats, integrated: Floats, multiples: tuple[Fraction | int, ...]
) -> dict[Fraction, tuple[float, float]]:
    """Amplitudes at multiples of omega over the last whole periods."""
    period = 2.0 * np.pi / omega
    periods = min(MOST_PERIODS, math.floor(0.2 * float(t[-1]) / period))
    if periods < FEWEST_PERIODS:
        return {}
    start = float(t[-1]) - periods * period
    use = t >= start
    share = (t[use] - start) / (periods * period)
    weight = np.array(BLACKMAN_HARRIS) @ np.cos(2.0 * np.pi * np.outer(np.arange(4), share))
    weight = weight / np.sum(weight)
    amplitudes = {}
    for multiple in multiples:
        wave = 2.0 * weight * np.exp(-1j * float(multiple) * omega * t[use])
        amplitudes[Fraction(multiple)] = (float(abs(wave @ theory[use])), float(abs(wave @ integrated[use])))
    return amplitudes
