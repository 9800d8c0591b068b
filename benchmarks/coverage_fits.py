"""Coverage of the 95 % intervals of fits over synthetic data sets, with white, coloured and quantised noise.

    python benchmarks/coverage_fits.py [white] [coloured] [quantised] [--sets 400]

Regression is linear.
"""

import sys
import time

import numpy as np
from scipy.signal import lfilter

import strainwave as sw
from strainwave.study.identification.intervals import interval

KINDS = ("white", "coloured", "quantised")


def noisy(kind, clean, size, rng):
    """Clean values with noise of about a size: white; AR(1) with 0.9; rounded to steps of three sizes."""
    noise = size * rng.standard_normal(len(clean) + 500)
    if kind == "coloured":
        return clean + np.sqrt(1.0 - 0.81) * lfilter([1.0], [1.0, -0.9], noise)[500:]
    return clean + noise[500:] if kind == "white" else 3.0 * size * np.round((clean + noise[500:]) / (3.0 * size))


def regression():
    k = np.arange(2000)
    motion = np.cos(0.75 * k + 3.0 * np.sin(np.pi * k / 1000.0))
    table = np.column_stack([np.ones(2000), np.sin(0.004 * k), motion, np.sin(0.75 * k), motion**3])
    true = np.array([0.3, 1.1, 0.7, -0.4, 0.2])
    clean, inverse = table @ true, np.linalg.pinv(table)

    def one(kind, rng):
        y = noisy(kind, clean, 0.1, rng)
        found = inverse @ y
        scatter = sw.fit.spread(table, y - table @ found)
        return np.abs(found - true), np.sqrt(np.diag(scatter.covariance)), scatter.freedom

    return ("offset", "drift", "motion", "quadrature", "cube"), one


CASES = {"regression": regression}


def coverage(name, kinds, sets):
    """Rows of the table: share of the sets in which the interval holds the value, for each kind of noise."""
    names, one = CASES[name]()
    for kind in kinds:
        start, rng, hits = time.process_time(), np.random.default_rng(16), np.zeros(len(names))
        for _ in range(sets):
            off, deviation, freedom = one(kind, rng)
            hits += [interval(0.0, d, f).high >= o for o, d, f in zip(off, deviation, freedom, strict=True)]
        shares = "  ".join(f"{path} {100.0 * hit / sets:5.1f}" for path, hit in zip(names, hits, strict=True))
        print(
            f"{name:10s} {kind:9s} {sets} sets  {shares} %   {(time.process_time() - start) / sets:.3f} s", flush=True
        )


def main(arguments):
    sets = int(arguments.pop(arguments.index("--sets") + 1)) if "--sets" in arguments else 400
    kinds = [kind for kind in KINDS if kind in arguments] or KINDS
    for name in CASES:
        coverage(name, kinds, sets)


if __name__ == "__main__":
    main(sys.argv[1:])
