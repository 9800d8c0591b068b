"""The phase portrait of a proof of stability: levels of V, motions from a dozen starts, saddles and the boundary.

A light damping is drawn larger, as a motion has hundreds of turns otherwise: that changes neither V nor the boundary.
"""

import math
from typing import Any

import numpy as np

from ..base.results import Floats
from ..model.oscillator import Oscillator
from ..numerics.integration.steps import rk4_step
from ..theory.stability_proof import StabilityProof
from .panels import BLACK, BLUE, DASHES, ORANGE, PALE, Panel, angle, panels_of

POINTS, STARTS = 801, 12  # of a level, and of the figure
RATIO = 0.15  # damping ratio up to which the damping is drawn larger
DECAY, MOST_TURNS = 3.0, 8.0  # of a motion: to exp(-3), within so many turns
STEP, MOST_STEPS = 0.1, 1500  # of the fastest turn [rad]
LEVELS, START = (0.2, 0.4, 0.6, 0.8, 1.0), 0.95  # amplitudes, of the outermost
BEYOND = 1.3  # distances to the farther saddle that the figure shows
SMALL, NOISY = 1e-5, 1e-4  # torsions beyond the rest that V resolves: [rad], and as a share of the rest
BENT, STRAIGHT = 0.15, 1e-3  # share of V where a law counts as bent, and the reach [rad] of one that never is


@panels_of.register
def proof_panels(proof: StabilityProof) -> list[Panel]:
    """Levels of V, a dozen motions that decay, the rest; of a local claim its boundary, saddles and what leaves there.

    There is no figure where nothing is claimed.
    """
    if proof.rest is None or proof.region is None:
        return []
    x_e, region = 0.5 * (proof.rest[0] + proof.rest[1]), proof.region
    borders = [x for x in (region.x_low, region.x_high) if math.isfinite(x)]
    saddles = [x for x in borders if x in proof.equilibria]
    reach = max((abs(x - x_e) for x in borders), default=0.0) * (BEYOND if saddles else 1.0) or _bend(proof, x_e)
    x = np.linspace(x_e - reach, x_e + reach, POINTS)
    height = _height(proof, x)
    square = float(proof.V(x_e, 1.0) - proof.V(x_e, 0.0))  # what V has of v^2
    top = region.energy_limit if saddles else float(min(height[0], height[-1]))
    fastest, within = math.sqrt(top / square), (x >= region.x_low) & (x <= region.x_high)
    starts = _starts(x, height / top, fastest)
    stiffest = float(np.max(np.diff(height, 2))) / (x[1] - x[0]) ** 2
    system, larger, times = _pace(proof.system, fastest, 0.5 * float(np.ptp(starts[:, 0])), stiffest)
    title = "phase portrait without excitation" + (f", {larger} times its damping" if larger > 1 else "")
    panel = Panel(title, angle("x", x - x_e), angle("x'", fastest, "/s"))
    if larger > 1:
        panel.caption = [f"Drawn with {larger} times the damping of the drive; V does not depend on the damping."]
    panel.xlim, panel.ylim = (x_e - 1.03 * reach, x_e + 1.03 * reach), (-1.2 * fastest, 1.2 * fastest)
    for share in LEVELS:
        part = within if share < 1.0 else slice(None)
        across, up = _level(proof, x[part], share**2 * top, square)
        panel.line(across, up, PALE, "levels of V", width=1.8)
    for start in starts.tolist():
        across, up = motion(system, start, times, 2.0 * reach)
        panel.line(across, up, BLUE, "motions", width=0.8)
    panel.points(starts[:, 0], starts[:, 1], BLUE, "initial states", ".", BLUE)
    for saddle in saddles:
        across, up = motion(system, [saddle + 0.04 * (saddle - x_e), 0.0], times, 2.0 * reach)
        panel.line(across, up, ORANGE, "motions that escape", "2 2")
    if saddles:
        across, up = _level(proof, x[within], top, square)
        panel.line(across, up, ORANGE, "boundary of the stability region", DASHES, 2.2)
        panel.points(saddles, np.zeros(len(saddles)), BLACK, "saddle", "s")
    panel.line(proof.rest, [0.0, 0.0], BLACK, width=4.0)
    panel.points(proof.rest, [0.0, 0.0], BLACK, "rest", "o", BLACK)
    return [panel]


