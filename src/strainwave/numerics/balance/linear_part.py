"""Part of an oscillator's balance that does not depend on its law: inertia, damping, torque and kinematic error.

The virtual leaves are parameters that are no numbers of the system: along them orbits that coexist are connected.

One harmonic tells of an oscillator's orbits: starts of solvers, places of other orbits, and what connects them.
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import omega_of
from ...base.results import Booleans, Floats
from ...compile.jit import kernel_as, routine
from ..operating_point import operating_point
from .fourier import orders
from .rates import base_speed

WAVE = np.cos(np.pi * (np.arange(16) + 0.5) / 16)  # half a vibration
SIZES = np.geomspace(1e-5, 1.0, 50)  # amplitudes at which the law is asked, of the largest that the damping allows
FINE_SIZES = np.geomspace(1e-4, 1.0, 200)  # the same for the strongest excitation
LEAST_DAMPING = 1e-4  # damping that counts at least, of critical
SHARED = 0.03  # of the largest drive: what other harmonics of a larger motion may have
INERTIA_FACTOR = 1.4  # factor of J (k w)^2 for what one harmonic leaves out
MARGIN = 2.0  # factor of a drive that is too small for a second orbit
STRONGEST, STRONG = 1e3, 30.0  # factors of the strength: at most, and at least
LEAST_LINE = 1e-3  # of the largest line: one below it is no way to other orbits

# In the place of a leaf, at a fixed frequency: the parameter is the logarithm of a factor of all that alternates, or a
# constant torque [N*m] beside that of the excitation; with LINE - k it is added to the factor 1 of line k alone.
STRENGTH, CONSTANT, LINE = -2, -3, -3


def _add_linear_loops(
    J: float, B: float, w: float, stride: int, z: Floats, torque: Floats, error: Floats, r: Floats
) -> None:
    h = len(r) // 2
    r[0] -= torque[0]
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        inertia = J * kw * kw
        damping = B * kw
        c, s = z[k], z[h + k]
        r[k] += -inertia * (c + error[k]) + damping * s - torque[k]
        r[h + k] += -inertia * (s + error[h + k]) - damping * c - torque[h + k]


@kernel_as(_add_linear_loops)
def add_linear(J: float, B: float, w: float, stride: int, z: Floats, torque: Floats, error: Floats, r: Floats) -> None:
    """Add J u'' + B u' - tau + J e'' in Fourier coefficients."""
    h = len(r) // 2
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    c, s = z[1 : h + 1], z[h + 1 : 2 * h + 1]
    r -= torque
    r[1 : h + 1] += damping * s - inertia * (c + error[1 : h + 1])
    r[h + 1 :] -= damping * c + inertia * (s + error[h + 1 :])


def _add_linear_jacobian_loops(J: float, B: float, w: float, stride: int, h: int, jacobian: Floats) -> None:
    for k in range(1, h + 1):
        kw = (1 + stride * (k - 1)) * w
        jacobian[k, k] -= J * kw * kw
        jacobian[h + k, h + k] -= J * kw * kw
        jacobian[k, h + k] += B * kw
        jacobian[h + k, k] -= B * kw


@kernel_as(_add_linear_jacobian_loops)
def add_linear_jacobian(J: float, B: float, w: float, stride: int, h: int, jacobian: Floats) -> None:
    """Add the Jacobian of J u'' + B u'."""
    k = np.arange(1, h + 1)
    kw = w * orders(h, stride)
    inertia, damping = J * kw * kw, B * kw
    jacobian[k, k] -= inertia
    jacobian[h + k, h + k] -= inertia
    jacobian[k, h + k] += damping
    jacobian[h + k, k] -= damping


@routine
def clean_mean(series: Floats) -> None:
    """Remove the rounding from the mean of a series without one: in the play of a gear nothing holds against it."""
    top = 0.0
    for i in range(1, len(series)):
        top = max(top, abs(series[i]))
    if abs(series[0]) < 1e-14 * top:
        series[0] = 0.0


