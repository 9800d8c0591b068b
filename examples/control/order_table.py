"""
How much of the kinematic error does a table of so few points remove?
=====================================================================

A CSG-40-50 turns 36 degrees, five turns of its wave generator; its error of order 2 is 23 arcsec. The order table goes
into the compensation file of a LinuxCNC joint, which holds 256 points and joins them by straight lines, and into files
of fewer. Every file is then read as the control reads it.

The number: what is left of the error with 256 points, peak, relative to the 25 arcsec of the two lines together.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC = np.pi / 648000
ERROR = sw.KinematicError((sw.Line(2, 23 * ARCSEC, 0.3), sw.Line(4, 2 * ARCSEC, 2.0)))
TABLE = sw.OrderTable.of(ERROR, sign="error", ratio=50.0, source="made-up scan of a CSG-40-50")
TRAVEL = 36.0  # degrees of the joint, from 0


def left_by(points, folder):
    """Angles of the joint, what is left of the error there, and the residual that the writer predicts [arcsec]."""
    path = Path(folder) / f"joint-{points}.comp"
    predicted = TABLE.write(path, "linuxcnc", span=(0.0, TRAVEL), points=points)
    nominal, forward, _ = np.loadtxt(path).T
    joint = np.linspace(0.0, TRAVEL, 20_001)
    correction = np.interp(joint, nominal, nominal - forward)
    error = np.degrees(ERROR.value(np.radians(joint) * 50.0))
    return joint, 3600.0 * (error - correction), predicted.peak / ARCSEC


def main():
    _, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    counts, peaks = (64, 80, 96, 128, 160, 192, 256), []
    with tempfile.TemporaryDirectory() as folder:
        for points in counts:
            joint, missing, predicted = left_by(points, folder)
            assert abs(np.max(np.abs(missing)) - predicted) < 0.02 * predicted
            peaks.append(np.max(np.abs(missing)))
            if points in (64, 256):
                left.plot(joint, missing, lw=1, label=f"{points} points")
    left.set(xlabel="joint (degrees)", ylabel="error left (arcsec)", xlim=(0, 7.2), title="over one turn of the motor")
    left.legend()
    per_turn = (np.array(counts) - 1) / 5.0
    right.loglog(counts, peaks, "o", label="of the file")
    right.loglog(counts, 23 * (np.pi * 2 / per_turn) ** 2 / 2, "k--", label="order 2: (π n/P)²/2")
    right.set(xlabel="points", ylabel="largest error left (arcsec)", title="256 points are all there are")
    right.legend()
    return peaks[-1] / 25.0


if __name__ == "__main__":
    print(f"{100 * main():.2f} % of the error is left by a file of 256 points")
    plt.show()
