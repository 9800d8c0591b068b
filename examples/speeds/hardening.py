"""
Should the gear's stiffness rise with the load?
===============================================

A CSG-40-50 turns a load of 1.3 kg m^2, with a damping ratio of 3 % and a kinematic error of order 2, 23 arcsec. Its
stiffness rises with the torsion: T = K (u + alpha u^3) with alpha = 6.9e4 1/rad^2. Softer and harder laws with the same
K move the peak and bend it. Left: the curves. Right: what each alpha costs. A kinematic error excites with the square
of the speed, so that a harder gear, whose peak is faster, has a larger error there and jumps over more speeds.

The number: how much larger the largest error of the real gear is than that of a linear one (percent).
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC, RPM = np.pi / 648000.0, np.pi / 30.0
GEAR, INERTIA, ZETA = sw.catalogue.gear("CSG-40-50"), 1.3, 0.03
LAW = GEAR.cubic
OMEGA_0 = np.sqrt(LAW.K / INERTIA)
RANGE = 0.12 * OMEGA_0, 0.9 * OMEGA_0
DRIVE = sw.Oscillator(
    INERTIA, 2.0 * ZETA * INERTIA * OMEGA_0, LAW, sw.Harmonic(0.0), 0.5 * OMEGA_0,
    sw.KinematicError((sw.Line(2, 23.0 * ARCSEC),)),
)  # fmt: skip


def main():
    _, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    shown = np.array([-0.4, 0.0, 1.0, 2.0]) * LAW.alpha
    curves = sw.numerics.response_family(DRIVE, RANGE, {"law.alpha": shown})
    for alpha, curve, style in zip(shown, curves, ("-.", ":", "-", "--"), strict=True):
        left.plot(curve.omega / RPM, curve.oscillation / ARCSEC, style, color="k", label=f"{alpha:.3g}")
    left.set(xlabel="motor (rpm)", ylabel="oscillation of the error (arcsec)", title="CSG-40-50: alpha (1/rad²)")
    left.legend()

    alpha = np.linspace(-0.4, 2.0, 25) * LAW.alpha
    found = sw.study.hardening(DRIVE, alpha, RANGE)
    right.plot(alpha, found.peak / ARCSEC, "k-", label="largest error (arcsec)")
    right.plot(alpha, found.jump_width / RPM, "k--", label="speeds with two motions (rpm)")
    real = [gear.cubic.alpha for gear in map(sw.catalogue.gear, ("CSG-40-50", "CSG-40-100"))]
    for name, value in zip(("ratio 50", "ratio 100"), real, strict=True):
        right.axvline(value, color="#999999", lw=0.8)
        right.text(value, right.get_ylim()[1], f"{name} ", rotation=90, ha="right", va="top", fontsize=8)
    right.set(xlabel="alpha (1/rad²)", title="what it trades")
    right.legend(loc="center left")
    own = sw.study.hardening(DRIVE, [0.0, LAW.alpha], RANGE)
    return 100.0 * (own.peak[1] / own.peak[0] - 1.0)


if __name__ == "__main__":
    print(f"the real gear's peak is {main():.1f} % higher than a linear one's")
    plt.show()
