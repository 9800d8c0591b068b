"""Response curves of random systems: how each one ends, and whether every curve is sound.

    python benchmarks/robustness.py [number] [first seed] [harmonics]

Counts the curves that reach both ends of their range and lists the others with their seeds and statuses. A curve is
sound if all its numbers are finite, no two neighbouring points are further apart than the step allows, and its status
is a sentence. Without `harmonics` their number is found for each curve, which takes about ten times as long as with 15.
"""

import os
import sys
import time
from collections import Counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads cost more than they save at this size

import numpy as np

import strainwave as sw
from strainwave.numerics.curves.response import frequency_response

KINDS = ("linear", "hard", "soft", "polynomial", "piecewise", "backlash", "biased backlash")
LONGEST = 0.1  # neighbouring points, in units of the range and of the largest solution


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def law_of(kind, rng):
    """A law with stiffness of order 1 and bends at torsions of order 1, and the torque it can bear."""
    if kind == "linear":
        return sw.Linear(1.0), 10.0
    if kind == "hard":
        return sw.Cubic(1.0, log_uniform(rng, 1e-3, 10.0)), 10.0
    if kind == "soft":  # beyond the torque of its maximum it bears nothing
        alpha = -log_uniform(rng, 1e-3, 10.0)
        return sw.Cubic(1.0, alpha), 2.0 / 3.0 / np.sqrt(-3.0 * alpha)
    if kind == "polynomial":  # monotonic: c2^2 < 3 c1 c3
        c3 = log_uniform(rng, 1e-3, 3.0)
        c2 = rng.uniform(-0.95, 0.95) * np.sqrt(3.0 * c3)
        return sw.Polynomial((0.0, 1.0, float(c2), c3, 0.0, log_uniform(rng, 1e-4, 1.0))), 10.0
    if kind == "piecewise":
        K2, K3 = rng.uniform(1.0, 2.5, 2) if rng.random() < 0.8 else rng.uniform(0.4, 1.0, 2)
        T1 = log_uniform(rng, 0.1, 1.0)
        return sw.PiecewiseLinear(1.0, float(K2), float(K3), T1, T1 * float(rng.uniform(1.2, 5.0))), 10.0
    return sw.Backlash(1.0, log_uniform(rng, 0.01, 1.0)), 10.0


def scaled(law, K, X):
    """The law with stiffness K and torsion X as units."""
    if isinstance(law, sw.Linear):
        return sw.Linear(K)
    if isinstance(law, sw.Cubic):
        return sw.Cubic(K, law.alpha / (X * X))
    if isinstance(law, sw.Polynomial):
        return sw.Polynomial(tuple(float(c * K * X / X**k) for k, c in enumerate(law.coefficients)))
    if isinstance(law, sw.PiecewiseLinear):
        return sw.PiecewiseLinear(law.K1 * K, law.K2 * K, law.K3 * K, law.T1 * K * X, law.T2 * K * X)
    return sw.Backlash(K, law.half_gap * X)


def random_system(seed):
    """Kind, system and range of a seed: dimensionless, or with the inertia, stiffness and torsion of a gear."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    law, bears = law_of(kind, rng)
    J, K, X = 1.0, 1.0, 1.0
    if rng.random() < 0.5:  # of a size 8 to a size 80 gear
        J, K, X = log_uniform(rng, 1e-4, 50.0), log_uniform(rng, 300.0, 2e6), log_uniform(rng, 3e-4, 5e-3)
    zeta = log_uniform(rng, 1e-4, 0.5)
    amplitude = bears * log_uniform(rng, 1e-4, 0.7)
    mean = 0.0
    if kind == "biased backlash" or (kind not in ("soft", "backlash") and rng.random() < 0.4):
        mean = bears * log_uniform(rng, 1e-3, 0.3)
    if kind == "soft" and rng.random() < 0.4:
        mean = bears * float(rng.uniform(0.0, 0.25))
    second = amplitude * float(rng.uniform(0.0, 0.3)) if rng.random() < 0.3 else 0.0
    error = log_uniform(rng, 1e-3, 0.1) if rng.random() < 0.3 else 0.0
    unit = K * X
    excitation = sw.Harmonics((
        sw.Harmonic(amplitude * unit, mean=mean * unit),
        sw.Harmonic(second * unit, order=2, phase=float(rng.uniform(0.0, 6.0))),
    ))  # fmt: skip
    natural = float(np.sqrt(K / J))
    system = sw.Oscillator(
        J, 2.0 * zeta * J * natural, scaled(law, K, X), excitation, natural,
        sw.KinematicError((sw.Line(2, error * X),)),
    )  # fmt: skip
    span = natural * float(rng.uniform(0.2, 0.7)), natural * float(rng.uniform(1.4, 3.0))
    return kind, system, span


def gap(branch, span):
    """Largest distance of neighbouring points of an arc, in units of the range and of the largest solution."""
    x = branch.coefficients / max(float(np.max(np.linalg.norm(branch.coefficients, axis=1))), 1e-300)
    change = np.linalg.norm(np.diff(x, axis=0), axis=1)
    along = np.diff(branch.values) / (span[1] - span[0])
    seams = (along == 0.0) & np.isin(branch.values[1:], span)  # where an arc ends and another begins
    return float(np.max(np.hypot(change, along)[~seams], initial=0.0))


def judge(seed, harmonics=None):
    """How the curve of a seed ended, and what is unsound about it ("" for nothing)."""
    kind, system, span = random_system(seed)
    branch = frequency_response(system, span, harmonics=harmonics)
    numbers = (branch.values, branch.omega, branch.coefficients, branch.peak, branch.multipliers)
    fault = ""
    if not all(np.all(np.isfinite(a)) for a in numbers):
        fault = "not finite"
    elif len(branch) and gap(branch, span) > LONGEST:
        fault = f"gap {gap(branch, span):.2g}"
    elif not branch.message:
        fault = "no sentence"
    reached = bool(len(branch)) and span[0] in branch.values and span[1] in branch.values
    if bool(branch.status) and not reached:
        fault = "says it reached both ends"
    return kind, branch, reached, fault


def main(number=10_000, first=0, harmonics=None):
    reached, seen, unsound = Counter(), Counter(), 0
    start = time.process_time()
    for seed in range(first, first + number):
        before = time.process_time()
        kind, branch, good, fault = judge(seed, harmonics)
        seen[kind] += 1
        reached[kind] += good
        spent = time.process_time() - before
        if not good or fault:
            unsound += bool(fault)
            print(f"{seed:6d} {kind:16s} {branch.status.name:15s} {branch.message} {fault.upper()}", flush=True)
        if spent > 2.0:
            print(
                f"{seed:6d} {kind:16s} took {spent:.1f} s, {len(branch)} points, "
                f"{branch.coefficients.shape[1] // 2} harmonics",
                flush=True,
            )
    total = sum(reached.values())
    print(f"{total} of {number} ({100.0 * total / number:.2f} %) reach both ends; {unsound} unsound")
    for kind in KINDS:
        print(f"  {kind:16s} {reached[kind]} of {seen[kind]}")
    print(f"{time.process_time() - start:.0f} s of CPU time")


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:]))
