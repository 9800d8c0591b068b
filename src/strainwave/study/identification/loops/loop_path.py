"""A measured loop as it is fitted: samples in the order of time, reversals, noise of both axes, plausible units."""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ....base.quantities import SMALLEST
from ....base.results import Floats, Integers
from ..run import column
from .loop_model import Path

SAMPLES = 40
LEAP_SHARE, LEAP_STEPS = 0.1, 20.0  # of the range, and of the usual step: a larger one is no motion
REVERSAL = 10.0  # times the noise: a torsion that goes back by more has reversed
TORQUE_NOISE = 1e-9  # of the torque: less than any sensor leaves
LEAST_TRAVEL = 0.01  # of the range: the same
DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # of noise on a smooth path; the path's own is of fourth order
TURN_NOISE = 8.0  # times the noise: samples around a reversal that are read together
TENT_SHARE = 0.8  # of the parabola's squares: from there on the reversal is a corner
TOP_DEVIATION = 1.9  # of the top of a parabola through n values, over that of one / sqrt(n); measured
NORMAL_MEDIAN = 0.6745  # median of |normal|
STUCK_TRAVEL = 0.05  # of the range: a torsion that goes on by more at one torque is that of a saturated torque
MOST_TORSION = 0.04  # rad, 2.3 deg: catalogue gears twist by 0.6 to 2.4 mrad at their rated torque
LIKELY_TORSION = 1.5e-3  # rad: half the range of a usual loop
STIFFNESS = (20.0, 5e7)  # N*m/rad: of gears from size 3 to size 100, with an arm behind them
UNITS = {"degrees": 180.0 / math.pi, "arcmin": 10800.0 / math.pi, "arcsec": 648000.0 / math.pi, "mrad": 1e3}


class Loop(NamedTuple):
    """Samples (n,) of a loop with its path; noise [rad], [N*m] of both axes and [rad] of where branches begin."""

    torsion: Floats
    torque: Floats
    path: Path
    torsion_noise: float
    torque_noise: float
    begin_noise: Floats

    @property
    def cycles(self) -> float:
        """Number of cycles: two reversals each."""
        return 0.5 * (len(self.path.direction) - len(self.path.first))


def read_loop(torsion: Any, torque: Any, check_units: bool = True) -> Loop:
    """Check the samples of a loop and find its reversals.

    Raises
    ------
    ValueError
        If they are too few or not finite, one axis does not move, nothing reverses, the torque is saturated, or the
        loop runs the wrong way round.
    """
    x, t = column("torsion [rad]", torsion), column("torque [N*m]", torque)
    for name, values in (("torsion [rad]", x), ("torque [N*m]", t)):
        if values.ndim != 1 or len(values) < SAMPLES:
            raise ValueError(f"{name} has the shape {values.shape}; give one column of at least {SAMPLES} samples")
    if len(x) != len(t):
        raise ValueError(f"torsion has {len(x)} samples and torque {len(t)}; give one torque for every torsion")
    for name, unit, values in (("torsion", "rad", x), ("torque", "N*m", t)):
        if float(np.ptp(values)) <= max(1e-12 * float(np.max(np.abs(values))), SMALLEST):
            raise ValueError(
                f"the {name} is constant at {values[0]:.4g} {unit}; a loop needs both axes to move, check the channel"
            )
    slope, offset = np.polyfit(x, t, 1)
    if float(np.max(np.abs(t - slope * x - offset))) <= TORQUE_NOISE * float(np.ptp(t)):
        raise ValueError(
            f"the torque is a straight line over the torsion, of {slope:.6g} N*m/rad, without noise or loss; use "
            "measured samples, or this stiffness directly"
        )
    noise = _noise(x), _noise(t)
    path, begin_noise = _path(x, noise[0])
    if len(path.begin) == len(path.first):
        raise ValueError(
            f"the torsion runs from {x[0]:.4g} to {x[-1]:.4g} rad and never reverses; a loop needs at least one "
            "reversal, measure up and down"
        )
    _refuse_saturated(x, t, noise[0])
    if check_units:
        _refuse_units(x, t)
    _refuse_backward(x, t, path)
    return Loop(x, t, path, *noise, begin_noise)