def _bend(proof: StabilityProof, x_e: float) -> float:
    """Torsion [rad] beyond the rest by which V is no parabola any more."""
    least = max(SMALL, NOISY * abs(x_e), proof.rest[1] - x_e if proof.rest else 0.0)
    for size in (least * 1.25**k for k in range(80)):
        V = float(proof.V(x_e + 2.0 * size, 0.0))
        if abs(V - 4.0 * float(proof.V(x_e + size, 0.0))) > BENT * V:
            return 2.0 * size
    return max(STRAIGHT, 10.0 * least)


def _height(proof: StabilityProof, x: Floats) -> Floats:
    """V at rest at torsions x [rad]."""
    try:
        return np.asarray(proof.V(x, np.zeros_like(x)))
    except (TypeError, ValueError):  # a law that takes numbers alone
        return np.array([float(proof.V(torsion, 0.0)) for torsion in x.tolist()])


def _level(proof: StabilityProof, x: Floats, level: float, square: float) -> tuple[Floats, Floats]:
    """Curve on which V has a level: both of its halves, v at torsions x and more of them where it meets v = 0."""
    ends = np.flatnonzero(np.diff(_height(proof, x) <= level))
    x = np.sort(np.concatenate([x, *(np.linspace(x[i], x[i + 1], 32)[1:-1] for i in ends)]))
    height = _height(proof, x)
    below = height <= level
    shown = below | np.roll(below, 1) | np.roll(below, -1)
    v = np.where(shown, np.sqrt(np.maximum(level - height, 0.0) / square), np.nan)
    return np.r_[x, np.nan, x], np.r_[v, np.nan, -v]


def _starts(x: Floats, height: Floats, fastest: float) -> Floats:
    """States (starts, 2) on one level, evenly around the rest in the middle of x."""
    turn, out = 2.0 * np.pi * (np.arange(STARTS) + 0.5) / STARTS, np.linspace(0.0, 1.5, POINTS)
    across = x[POINTS // 2] + 0.5 * np.ptp(x) * np.outer(np.cos(turn), out)
    up = np.outer(np.sin(turn), out)
    first = np.argmax(np.interp(across, x, height) + up**2 >= START**2, axis=1)
    rows = np.arange(STARTS)
    return np.column_stack([across[rows, first], fastest * up[rows, first]])


def _pace(system: Any, fastest: float, width: float, stiffest: float) -> tuple[Any, int, Floats]:
    """System that is drawn, its damping over that of the drive, and the times [s] of the steps."""
    omega, of_angle = fastest / width, not isinstance(system, Oscillator)
    damping = float(system.damping.value(0.0, fastest)) if of_angle else system.B
    larger = 1 if of_angle or not damping else math.ceil(2.0 * RATIO * omega * system.J / damping)
    mu = larger * damping / system.J
    slowest = 0.5 * mu - math.sqrt(max(0.25 * mu**2 - omega**2, 0.0))
    end = min(DECAY / slowest, MOST_TURNS * 2.0 * np.pi / omega) if slowest > 0.0 else 2.0 * np.pi / omega
    step = STEP / max(math.sqrt(stiffest / system.J), omega, mu)
    drawn = system._replace(B=larger * damping) if larger > 1 else system
    return drawn, larger, step * np.arange(1 + min(MOST_STEPS, math.ceil(end / step)))


def motion(system: Any, start: list[float], times: Floats, far: float) -> tuple[Floats, Floats]:
    """Motion x [rad] and x' [rad/s] from a start at equidistant times [s], until x is far [rad] from it."""
    path, step = [tuple(start)], float(times[1] - times[0])
    for t in times[:-1].tolist():
        path.append(rk4_step(system, system.omega * t, system.omega * step, path[-1], step))
        if abs(path[-1][0] - start[0]) > far:
            break
    x, v = np.transpose(path)
    return x, v
