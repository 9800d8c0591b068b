"""
Where do the closed forms hold?
===============================

A CSG-40-50 turns a load of 1.3 kg m^2 with a damping ratio of 3 % and a kinematic error of order 2: where multiple
scales of first and second order are within 1, 5 and 20 % of the true amplitude, over the motor's speed and the size of
the error.

The number: error of first order (percent) in the amplitude of the peak that 0.5 arcmin peak-to-peak makes.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCMIN = np.pi / 180.0 / 60.0
GEAR, INERTIA, ZETA = sw.catalogue.gear("CSG-40-50"), 1.3, 0.03
LAW = GEAR.cubic
OMEGA_0 = np.sqrt(LAW.K / INERTIA)


def drive(peak_to_peak):
    """The load's equation under a kinematic error of order 2 [rad, peak-to-peak], the motor held."""
    error = sw.KinematicError((sw.Line(2, 0.5 * peak_to_peak),))
    return sw.Oscillator(INERTIA, 2.0 * ZETA * INERTIA * OMEGA_0, LAW, sw.Harmonic(0.0), 0.5 * OMEGA_0, error)


def main():
    _, axes = plt.subplots(layout="constrained")
    speeds = np.linspace(0.3, 0.8, 120) * OMEGA_0
    of_drive = sw.study.validity_map(drive(ARCMIN), sw.Resonance(2, 1), speeds, np.geomspace(0.05, 3.0, 80))
    of_drive.plot(axes).set(title="CSG-40-50, 3 % damping", ylabel="kinematic error (arcmin peak-to-peak)")

    resonance = sw.Resonance(2, 1)
    band = 0.4 * OMEGA_0, 0.75 * OMEGA_0
    first = sw.slow_flow(drive(0.5 * ARCMIN), resonance).response(band).peak[1]
    curve = sw.frequency_response(drive(0.5 * ARCMIN), band, harmonics=15)
    c = curve.coefficients[:, 3] - 0.25 * ARCMIN - 1j * curve.coefficients[:, 4]  # the torsion's order 2
    return 100.0 * (first / np.max(np.abs(c)) - 1.0)


if __name__ == "__main__":
    print(f"first order: peak {main():.1f} % too high")
    plt.show()
