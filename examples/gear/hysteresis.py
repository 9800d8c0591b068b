"""
How much of the vibration's energy does the gear's hysteresis take?
===================================================================

A law is fitted to the hysteresis loss and lost motion of a datasheet, for a CSF-40-50 with 0.5 and 0.3 arcmin. At the
resonance of the driven load, how much of the energy does the hysteresis take, and how much the viscous damping of 1 %?

The number: the share of the hysteresis in the energy lost over one period.
"""

import math

from matplotlib import pyplot as plt

import strainwave as sw

ARCMIN = math.pi / 180.0 / 60.0


def main():
    spring = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
    law = sw.fit.fit_hysteresis(spring, 0.5 * ARCMIN, 0.3 * ARCMIN, rated_torque=178.0).law
    J = 1.3
    B = 2.0 * 0.01 * math.sqrt(spring.K1 * J)
    system = sw.Oscillator(J, B, law, sw.Harmonic(10.0), math.sqrt(spring.K1 / J))

    loop = sw.hysteresis_loop(law, 178.0)
    orbit = sw.find_orbit(system)
    balance = sw.study.energy_balance(system, orbit)
    share = balance.losses["BoucWen"] / sum(balance.losses.values())

    figure, axes = plt.subplots(figsize=(6.4, 4.0))
    axes.plot(loop.torsion / ARCMIN, loop.torque, "C0")
    axes.set(xlabel="torsion (arcmin)", ylabel="torque (N m)")
    axes.set_title(f"Hysteresis loss {loop.loss / ARCMIN:.2f} arcmin; it takes {100.0 * share:.0f} % of the energy")
    axes.grid(alpha=0.3)
    figure.tight_layout()

    print(f"The hysteresis takes {100.0 * share:.1f} % of the energy at {1e3 * orbit.peak:.3f} mrad")
    return share, system, orbit


if __name__ == "__main__":
    main()
    plt.show()
