"""The functions of `strainwave.maths` in a loop over lanes, against the C library's in the same loop.

Thread CPU time, the two interleaved in one process, medians of the rounds, compiled code warm. See README.md.
"""

import argparse
import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from strainwave import maths
from strainwave.compile import jit, lanes

RANGES = {"cos": (-1e3, 1e3), "sin": (-1e3, 1e3), "exp": (-20.0, 20.0), "log": (1e-3, 1e3), "tanh": (-3.0, 3.0)}
RANGES |= {"power": (0.01, 10.0)}
LIBM = {name: getattr(math, "pow" if name == "power" else name) for name in RANGES}


def loop(function: Callable[..., float], both: bool) -> Callable[[Any, int], None]:
    """Return a kernel that applies the function to every lane so many times, never twice to the same number."""

    def of_one(rows: Any, repeats: int) -> None:
        for repeat in range(repeats):
            shift = 1e-12 * repeat
            for i in range(lanes.LANES):
                lanes.store(function(lanes.load(rows, 0, i) + shift), rows, 1, i)

    def of_two(rows: Any, repeats: int) -> None:
        for repeat in range(repeats):
            shift = 1e-12 * repeat
            for i in range(lanes.LANES):
                lanes.store(function(lanes.load(rows, 0, i) + shift, lanes.load(rows, 2, i)), rows, 1, i)

    return of_two if both else of_one


def nanoseconds(kernel: Callable[[Any, int], None], rows: np.ndarray, repeats: int) -> float:
    """Return the CPU time of this thread for one lane."""
    started = time.thread_time()
    jit.run(kernel, rows, repeats)
    return 1e9 * (time.thread_time() - started) / (repeats * lanes.LANES)


def main() -> None:
    """Measure each function, and print both times, their ratio and the largest difference in the values."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="interleaved rounds (7)")
    rounds = parser.parse_args().rounds
    print("function   ours ns/lane   libm ns/lane   ratio   largest relative difference")
    for name, (low, high) in RANGES.items():
        rows = np.zeros((3, lanes.LANES))
        rows[0] = np.random.default_rng(1).uniform(low, high, lanes.LANES)
        rows[2] = np.random.default_rng(2).uniform(-3.0, 3.0, lanes.LANES)
        kernels = [loop(function, name == "power") for function in (getattr(maths, name), LIBM[name])]
        values = []
        for kernel in kernels:
            jit.run(kernel, rows, 1)
            values.append(rows[1].copy())
        times: list[list[float]] = [[], []]
        for _ in range(rounds):
            for kernel, record in zip(kernels, times, strict=True):
                record.append(nanoseconds(kernel, rows, 4000))
        ours, libm = (statistics.median(record) for record in times)
        apart = np.max(np.abs(values[0] / values[1] - 1.0))
        print(f"{name:8} {ours:8.2f} {libm:16.2f} {libm / ours:12.1f} {apart:14.1e}")


if __name__ == "__main__":
    main()
