"""
How far does a load raise a gear's natural frequency?
=====================================================

A datasheet gives three slopes. The cubic that fits them, and a monotone curve through measured points, are smooth; a
gap in the coupling is put in series. Under a mean torque the drive works on a stiffer part of the law, and about that
point the law is no longer odd: its quadratic term makes the drive answer at half its natural frequency too.

The number: how much the rated torque of a CSG-40-50 raises its natural frequency, by the cubic fit.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")
MEASURED = [(0.3e-3, 27.0), (0.6e-3, 62.0), (1.0e-3, 117.0), (1.4e-3, 176.0), (1.8e-3, 247.0)]  # rad, N m: made up
LAWS = {
    "datasheet": GEAR.law,
    "cubic fit": GEAR.cubic,
    "through points": sw.tabulated(MEASURED, odd=True),
    "datasheet with play": sw.Play(1.5e-4, GEAR.law),
}
STYLES = {"datasheet": "k-", "cubic fit": "C0--", "through points": "C1-.", "datasheet with play": "C2:"}


def frequency_ratio(law, torque):
    return sw.small_signal(law, torque).frequency_ratio


def main():
    _, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    x = np.linspace(0.0, GEAR.reach, 401)
    for name, law in LAWS.items():
        left.plot(1e3 * x, law.torque(x), STYLES[name], label=name)
    left.plot(*(np.array(MEASURED) * (1e3, 1.0)).T, "C1o", ms=4)
    torques = np.linspace(0.0, GEAR.average_torque, 201)
    for name in ("datasheet", "cubic fit"):
        ratios = [frequency_ratio(LAWS[name], torque) for torque in torques]
        right.plot(torques, ratios, STYLES[name], label=name)
    right.axvline(GEAR.rated_torque, color="0.6", lw=0.8)
    left.set(xlabel="torsion (mrad)", ylabel="torque (N m)", title=f"{GEAR.name}: laws")
    right.set(xlabel="mean torque (N m)", ylabel="natural frequency, relative to rest", title="operating point")
    left.legend()
    right.legend()
    return 100.0 * (frequency_ratio(GEAR.cubic, GEAR.rated_torque) - 1.0)


if __name__ == "__main__":
    print(f"the rated torque raises the natural frequency by {main():.1f} %")
    plt.show()
