"""One call of a predictor's `update`, compiled: microseconds of thread CPU time, for every kind of law and order.

    python benchmarks/predictor.py [--rounds 5] [--calls 1000000]

A compiled loop runs the speed up and down through the range and sums what is predicted, so that no call can be left
out. The cases are interleaved in one process, medians of the rounds. See README.md.
"""

import argparse
import statistics
import time

import numpy as np

import strainwave as sw
from strainwave.compile.jit import run

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.05), sw.Harmonic(0.05), 1.05)
ERROR = sw.KinematicError((sw.Line(2, 1.1e-4),))
GEAR = sw.Oscillator(
    0.6030927835, 9.82317898446, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 205.0, ERROR
)
TABLE = sw.tabulated([(-1.1, -1.3), (-0.4, -0.42), (0.0, 0.0), (0.45, 0.46), (0.9, 1.0), (1.4, 1.7)])
TWO_LINES = sw.KinematicError((sw.Line(1, 0.02), sw.Line(2, 0.005)))
BIASED = DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.1, 0.05)))
SYSTEMS = {
    "cubic, primary": (DUFFING, sw.PRIMARY),
    "cubic, primary by kinematic error": (
        DUFFING._replace(excitation=sw.Harmonic(0.0), error=sw.KinematicError((sw.Line(1, 0.05),))),
        sw.PRIMARY,
    ),
    "cubic, superharmonic": (DUFFING._replace(excitation=sw.Harmonic(0.3), omega=0.34), sw.SUPERHARMONIC),
    "cubic, subharmonic": (DUFFING._replace(B=0.005, excitation=sw.Harmonic(4.0), omega=3.2), sw.SUBHARMONIC),
    "cubic, no resonance": (DUFFING._replace(omega=0.2), sw.NONRESONANT),
    "square and cube, 2:1": (BIASED._replace(excitation=sw.Harmonic(0.2), omega=0.51), sw.Resonance(2, 1)),
    "square and cube, 1:2": (BIASED._replace(excitation=sw.Harmonic(0.8), omega=2.02), sw.Resonance(1, 2)),
    "three slopes, kinematic error": (GEAR, sw.Resonance(2, 1)),
    "table of 6 points": (DUFFING._replace(law=TABLE), sw.PRIMARY),
    "fifth power": (DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.0, 0.05, 0.0, 0.02))), sw.PRIMARY),
    "two lines": (DUFFING._replace(error=TWO_LINES), sw.PRIMARY),
    "three rounded slopes": (
        DUFFING._replace(law=sw.laws.RoundedPiecewiseLinear(1.0, 1.05, 1.1, 0.3, 0.6, 0.1)), sw.PRIMARY
    ),
}  # fmt: skip


def loop(predictor, state, calls):
    """Sum of x over so many calls, along a speed that goes up and down through the range."""
    low, high = predictor.speeds
    total, by, omega = 0.0, 1e-4 * (high - low), state.omega
    for _ in range(calls):
        if omega + by > high or omega + by < low:
            by = -by
        omega += by
        found = predictor.update(omega, 1.0, state)
        state = found.state
        total += found.x + found.rate + found.flag
    return total


def made(system, resonance, order):
    """Predictor with 64 samples per period of the linear drive, near the resonance; None with the reason."""
    flow = sw.slow_flow(system, resonance, order=order)
    near = (0.97 * system.omega, 1.03 * system.omega)
    return flow.predictor(2.0 * np.pi / (64.0 * flow.omega_0), speeds=near)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--calls", type=int, default=1_000_000)
    parser.add_argument("--only", default="", help="cases whose name contains this")
    asked = parser.parse_args()
    cases = {}
    for name, (system, resonance) in SYSTEMS.items():
        for order in (1, 2):
            if asked.only not in name:
                continue
            try:
                cases[f"{name}, order {order}"] = made(system, resonance, order)
            except ValueError as error:
                print(f"{name}, order {order}: none: {error}")
    seen = {name: [] for name in cases}
    for round_ in range(asked.rounds + 1):  # the first compiles
        for name, predictor in cases.items():
            state = predictor.start(predictor.speeds[0])
            start = time.thread_time()
            total = run(loop, predictor, state, asked.calls if round_ else 10)
            seen[name].append(time.thread_time() - start)
            assert np.isfinite(total)
    for name, seconds in seen.items():
        each, force = 1e6 * statistics.median(seconds[1:]) / asked.calls, cases[name].force
        points = f", {force.points} points" if hasattr(force, "points") else ""
        print(f"{name}: {each:.3f} us ({type(force).__name__}{points}; compiled in {seconds[0]:.1f} s)")


if __name__ == "__main__":
    main()
