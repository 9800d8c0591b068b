"""
Which torsion law does a measured loop have?
============================================

An SHG-25-100 is twisted by three cycles with its input locked. The record has noise, offsets and steps of 2e-6 rad. The
fit gives slopes, corners, backlash and hysteresis with their intervals, and says why this law and no other.

The number: the lost motion of the fitted law at 4 % of the rated torque, in arcmin.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

GEAR = sw.catalogue.gear("SHG-25-100")
TRUE = sw.Parallel(sw.Play(4e-5, GEAR.law), sw.BoucWen(4.5e4, 0.0, 8e-5))
ARCMIN = np.pi / 10800.0


def measured(seed=0):
    """A made-up record: the true law along three cycles, noise of 0.3 N m, offsets of both axes."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0.0, 3.0, 1201)
    way = 2.2e-3 * np.where(turn < 2.0, 1.0, 0.5) * np.sin(2.0 * np.pi * turn)
    fine = np.interp(np.linspace(0.0, 3.0, 120001), turn, way)
    z = np.zeros(len(fine))
    for i, step in enumerate(np.diff(fine)):  # Bouc-Wen with n = 1, beta = gamma = 1/2
        z[i + 1] = z[i] + step - 0.5 * (abs(step) * z[i] + step * abs(z[i])) / 8e-5
    torque = TRUE.first.torque(way) + 4.5e4 * z[::100]
    return 2e-6 * np.round((way + 2e-4) / 2e-6), torque + 0.4 + 0.3 * rng.normal(size=len(way))


def main():
    torsion, torque = measured()
    fit = sw.fit_loop(torsion, torque, rated_torque=GEAR.rated_torque, ratio=GEAR.ratio)
    low, high = (end / ARCMIN for end in fit.interval("lost_motion"))

    _, axes = plt.subplots(figsize=(6.4, 6.4), layout="constrained")
    fit.plot(axes).set_title(f"K1 {fit.value('K1'):.0f} N m/rad, lost motion {low:.2f} to {high:.2f} arcmin")

    print(fit)
    print(fit.yaml)
    return fit.lost_motion / ARCMIN, fit


if __name__ == "__main__":
    main()
    plt.show()
