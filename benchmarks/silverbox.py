"""
What law does a measured Duffing oscillator have?
=================================================

The Silverbox, an electronic mass, spring and damper, is the benchmark of nonlinear identification (Wigren & Schoukens
2013; nonlinearbenchmark.org). Its record is not shipped: ``python benchmarks/silverbox.py SNLS80mV.csv``. The law was
chosen by ``compare_laws`` on the training part alone.

The number: the root mean square of the error in mV of a free run over each of the three test records.
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

RATE = 1e7 / 2**14
TRAIN = slice(40_650, 105_711)
TESTS = {"multisine": slice(105_712, 127_399), "arrow": slice(100, 40_574), "its first 32 000": slice(100, 32_099)}
FREE = ("J", "B", "law.first.K", "law.first.alpha", "law.second.D", "excitation.offset", "x.offset")
K, RESONANCE, DAMPING = 1.0, 2.0 * math.pi * 68.0, 0.05  # first guess: gain 1 at rest, resonance near 68 Hz


def read(path):
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1)).T


def fit(path, rows=TRAIN):
    V1, V2 = read(path)[:, rows]
    law = sw.Parallel(sw.Cubic(K, 1.0), sw.laws.QuadraticDamping(0.0))
    guess = sw.Oscillator(K / RESONANCE**2, 2.0 * DAMPING * K / RESONANCE, law, sw.Harmonic(0.0), 1.0)
    return sw.identify(guess, {"time": np.arange(len(V1)) / RATE, "input": V1, "output": V2}, FREE)


def free_run(found, V1, V2_start):
    return found.simulate({"input": V1}, {"output": V2_start})["output"]


def main(path=None):
    if path is None:
        return print("give the path of SNLS80mV.csv, from nonlinearbenchmark.org")
    found, (V1, V2), errors = fit(path), read(path), {}
    print(found)
    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for name, rows in TESTS.items():
        error = V2[rows] - free_run(found, V1[rows], V2[rows][:50])
        errors[name] = 1e3 * math.sqrt(np.mean(error[50:] ** 2))
        print(label := f"{name}: {errors[name]:.3f} mV")
        axes.plot(np.arange(50, len(error)) / RATE, 1e3 * error[50:], lw=0.3, label=label)
    axes.set(xlabel="time from the start of the record (s)", ylabel="measured − computed (mV)", title="free runs")
    axes.legend()
    return errors


if __name__ == "__main__":
    main(*sys.argv[1:2])
    plt.show()