def forced(system: Any, angles: Floats, table: Floats) -> tuple[Floats, Floats]:
    """Coefficients (in blocks) of torque and kinematic error, by their analysis `table` at base angles [rad]."""
    nothing = np.zeros(len(angles))
    tau = (system.excitation.torque(angles) + nothing) @ table
    clean_mean(tau)
    return tau, (system.error.value(angles) + nothing) @ table


@routine
def vary(leaf: int, value: float, torque: Floats, error: Floats, derive: bool) -> None:
    """Change series of torque and error (blocks) as the virtual leaf says, or into derivatives by its parameter."""
    h = len(torque) // 2
    torque[0] = (1.0 if leaf == CONSTANT else 0.0) if derive else torque[0] + (value if leaf == CONSTANT else 0.0)
    for k in range(1, h + 1):
        mine, unvaried = leaf == LINE - k, 0.0 if derive else 1.0
        factor = np.exp(value) if leaf == STRENGTH else (unvaried * value + 1.0 if mine else unvaried)
        torque[k] *= factor
        torque[h + k] *= factor
        error[k] *= factor
        error[h + k] *= factor


def carried(law: Any, mean: float) -> float:
    """Operating point [rad] to start a solver from: 0 where no torsion carries the mean torque [N*m]."""
    try:
        return operating_point(law, mean)
    except ValueError:
        return 0.0


def drive(system: Any, w: Floats, tau: Floats, error: Floats) -> Any:
    """Complex amplitudes [N*m] of what drives the torsion at the frequencies w [rad/s]: tau - J e''."""
    h, inertia = w.shape[-1], system.J * w * w
    return tau[1 : h + 1] + inertia * error[1 : h + 1] - 1j * (tau[h + 1 :] + inertia * error[h + 1 :])


def one_harmonic(law: Any, torque: float, sizes: Floats) -> tuple[Floats, Floats]:
    """Mean torsion [rad] and equivalent stiffness [N*m/rad] of vibrations of one harmonic with these amplitudes [rad].

    The mean carries the mean torque [N*m] (where the law lets it), the stiffness is the describing function.
    Gelb & Vander Velde 1968, Multiple-Input Describing Functions, sec. 6.1 (a harmonic and a bias).
    """
    wave = sizes[:, None] * WAVE
    mean = np.full(len(sizes), carried(law, torque))
    for _ in range(30):
        u = mean[:, None] + wave
        pull = law.torque(u) + 0.0 * u
        short = torque - pull.mean(axis=1)
        if np.all(np.abs(short) <= 1e-9 * np.abs(pull).max(axis=1)):
            break
        slope = (law.stiffness(u) + 0.0 * u).mean(axis=1)
        mean += np.divide(short, slope, out=np.zeros(len(sizes)), where=slope > 0.0)
    return mean, 2.0 / len(WAVE) * (pull @ WAVE) / sizes


class Around(NamedTuple):
    """Linear part around a law: mean torque [N*m]; mass, damping [N*m/rad] and drive [N*m] (points, H) at harmonics.

    The dynamic stiffness is -mass + i damping; `twice` (H,) are the places of twice the harmonics in a spectrum.
    """

    law: Any
    mean: float
    mass: Floats
    damping: Floats
    driven: Floats
    twice: Any


