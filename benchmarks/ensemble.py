"""Ensembles: steps per second against the processor's FMA rate, and trajectories per second against other integrators.

    python benchmarks/ensemble.py [--rounds 5] [--peers PYTHON]

The bound is 30 multiply-adds per Runge-Kutta step, at the rate that this process reaches on independent vector
multiply-adds in the same round (thread CPU time, medians). `--peers` names a Python with heyoka and diffrax
(`pip install heyoka diffrax` in an environment of its own).
"""

import argparse
import json
import os
import statistics
import subprocess
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.compile.lanes import LANES
from strainwave.compile.numba_import import numba_module
from strainwave.numerics.ensemble.blocks import march
from strainwave.numerics.ensemble.ensemble import _batch

DUFFING = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
FMA_PER_STEP = 30  # of RK4 on the Duffing oscillator
# Of a Dormand-Prince step on it: sums 40, error 12, rates times h 14, six rates 30; and of its five cosines, as
# `maths_kernels.cos` has them, because every lane has its own phase. The step control is not counted.
FMA_PER_ATTEMPT = 96 + 5 * 18


def chains(x, a, b, rounds):
    """Twelve dependent multiply-adds on each of 512 independent numbers, again and again."""
    for _ in range(rounds):
        for i in range(x.shape[0]):
            v = x[i]
            for _ in range(12):
                v = v * a + b
            x[i] = v


def fma_rate():
    """Multiply-adds per second of one core."""
    x = np.ones(512)
    run(chains, x, 0.5, 0.5, 10)
    best = 0.0
    for _ in range(5):
        start = time.thread_time()
        run(chains, x, 0.5, 0.5, 2000)
        best = max(best, 512 * 12 * 2000 / (time.thread_time() - start))
    return best


def block_of(system, measures, settle, periods, y0=(0.0, 0.0)):
    """One block of lanes over a range of hardening and speed."""
    omega = np.linspace(0.9, 1.1, LANES)
    varied = {"omega": omega}
    states = np.repeat(np.array(y0)[:, None], LANES, 1)
    return _batch(system, varied, states, LANES, measures, settle, periods)


def rate(batch, method, steps):
    """Steps per second of one block on one core."""
    places = np.arange(LANES)
    start = time.thread_time()
    march(batch, places, method, steps)
    return LANES * steps * (batch.settle + batch.periods) / (time.thread_time() - start)


def attempts_per_second(batch):
    """Adaptive steps attempted per second of one block on one core, at 1e-9."""
    start = time.thread_time()
    block = march(batch, np.arange(LANES), sw.Dopri5(rtol=1e-9, atol=1e-12), 0)
    return LANES * block.attempts / (time.thread_time() - start)


def bounds(rounds):
    """Share of the FMA bound that RK4 and adaptive steps reach without and with measures."""
    both = (sw.Peak(), sw.Rms())
    plain, measured = block_of(DUFFING, both, 100, 1), block_of(DUFFING, both, 0, 100)
    bare = block_of(DUFFING, (), 0, 100)
    contenders = {
        "RK4": (FMA_PER_STEP, lambda: rate(plain, sw.Rk4(), 100)),
        "RK4 with peak and rms": (FMA_PER_STEP, lambda: rate(measured, sw.Rk4(), 100)),
        "Dopri5": (FMA_PER_ATTEMPT, lambda: attempts_per_second(bare)),
        "Dopri5 with peak and rms": (FMA_PER_ATTEMPT, lambda: attempts_per_second(measured)),
    }
    seen = {name: [] for name in contenders}
    for _ in range(rounds + 1):  # the first compiles
        for name, (cost, steps) in contenders.items():
            seen[name].append((fma_rate() / cost, steps()))
    for name, pairs in seen.items():
        share = statistics.median(steps / bound for bound, steps in pairs[1:])
        speed = statistics.median(steps for _, steps in pairs[1:])
        print(f"Duffing, {name}: {speed:.3g} steps/s, {100 * share:.0f} % of the FMA bound")
    return seen


