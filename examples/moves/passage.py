"""
At what acceleration does a drive pass its resonance without a jump?
====================================================================

A CSG-40-50 with 23 arcsec of kinematic error at order 2 is run up from 100 to 200 rad/s (955 to 1910 rpm), the motor
held on the ramp. `passage` follows the slow amplitude of the vibration instead of every period, at 30 accelerations at
once: slow run-ups jump, late, beyond the fold; fast ones are through before the vibration has grown.

The number: the largest dynamic error of a run-up in half a second, in mrad.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

LAW = sw.Cubic(K=1.089e5, alpha=6.85e4)  # least-squares cubic of the catalogue's stiffness
DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=2 * 0.03 * (1.3 * LAW.K) ** 0.5, law=LAW)
ERROR = sw.KinematicError((sw.Line(order=2, amplitude=1.115e-4),))
SYSTEM = DRIVE.error_equation(motor="held", kinematic_error=ERROR)
BAND = (100.0, 200.0)  # rad/s


def main():
    study = sw.passage(SYSTEM, sw.Resonance(2, 1), BAND, np.geomspace(4.0, 400.0, 30))
    half_second = sw.passage(SYSTEM, sw.Resonance(2, 1), BAND, 200.0)

    _, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    for one in (study.passages[0], study.passages[15], half_second):
        ramp = one.omega < BAND[1]  # after it the speed is held until the motion has settled
        left.plot(one.omega[ramp], 1e3 * one.envelope[ramp], label=f"{one.rate:.3g} rad/s²")
    left.set(xlabel="motor speed (rad/s)", ylabel="largest |dynamic error| (mrad)", title="run-up")
    left.legend()
    right.semilogx(study.rate, 1e3 * study.peak, color="#0072B2")
    right.axvline(study.rate_without_jump, color="0.5", ls="--", label="no jump above")
    right.set(xlabel="acceleration of the motor (rad/s²)", title="largest |dynamic error| (mrad)")
    right.legend()
    return 1e3 * half_second.peak


if __name__ == "__main__":
    print(f"largest dynamic error of the run-up in 0.5 s: {main():.3f} mrad")
    plt.show()
