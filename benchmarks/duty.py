"""Designs of random specifications, with duties, payloads and both signs, against their own equations of motion.

    python benchmarks/duty.py [--count 60] [--seed 1]

Of each specification one design that serves and one gear that is turned away for its oscillation are integrated over
the speeds with every load, under every torque of the duty and none. None that serves may be above the limit, and none
that is turned away below it in all of them. See README.md.
"""

import argparse
import math
import time
from dataclasses import replace

import numpy as np
from own_drive import CASCADE, HELD, POSITION, largest

import strainwave as sw

ARCSEC, RPM = math.pi / 648000.0, math.pi / 30.0
SHARES = ((1, 1.0), (2, 4.0), (4, 1.0))  # of an accuracy class, peak-to-peak


def specification(random):
    """One that some gears serve and some do not."""
    torque, load = np.exp(random.uniform(np.log(5.0), np.log(150.0))), np.exp(random.uniform(np.log(0.1), np.log(4.0)))
    loads = load * np.array([1.0, random.uniform(1.2, 5.0)][: random.integers(1, 3)])
    duty = [
        sw.DutySegment(torque * s * random.choice([-1, 1]), random.uniform(5, 30) * RPM, random.uniform(0.2, 2.0))
        for s in [1.0, *random.uniform(0.0, 1.0, random.integers(0, 3))]
    ]
    tuning = sw.train.Tuning(random.uniform(15.0, 45.0) * math.tau, 0.7, kind=random.choice(["cascade", "position"]))
    return sw.Specification(
        load_inertias=tuple(loads.tolist()),
        speeds=(random.uniform(1.0, 4.0) * RPM, random.uniform(20.0, 45.0) * RPM),
        limit=random.uniform(50.0, 150.0) * ARCSEC,
        rotor_inertias=tuple(np.geomspace(2e-5, 4e-4, 2).tolist()),
        damping_ratio=random.uniform(0.02, 0.05),
        duty=tuple(duty),
        preload=float(random.choice([0.0, 0.0, 0.1 * torque])),
        largest_size=int(random.choice([32, 40, 50, 65])),
        loop=None if random.random() < 0.2 else tuning,
    )


def own_sizes(spec, c):
    """Largest oscillation [rad] of a design by load and torque, by its own equations from numbers alone."""
    gear = sw.catalogue.gear(c.gear)
    law, N, K1 = (gear.K1, gear.K2, gear.K3, gear.T1, gear.T2), gear.ratio, gear.K1
    angle = np.linspace(0.0, math.tau, 100_001)
    wave = sum(s * np.cos(k * angle) for k, s in SHARES)
    lines = [(k, s * gear.accuracy / (wave.max() - wave.min())) for k, s in SHARES]
    light = min(spec.load_inertias)
    J, kind, loop = c.motor_inertia + light / N**2, HELD, (0.0, 0.0, 1.0)
    if spec.loop is not None:
        w, z = spec.loop.bandwidth, spec.loop.damping
        control = sw.train.from_bandwidth(w, J, z, kind=spec.loop.kind)
        kind = CASCADE if spec.loop.kind == "cascade" else POSITION
        loop = (control.K_v, control.K_p, control.T_n) if kind == CASCADE else (control.K_p, control.K_d, 1.0)
    B, speeds = 2.0 * spec.damping_ratio * math.sqrt(K1 * light), (N * spec.speeds[0], N * spec.speeds[1])
    sizes = {0.0, *(abs(p.torque) + abs(spec.preload) for p in spec.duty), abs(spec.preload)}
    return {
        (load, sign * size): largest(c.motor_inertia, load, N, B, law, lines, sign * size, speeds, kind, loop)
        for load in spec.load_inertias
        for size in sizes
        for sign in ((-1.0, 1.0) if size else (1.0,))
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    random, serving, turned, wrong, began = np.random.default_rng(asked.seed), 0, 0, 0, time.process_time()
    while min(serving, turned) < asked.count:
        spec = specification(random)
        found = sw.design(spec)
        by_error = {name for name, said in found.rejected.items() if "oscillates" in said}
        loose = sw.design(replace(spec, limit=1.0), gears=[sw.catalogue.gear(name) for name in by_error])
        for chosen, serves in ((found.feasible, True), (loose.feasible, False)):
            if not chosen or (serving if serves else turned) >= asked.count:
                continue
            c = chosen[int(random.integers(len(chosen)))]
            own = own_sizes(spec, c)
            (load, torque), most = max(own.items(), key=lambda item: item[1])
            right = (most <= spec.limit) == serves
            serving, turned, wrong = serving + serves, turned + (not serves), wrong + (not right)
            print(
                f"{'serves' if serves else 'turned'} {c.gear:11} {c.oscillation / ARCSEC:7.2f} ({c.method[:4]}), own "
                f"{most / ARCSEC:7.2f} of {spec.limit / ARCSEC:6.2f} arcsec, load {load:.3g}, {torque:+.4g} N*m"
                f"{'' if right else '  WRONG'}",
                flush=True,
            )
    print(
        f"{serving} that serve and {turned} turned away: {wrong} wrong; {time.process_time() - began:.0f} s of CPU time"
    )


if __name__ == "__main__":
    main()
