"""
How fast must a drive pass its resonance?
=========================================

A CSG-40-50 with 23 arcsec of kinematic error at order 2 is run through its resonance between 100 and 200 rad/s (955 and
1910 rpm), up and down: the motor follows the speed exactly (``Held``). At a low rate the drive follows the steady
response up to the jump; at a high one it is through before the vibration has grown.

The number: the largest error of a run-up in half a second, over that of the steady response.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

LAW = sw.Cubic(K=1.089e5, alpha=6.85e4)  # least-squares cubic of the catalogue's stiffness
DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=2 * 0.03 * (1.3 * LAW.K) ** 0.5, law=LAW)
ERROR = sw.KinematicError((sw.Line(order=2, amplitude=1.115e-4),))
SPEEDS = (100.0, 200.0)  # rad/s


def main():
    train = DRIVE.train(control=sw.train.Held(), kinematic_error=ERROR)
    runs = sw.run_up(train, np.geomspace(2.0, 1000.0, 16), speeds=SPEEDS)
    half_second = sw.run_up(train, 200.0, speeds=SPEEDS).largest[0, 0]
    steady = sw.frequency_response(DRIVE.error_equation(motor="held", kinematic_error=ERROR), SPEEDS).peak.max()

    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    axes.semilogx(runs.rates, 1e3 * runs.largest[0], "o-", color="#0072B2", label="run-up")
    axes.semilogx(runs.rates, 1e3 * runs.largest[1], "o-", color="#E69F00", label="run-down")
    axes.axhline(1e3 * steady, color="k", ls="--", label="peak of the steady response")
    axes.set(xlabel="acceleration of the motor (rad/s²)", ylabel="largest |pointing error| (mrad)", ylim=(0.0, None))
    axes.legend()
    return half_second / steady


if __name__ == "__main__":
    print(f"largest error of the run-up in 0.5 s over that of the steady response: {main():.3f}")
    plt.show()
