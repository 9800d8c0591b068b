"""Random projects, whose allowed speeds every face must tell alike: `benchmarks/allowed_speeds.py [NUMBER] [SEED]`.

`analyze --json`, `speed-map --json`, the table of the report and the function that decides are compared to 1e-9.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from allowed_speeds import project_at_random, told

NUMBER, SEED, SAME = 60, 56, 1e-9


def main(number: int = NUMBER, seed: int = SEED) -> int:
    """Number of projects of which two faces differ."""
    rng, different = np.random.default_rng(seed), 0
    with tempfile.TemporaryDirectory() as folder:
        for i in range(number):
            text = project_at_random(rng)
            path = Path(folder) / f"{i}.yaml"
            path.write_text(text, encoding="utf-8")
            rows = told(path, Path(folder) / str(i))
            first = next(iter(rows.values()))
            bad = [
                face for face, row in rows.items() if len(row) != len(first) or not np.allclose(row, first, SAME, 0.0)
            ]
            different += bool(bad)
            said = f"DIFFERENT: {rows}\n{text}" if bad else " ".join(f"{end:.1f}" for end in first)
            print(f"{i}: {said}", flush=True)
    print(f"{different} of {number} projects have faces that differ")
    return different


if __name__ == "__main__":
    sys.exit(bool(main(*map(int, sys.argv[1:]))))
