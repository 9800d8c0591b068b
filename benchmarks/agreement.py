"""Random drives by every road: where Python, commands, app, scripts, notebook and report disagree on a quantity.

    python benchmarks/agreement.py --drives 50 --seed 1

Every drive has a law, hysteresis or a gap or none, a held motor or a loop, gravity, a coupling or torques of the load,
one to three orders of the kinematic error, a limit and a move (tests/random_projects.py). Prints a line a drive, and
exits with 1 where two faces disagree. A drive without a steady motion must be refused in the same sentence by all.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from agreement import disagreements
from random_projects import drive_at_random

TOGETHER = 5  # drives of one comparison


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first drive of the seed")
    given = parser.parse_args()
    wrong = 0
    last = given.first + given.drives
    for first in range(given.first, last, TOGETHER):
        numbers = range(first, min(first + TOGETHER, last))
        texts = [drive_at_random(np.random.default_rng([given.seed, i])) for i in numbers]
        with tempfile.TemporaryDirectory() as folder:
            found = disagreements(texts, Path(folder))
        for i, text, said in zip(numbers, texts, found, strict=True):
            wrong += bool(said)
            print("\n    ".join([f"{given.seed}:{i}", *(said or ["equal"])]), flush=True)
            print(text if said else "", end="", flush=True)
    print(f"{wrong} of {given.drives} drives of seed {given.seed} have faces that disagree")
    sys.exit(int(wrong > 0))


if __name__ == "__main__":
    main()