def several_at(problem: Any, points: Floats) -> Booleans:
    """True for an orbit beside which others may exist, from what one harmonic on top allows; of one law alone."""
    around = problem.around(base_speed(problem, points[:, -1]))
    if around is None:
        return np.ones(len(points), bool)
    law, mean, mass, damping, driven, twice = around
    series, synthesis = points[:, : len(problem.synthesis)], problem.synthesis
    h = series.shape[1] // 2
    loss = np.maximum(damping, LEAST_DAMPING * np.abs(mass))
    u = series @ synthesis
    stiffness = law.stiffness(u) + 0.0 * u
    tangent = stiffness.mean(axis=1, keepdims=True)
    moving = u - series[:, :1]
    square = np.vecdot(moving, moving)[:, None]
    work = np.vecdot(law.torque(u) + 0.0 * u, moving)[:, None]
    secant = np.divide(work, square, out=tangent.copy(), where=square > 0.0)
    size = np.hypot(series[:, 1 : h + 1], series[:, h + 1 :])
    driven = np.maximum(driven, np.hypot(secant - mass, loss) * size)
    # A larger motion drives harmonics that this one does not, above all where it reaches a corner of the law.
    driven = np.maximum(driven, (1.0 if breakpoints_of(law) else SHARED) * driven.max(axis=1, keepdims=True))
    reach = MARGIN * driven / loss
    top = float(reach.max())
    if not top > 0.0:
        return np.zeros(len(series), bool)
    sizes = top * SIZES
    _, kappa = one_harmonic(law, mean, sizes)
    bear = np.searchsorted(sizes, reach, side="right")  # how many of the amplitudes the drive bears
    low, high = np.minimum.accumulate(kappa)[bear - 1], np.maximum.accumulate(kappa)[bear - 1]
    wide = (bear > 0) & (high - low > loss)
    lower, upper = mass / INERTIA_FACTOR, INERTIA_FACTOR * mass
    above = tangent - kappa[0]  # of an orbit: on top of it the stiffness is that much larger
    may = wide & (((low < upper) & (high > lower)) | ((low + above < upper) & (high + above > lower)))
    # a vibration that the varying stiffness of the orbit itself keeps up; no wave of that is larger than its range
    off = np.hypot(tangent - mass, loss)
    if (off <= 0.51 * MARGIN * (stiffness.max(axis=1) - stiffness.min(axis=1))[:, None]).any():
        waves = np.abs(np.fft.rfft(stiffness)) * (2.0 / u.shape[1])
        inside = twice < waves.shape[1]
        may |= inside & (off <= 0.5 * MARGIN * waves[:, np.where(inside, twice, 0)])
    several: Booleans = may.any(axis=1)
    return several


def floating(law: Any, series: Floats, synthesis: Floats) -> Booleans:
    """True for an orbit (series (points, 2H+1) of its torsion) that moves without any torque of a law."""
    if law.torque(0.0) != 0.0 or law.stiffness(0.0) != 0.0:
        return np.zeros(len(series), bool)
    u = series @ synthesis
    idle: Booleans = np.all(law.torque(u) + np.zeros_like(u) == 0.0, axis=1) & (np.ptp(u, axis=1) > 0.0)
    return idle


def driven_lines(problem: Any) -> tuple[Floats, Any, Floats]:
    """Frequencies [rad/s] of all harmonics, which of them (0, 1, ...) are driven, and how [N*m], at the own speed."""
    w = problem.system.omega / problem.turns * orders(problem.size() // 2, problem.stride)
    size = np.abs(drive(problem.system, w, problem.tau, problem.error))
    return w, np.flatnonzero(size > LEAST_LINE * size.max()), size


def strongest(problem: Any) -> float:
    """Factor of the strength at which every line alone has passed its last fold, by one harmonic."""
    around = problem.around(np.array([omega_of(problem.system)]))
    if around is None or not len(lines := np.flatnonzero(around.driven > LEAST_LINE * np.max(around.driven))):
        return STRONG
    mass, damping, size = (each[0, lines, None] for each in around[2:5])
    loss = np.maximum(damping, LEAST_DAMPING * np.abs(mass))
    sizes = float(np.max(size / loss)) * FINE_SIZES
    _, stiffness = one_harmonic(around.law, around.mean, sizes)
    pull = np.hypot(stiffness - mass, loss) * sizes
    folds = np.where(pull[:, 1:] < pull[:, :-1], pull[:, :-1] / size, 0.0)
    return min(STRONGEST, max(STRONG, 1.5 * float(np.max(folds))))


def ways(problem: Any) -> list[int]:
    """Leaves, virtual ones too, along which orbits are connected: of several lines each has its own strength too."""
    _, lines, size = driven_lines(problem)
    weakest_first = (1 + lines[np.argsort(size[lines])]).tolist()
    return [CONSTANT, STRENGTH, problem.omega_leaf, *(LINE - k for k in weakest_first if len(lines) > 1)]
