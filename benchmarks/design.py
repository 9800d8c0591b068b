"""A design search: the catalogue and 1000 pairs of motor and load inertia, in seconds.

    python benchmarks/design.py [--motors 32] [--loads 32] [--held]

The limit lies where some gears serve and others do not, so that both averaging and harmonic balance have work. The
first search compiles, or loads compiled code; the second is measured. See README.md.
"""

import argparse
import math
import time

import numpy as np

import strainwave as sw
from strainwave.base.units import ARCSEC, RPM


def specification(motors, loads, held):
    duty = (sw.DutySegment(60.0, 20.0 * RPM, 2.0), sw.DutySegment(30.0, 10.0 * RPM, 3.0))
    return sw.Specification(
        load_inertias=tuple(np.geomspace(0.8, 1.6, loads)),
        speeds=(2.0 * RPM, 30.0 * RPM),
        limit=90.0 * ARCSEC,
        rotor_inertias=tuple(np.geomspace(2e-5, 1e-3, motors)),
        damping_ratio=0.03,
        duty=duty,
        loop=None if held else sw.train.Tuning(60.0 * math.pi),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--motors", type=int, default=32)
    parser.add_argument("--loads", type=int, default=32)
    parser.add_argument("--held", action="store_true")
    asked = parser.parse_args()
    sw.design(specification(2, 2, asked.held))
    spec = specification(asked.motors, asked.loads, asked.held)
    wall, cpu = time.perf_counter(), time.process_time()
    found = sw.design(spec)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    gears = len(found.rejected) + len({c.gear for c in found.feasible})
    print(f"{gears} gears, {asked.motors * asked.loads} pairs of inertias: {found.drives} drives by averaging,")
    print(f"{found.balanced} designs by harmonic balance; {cpu:.1f} s of CPU time, {wall:.1f} s on the wall (bar 60 s)")
    print(found)


if __name__ == "__main__":
    main()