def _noise(values: Floats) -> float:
    """Standard deviation of the noise around a smooth path; at least that of the steps of a quantised axis."""
    differences = np.abs(np.convolve(values, DIFFERENCE, "valid"))
    spread = float(np.median(differences)) / NORMAL_MEDIAN / math.sqrt(float(DIFFERENCE @ DIFFERENCE))
    levels = np.unique(values)
    step = float(np.min(np.diff(levels))) if len(levels) < 0.5 * len(values) else 0.0
    return max(spread, step / math.sqrt(12.0))


def reversals(x: Floats, threshold: float) -> list[int]:
    """Samples at which a path has its extremes before it goes back by more than a threshold."""
    extremes: list[int] = []
    low = high = 0
    direction = 0
    for i, value in enumerate(x.tolist()):
        if value > x[high]:
            high = i
        if value < x[low]:
            low = i
        if direction >= 0 and x[high] - value > threshold:
            if direction > 0 or x[high] - x[0] > threshold:
                extremes.append(high)
            direction, low = -1, i
            high = i
        elif direction <= 0 and value - x[low] > threshold:
            if direction < 0 or x[0] - x[low] > threshold:
                extremes.append(low)
            direction, high = 1, i
            low = i
    return [i for i in extremes if 0 < i < len(x) - 1]


