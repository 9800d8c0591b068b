"""
Which gear of the catalogue does a joint need?
==============================================

A robot's elbow must point within 90 arcsec of oscillation at 5 to 30 rpm, carry 60 N m for part of its time, and last
10 000 h. The catalogue has 183 gears: most are turned away by their datasheets or because no source gives a number that
the decision needs; of those left, the vibration through the range of speeds decides.

The number: the oscillation of the best design, confirmed by the response of its project.
"""

import math
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

RPM, ARCSEC = math.pi / 30.0, math.pi / 648000.0
ELBOW = sw.Specification(
    title="elbow of a robot",
    load_inertias=(0.8, 1.3),
    speeds=(5.0 * RPM, 30.0 * RPM),
    limit=90.0 * ARCSEC,
    rotor_inertias=(5e-5, 1e-4, 2e-4, 5e-4),
    damping_ratio=0.03,
    duty=(sw.DutySegment(60.0, 20.0 * RPM, 2.0), sw.DutySegment(30.0, 10.0 * RPM, 3.0)),
    life=10_000.0,
    loop=sw.train.Tuning(60.0 * math.pi),
)


def confirmed(candidate):
    """Largest oscillation [rad] of the design's project."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "design.yaml"
        file.write_text(sw.design_text(ELBOW, candidate))
        drive = sw.read_project(file).under(candidate.load_torque)
        return float(np.max(drive.response().oscillation))


def main():
    found = sw.design(ELBOW)
    print(found)
    print(found.rejected["CSG-20-160"])
    found.plot()
    best = found.pareto[0]
    assert abs(confirmed(best) / best.oscillation - 1.0) < 1e-6
    return best.oscillation / ARCSEC, best


if __name__ == "__main__":
    print(f"the best design oscillates by {main()[0]:.1f} arcsec")
    plt.show()
