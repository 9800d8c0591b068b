"""
Which order vibrates, and how fast, while the speed rises?
==========================================================

A CSG-40-50 with a load of 10 kg m² runs up from 20 to 80 rad/s of the motor in 30 s, through the speed at which order 2
of its kinematic error meets the resonance, and beyond it jumps. Where the motor's angle is known, demodulation gives
the amplitude of each order; where it is not, a tracker finds the frequency of the vibration itself. In a run-up a
tracker of the rate r lags by a/r where the frequency rises by a.

The number: how far the tracked frequency is behind that of order 2 at the end, in rad/s.
"""

from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC = np.pi / 648_000.0
DRIVE = sw.catalogue.gear("CSG-40-50").drive(load_inertia=10.0, motor_inertia=4.5e-4, B=60.0)
ERROR = sw.KinematicError((sw.Line(2, 23.0 * ARCSEC), sw.Line(4, 2.0 * ARCSEC)))
LOW, HIGH, DURATION = 20.0, 80.0, 30.0  # rad/s, rad/s, s
RATE = (HIGH - LOW) / DURATION


class RunUp(NamedTuple):
    """The drive with a held motor whose speed rises evenly; its base angle is the time."""

    drive: Any

    def rhs(self, t, y):
        (x, v), drive, angle = y, self.drive, (LOW + 0.5 * RATE * t) * t
        twist, rate = x - drive.error.value(angle), v - (LOW + RATE * t) * drive.error.slope(angle)
        return v, -(drive.law.torque(twist) + drive.B * rate) / drive.J


def main():
    drive = DRIVE.error_equation(kinematic_error=ERROR, motor="held")
    t = np.arange(0.0, DURATION, 1e-3)
    x = sw.simulate(RunUp(drive), (0.0, 0.0), t, method=sw.Dopri5(rtol=1e-8, atol=1e-12)).y[0]
    known = sw.monitor(t, x, angle=(LOW + 0.5 * RATE * t) * t, orders=(2, 4))
    tracked = sw.monitor(t, x, frequencies=(2.0 * LOW, 2.2 * HIGH), bandwidth=3.0)

    _, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    for order, row in zip(known.orders, known.amplitude, strict=True):
        left.plot(known.frequency / 2.0, row / ARCSEC, label=f"order {order:g}, angle known")
    left.plot(known.frequency / 2.0, tracked.amplitude[0] / ARCSEC, "k:", label="tracked")
    left.set(xlabel="motor speed (rad/s)", ylabel="amplitude of the error (arcsec)", ylim=(0.0, None))
    right.plot(known.frequency / 2.0, tracked.frequency, "k", label="tracked")
    right.plot(known.frequency / 2.0, known.frequency, "C0--", label="order 2 of the motor")
    right.set(xlabel="motor speed (rad/s)", ylabel="frequency (rad/s)")
    for axes in (left, right):
        axes.legend(loc="upper left", fontsize=8)
    return float(np.mean((known.frequency - tracked.frequency)[-1000:]))


if __name__ == "__main__":
    print(f"the tracked frequency is {main():.2f} rad/s behind")
    plt.show()