def _path(x: Floats, noise: float) -> tuple[Path, Floats]:
    """Branches between reversals; where a branch begins is read off the samples around the reversal.

    A torsion that leaps from one sample to the next begins a piece of its own, as of two records in one file.
    """
    steps, wide = np.abs(np.diff(x)), float(np.ptp(x))
    leaps = np.flatnonzero(steps > max(LEAP_SHARE * wide, LEAP_STEPS * float(np.median(steps)), REVERSAL * noise)) + 1
    lengths = np.diff([0, *leaps.tolist(), len(x)])
    leaps = leaps[np.minimum(lengths[:-1], lengths[1:]) >= SAMPLES // 2]  # others are wild samples
    branch, direction, begin, first = np.zeros(len(x), int), list[float](), list[tuple[float, float]](), list[int]()
    for start, stop in pairwise([0, *leaps.tolist(), len(x)]):
        piece = x[start:stop]
        turns = reversals(piece, max(REVERSAL * noise, LEAST_TRAVEL * wide))
        first.append(len(direction))
        branch[start:stop] = len(direction) + np.searchsorted(turns, np.arange(len(piece)))
        # Of the whole branch: its first samples may be noise.
        direction += [float(np.sign(piece[j] - piece[i])) or 1.0 for i, j in pairwise([0, *turns, len(piece) - 1])]
        begin += [(float(piece[0]), noise), *(_extreme(piece, turn, noise) for turn in turns)]
    begins, spread = np.array(begin).T
    return Path(branch, np.array(direction), begins, tuple(first)), spread


def _extreme(x: Floats, turn: int, noise: float) -> tuple[float, float]:
    """Torsion [rad] at a reversal and its noise: the extreme sample, or a parabola or a tent through the noise."""
    far = np.flatnonzero(np.abs(x - x[turn]) >= TURN_NOISE * noise)
    low, high = int(np.max(far[far < turn], initial=-1)) + 1, int(np.min(far[far > turn], initial=len(x))) - 1
    if high - low < 6:
        return float(x[turn]), noise
    for _ in range(2):  # the first window ends where the noise lets it; the second one is centred
        index = np.arange(low, high + 1, dtype=float)
        values = x[low : high + 1]
        bend, slope, level = np.polyfit(index - turn, values, 2)
        if bend * (x[turn] - np.mean(values)) >= 0.0:
            break
        middle = min(max(turn - 0.5 * slope / bend, low), high)
        half = max(math.sqrt(0.8 * TURN_NOISE * noise / abs(bend)), 3.0)
        low, high = max(int(middle - half), 0), min(int(middle + half) + 1, len(x) - 1)
    parabola = level - 0.25 * slope**2 / bend if bend else level
    miss = float(np.sum((np.polyval([bend, slope, level], index - turn) - values) ** 2))
    tents = []
    for tip in index[1:-1]:
        columns = np.column_stack([np.ones_like(index), np.minimum(index - tip, 0.0), np.maximum(index - tip, 0.0)])
        solved = np.linalg.lstsq(columns, values, rcond=None)[0]
        tents.append((float(np.sum((columns @ solved - values) ** 2)), float(solved[0])))
    least, tip_value = min(tents)
    best = tip_value if least < TENT_SHARE * miss else float(parabola)
    return best, TOP_DEVIATION * noise / math.sqrt(len(index))


def _refuse_saturated(x: Floats, t: Floats, noise: float) -> None:
    """Refuse a torque that stands still at its largest value while the torsion goes on (ValueError)."""
    levels, counts = np.unique(t, return_counts=True)
    slope = float(np.ptp(t)) / float(np.ptp(x))
    for side, end, next_one in (("largest", -1, -2), ("smallest", 0, 1)):
        moved = float(np.ptp(x[t == levels[end]]))
        usual = STUCK_TRAVEL * float(np.ptp(x)) + 6.0 * noise + 4.0 * abs(levels[end] - levels[next_one]) / slope
        if counts[end] > 5 and moved > usual:
            raise ValueError(
                f"{counts[end]} of {len(t)} samples have the {side} torque, {levels[end]:.6g} N*m, while the "
                f"torsion moves by {moved:.3g} rad: the torque is saturated; remove them, or use a larger range"
            )


def _refuse_units(x: Floats, t: Floats) -> None:
    """Refuse a torsion or a stiffness that no gear has, with the unit that would explain it (ValueError)."""
    reach, slope = 0.5 * float(np.ptp(x)), abs(float(np.polyfit(x, t, 1)[0]))
    if reach > MOST_TORSION:
        unit = min(UNITS, key=lambda unit: abs(math.log(reach / UNITS[unit] / LIKELY_TORSION)))
        raise ValueError(
            f"the torsion reaches {reach:.4g} rad to either side, with {slope:.4g} N*m/rad on average, which no gear "
            f"does; it is likely in {unit}: convert to radians, or say check_units=False if it is meant"
        )
    if not STIFFNESS[0] <= slope <= STIFFNESS[1]:
        raise ValueError(
            f"the torque rises by {slope:.4g} N*m/rad on average and gears by {STIFFNESS[0]:g} to {STIFFNESS[1]:g}; "
            "check that the torque is in N*m and the torsion in rad on the output side, or say check_units=False"
        )


def closed_energy(x: Floats, t: Floats, path: Path) -> float:
    """Energy [J] dissipated between the first reversal and the last at the same torsion; 0 where no cycle closes."""
    pieces = pairwise([*np.searchsorted(path.branch, path.first).tolist(), len(x)])
    return sum(_energy(x[start:stop], t[start:stop], path.branch[start:stop]) for start, stop in pieces)


def _energy(x: Floats, t: Floats, branch: Integers) -> float:
    total = 0.0
    ends = [*(np.flatnonzero(np.diff(branch)) + 1).tolist(), len(x)]
    for a, b, c in zip(ends[::2], ends[1::2], ends[2::2], strict=False):
        if b - a < 4 or c - b < 4:  # too few samples on one way of a cycle
            continue
        up, down = slice(a, b), slice(b, c)
        low = max(float(np.min(x[up])), float(np.min(x[down])))
        high = min(float(np.max(x[up])), float(np.max(x[down])))
        grid = np.linspace(low, high, 200)
        sign = 1.0 if x[b - 1] > x[a] else -1.0
        total += sign * float(np.mean(_over(grid, x[up], t[up]) - _over(grid, x[down], t[down]))) * (high - low)
    return total


def _over(grid: Floats, x: Floats, t: Floats) -> Floats:
    order = np.argsort(x)
    return np.interp(grid, x[order], t[order])


def _refuse_backward(x: Floats, t: Floats, path: Path) -> None:
    """Refuse a loop whose torque falls with the torsion or that gives energy (ValueError)."""
    slope = float(np.polyfit(x, t, 1)[0])
    if slope < 0.0:
        raise ValueError(
            f"the torque falls with the torsion, by {-slope:.4g} N*m/rad on average; the sign of one axis is wrong; "
            "change it"
        )
    energy = closed_energy(x, t, path)
    scale = float(np.ptp(x) * np.ptp(t))
    noise = 4.0 * (_noise(t) + slope * _noise(x)) * float(np.ptp(x)) / math.sqrt(len(x))
    if energy < -max(1e-3 * scale, noise):
        raise ValueError(
            f"the loop gives {-energy:.3g} J where a gear loses energy: the loop has the wrong direction; torsion and "
            "torque are swapped, the samples stand in reverse order, or one axis lags behind the other"
        )
