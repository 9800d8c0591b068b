"""How often 95 % intervals of `fit_bode` hold the true value, over simulated sweeps in a closed loop.

    python benchmarks/coverage_bode.py [COUNT]

A motor of 4.5 kg cm2 with a gear of ratio 100 and a load of 5 kg m2 turns in a sampled PI loop of its speed (2 kHz, 25
Hz, one sample late), by matrix exponentials (tests/bode_machine.py). Nine swept sines of 1 s, from 3 to 300 Hz, with
noise of 0.6 rad/s on the measured speed and of 20 N*m on the load; start values are off by 30 to 50 %. The first column
is the share of intervals that hold the value, the second the median of their half width over the value, the third what
the scatter of the estimates gives for it, the fourth the share for a fit to the plain H1, which is biased.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import strainwave as sw

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from bode_machine import TRUE, N, records

START = sw.Drive(6e-4, 3.5, N, 60.0, sw.Linear(4e4)).train()
TOGETHER, OF_H1 = 50, 8  # seeds, of which one in eight is fitted to H1, too


def plain(time, torque, speed, omega):
    """The plain H1 at frequencies [rad/s]."""
    n = round(1.0 / (time[1] - time[0]))
    u, y = (np.fft.rfft(row[n:].reshape(-1, n), axis=1) for row in (torque, speed))
    at = np.round(omega / (2.0 * np.pi)).astype(int)
    return (np.sum(u.conj() * y, axis=0) / np.sum(np.abs(u) ** 2, axis=0))[at]


def main():
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    hits, biased, widths, values = ({name: [] for name in TRUE} for _ in range(4))
    for begin in range(0, count, TOGETHER):
        t, r, torques, speeds = records(range(begin, min(begin + TOGETHER, count)))
        for k, (u, y) in enumerate(zip(torques.T, speeds.T, strict=True)):
            measured = sw.fit.bode_of_records(t, r, u, y)
            fit = sw.fit.fit_bode(measured, START)
            for name, value in TRUE.items():
                low, high = fit.interval(name)
                hits[name].append(low <= value <= high)
                widths[name].append(0.5 * (high - low) / value)
                values[name].append(fit.values[name] / value)
            if k % OF_H1 == 0:
                h1 = sw.fit.fit_bode(replace(measured, value=plain(t, u, y, measured.omega)), START)
                for name, value in TRUE.items():
                    low, high = h1.interval(name)
                    biased[name].append(low <= value <= high)
    for name in TRUE:
        share, width, scatter = np.mean(hits[name]), np.median(widths[name]), 1.96 * np.std(values[name])
        off, by_h1 = np.mean(values[name]) - 1.0, np.mean(biased[name])
        print(
            f"{name:6s} covered {100.0 * share:5.1f} %   half width {100.0 * width:5.2f} %   by scatter "
            f"{100.0 * scatter:5.2f} %   mean off {100.0 * off:+5.2f} %   by H1 {100.0 * by_h1:5.1f} %"
        )
    print(f"pooled {100.0 * np.mean(list(hits.values())):.2f} % of {count} sets")


if __name__ == "__main__":
    main()
