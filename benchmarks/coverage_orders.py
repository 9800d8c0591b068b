"""Coverage of the 95 % intervals of `order_scan` over synthetic data sets, for noise of four kinds.

    python benchmarks/coverage_orders.py [white] [coloured] [resonant] [quantised] [--sets 400]
    python benchmarks/coverage_orders.py slow [--sets 200]

Each set has three runs at three speeds over part of a turn: friction that depends on the angle, the orders 200 and 400,
one delay. Coloured noise is an autoregression with 0.9; resonant noise one of second order with a peak at 40 Hz, near
which the orders pass; quantised runs are rounded to steps of half an amplitude, and have a third of the noise.
Slow: the value has times of its own, 250 a second beside 999 of the angle, with holes; a line of order 1300 is beyond
what they show, and has other images at each speed. No order is given: lines that are none are counted.
"""

import math
import sys
import time

import numpy as np
from scipy.signal import lfilter

import strainwave as sw

KINDS = ("white", "coloured", "resonant", "quantised")
LINES = {200.0: (0.04, 0.7), 400.0: (0.02, -1.0)}
SPEEDS = (0.3, 0.5, 0.8)
DELAY, RATE, DURATION, NOISE, STEP = 2.3e-3, 999.0, 2.0, 0.02, 0.01
SLOW_RATE, SLOW_DURATION, ALIAS = 250.0, 4.0, (1300.0, 0.01)
RADIUS, PEAK = 0.95, 2.0 * math.pi * 40.0 / RATE


def noise(kind, count, rng):
    """Noise (count,) whose root mean square is about `NOISE`."""
    drawn = rng.standard_normal(count + 500)
    if kind == "coloured":
        drawn = lfilter([1.0], [1.0, -0.9], drawn) * math.sqrt(1.0 - 0.81)
    if kind == "resonant":
        drawn = 0.1 * lfilter([1.0], [1.0, -2.0 * RADIUS * math.cos(PEAK), RADIUS**2], drawn)
    return drawn[500:] * (NOISE / 3.0 if kind == "quantised" else NOISE)


def made(kind, speed, rng):
    """One run."""
    t = np.arange(int(DURATION * RATE)) / RATE
    zero = rng.uniform(0.0, 6.0)

    def angle(s):
        return zero + speed * (s + 0.02 * np.sin(0.7 * s))

    theta = angle(t - DELAY)
    value = 0.5 + 0.1 * np.sin(theta) + noise(kind, len(t), rng)
    for k, (amplitude, phase) in LINES.items():
        value += amplitude * np.cos(k * theta + phase)
    return sw.Run(t, angle(t), STEP * np.round(value / STEP) if kind == "quantised" else value)


def hits(kind, rng):
    """Whether the intervals hold the amplitudes, the phases and the delay of one set."""
    return held_by(sw.order_scan([made(kind, speed, rng) for speed in SPEEDS], orders=list(LINES)))


def held_by(found):
    """Whether the intervals of a scan hold the amplitudes, the phases and the delay."""
    said = []
    for name, i in (("amplitude", 0), ("phase", 1)):
        for line in found.lines:
            low, high = line.interval(name)
            said.append(low <= LINES[line.order][i] <= high)
    low, high = found.delay_interval()
    return [*said, low <= DELAY <= high]


def slow(speed, rng):
    """One run whose value has times of its own, with holes, and a line beyond what they show."""
    t = np.arange(int(SLOW_DURATION * RATE)) / RATE
    at = np.arange(3, int(SLOW_DURATION * SLOW_RATE) - 3) / SLOW_RATE + rng.uniform(0.0, 1.0 / RATE)
    for begin in rng.uniform(0.0, SLOW_DURATION, 4):
        at = at[(at < begin) | (at > begin + rng.uniform(0.01, 0.1))]
    zero = rng.uniform(0.0, 6.0)

    def angle(s):
        return zero + speed * (s + 0.02 * np.sin(0.7 * s))

    theta = angle(at - DELAY)
    value = 0.5 + 0.1 * np.sin(theta) + noise("white", len(at), rng)
    for k, (amplitude, phase) in {**LINES, ALIAS[0]: (ALIAS[1], 1.0)}.items():
        value += amplitude * np.cos(k * theta + phase)
    return sw.Log(
        t, {"load_angle": angle(t), "torque": np.interp(t, at, value)}, own={"torque": (at, value)}
    ).run("torque")  # fmt: skip


def slow_sets(sets):
    """Coverage with the orders given; without, how often there is a line that is none, or one is lost."""
    rng, said, lost, false = np.random.default_rng(17), [], 0, 0
    for _ in range(sets):
        runs = [slow(speed, rng) for speed in SPEEDS]
        said += held_by(sw.order_scan(runs, orders=list(LINES)))
        lines = sw.order_scan(runs).lines
        right = [k for k in LINES if any(abs(line.order - k) <= 2.0 * line.order_error for line in lines)]
        lost, false = lost + (len(right) < len(LINES)), false + (len(lines) > len(right))
    print(f"slow: {100 * np.mean(said):.2f} % of {len(said)} intervals hold the value; of {sets} sets {false} have a "
          f"line that is none, {lost} lack one")  # fmt: skip


def main(arguments):
    sets = int(arguments.pop(arguments.index("--sets") + 1)) if "--sets" in arguments else 400
    if "slow" in arguments:
        slow_sets(sets)
        return
    columns = [*(f"amplitude {k:g}" for k in LINES), *(f"phase {k:g}" for k in LINES), "delay"]
    print(f"{'':10s}" + "".join(f"{name:>15s}" for name in columns))
    for kind in [kind for kind in KINDS if kind in arguments] or KINDS:
        start, rng = time.process_time(), np.random.default_rng(16)
        shares = 100.0 * np.mean([hits(kind, rng) for _ in range(sets)], axis=0)
        took = (time.process_time() - start) / sets
        print(f"{kind:10s}" + "".join(f"{share:15.2f}" for share in shares) + f"   {took:.3f} s a set", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
