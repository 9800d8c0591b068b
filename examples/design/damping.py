"""
How much damping does the drive need?
=====================================

The kinematic error of the gear, two lines a motor turn, shakes the load through the spring of the teeth; near the
resonance only damping limits the dynamic error. The sweep integrates the drive at 17 damping ratios and 60 speeds, all
of them side by side, and keeps the largest error of the settled motion.

The number: smallest damping ratio (percent of critical) at which no speed shows more than 40 arcsec.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC = np.pi / 180.0 / 3600.0
ALLOWED = 40.0 * ARCSEC
DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=0.0, law=sw.Cubic(K=1e5, alpha=6.9e4))
ERROR = sw.KinematicError(lines=(sw.Line(order=2, amplitude=6.0 * ARCSEC),))


def main():
    system = DRIVE.error_equation(kinematic_error=ERROR, omega=140.0, motor="held")
    critical = 2.0 * np.sqrt(DRIVE.J_l * DRIVE.law.K)
    ratios = np.linspace(0.04, 0.12, 17)
    speeds = np.linspace(110.0, 160.0, 60)
    measure = sw.EnsembleMeasure((0.0, 0.0), periods=1, settle=40, measures=(sw.Peak(),))
    found = sw.sweep(measure, system, {"B": ratios * critical, "omega": speeds})

    worst = found["peak"].max("omega").values
    last = np.flatnonzero(worst > ALLOWED)[-1]
    needed = float(np.interp(ALLOWED, worst[last : last + 2][::-1], ratios[last : last + 2][::-1]))

    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    shown = axes.pcolormesh(speeds * 60.0 / (2.0 * np.pi), 100.0 * ratios, found["peak"] / ARCSEC, cmap="cividis")
    axes.contour(
        speeds * 60.0 / (2.0 * np.pi), 100.0 * ratios, found["peak"] / ARCSEC, levels=[ALLOWED / ARCSEC], colors="w"
    )
    axes.axhline(100.0 * needed, color="w", ls="--")
    axes.set(xlabel="motor speed (rpm)", ylabel="damping (% of critical)", title="line: 40 arcsec; dashed: enough")
    axes.figure.colorbar(shown, label="largest dynamic error (arcsec)")
    return 100.0 * needed


if __name__ == "__main__":
    print(f"damping needed: {main():.2f} % of critical")
    plt.show()
