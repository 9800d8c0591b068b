"""Coverage of the 95 % intervals of fits over synthetic data sets, with white, coloured and quantised noise.

    python benchmarks/coverage_fits.py [regression] [decay] [missing] [white] [coloured] [quantised] [--sets 400]

The measurements of the decay come from SciPy's integrator; regression is linear.
"""

import sys
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

import strainwave as sw
from strainwave.study.identification.intervals import interval

KINDS = ("white", "coloured", "quantised")
DUFFING = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.1), sw.Harmonic(0.1), 1.0)


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


def decay():
    def rhs(_, y):
        return y[1], -0.02 * y[1] - y[0] - 0.1 * y[0] ** 3

    t = 0.15 * np.arange(1300)
    x = solve_ivp(rhs, (0.0, t[-1]), (1.5, 0.0), "DOP853", t, rtol=1e-10, atol=1e-13).y[0]
    true = {"B": 0.02, "law.K": 1.0, "law.alpha": 0.1}
    guess = DUFFING._replace(B=0.03, law=sw.Cubic(1.1, 0.07))

    def one(kind, rng):
        found = sw.fit_decay(t, noisy(kind, x, 0.01, rng), guess, free=tuple(true))
        return np.abs(found.values - [*true.values()]), np.sqrt(np.diag(found.covariance)), found.freedom

    return tuple(true), one


CASES = {"regression": regression, "decay": decay}


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


def missing(kinds, sets):
    """Share of the decays with drag 0.01 |v| v in which a law without it covers its cubic coefficient or is flagged."""

    def rhs(_, y):
        return y[1], -0.01 * y[1] - 0.01 * abs(y[1]) * y[1] - y[0] - 0.1 * y[0] ** 3

    t = 0.15 * np.arange(1300)
    x = solve_ivp(rhs, (0.0, t[-1]), (1.5, 0.0), "DOP853", t, rtol=1e-10, atol=1e-13).y[0]
    guess = DUFFING._replace(B=0.03, law=sw.Cubic(1.1, 0.07))
    for kind in kinds:
        rng, flagged, covered = np.random.default_rng(17), 0, 0
        for _ in range(sets):
            found = sw.fit_decay(t, noisy(kind, x, 0.01, rng), guess, free=("B", "law.K", "law.alpha"))
            low, high = found.interval("law.alpha")
            named = "|v| v" in found.discrepancy.flagged
            flagged, covered = flagged + named, covered + (named or low <= 0.1 <= high)
        share = f"flagged {100.0 * flagged / sets:5.1f}  flagged or covered {100.0 * covered / sets:5.1f} %"
        print(f"missing    {kind:9s} {sets} sets  {share}", flush=True)


def main(arguments):
    sets = int(arguments.pop(arguments.index("--sets") + 1)) if "--sets" in arguments else 400
    kinds = [kind for kind in KINDS if kind in arguments] or KINDS
    for name in [name for name in CASES if name in arguments] or ([] if "missing" in arguments else CASES):
        coverage(name, kinds, sets)
    if "missing" in arguments or not any(name in arguments for name in CASES):
        missing(kinds, sets)


if __name__ == "__main__":
    main(sys.argv[1:])
