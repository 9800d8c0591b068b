"""Closed forms at many speeds: a curve of 1000 speeds by both orders.

The curve is every steady state of x'' + 0.01 x' + x + 0.2 x^3 = 0.01 cos(omega t) at 1000 speeds between 0.8 and 1.3,
with its stability; beside it the same by one slow flow a speed (100 of the 1000 speeds, times ten). Thread CPU time of
the library's own calls, contenders in turn, medians with the extremes.

    python benchmarks/slow_flow.py [--rounds 7]
"""

import argparse
import statistics
import time

import numpy as np

import strainwave as sw

DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.05)
SPEEDS = np.linspace(0.8, 1.3, 1000)


def both_orders() -> int:
    """Number of states at all speeds by both orders."""
    return sum(len(sw.slow_flow(DUFFING, sw.PRIMARY, order=order).states_at(SPEEDS).omega) for order in (1, 2))


def one_by_one() -> int:
    """The same at every tenth speed, a slow flow each."""
    return sum(
        len(sw.slow_flow(DUFFING._replace(omega=float(w)), sw.PRIMARY, order=order).steady_states())
        for order in (1, 2)
        for w in SPEEDS[::10]
    )


def main(rounds: int = 7) -> dict[str, float]:
    """Print the table and return the medians [s]."""
    tasks = {
        "curve of 1000 speeds, both orders": (both_orders, 1.0),
        "the same, one slow flow a speed": (one_by_one, 10.0),
    }
    both_orders(), one_by_one()  # warm
    times: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(rounds):
        for name, (task, factor) in tasks.items():
            start = time.thread_time()
            task()
            times[name].append(factor * (time.thread_time() - start))
    for name, some in times.items():
        low, middle, high = (1e3 * f(some) for f in (min, statistics.median, max))
        print(f"{name}: {middle:.1f} ms CPU ({low:.1f} .. {high:.1f})")
    return {name: statistics.median(some) for name, some in times.items()}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    main(parser.parse_args().rounds)
