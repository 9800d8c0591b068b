"""
How fast must a drive pass its resonance?
=========================================

A CSG-40-50 with 23 arcsec of kinematic error at order 2 is run up through its resonance: the motor follows a speed ramp
from 100 to 200 rad/s (955 to 1910 rpm), exactly (``Held``). A slow ramp follows the steady response up to the jump, a
fast one is through before the vibration has grown.

The number: the largest dynamic error of a run-up in half a second, over that of the steady response.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

LAW = sw.Cubic(K=1.089e5, alpha=6.85e4)  # least-squares cubic of the catalogue's stiffness
DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=2 * 0.03 * (1.3 * LAW.K) ** 0.5, law=LAW)
ERROR = sw.KinematicError((sw.Line(order=2, amplitude=1.115e-4),))
LOW, HIGH = 100.0, 200.0  # rad/s


def run_up(seconds):
    """Motor speed [rad/s] and dynamic error [rad] of a run-up that takes so long."""
    ramp = sw.train.SpeedProfile(times=(0.0, seconds), speeds=(LOW, HIGH))
    train = DRIVE.train(control=sw.train.Held(), kinematic_error=ERROR, reference=ramp)
    orbit = sw.find_orbit(DRIVE.error_equation(motor="held", kinematic_error=ERROR, omega=LOW))
    times = np.linspace(0.0, seconds, 20001)
    run = sw.simulate(train, orbit.state(0.0), times, method=sw.Dopri5(rtol=1e-8))
    return train.motor_speed(times, tuple(run.y)), run.y[0]


def main():
    steady = sw.frequency_response(DRIVE.error_equation(motor="held", kinematic_error=ERROR), (LOW, HIGH))
    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for seconds, colour in ((8.0, "#9ecae1"), (2.0, "#E69F00"), (0.5, "#D55E00")):
        speed, x = run_up(seconds)
        axes.plot(speed, 1e3 * np.abs(x), color=colour, lw=0.6, label=f"run-up in {seconds:g} s")
    axes.plot(steady.omega, 1e3 * steady.peak, "k", lw=1.2, label="steady response")
    axes.set(xlabel="motor speed (rad/s)", ylabel="|dynamic error| (mrad)", title="run-up through resonance")
    axes.legend(loc="upper left")
    return float(np.max(np.abs(x))) / float(steady.peak.max())


if __name__ == "__main__":
    print(f"largest error of the run-up in 0.5 s over that of the steady response: {main():.3f}")
    plt.show()
