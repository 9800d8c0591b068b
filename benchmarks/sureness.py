"""Narrow speed ranges: the largest oscillation that `how_sure` tells of, against drives drawn from the same ranges.

    python benchmarks/sureness.py --draws 200 --seed 1

36 drives: three loops, their damping, that of the gear and the inertia of the load; the speeds lie within 2 % of the
resonance of order 2 with a loop of 28 Hz. The loop is assumed, in two of three drives the damping of the gear, and in
one the kinematic error as well. Each draw has every group of assumed numbers anywhere in its range, its curve with 60
points. Prints a line a drive: what is told, the largest drawn, their ratio.
"""

import argparse
import itertools
import math
from pathlib import Path

import numpy as np

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text

DRIVE = """\
gear:
  ratio: 100
  law: {{type: piecewise_linear, T1: 14 N*m, T2: 48 N*m, K1: 3.1e4 N*m/rad, K2: 5.0e4 N*m/rad, K3: 5.7e4 N*m/rad}}
motor: {{inertia: 3 kg*cm^2, loop: {{type: {loop}, bandwidth: 30 Hz, damping: {loop_damping}}}}}
load: {{inertia: {inertia} kg*m^2}}
damping: {{ratio: {damping} %}}
speed: {{from: {low} rpm, to: {high} rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 20 arcsec}}]}}
sources: {{{sources}}}
"""
SOURCES = "motor.loop: assumed", "damping: assumed", "excitation: assumed"
PATHS = "motor.loop.bandwidth", "damping.ratio", "excitation.kinematic_error.0.amplitude"
RANGES = ((20.0, 45.0, "Hz"), (2.0 / 3.0, 5.0 / 3.0, "%"), (10.0, 20.0, "arcsec"))


def drives():
    """Number of groups that are assumed, and the numbers of each drive."""
    kinds = itertools.product(("cascade", "position", "speed"), (0.4, 0.7), (1.0, 3.0), (0.4, 1.2, 4.0))
    names = "loop", "loop_damping", "damping", "inertia"
    return [(1 + i % 3, dict(zip(names, kind, strict=True))) for i, kind in enumerate(kinds)]


def project_of(assumed, numbers):
    """The project whose speeds lie within 2 % of its resonance with a loop of 28 Hz."""

    def between(low, high):
        sources = ", ".join(SOURCES[:assumed])
        return from_text(DRIVE.format(**numbers, low=low, high=high, sources=sources), Path("drive.yaml"))

    found = sw.replaced(between(200.0, 2500.0), {PATHS[0]: "28 Hz"}, retune=True).response(coexisting=False)
    rpm = float(found.omega[found.top]) * 30.0 / math.pi
    return between(0.98 * rpm, 1.02 * rpm)


def drawn(project, assumed, damping, rng):
    """Largest oscillation [rad] of a drive with its assumed numbers anywhere in their ranges; 0 where it has none."""
    changes = {}
    for path, (low, high, unit) in zip(PATHS[:assumed], RANGES, strict=False):
        scale = damping if unit == "%" else 1.0
        changes[path] = f"{scale * rng.uniform(low, high):.6g} {unit}"
    try:
        found = sw.replaced(project, changes, retune=True).response(coexisting=False)
    except (ValueError, sw.SolveError):
        return 0.0
    return float(found.oscillation[found.top])


def main():
    """Print a line a drive, and the smallest ratio of what is told to what is drawn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    given, ratios = parser.parse_args(), []
    for i, (assumed, numbers) in enumerate(drives()):
        rng = np.random.default_rng([given.seed, i])
        project = project_of(assumed, numbers)
        sure = project.sureness
        most = max(drawn(project, assumed, numbers["damping"], rng) for _ in range(given.draws))
        ratios.append(sure.largest[1] / most)
        low, high = (w * 30.0 / math.pi for w in project.speeds.limits)
        sizes = f"told {sure.largest[1] / ARCSEC:.2f} arcsec of {sure.drives} drives, drawn {most / ARCSEC:.2f}"
        where = f"{assumed} assumed, {low:.0f} to {high:.0f} rpm"
        print(f"{i + 1:2} {numbers} {where}: {sizes}, {ratios[-1]:.4f}", flush=True)
    print(f"{len(ratios)} ranges, told over drawn: {min(ratios):.4f} to {max(ratios):.4f}")


if __name__ == "__main__":
    main()
