"""
Which stiffness does a free vibration show?
===========================================

The wave generator is held, the load is turned until the gear carries 300 N m, and let go: it rings. Frequency and
damping against the amplitude are read from the record without any law; the three slopes of the datasheet are then
fitted to it, each with an interval that allows for the encoder's noise. The corner where the teeth have closed up
shows where the frequency begins to rise.

The number: torque (N m) of the first corner of the stiffness curve, T1, which is 54 in the gear that was simulated.
"""

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

GEAR = sw.PiecewiseLinear(K1=1e5, K2=1.4e5, K3=1.8e5, T1=54.0, T2=196.0)  # CSF-40-50, Harmonic Drive LLC
INERTIA, DAMPING = 1.3, 12.0  # kg m^2, N m s/rad
NOISE = 3e-5  # rad
FREE = ("B", "law.K1", "law.K2", "law.K3", "law.T1", "law.T2")


def record():
    """Time [s] and torsion [rad] from the moment of release on, sampled at 4 kHz."""
    load = sw.Oscillator(INERTIA, DAMPING, GEAR, sw.Harmonic(0.0), omega=1.0)
    time = np.arange(0.0, 1.2, 1.0 / 4000.0)
    start = 54.0 / 1e5 + (196.0 - 54.0) / 1.4e5 + (300.0 - 196.0) / 1.8e5
    torsion = sw.simulate(load, (start, 0.0), time).y[0]
    return time, torsion + NOISE * np.random.default_rng(1).standard_normal(len(time))


def main():
    time, torsion = record()
    guess = sw.PiecewiseLinear(K1=0.9e5, K2=1.3e5, K3=1.9e5, T1=45.0, T2=220.0)
    found = sw.fit_decay(time, torsion, sw.Oscillator(INERTIA, 9.0, guess, sw.Harmonic(0.0), 1.0), free=FREE)
    print(found)

    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    found.plot(axes)
    axes.set_title("measured without a law (points) and fitted with three slopes (lines)")
    return found.value("law.T1")


if __name__ == "__main__":
    print(f"first corner at {main():.1f} N m")
    plt.show()
