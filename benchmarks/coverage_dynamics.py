"""How often the 95 % intervals of `identify` cover the truth, over synthetic records with several kinds of noise.

A Duffing oscillator, J x'' + B x' + K (x + alpha x^3) = u + offset, has a random multisine, 800 samples at 200 Hz.
Clean records are DOP853's. Noise of 2 % of the motion: white, coloured (a first-order autoregression with .9; a second
one with a resonance), and quantisation into 40 steps. The last line has |x'| x' in the truth and not in the model: the
interval of alpha covers, or the term is flagged.

python benchmarks/coverage_dynamics.py [--sets 400]
"""

import argparse
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

import strainwave as sw

RATE, SAMPLES, FINE = 200.0, 800, 16
J, B, K, ALPHA, OFFSET = 2.0e-4, 4.0e-3, 1.0, 0.6, 0.05
TRUTH = {"J": J, "B": B, "law.K": K, "law.alpha": ALPHA, "excitation.offset": OFFSET}
GUESS = sw.Oscillator(1.8e-4, 5e-3, sw.Cubic(0.9, 0.4), sw.Harmonic(0.0), 1.0)
NOISE = 0.02


def clean_record(seed, d=0.0):
    rng = np.random.default_rng(seed)
    k = np.arange(SAMPLES * FINE // 2 + 1)
    spectrum = np.where((k > 0) & (k * RATE / SAMPLES < 30.0), np.exp(2j * np.pi * rng.random(len(k))), 0.0)
    u = np.fft.irfft(spectrum)
    u *= 0.8 / np.std(u)
    force = CubicSpline(np.arange(len(u) + 1) / (FINE * RATE), np.append(u, u[0]))
    t = np.arange(SAMPLES) / RATE

    def rhs(s, y):
        torque = force(s) + OFFSET - B * y[1] - d * abs(y[1]) * y[1] - K * (y[0] + ALPHA * y[0] ** 3)
        return y[1], torque / J

    x = solve_ivp(rhs, (0.0, t[-1]), (0.2, 0.0), "DOP853", t, rtol=1e-9, atol=1e-11, max_step=1.0 / RATE).y[0]
    return t, u[::FINE], x


def white(x, rng):
    return x + NOISE * np.std(x) * rng.standard_normal(len(x))


def coloured(x, rng):
    noise = lfilter([1.0], [1.0, -0.9], rng.standard_normal(len(x) + 500))[500:]
    return x + NOISE * np.std(x) * noise / np.std(noise)


def resonant(x, rng):
    noise = lfilter([1.0], [1.0, -1.8 * np.cos(0.4), 0.81], rng.standard_normal(len(x) + 500))[500:]
    return x + NOISE * np.std(x) * noise / np.std(noise)


def quantised(x, rng):
    step = 8.0 * np.std(x) / 40.0
    zero = rng.uniform(0.0, step)  # where the encoder counts from
    return step * np.round((x - zero) / step) + zero


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=400)
    sets = parser.parse_args().sets
    started = time.perf_counter()
    made = [clean_record(i) for i in range(20)]
    lacking = [clean_record(100 + i, d=1.5e-4) for i in range(20)]
    print(f"{'noise':<12}" + "".join(f"{name:>20}" for name in TRUTH))
    for kind in (white, coloured, resonant, quantised):
        hits = np.zeros(len(TRUTH))
        for i in range(sets):
            t, u, x = made[i % 20]
            log = {"time": t, "input": u, "output": kind(x, np.random.default_rng(1000 + i))}
            found = sw.identify(GUESS, log, tuple(TRUTH))
            hits += [found.interval(p).low <= v <= found.interval(p).high for p, v in TRUTH.items()]
            print(f"{kind.__name__} {i + 1}", end="\r", file=sys.stderr)
        print(f"{kind.__name__:<12}" + "".join(f"{100.0 * h / sets:19.1f}%" for h in hits), flush=True)
    good = flagged = not_white = 0
    for i in range(sets):
        t, u, x = lacking[i % 20]
        log = {"time": t, "input": u, "output": white(x, np.random.default_rng(5000 + i))}
        found = sw.identify(GUESS, log, tuple(TRUTH))
        low, high = found.interval("law.alpha")
        named, dyed = "|v| v" in found.discrepancy.flagged, found.discrepancy.white < 0.05
        good += low <= ALPHA <= high or named or dyed
        flagged, not_white = flagged + named, not_white + dyed
    shares = [f"{100.0 * count / sets:.1f} %" for count in (good, flagged, not_white)]
    print(f"missing |v| v: covered or flagged {shares[0]}, the term named {shares[1]}, residual not white {shares[2]}")
    print(f"{time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
