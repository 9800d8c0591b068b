"""
What will the drive do at the next sample?
==========================================

A hardening drive runs up through its resonance until it jumps. A predictor of second order, the few operations that a
controller makes in every sample, follows it from the speed alone; the full equation is integrated beside it.

The number: root mean square of the difference over that of the motion, up to the jump, in percent.
"""

from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

DRIVE = sw.Oscillator(J=1.0, B=0.02, law=sw.Cubic(1.0, 0.1), excitation=sw.Harmonic(0.03), omega=1.0)
LOW, HIGH, DURATION, SAMPLE = 0.85, 1.15, 3000.0, 0.05  # rad/s, rad/s, s, s
RATE = (HIGH - LOW) / DURATION


class RunUp(NamedTuple):
    """The drive while its speed rises evenly; its base angle is the time."""

    drive: Any
    low: float
    rate: float

    def rhs(self, t, y):
        theta = (self.low + 0.5 * self.rate * t) * t
        return self.drive.rhs(theta, y)


def main():
    predictor = sw.slow_flow(DRIVE, sw.PRIMARY, order=2).predictor(SAMPLE, speeds=(LOW, HIGH))
    state = predictor.start(LOW)
    t = SAMPLE * np.arange(1, round(DURATION / SAMPLE) + 1)
    predicted = np.empty(len(t))
    for i, omega in enumerate(LOW + RATE * t):
        prediction = predictor.update(omega, 1.0, state)
        state, predicted[i] = prediction.state, prediction.x
        if prediction.flag:
            print(predictor.meaning(prediction.flag))
    method = sw.Dopri5(rtol=1e-9, atol=1e-11)
    integrated = sw.simulate(RunUp(DRIVE, LOW, RATE), (0.0, 0.0), np.append(0.0, t), method=method).y[0, 1:]

    before = t < t[np.argmax(predicted)]
    _, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    axes.plot(LOW + RATE * t, integrated, color="#9ecae1", lw=0.3, label="integrated")
    parts = zip(np.array_split(LOW + RATE * t, 400), np.array_split(predicted, 400), strict=True)
    axes.plot(*np.transpose([(np.mean(omega), np.max(x)) for omega, x in parts]), "C3--", label="predicted, crests")
    axes.set(xlabel="speed (rad/s)", ylabel="dynamic error (rad)")
    axes.legend(loc="upper left")
    return 100.0 * float(np.sqrt(np.mean((predicted - integrated)[before] ** 2) / np.mean(integrated[before] ** 2)))


if __name__ == "__main__":
    print(f"the prediction differs from the motion by {main():.2f} % up to the jump")
    plt.show()
