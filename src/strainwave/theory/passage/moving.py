"""The slow flow while the speed changes: theta'' = rate.

With Omega = (p/q) omega(t) the component z E of the motion leaves on E

    z'' + (2 i Omega + mu) z' = R(z; omega) - i Omega' z - i (p/q) rate e_k = R_1

where R is the balance of constant speed and e_k the line of the kinematic error on E: its torque is
-e'' = (k^2 omega^2 - i k rate) e_k. With g = R_1/(2 i Omega + mu), z'' is that of the flow itself,
z'' = g_z z' + g_omega rate, so that z' = (g - g_omega rate/c)/(1 + g_z/c), c = 2 i Omega + mu. The term of g_omega is
of the same size as -i Omega' z and cancels it for a free vibration, whose amplitude does not depend on the frame it is
seen from. First order has neither of them.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..slow_flow.averaging import AveragedFlow, Exact
from ..slow_flow.cubic import CubicFlow
from ..slow_flow.fixed_points import Flow
from ..slow_flow.second_order import STEP, Samples, SecondOrderFlow, Small
from ..slow_flow.setting import Complexes, Setting, real_matrix

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

ALONE, AMONG_OTHERS = (400, 17, 1), (120, 9, 16)  # amplitudes, speeds and phases of a table
SMALLEST = 1e-4  # of the largest function: a smaller one is left out
CHUNK = 400  # states sampled at a time


def moving_rates(flow: Flow, omega: Any, rate: Any, z: Complexes) -> Complexes:
    """Rates z' [rad/s] (lanes,) at speeds omega [rad/s] that change by rate [rad/s^2], all (lanes,)."""
    if isinstance(flow, SecondOrderFlow):
        return _second(flow, omega, rate, z)
    if isinstance(flow, AveragedFlow):
        if isinstance(flow.means, Exact):
            if np.any(flow.setting.hard):
                return np.array([complex(flow.at(w).rates(x)) for w, x in zip(omega, z, strict=True)])
            return np.asarray(replace(flow, setting=flow.setting.at(omega)).rates(z))
        return np.asarray(flow.at(omega).rates(z))
    return np.asarray(CubicFlow(flow.setting.at(omega), flow.kind).rates(z))


def _second(flow: SecondOrderFlow, omega: Any, rate: Any, z: Complexes) -> Complexes:
    s = flow.setting
    n, ratio = len(z), s.fast / s.omega
    step, d = STEP * (np.abs(z) + 1e-3 * abs(z).max(initial=1e-30)), STEP * omega
    places = np.concatenate([z, z + step, z - step, z + 1j * step, z - 1j * step, z, z])
    speeds = np.concatenate([omega] * 5 + [omega + d, omega - d])
    along = np.tile(rate, 7)
    here = flow.at(speeds)
    c: Any = 2j * here.setting.fast + s.mu
    line = np.sum(s.error_lines[s.on_fast]) if s.on_fast.any() else 0.0
    g = here.unforced(places) - here.push - 1j * ratio * along * (places + line) / c
    g = np.asarray(g).reshape(7, n)
    by_re, by_im = (g[1] - g[2]) / (2.0 * step), (g[3] - g[4]) / (2.0 * step)
    c = c[:n]
    right = g[0] - rate * (g[5] - g[6]) / (2.0 * d) / c
    matrix = np.eye(2) + real_matrix(by_re / c, by_im / c)
    (a, b), (e, f) = np.moveaxis(matrix, (-2, -1), (0, 1))
    x, y = right.real, right.imag
    return np.asarray(((f * x - b * y) + 1j * (a * y - e * x)) / (a * f - b * e))


@dataclass(frozen=True, eq=False)
class Tabulated:
    """The torque's harmonic on E from a table: z times a function of |z| and omega for each multiple of z's phase.

    Without hard lines the phase plays no role, and there is one function.

    Attributes
    ----------
    multiples : tuple of int
        Multiples of the phase.
    parts : tuple of (spline, spline)
        Real and imaginary part of the function of each.
    largest : float
        Amplitude [rad] up to which they reach; beyond it the drive is taken for linear.
    """

    multiples: tuple[int, ...]
    parts: tuple[tuple["RectBivariateSpline", "RectBivariateSpline"], ...]
    largest: float

    def values(self, s: Setting, z: Any) -> tuple[Small, Any]:
        """No small harmonics, and 2 <n conj(E)> [rad/s^2]."""
        a, omega = np.abs(z), np.broadcast_to(s.omega, np.shape(z))
        turn = np.where(a > 0.0, z, 1.0) / np.where(a > 0.0, a, 1.0)
        found: Any = 0.0
        for m, (re, im) in zip(self.multiples, self.parts, strict=True):
            found = found + (re.ev(a, omega) + 1j * im.ev(a, omega)) * turn**m
        return [], found * np.maximum(a / self.largest, 1.0)


def tabulated(flow: Flow, band: tuple[float, float], largest: float) -> Flow:
    """The flow with its samples in a table up to an amplitude [rad]; as it is where it has none."""
    if not (isinstance(flow, SecondOrderFlow) and isinstance(flow.force, Samples)):
        return flow
    from scipy.interpolate import RectBivariateSpline  # a third of a second of every start, and tables alone need it

    alone = bool(flow.setting.on_fast.all())
    amplitudes, speeds, phases = ALONE if alone else AMONG_OTHERS
    margin = 1e-3 * (band[1] - band[0])
    a, omega = np.linspace(0.0, largest, amplitudes), np.linspace(band[0] - margin, band[1] + margin, speeds)
    turn = np.exp(2j * np.pi * np.arange(phases) / phases)
    z = (a[:, None, None] * turn).repeat(speeds, 1).ravel()
    w = np.broadcast_to(omega[:, None], (amplitudes, speeds, phases)).ravel()
    force, pieces = flow.force, range(0, len(z), CHUNK)
    found = [force.values(flow.setting.at(w[i : i + CHUNK]), z[i : i + CHUNK])[1] for i in pieces]
    shares = np.fft.fft(np.concatenate(found).reshape(amplitudes, speeds, phases), axis=2) / phases
    # functions of |z| times exp(i m phase), m = 1 alone where only the whole turn matters
    multiples = (1,) if alone else tuple(range(1 - phases // 2, 1 + phases // 2))
    each = [shares.sum(axis=2) if alone else shares[:, :, m] for m in multiples]
    least = SMALLEST * max(float(np.max(np.abs(one))) for one in each)
    kept = [(m, one) for m, one in zip(multiples, each, strict=True) if np.max(np.abs(one)) > least]
    parts = tuple((RectBivariateSpline(a, omega, one.real), RectBivariateSpline(a, omega, one.imag)) for _, one in kept)
    return replace(flow, force=Tabulated(tuple(m for m, _ in kept), parts, largest))  # type: ignore[arg-type]
