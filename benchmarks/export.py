"""Exported C: time of a step of the plant and of an update of each controller, with the parameters in their struct.

    python benchmarks/export.py [--rounds 7] [--steps 200000]

A driver in C calls the code in a loop with inputs that change; the processor time of the loop over its length, medians
of the rounds. It needs the compiler `cc`.
"""

import argparse
import math
import statistics
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import strainwave as sw
from strainwave.study.compensation.bench import bench_of

ARCSEC, TURN = math.pi / 648_000.0, 2.0 * math.pi
DRIVE = sw.catalogue.gear("CSG-40-50").drive(load_inertia=10.0, motor_inertia=4.5e-4, B=40.0)
LOOP = sw.train.from_bandwidth(TURN * 30.0, DRIVE.J_m + DRIVE.J_l / DRIVE.N**2, 0.7)
TRAIN = DRIVE.train(kinematic_error=sw.KinematicError((sw.Line(2, 23.0 * ARCSEC),)), control=LOOP, omega=50.0)
SAMPLING = sw.controllers.Sampling(limit=3.0, motor_quantum=TURN / 2**16, load_quantum=TURN / 2**24)
SPEED = 55.0  # of the motor [rad/s]
DRIVER = """#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "code.h"
int main(int count, char **given)
{
    const long steps = count > 1 ? atol(given[1]) : 0;
    double sum = 0.0;
    code_state state;
    %s
    const clock_t begin = clock();
    for (long i = 0; i < steps; i++) {
        %s
    }
    printf("%%.3f %%g\\n", 1e9 * (double)(clock() - begin) / CLOCKS_PER_SEC / steps, sum);
    return 0;
}
"""
PLANT = DRIVER % (
    "code_inputs in = {0.3, -8.0}; code_outputs out; code_init(&state);",
    "in.motor_torque = 0.3 + 0.05 * (i % 7); code_step(&code_default, &state, &in, &out); sum += out.gear_torque;",
)
CONTROLLER = DRIVER % (
    "code_inputs in = {0.0, 50.0}; code_init(&code_default, &state);",
    "in.reference = 0.0125 * i; in.motor = in.reference + 1e-4 * (i % 7 - 3); in.load = in.motor / 50.0; "
    "in.applied = 0.02 * (i % 5); sum += code_update(&code_default, &state, &in);",
)


def nanoseconds(source, to, rounds, steps, **options):
    """Median time [ns] of a step of exported code, on one processor."""
    with TemporaryDirectory() as folder:
        driver, program = Path(folder) / "driver.c", Path(folder) / "driver"
        code = sw.export(source, Path(folder) / "code.c", to="c", **options).path
        driver.write_text(to)
        subprocess.run(["cc", "-std=c99", "-O2", code, driver, "-lm", "-o", program], check=True)
        runs = [subprocess.run([program, str(steps)], capture_output=True, check=True).stdout for _ in range(rounds)]
    return statistics.median(float(run.split()[0]) for run in runs)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--steps", type=int, default=200_000)
    given = parser.parse_args()
    bench = bench_of(TRAIN, SAMPLING)
    print(f"{'plant, Dop8':20}{nanoseconds(TRAIN, PLANT, given.rounds, given.steps, step=1e-4):10.1f} ns a step")
    method = sw.Rk4()
    print(f"{'plant, Rk4':20}{nanoseconds(TRAIN, PLANT, given.rounds, given.steps, step=1e-4, method=method):10.1f}")
    for name, design in sw.study.COMPENSATORS.items():
        controller = bench.closed(design.build(bench, SPEED), SPEED).controller
        print(f"{name:20}{nanoseconds(controller, CONTROLLER, given.rounds, given.steps):10.1f}")


if __name__ == "__main__":
    main()
