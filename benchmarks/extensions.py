"""A gap without preload, and stiffness that varies, by averaging: the certificate against the error of integration.

Twenty random drives of each kind (`tests/averaged.py`). The true error is that of the largest steady state's amplitude
against an integration from its motion (DOP853, rtol 1e-9) over 12 time constants of the amplitude; the estimate is
`certificate().amplitude_at_speed`. Drives whose certificate is not valid are listed with its reason.

    python benchmarks/extensions.py [--drives 20]
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import strainwave as sw

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from averaged import integrated, with_gap, with_varying


def row(flow, damping):
    """Amplitude [rad], true error and estimate of a flow's largest steady state, or the reason against it."""
    state, certificate = flow.steady_states()[0], flow.certificate()
    if not certificate.valid:
        return certificate.sentence.split(": ", 1)[1]
    true = abs(state.amplitude / integrated(flow, state.z, damping) - 1.0)
    return state.amplitude, true, certificate.amplitude_at_speed


def shown(name, rows):
    """Print the rows of one kind and order, and their sum."""
    good = np.array([r for r in rows if not isinstance(r, str)])
    for i, r in enumerate(rows):
        print(
            f"{name} {i:2d}: "
            + (f"refused: {r}" if isinstance(r, str) else "a {:.4g} rad, true {:.2e}, estimate {:.2e}".format(*r))
        )
    off = np.abs(good[:, 1] - good[:, 2])
    print(
        f"{name}: {len(good)} valid, {len(rows) - len(good)} refused; largest error {np.max(good[:, 1]):.2e}, ", end=""
    )
    print(f"largest difference from the estimate {np.max(off):.1e}\n")


def main(drives: int = 20) -> None:
    """Print both tables."""
    rng = np.random.default_rng(1)
    gaps = [with_gap(rng) for _ in range(drives)]
    for order in (1, 2):
        shown(f"gap, order {order}", [row(sw.slow_flow(s, sw.PRIMARY, order=order), s.B) for s in gaps])
    varying = [with_varying(rng) for _ in range(drives)]
    shown("varying", [row(sw.slow_flow(s, resonance), s.damping.B) for s, resonance in varying])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=20)
    main(parser.parse_args().drives)