def against_scipy(rounds):
    """Trajectories of 50 periods at an error of 1e-6 per second and core, against solve_ivp's RK45."""
    n = 8 * LANES
    omega = np.linspace(0.9, 1.1, n)
    steps = next(s for s in (16, 20, 24, 28, 32, 40, 48) if error_of(sw.Dop8(steps_per_period=s)) < 1e-6)
    method = sw.Dop8(steps_per_period=steps)
    ours, theirs = [], []
    for _ in range(rounds):
        start = time.thread_time()
        sw.ensemble(
            DUFFING,
            {"omega": omega},
            (0.0, 0.0),
            periods=50,
            measures=(sw.Final(), sw.Peak()),
            method=method,
            threads=1,
        )
        ours.append(n / (time.thread_time() - start))
        start = time.thread_time()
        solve_ivp(lambda t, y: DUFFING.rhs(t, y), (0.0, 100.0 * np.pi), (0.0, 0.0), rtol=1e-7, atol=1e-9)
        theirs.append(1.0 / (time.thread_time() - start))
    a, b = statistics.median(ours), statistics.median(theirs)
    print(
        f"Dop8, {steps} steps a period, error below 1e-6: {a:.3g} trajectories of 50 periods/s and core, "
        f"{a / b:.0f} times solve_ivp RK45"
    )
    return a / b


def error_of(method, omegas=(0.9, 1.0, 1.1)):
    """Largest error of the state after 50 periods."""
    worst = 0.0
    for omega in omegas:
        system = sw.replaced(DUFFING, {"omega": omega})
        end = 100.0 * np.pi / omega
        exact = sw.simulate(system, (0.0, 0.0), end, method=sw.Dopri5(rtol=1e-13, atol=1e-15)).y[:, -1]
        found = sw.ensemble(system, {}, (0.0, 0.0), periods=50, measures=(sw.Final(),), method=method)["final"].values[
            :, 0
        ]
        worst = max(worst, float(np.max(np.abs(found - exact))))
    return worst


def laws(rounds):
    """Steps per second of RK4 (100 a period) and of adaptive steps (at 1e-9) for every kind of law."""
    found = {}
    print("| law | RK4, steps/s | adaptive, steps/s |\n|---|---|---|")
    for name, law, states in (
        ("Linear", sw.Linear(1.0), 2),
        ("Cubic", sw.Cubic(1.0, 0.05), 2),
        ("Polynomial of degree 5", sw.Polynomial((0.0, 1.0, 0.1, 0.05, 0.01, 0.02)), 2),
        ("PiecewiseLinear", sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), 2),
        ("Backlash", sw.Backlash(1.0, 0.5), 2),
        ("Play before Cubic", sw.Play(0.1, sw.Cubic(1.0, 0.05)), 2),
        ("Tabulated, 7 points", sw.tabulated([(0.5, 0.6), (1.0, 1.3), (2.0, 3.0)], odd=True), 2),
        ("RoundedPiecewiseLinear", sw.laws.RoundedPiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2, 0.1), 2),
        ("Coulomb beside Cubic", sw.Parallel(sw.Cubic(1.0, 0.05), sw.laws.Coulomb(0.1, 0.05)), 2),
        ("Stribeck beside Cubic", sw.Parallel(sw.Cubic(1.0, 0.05), sw.laws.Stribeck(0.1, 0.15, 0.1, 0.05)), 2),
        ("LuGre beside Cubic", sw.Parallel(sw.Cubic(1.0, 0.05), sw.laws.LuGre(50.0, 0.5, 0.1, 0.1, 0.15, 0.1)), 3),
        ("BoucWen", sw.BoucWen(1.0, 0.4, 0.3), 3),
    ):
        batch = block_of(DUFFING._replace(law=law), (sw.Peak(),), 10, 1, (0.0,) * states)
        fixed, adaptive = [], []
        for _ in range(rounds + 1):  # the first compiles
            fixed.append(rate(batch, sw.Rk4(), 100))
            adaptive.append(attempts_per_second(batch))
        found[name] = statistics.median(fixed[1:]), statistics.median(adaptive[1:])
        print(f"| {name} | {found[name][0]:.2g} | {found[name][1]:.2g} |", flush=True)
    return found


