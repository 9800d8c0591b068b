"""How often 95 % intervals of `fit_loop` hold the true value, over synthetic data sets.

    python benchmarks/coverage_loops.py [white|coloured|quantised|small] [COUNT]

Loops are integrated by SciPy with equations of their own (tests/loop_machines.py): three cycles of an SHG-25-100 with
hysteresis, 1200 samples, noise of 0.3 N*m. White: also 1e-6 rad (0.2 arcsec) on the torsion. Coloured: first-order
autoregression with phi = 0.8. Quantised: white noise, torque in steps of 0.5 N*m, torsion of 2e-6 rad.
Small: two cycles within 4 % of a rated torque of 60 N*m, 800 samples, noise of 0.02 N*m and 2e-6 rad.
Wrong candidates that were taken count as misses where the number is missing. The last column is how often the law,
which is the right one, is said not to fit.
"""

import sys
from pathlib import Path

import numpy as np

import strainwave as sw

TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "study" / "identification")]

from loop_machines import ELEMENT, SLOPES, coloured, loop  # noqa: E402

RATED = {"small": 60.0}  # N*m
LARGE = 87.0
LACK = "lack of fit"  # said, where there is none
KINDS = ("white", "coloured", "quantised", "small")
SMALL, SMALL_ELEMENT = (2.4e4, 3.5e4, 4.2e4, 10.0, 34.0), (2e4, 6e-5)


def of_loop(kind, x, t, rng):
    """Fit one noisy loop."""
    rated = RATED.get(kind, LARGE)
    if kind == "small":
        return sw.fit_loop(x + 2e-6 * rng.normal(size=len(x)), t + 0.02 * rng.normal(size=len(t)), rated_torque=rated)
    if kind == "coloured":
        return sw.fit_loop(x, t + coloured(rng, len(t), 0.3, 0.8), rated_torque=rated)
    x, t = x + 1e-6 * rng.normal(size=len(x)), t + 0.3 * rng.normal(size=len(t))
    if kind == "quantised":
        x, t = 2e-6 * np.round(x / 2e-6), 0.5 * np.round(t / 0.5)
    return sw.fit_loop(x, t, rated_torque=rated)


def coverage(kind, count):
    """Share of the intervals that hold the true value, by the number's name."""
    slopes, element, rated = SLOPES, ELEMENT, RATED.get(kind, LARGE)
    x, t = loop(samples=1200)
    if kind == "small":
        slopes, element = SMALL, SMALL_ELEMENT
        x, t = loop(800, (1.0, 1.0), 6.6e-5, slopes, element=element)
    law = sw.Parallel(sw.PiecewiseLinear(*slopes), sw.BoucWen(element[0], 0.0, element[1]))
    truth = dict(zip(("K1", "K2", "K3", "T1", "T2"), slopes, strict=True))
    truth |= {"K": element[0], "yield_twist": element[1], "torsion_offset": 0.0, "torque_offset": 0.0}
    truth |= {"lost_motion": sw.study.lost_motion(law, rated), "hysteresis_loss": sw.hysteresis_loop(law, rated).loss}
    hits = dict.fromkeys((*truth, LACK), 0)
    for seed in range(count):
        fit = of_loop(kind, x, t, np.random.default_rng(seed))
        for name, value in truth.items():
            if name in fit.values and name not in fit.unidentified:
                low, high = fit.interval(name)
                hits[name] += low <= value <= high
        hits[LACK] += fit.lack_of_fit is not None and fit.lack_of_fit.found
    return {name: hit / count for name, hit in hits.items()}


def main():
    """Print the table."""
    given = sys.argv[1:]
    count = next((int(word) for word in given if word.isdigit()), 400)
    for kind in [word for word in given if word in KINDS] or KINDS:
        row = "  ".join(f"{name} {100.0 * share:.1f}" for name, share in coverage(kind, count).items())
        print(f"{kind:<10}{count} sets, %: {row}", flush=True)


if __name__ == "__main__":
    main()
