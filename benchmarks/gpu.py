"""Ensembles on a graphics processor: trajectories per second, and the difference to the processor's answer.

    python benchmarks/gpu.py [--lanes 1048576] [--periods 200] [--code]

Everything that needs a device, in two commands (with an NVIDIA device, its driver, and the extra `cuda`):

    export PYTHONPATH=src:tests; python3 benchmarks/gpu.py --code
    python3 -m pytest -q tests/numerics/ensemble/test_gpu.py

Wall time, as a device has no thread time: the median of the rounds without compilation; trajectories per second are
those of the whole call (estimate of the error included), steps per second those of the device with all transfers.
`--code` adds what the assembler makes of every canonical system: registers, stack and spills of a thread (no device
needed; where `ptxas` is found). Without a device one sentence says so.
"""

import argparse
import statistics
import sys
import time

import numpy as np

import strainwave as sw
from strainwave.compile import cuda
from strainwave.numerics.ensemble import machine as gpu
from strainwave.numerics.ensemble.ensemble import _batch
from strainwave.numerics.ensemble.stepping import FixedLanes

DUFFING = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
ERROR = sw.KinematicError((sw.Line(2, 0.02), sw.Line(4, 0.005, 0.7)))
CASES = {
    "Duffing, Rk4, 100 steps": (DUFFING, sw.Rk4(steps_per_period=100)),
    "Duffing, Dop8, 24 steps": (DUFFING, sw.Dop8(steps_per_period=24)),
    "Duffing, Dopri5, 1e-6": (DUFFING, sw.Dopri5(rtol=1e-6, atol=1e-8)),
    "two error lines, Rk4, 200 steps": (DUFFING._replace(error=ERROR), sw.Rk4(steps_per_period=200)),
    "two error lines, Dop8, 48 steps": (DUFFING._replace(error=ERROR), sw.Dop8(steps_per_period=48)),
    "BoucWen, Rk4, 100 steps": (DUFFING._replace(law=sw.BoucWen(1.0, 0.3, 0.4)), sw.Rk4(steps_per_period=100)),
}
SMALL = 2048  # lanes that both compute


def ensemble_of(system, method, lanes, periods, device):
    """Variants in speed and damping, from rest; and the wall time."""
    varied = {"omega": np.linspace(0.6, 1.6, lanes), "B": np.linspace(0.1, 0.3, lanes)}
    start = time.perf_counter()
    states = (0.0,) * len(system.state_names())
    found = sw.ensemble(system, varied, states, periods=periods, method=method, device=device)
    return found, time.perf_counter() - start


def largest_difference(system, method):
    """Largest relative difference of peak and rms between the two, over a few periods."""
    here, there = (ensemble_of(system, method, SMALL, 20, device)[0] for device in ("cpu", "gpu"))
    gaps = [np.max(np.abs(there[name].values / here[name].values - 1.0)) for name in ("peak", "rms")]
    return float(max(gaps)), bool((here["status"] == there["status"]).all())


def march_time(system, method, lanes, periods):
    """Wall time of the device's part alone: parameters in, all steps, measures out."""
    varied = {"omega": np.linspace(0.6, 1.6, lanes)}
    states = np.zeros((len(system.state_names()), lanes))
    batch = _batch(system, varied, states, lanes, (sw.Peak(), sw.Rms()), 0, periods, False)
    start = time.perf_counter()
    gpu.march_on_gpu(batch, np.arange(lanes), method, getattr(method, "steps_per_period", 0))
    return time.perf_counter() - start


def measure(lanes, periods, rounds):
    """Print the table of rates, and return how many cases differ from the processor's answer."""
    print(f"{lanes} trajectories of {periods} periods on {cuda.load().get_current_device().name}")
    print(f"{'case':34s} {'trajectories/s':>15s} {'steps/s':>9s} {'difference to the processor':>28s}")
    wrong = 0
    for name, (system, method) in CASES.items():
        gap, same = largest_difference(system, method)
        whole = statistics.median(ensemble_of(system, method, lanes, periods, "gpu")[1] for _ in range(rounds))
        steps = getattr(method, "steps_per_period", 0)
        march = statistics.median(march_time(system, method, lanes, periods) for _ in range(rounds))
        rate = f"{lanes * periods * steps / march:9.2e}" if steps else " " * 9
        print(f"{name:34s} {lanes / whole:15.3e} {rate} {gap:28.1e}{'' if same else '  STATUS DIFFERS'}", flush=True)
        wrong += not same or gap > 1e-9
    return wrong


def compare_choices(lanes, periods):
    """Print the rates of other numbers of threads in a block and of lanes in a thread."""
    system, method = CASES["Duffing, Rk4, 100 steps"]
    chosen, threads = FixedLanes.of_thread, cuda.THREADS
    for of_block in (32, 64, 128, 256):
        for of_thread in (1, 2, 4):
            cuda.THREADS, FixedLanes.of_thread = of_block, of_thread
            cuda.kernel.cache_clear()
            march_time(system, method, SMALL, 2)  # compiles
            rate = lanes * periods * 100 / march_time(system, method, lanes, periods)
            print(f"blocks of {of_block:3d} threads, {of_thread} lanes of a thread: {rate:9.2e} steps/s", flush=True)
    cuda.THREADS, FixedLanes.of_thread = threads, chosen
    cuda.kernel.cache_clear()


def show_code(wanted):
    """Print registers, stack and spills for canonical systems whose name contains the wanted text."""
    import device_code
    from canonical import DISSIPATIVE_SYSTEMS, SYSTEMS

    print(f"{'system':28s} {'method':6s} lanes registers stack spilled bytes of PTX (sm_90)")
    for name, system in (SYSTEMS | DISSIPATIVE_SYSTEMS).items():
        if wanted not in name:
            continue
        for method in (sw.Rk4(steps_per_period=64), sw.Dop8(steps_per_period=32), sw.Dopri5()):
            made, lanes = device_code.code(system, method, ((9, 0),))
            used = device_code.registers(made[9, 0], (9, 0)) or ("?", "?", "?")
            kind = type(method).__name__
            print(
                f"{name:28s} {kind:6s} {lanes:5d} {used[0]:>9} {used[1]:>5} {used[2]:>7} {len(made[9, 0]):9d}",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--lanes", type=int, default=2**20)
    parser.add_argument("--periods", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--code", nargs="?", const="", help="show the code of systems whose name contains this (all)")
    asked = parser.parse_args()
    reason = cuda.missing()
    wrong = 0
    if reason:
        print(f"No rates: {reason}.")
    else:
        wrong = measure(asked.lanes, asked.periods, asked.rounds)
        compare_choices(asked.lanes, asked.periods)
    if asked.code is not None:
        show_code(asked.code)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
