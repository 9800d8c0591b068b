"""Sampled controllers: one `update`, one sample of plant and controller, and a thousand loops of 10 s at 4 kHz.

    python benchmarks/compensation.py [--rounds 5] [--loops 1000] [--calls 1000000]

An `update` is timed in a compiled loop over measurements that change from sample to sample, less the same loop without
it. A sample of plant and controller is the thread time of one loop over its samples. The thousand loops are those of
the bench in docs/compensation.md, with stiffnesses and phases that differ, on all processors: wall and CPU seconds.
"""

import argparse
import math
import os
import statistics
import time

import numpy as np

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.model.controllers.loops import Measurement
from strainwave.study.compensation.bench import bench_of

ARCSEC, TURN = math.pi / 648_000.0, 2.0 * math.pi
DRIVE = sw.catalogue.gear("CSG-40-50").drive(load_inertia=10.0, motor_inertia=4.5e-4, B=40.0)
LOOP = sw.train.from_bandwidth(TURN * 30.0, DRIVE.J_m + DRIVE.J_l / DRIVE.N**2, 0.7)
TRAIN = DRIVE.train(kinematic_error=sw.KinematicError((sw.Line(2, 23.0 * ARCSEC),)), control=LOOP, omega=50.0)
SAMPLING = sw.controllers.Sampling(limit=3.0, motor_quantum=TURN / 2**16, load_quantum=TURN / 2**24)
SPEED = 55.0  # of the motor [rad/s]
SAMPLES = 4000


def updates(controller, state, calls):
    """Sum of the torques of so many updates."""
    total, angle = 0.0, 0.0
    for i in range(calls):
        angle += 0.0125
        off = 1e-4 * (i % 7 - 3)
        m = Measurement(angle, 50.0, 0.0, angle + off, angle / 50.0 + 0.01 * off, 0.1 * off, 0.0)
        state, torque = controller.update(state, m)
        total += torque
    return total


def empty(_controller, _state, calls):
    """Sum of the measurements of so many samples."""
    total, angle = 0.0, 0.0
    for i in range(calls):
        angle += 0.0125
        off = 1e-4 * (i % 7 - 3)
        m = Measurement(angle, 50.0, 0.0, angle + off, angle / 50.0 + 0.01 * off, 0.1 * off, 0.0)
        total += m.reference + m.motor + m.load + m.applied
    return total


def thread_time(function):
    """Thread seconds of one call."""
    begin = time.thread_time()
    function()
    return time.thread_time() - begin


def one_update(controllers, rounds, calls):
    """Nanoseconds of an update, and of a sample with the plant, medians of the rounds, for each controller."""
    bench = bench_of(TRAIN, SAMPLING)
    jobs = {}
    for name, controller in controllers.items():
        closed = bench.closed(controller, SPEED)
        jobs[name] = (
            lambda c=closed.controller: run(updates, c, c.start(), calls),
            lambda c=closed.controller: run(empty, c, c.start(), calls),
            lambda loop=closed: sw.numerics.run_loop(loop, SAMPLES * SAMPLING.period, every=SAMPLES),
        )
        for job in jobs[name]:
            job()  # compiles
    found = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, (full, bare, whole) in jobs.items():
            found[name].append(
                (1e9 * (thread_time(full) - thread_time(bare)) / calls, 1e9 * thread_time(whole) / SAMPLES)
            )
    print(f"{'controller':18}{'update ns':>12}{'range':>16}{'with plant ns':>16}")
    for name, rows in found.items():
        alone, whole = zip(*rows, strict=True)
        reach = f"{min(alone):.1f} .. {max(alone):.1f}"
        print(f"{name:18}{statistics.median(alone):12.1f}{reach:>16}{statistics.median(whole):16.0f}")


def many_loops(controllers, loops, name="adaptive-inverse"):
    """Wall and CPU seconds of an ensemble of loops of 10 s."""
    closed = bench_of(TRAIN, SAMPLING).closed(controllers[name], SPEED)
    draw = np.random.default_rng(1)
    varied = {
        "train.law.K1": closed.train.law.K1 * draw.uniform(0.85, 1.15, loops),
        "train.error.lines.0.phase": draw.uniform(0.0, TURN, loops),
    }
    sw.numerics.loop_ensemble(
        closed, {"train.law.K1": varied["train.law.K1"][:2]}, 0.01, settle=0.0, orders=[2.0]
    )  # compiles
    wall, cpu = time.perf_counter(), time.process_time()
    found = sw.numerics.loop_ensemble(closed, varied, 10.0, settle=8.0, orders=[2.0])
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{loops} loops of 10 s at 4 kHz, {name}: {wall:.1f} s wall, {cpu:.1f} s CPU, {os.cpu_count()} processors")
    print(f"{found.steps} step(s) between samples; {int(np.sum(~found.stable))} unstable")


def main():
    """Print both tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--loops", type=int, default=1000)
    parser.add_argument("--calls", type=int, default=1_000_000)
    given = parser.parse_args()
    bench = bench_of(TRAIN, SAMPLING)
    controllers = {name: design.build(bench, SPEED) for name, design in sw.study.COMPENSATORS.items()}
    one_update(controllers, given.rounds, given.calls)
    many_loops(controllers, given.loops)


if __name__ == "__main__":
    main()
