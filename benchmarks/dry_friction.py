"""Moves and rests of drives with dry friction against event-located integration of equations by hand.

    python benchmarks/dry_friction.py [DRIVES] [SEED]

Random drives (`tests/dry_inertias.py`: Coulomb or Stribeck friction on both shafts, viscous, gravity, cascade or
position loop) begin from the same state. Each makes a trapezoid and rests; a line a drive: settling times, rest, and
the CPU times. A settling time differs where an extremum of the error lies within 1 % of the window: marked `edge`.
"""

import random
import sys
from pathlib import Path
from time import thread_time

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from dry_inertias import ARCSEC, drawn

import strainwave as sw

WINDOW, AFTER = 30.0 * ARCSEC, 1.0  # rad, s


def own_move(drive, angle, time):
    """Times and pointing errors of the same move, from the state in which the package begins."""
    train = drive.train()
    start = drive.own(train, train_start(train))
    ramp, N = time / 3.0, drive.N
    top = 1.5 * angle / time * N
    knots = (0.0, ramp, 2.0 * ramp, time, time + AFTER)
    rates = (top / ramp, 0.0, -top / ramp, 0.0)
    segments, at, speed = [], 0.0, 0.0
    for begin, end, rate in zip(knots, knots[1:], rates, strict=False):

        def reference(t, begin=begin, at=at, speed=speed, rate=rate):
            h = t - begin
            return at + h * (speed + 0.5 * h * rate), speed + h * rate

        segments.append((begin, end, reference))
        at, speed = reference(end)
    t, y, asked = drive.run(start, segments)
    return t, asked / N - y[2]


def train_start(train):
    """State in which the package's train waits."""
    return sw.drive_run(train, None, 1e-9).trajectory.y[:, 0]


def settled(t, error, rest, end):
    """Time after `end` from which on the error stays within the window about the rest, and whether that is on edge."""
    off = np.abs(error - rest)
    late = np.flatnonzero((off > WINDOW) & (t >= end))
    time = t[late[-1]] - end if len(late) else 0.0
    turns = np.flatnonzero((np.diff(off)[:-1] > 0.0) & (np.diff(off)[1:] <= 0.0)) + 1
    return time, bool(np.any(np.abs(off[turns][t[turns] >= end] / WINDOW - 1.0) < 0.01))


def main() -> None:
    """Print a line a drive."""
    count, seed = map(int, (sys.argv[1:] + ["30", "1"][len(sys.argv) - 1 :])[:2])
    draw = random.Random(seed)
    for i in range(count):
        drive = drawn(draw)
        angle, time = draw.uniform(0.3, 1.5), draw.uniform(0.3, 0.8)
        begin = thread_time()
        move = sw.move(drive.train(), sw.Trapezoid(angle, time), window=WINDOW, tail=AFTER)
        ours = thread_time() - begin
        t, error = own_move(drive, angle, time)
        own, edge = settled(t, error, move.rest_error, time)
        kind, ends = "cascade" if drive.T_n else "position", (move.pointing_error[-1], error[-1])
        peaks, apart = (move.peak_error, np.max(np.abs(error))), " edge" if edge else ""
        print(f"{i:3} {kind:8} settling {move.settling_time} s, own {own:.6f}{apart};", end=" ")
        print(f"at the end {ends[0] / ARCSEC:.4f} arcsec, own {ends[1] / ARCSEC:.4f};", end=" ")
        print(f"largest {peaks[0] / ARCSEC:.3f}, own {peaks[1] / ARCSEC:.3f}; {ours:.2f} s", flush=True)


if __name__ == "__main__":
    main()
