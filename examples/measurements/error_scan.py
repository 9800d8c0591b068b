"""
Which orders does a measured kinematic error have?
==================================================

A rig turns a CSG-40-50 by two turns of its wave generator and back and records the error at the output. Its lines
follow by least squares, those that noise could make are left out, and the
difference of the directions is the lost motion. The
lines then drive the model near its resonance: pure error, torsion, and their sum.

The number: the error between motor and load at 1500 rpm, peak-to-peak, relative to that of the slow scan.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")
ARCSEC = np.pi / 648000
TRUE = sw.KinematicError((sw.Line(1, 4 * ARCSEC, -1.0), sw.Line(2, 15 * ARCSEC, 0.3), sw.Line(4, 2 * ARCSEC, 2.0)))
SPEED = 1500 * 2 * np.pi / 60  # of the motor, rad/s


def measured(seed=0):
    """A made-up scan: the true lines, 2.5 arcsec of friction either way, 1.5 arcsec of noise."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0.0, 4 * np.pi, 1440, endpoint=False)
    runs = [TRUE.value(angle) + side * 2.5 * ARCSEC + 1.5 * ARCSEC * rng.normal(size=1440) for side in (1, -1)]
    return angle, *runs


def main():
    angle, forward, backward = measured()
    scan = sw.error_scan(angle, forward, backward=(angle, backward))
    drive = GEAR.drive(load_inertia=1.3, B=40.0)
    system = drive.error_equation(kinematic_error=scan.error, omega=SPEED, motor="held")
    parts = sw.study.error_parts(system, sw.find_orbit(system))

    _, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    turns = angle / (2 * np.pi)
    left.plot(turns, forward / ARCSEC, "C0.", ms=1, label="forward")
    left.plot(turns, backward / ARCSEC, "C1.", ms=1, label="backward")
    left.plot(turns, scan.error.value(angle) / ARCSEC, "k-", lw=1, label=f"{len(scan.lines)} lines")
    left.set(xlabel="turns of the motor", ylabel="error (arcsec)", title="scan")
    left.legend()
    for name, values, style in (
        ("pure", parts.pure, "k-"),
        ("torsion", parts.torsion, "C0--"),
        ("load", parts.total, "C3-"),
    ):
        right.plot(parts.phase / (2 * np.pi), values / ARCSEC, style, label=name)
    right.set(xlabel="turns of the motor", ylabel="error (arcsec)", title="at 1500 rpm")
    right.legend()
    return parts.total_peak_to_peak / scan.peak_to_peak


if __name__ == "__main__":
    print(f"the error between motor and load at 1500 rpm is {main():.2f} times that of the slow scan")
    plt.show()