def peers(python):
    """heyoka and diffrax on the same task, and our rate at the error that each of them has."""
    exact = []
    for omega in (0.9, 1.0, 1.1):
        run_ = sw.simulate(
            sw.replaced(DUFFING, {"omega": omega}), (0.0, 0.0), 100.0 * np.pi / omega, method=sw.Dopri5(1e-13, 1e-15)
        )
        exact.append(run_.y[:, -1].tolist())
    script = Path(__file__).with_name("ensemble_peers.py")
    theirs = json.loads(subprocess.run([python, script, json.dumps(exact)], capture_output=True, check=True).stdout)
    omega = np.linspace(0.9, 1.1, 64 * LANES)
    ours = {}
    for steps in range(16, 60, 4):  # the fewest that are as exact as a peer are compared with it
        method, taken = sw.Dop8(steps_per_period=steps), []
        for _ in range(3):
            start = time.thread_time()
            sw.ensemble(
                DUFFING, {"omega": omega}, (0.0, 0.0), periods=50, measures=(sw.Final(),), method=method, threads=1
            )
            taken.append(time.thread_time() - start)
        ours[steps] = len(omega) / statistics.median(taken), error_of(method)
        print(f"Dop8, {steps} steps a period: error {ours[steps][1]:.1e}, {ours[steps][0]:.3g} trajectories/s")
    for name, (speed, error) in theirs.items():
        better = [s for s, e in ours.values() if e <= error] or [min(s for s, _ in ours.values())]
        print(
            f"{name}: error {error:.1e}, {speed:.3g} trajectories/s; ours at that error or less "
            f"{max(better) / speed:.1f} times"
        )
    return theirs


def calls(rounds):
    """Trajectories of 50 periods per second and core in calls of few and of many lanes, with the Dataset."""
    method, speeds = sw.Dop8(steps_per_period=16), {}
    for lanes in (64, 256, 16_384):
        times = []
        for _ in range(rounds + 1):
            start = time.thread_time()
            sw.ensemble(
                DUFFING, {"omega": np.linspace(0.9, 1.1, lanes)}, (0.0, 0.0), periods=50, method=method, threads=1
            )
            times.append(time.thread_time() - start)
        speeds[lanes] = lanes / statistics.median(times[1:])
        print(f"a call of {lanes} lanes: {speeds[lanes]:.3g} trajectories/s")
    return speeds


def many(threads):
    """Wall time of 99 840 trajectories of 200 periods with 100 Runge-Kutta steps each, against the FMA bound."""
    n = 99_840
    rng = np.random.default_rng(0)
    values = {"omega": rng.uniform(0.9, 1.1, n), "law.alpha": rng.uniform(0.04, 0.06, n)}
    method = sw.Rk4(steps_per_period=100)
    sw.ensemble(DUFFING, {"omega": np.ones(2)}, (0.0, 0.0), periods=2, method=method)
    bound = n * 200 * 100 * FMA_PER_STEP / fma_rate() / threads
    start = time.perf_counter()
    sw.ensemble(DUFFING, values, (0.0, 0.0), periods=200, method=method, threads=threads)
    wall = time.perf_counter() - start
    print(
        f"99 840 trajectories x 200 periods, {threads} threads: {wall:.1f} s wall, "
        f"{wall / bound:.2f} times the FMA bound"
    )
    return wall / bound


def main(rounds=5, python=None):
    """Print the table."""
    numba_module()
    figures = {"bounds": bounds(rounds), "laws": laws(rounds), "scipy": against_scipy(rounds)}
    figures["calls"] = calls(rounds)
    if python:
        figures["peers"] = peers(python)
    figures["one"], figures["two"] = many(1), many(2)
    return figures


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--peers", metavar="PYTHON")
    main(*vars(parser.parse_args()).values())
