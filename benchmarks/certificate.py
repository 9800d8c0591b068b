"""The certificate of multiple scales on random drives: its estimate against the true error, and a histogram of both.

Laws of seven kinds, damping ratios from 0.005 to 0.1, amplitudes to three times the bend of the law (or what makes a
smooth law as much stiffer), speeds about the primary resonance. The estimate is `certificate().amplitude_at_speed` of
the largest steady state; the true error is that state's against `find_orbit` with 24 harmonics, begun there. Drives
without a true motion near that state, beyond the jump, are counted apart: the certificate has no number for them.

    python benchmarks/certificate.py [--drives 500] [--figure docs/_static/certificate.svg]
"""

import argparse
import math
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np

import strainwave as sw

matplotlib.use("svg")
import matplotlib.pyplot as plt

HARMONICS, SAMPLES = 24, 512
FLOOR = 1e-6  # the reference is as good as that: smaller errors are not compared


class Drive(NamedTuple):
    """One random drive at one speed, as the two orders see it."""

    law: str
    order: int
    valid: bool
    true: float | None
    estimated: float | None


def laws(rng: np.random.Generator) -> Iterator[tuple[str, object, float]]:
    """Laws with omega_0 near 1 and a bend near 1 rad, each with a mean torque."""
    while True:
        second = rng.uniform(1.1, 1.8)
        slopes = sw.PiecewiseLinear(1.0, second, second * rng.uniform(1.05, 1.4), 1.0, 2.0)
        yield "cubic", sw.Cubic(1.0, rng.uniform(0.02, 0.3)), 0.0
        yield "softening cubic", sw.Cubic(1.0, -rng.uniform(0.01, 0.03)), 0.0
        yield "cubic under a mean torque", sw.Cubic(1.0, rng.uniform(0.02, 0.3)), rng.uniform(0.1, 1.0)
        yield "three slopes", slopes, 0.0
        yield "three slopes under a mean torque", slopes, rng.uniform(0.1, 1.5)
        yield "preloaded gap", sw.Backlash(1.0, 0.3), rng.uniform(0.5, 2.0)
        yield "fifth power", sw.Polynomial((0.0, 1.0, 0.0, 0.1, 0.0, rng.uniform(0.01, 0.05))), 0.0


def true_amplitude(flow: object, z: complex) -> float | None:
    """Amplitude at the forcing frequency of the true motion next to a steady state; None where there is none."""
    t = 2.0 * np.pi / flow.system.omega * np.arange(SAMPLES) / SAMPLES
    x = np.fft.rfft(flow.steady_x(z, t))[: HARMONICS + 1] / SAMPLES
    guess = np.empty((2 * HARMONICS + 1, 2))
    for state, c in enumerate((x, 1j * flow.system.omega * np.arange(HARMONICS + 1) * x)):
        guess[0, state], guess[1::2, state], guess[2::2, state] = c[0].real, 2.0 * c[1:].real, -2.0 * c[1:].imag
    orbit = sw.find_orbit(flow.system, harmonics=HARMONICS, guess=guess, throw=False)
    return orbit.amplitude(1) if orbit.status else None


def judged(rng: np.random.Generator, law: str, spring: object, mean: float) -> list[Drive]:
    """One random drive at both orders."""
    zeta, amplitude = math.exp(rng.uniform(math.log(0.005), math.log(0.1))), rng.uniform(0.1, 3.0)
    system = sw.Oscillator(1.0, 2.0 * zeta, spring, sw.Harmonic(2.0 * zeta * amplitude, mean=mean), 1.0)
    middle = float(sw.slow_flow(system, sw.PRIMARY).backbone(amplitude))
    system = system._replace(omega=middle + rng.uniform(-3.0, 3.0) * zeta)
    found = []
    for order in (1, 2):
        flow = sw.slow_flow(system, sw.PRIMARY, order=order)
        z, certificate = flow.steady_states()[0].z, flow.certificate()
        true = true_amplitude(flow, z)
        error = None if true is None else abs(abs(z) / true - 1.0)
        found.append(Drive(law, order, certificate.valid, error, certificate.amplitude_at_speed))
    return found


def report(drives: list[Drive]) -> None:
    """Print what the certificate is worth, order by order."""
    for order in (1, 2):
        those = [drive for drive in drives if drive.order == order]
        known = [d for d in those if d.true is not None and d.estimated is not None and d.true > FLOOR]
        ratio = np.array([d.true / d.estimated for d in known])
        within = np.mean((ratio > 1 / 1.5) & (ratio < 1.5))
        valid = max((r for r, d in zip(ratio, known, strict=True) if d.valid), default=0.0)
        exact = sum(d.true is not None and d.true <= FLOOR for d in those)
        alone = sum(d.true is None or d.estimated is None for d in those)
        print(
            f"order {order}: {len(those)} drives, valid {np.mean([d.valid for d in those]):.0%}; {len(known)} compared:"
        )
        print(f"  true over estimated error {ratio.min():.3f} .. {ratio.max():.3f}, within 1.5 in {within:.1%}")
        print(f"  at most {valid:.3f} where valid")
        print(f"  {exact} with errors below {FLOOR:g}, {alone} without a true motion nearby")


def draw(drives: list[Drive], path: Path) -> None:
    """Histogram of the true errors of both orders, and the ratio to the estimate."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.6, 3.4), layout="constrained")
    for order, colour, hatch in ((1, "#E69F00", "//"), (2, "#0072B2", "")):
        known = [d for d in drives if d.order == order and d.true is not None and d.estimated]
        errors = np.array([max(d.true, 1e-9) for d in known])
        style = {"color": colour, "hatch": hatch, "edgecolor": "black", "lw": 0.5, "alpha": 0.75}
        left.hist(errors, np.geomspace(1e-9, 3.0, 40), label=f"order {order}", **style)
        ratio = [d.true / d.estimated for d in known if d.true > FLOOR]
        right.hist(ratio, np.geomspace(0.5, 2.0, 41), label=f"order {order}", **style)
    left.set(xscale="log", xlabel="true relative error (1e-9 and less in the first bin)", ylabel="number of drives")
    right.set(xscale="log", xlabel="true over estimated error", ylabel="number of drives")
    right.set_xticks([0.5, 1 / 1.5, 1.0, 1.5, 2.0], ["0.5", "1/1.5", "1", "1.5", "2"])
    right.minorticks_off()
    for edge in (1 / 1.5, 1.5):
        right.axvline(edge, color="black", ls=":")
    left.legend(frameon=False)
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    """Judge the drives, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=500)
    parser.add_argument("--figure", type=Path)
    asked = parser.parse_args()
    rng = np.random.default_rng(20)
    drives: list[Drive] = []
    for number, (law, spring, mean) in zip(range(asked.drives), laws(rng), strict=False):
        drives += judged(rng, law, spring, mean)
        if sys.stderr.isatty() or number % 50 == 49:
            print(f"\r{number + 1} drives", end="" if sys.stderr.isatty() else "\n", file=sys.stderr)
    report(drives)
    if asked.figure:
        plt.rcParams["svg.hashsalt"] = "certificate"
        draw(drives, asked.figure)


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()
