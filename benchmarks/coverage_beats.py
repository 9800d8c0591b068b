"""Two lines that beat in synthetic scans: how often `order_scan` finds both, and coverage of the 95 % intervals.

    python benchmarks/coverage_beats.py [--sets 400] [--seed 38] [ratio] [bare] [one] [short]

A set is one run of a gear of ratio 51 or 101: a line of the wave generator against the fixed spline (2, 0), one against
the spline that turns (2, -2), wind-up as a sine of the output's angle, an autoregressive noise, samples 2.4 to 5.6 ms
apart. Runs hold 0.55 to 1.5 beats (`ratio`: the ratio is given), or at least one beat and 45 turns (`bare`: it is not).
`one` has one line alone; `short` runs hold 0.1 to 0.48 beats, with and without the ratio.
"""

import math
import sys
import time

import numpy as np
from scipy.signal import lfilter

import strainwave as sw

SPEED, STEP, COLOUR, NOISE, WINDUP = 20.0, 4e-3, 0.8, 2e-5, 2.5e-3
SIZES = (3e-5, 8e-5)  # rad, 0-to-peak: between these
KINDS = ("ratio", "bare", "one", "short")


def made(ratio, beats, sizes, rng):
    """A run over so many beats, and its lines by order: amplitude and phase."""
    turns = beats * ratio / 2.0
    t = np.cumsum(STEP * (1.0 + 0.4 * rng.uniform(-1.0, 1.0, int(turns * 2.0 * np.pi / SPEED / STEP))))
    angle = rng.uniform(0.0, 6.0) + SPEED * t + 0.2 * np.sin(0.5 * t)
    lines = {order: (size, rng.uniform(-np.pi, np.pi)) for order, size in sizes.items()}
    coloured = lfilter([1.0], [1.0, -COLOUR], rng.standard_normal(len(t) + 300))[300:] * math.sqrt(1.0 - COLOUR**2)
    value = NOISE * coloured + WINDUP * np.cos(angle / ratio + rng.uniform(0.0, 6.0))
    for order, (size, phase) in lines.items():
        value += size * np.cos(order * angle + phase)
    return sw.Run(t, angle, value, unit="rad"), lines


def hits(found, lines, near):
    """Whether amplitude and phase of each line are inside their intervals; None where a line was not found."""
    told = []
    for order, (size, phase) in lines.items():
        line = min(found, key=lambda one: abs(one.order - order), default=None)
        if line is None or abs(line.order - order) > near or len(found) != len(lines):
            return None
        low, high = line.interval("amplitude")
        turned = abs(math.remainder(line.phase - phase, 2.0 * math.pi))
        told += [low <= size <= high, turned <= (line.interval("phase").high - line.phase)]
    return told


def scanned(run, ratio=None):
    """Lines within 0.15 of order 2, and the notes."""
    scan = sw.order_scan([run], ratio=ratio, highest=20.0)
    return [line for line in scan.lines if line.kind != "frequency" and abs(line.order - 2.0) < 0.15], scan.notes


def one_set(kind, rng):
    """What a set tells: a row of columns, or None without an answer."""
    ratio = int(rng.choice([51, 101]))
    second, sizes = 2.0 - 2.0 / ratio, rng.uniform(*SIZES, 2)
    both = {2.0: sizes[0], second: sizes[1]}
    if kind == "one":
        alone = {float(rng.choice([2.0, second])): sizes[0]}
        run, _ = made(ratio, rng.uniform(0.55, 1.5) if ratio == 51 else rng.uniform(0.9, 1.5), alone, rng)
        return [len(scanned(run, ratio)[0]) > 1, len(scanned(run)[0]) > 1]
    if kind == "short":
        run, _ = made(ratio, rng.uniform(0.1, 0.48), both, rng)
        told = [scanned(run, r) for r in (ratio, None)]
        return [len(lines) < 2 and (not lines or "cannot tell" in str(notes)) for lines, notes in told]
    beats = rng.uniform(0.55, 1.5) if kind == "ratio" else max(rng.uniform(1.0, 1.5), 90.0 / ratio)
    run, lines = made(ratio, beats, both, rng)
    found, _ = scanned(run, ratio if kind == "ratio" else None)
    if kind == "ratio" and {line.pair for line in found} != {(2, 0), (2, -2)}:
        return None
    return hits(found, lines, 0.5 * (2.0 - second))


COLUMNS = {
    "ratio": ("amplitude 2", "phase 2", "amplitude 2-", "phase 2-"),
    "bare": ("amplitude 2", "phase 2", "amplitude 2-", "phase 2-"),
    "one": ("two with ratio", "two without"),
    "short": ("told with ratio", "told without"),
}


def main(arguments):
    sets, seed = (
        int(arguments[arguments.index(name) + 1]) if name in arguments else usual
        for name, usual in (("--sets", 400), ("--seed", 38))
    )
    for kind in [kind for kind in KINDS if kind in arguments] or KINDS:
        start, rng = time.process_time(), np.random.default_rng(seed)
        rows = [one_set(kind, rng) for _ in range(sets)]
        answers = [row for row in rows if row is not None]
        shares = 100.0 * np.mean(answers, axis=0)
        told = ", ".join(f"{name} {share:.2f} %" for name, share in zip(COLUMNS[kind], shares, strict=True))
        took = (time.process_time() - start) / sets
        print(f"{kind}: {len(answers)} of {sets} sets answered; {told}; {took:.2f} s a set", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
