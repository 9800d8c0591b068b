"""
How accurate are the closed forms?
==================================

The article's drive (its Table 3, torque-driven, 10 N m at the motor) from rest, by first-order multiple scales and by
integration, in the four regimes: no resonance, primary, superharmonic (omega_0/3) and subharmonic (3 omega_0).

The number: normalised RMS difference over 0 to 5/mu in each regime, in percent. The source article claims 2.1, 4.8, 3.5
and 4.2; with its formulas corrected (errata E2 to E6) it is below 0.05, 2, 0.1 and 0.1.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

DRIVE = sw.HDC_40_050
REGIMES = {
    "no resonance": (10.47, sw.NONRESONANT, 0.3),
    "primary": (DRIVE.omega_0, sw.PRIMARY, None),
    "superharmonic": (DRIVE.omega_0 / 3, sw.SUPERHARMONIC, 0.1),
    "subharmonic": (DRIVE.omega_0 * 3, sw.SUBHARMONIC, 0.1),
}


def main():
    figure, panels = plt.subplots(2, 2, figsize=(9, 5.2), layout="constrained")
    differences = {}
    for axes, (name, (omega, resonance, shown)) in zip(panels.flat, REGIMES.items(), strict=True):
        system = DRIVE.error_equation(motor_torque=sw.Harmonic(10.0), omega=omega)
        both = sw.study.compare_with_integration(system, resonance)
        differences[name] = 100 * both.rms_difference
        t, integrated, theory = both.t, both.integrated.y[0] * 1e3, both.theory.x * 1e3
        if shown is None:  # 870 cycles: show the extremes of each
            cycles = np.array_split(np.arange(len(t)), 400)
            low, high = ([extreme(integrated[c]) for c in cycles] for extreme in (np.min, np.max))
            axes.fill_between([t[c[0]] for c in cycles], low, high, color="#9ecae1")
            axes.plot(t, both.theory.amplitude * 1e3, color="#D55E00", ls=(0, (4, 3)))
        else:
            part = t <= shown
            lines = axes.plot(t[part], integrated[part], color="#9ecae1", lw=4.0)
            lines += axes.plot(t[part], theory[part], color="#D55E00", ls=(0, (4, 3)))
        axes.set(title=f"{name}: {differences[name]:.2g} % RMS", xlabel="time (s)", ylabel="x (mrad)")
    figure.legend(lines, ("integration", "multiple scales"), loc="outside lower center", ncols=2)
    return differences


if __name__ == "__main__":
    for regime, percent in main().items():
        print(f"{regime}: {percent:.3g} %")
    plt.show()
