"""One trajectory of the cubic oscillator over 1000 forcing periods, against scipy.integrate.solve_ivp (RK45).

Both integrate x'' + 0.05 x' + x + 0.1 x^3 = 0.18 cos t from rest with rtol 1e-9 and atol 1e-12 and record every step.
Thread CPU time, the two interleaved in one process, medians of the rounds, compiled code warm. See README.md.
"""

import argparse
import math
import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

import strainwave as sw

BAR = 300.0
PERIOD = 2.0 * math.pi
SYSTEM = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)
RTOL, ATOL = 1e-9, 1e-12


def rhs(t: float, y: np.ndarray) -> tuple[float, float]:
    """Write the equation as a user of SciPy would."""
    x, v = y
    return v, 0.18 * math.cos(t) - 0.05 * v - x - 0.1 * x * x * x


def by_strainwave(periods: int) -> np.ndarray:
    """Return the last state by `simulate`."""
    return sw.simulate(SYSTEM, (0.0, 0.0), periods * PERIOD, method=sw.Dopri5(RTOL, ATOL)).y[:, -1]


def by_scipy(periods: int, method: str = "RK45", rtol: float = RTOL, atol: float = ATOL) -> np.ndarray:
    """Return the last state by `solve_ivp`."""
    return solve_ivp(rhs, (0.0, periods * PERIOD), (0.0, 0.0), method=method, rtol=rtol, atol=atol).y[:, -1]


def cpu_seconds(work: Callable[[int], np.ndarray], periods: int) -> float:
    """Return the CPU time of this thread for one run."""
    started = time.thread_time()
    work(periods)
    return time.thread_time() - started


def main() -> None:
    """Measure, and print the ratio and the accuracy of both."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5, help="interleaved rounds (5)")
    parser.add_argument("--full", action="store_true", help="give SciPy all 1000 periods in each round, not 100")
    options = parser.parse_args()
    scipy_periods = 1000 if options.full else 100

    by_strainwave(1000)  # compiles, or loads what was compiled
    ours, theirs = [], []
    for _ in range(options.rounds):
        theirs.append(cpu_seconds(by_scipy, scipy_periods) * 1000 / scipy_periods)
        ours.append(cpu_seconds(by_strainwave, 1000))
    mine, scipy = statistics.median(ours), statistics.median(theirs)
    scaled = "" if options.full else f" (measured over {scipy_periods} periods, times {1000 // scipy_periods})"
    print(f"1000 forcing periods, rtol {RTOL:g}, median of {options.rounds} rounds, CPU time of the thread")
    print(f"  strainwave   {mine * 1e3:10.1f} ms   from {min(ours) * 1e3:.1f} to {max(ours) * 1e3:.1f}")
    print(f"  scipy RK45   {scipy * 1e3:10.1f} ms   from {min(theirs) * 1e3:.1f} to {max(theirs) * 1e3:.1f}{scaled}")
    print(f"  ratio        {scipy / mine:10.0f}      bar {BAR:.0f}: {'passed' if scipy / mine >= BAR else 'MISSED'}")

    exact = by_scipy(100, "DOP853", 1e-12, 1e-15)
    for name, work in (("strainwave", by_strainwave), ("scipy RK45", by_scipy)):
        error = np.max(np.abs(work(100) - exact))
        print(f"  {name}   error {error:.1e} after 100 periods, against DOP853 at 1e-12")


if __name__ == "__main__":
    main()
