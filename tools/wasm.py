"""Make the kernels of pages anew: `python tools/wasm.py`, after `pip install ziglang`; `--check` compares the sources.

They are `src/strainwave/app/report/page/kernels.wasm.gz`, with the kinds of their arguments and the functions that they
were made of in `kernels.json`. A test compares the hash of these functions with the one there.
"""

import gzip
import json
import sys
from pathlib import Path

import numpy as np

import strainwave as sw
from strainwave.compile.address import MATRIX, VECTOR
from strainwave.compile.wasm import Wanted, compiled, linked, stamp
from strainwave.numerics.addressed import LawAt
from strainwave.numerics.balance.condensed.problem import Condensed
from strainwave.numerics.balance.springs import Spring, SpringsAt
from strainwave.numerics.curves.answer import answer
from strainwave.numerics.curves.drive_numbers import drive_numbers, problem_for
from strainwave.numerics.curves.inner_balance import Functions

FOLDER = Path(__file__).parents[1] / "src" / "strainwave" / "app" / "report" / "page"
LAWS = sw.Cubic(1.0, 0.1), sw.PiecewiseLinear(1.0, 2.0, 3.0, 1.0, 2.0)  # sampled, exact


def wanted() -> list[Wanted]:
    """The kernel, and all that it calls by address but the functions of laws."""
    two, law, found = (VECTOR, VECTOR), LawAt(0, 0, 0, 0, 0), []
    for i, own in enumerate(LAWS):
        problem = problem_for(sw.Oscillator(1.0, 0.1, own, sw.Harmonic(1.0), 1.0), (1.0, 2.0))
        spring = problem.springs.springs[0]._replace(law=law)
        found += [
            Wanted(f"torques{i}", Spring.torques, (spring,), (VECTOR, MATRIX, VECTOR)),
            Wanted(f"stiffness{i}", Spring.stiffness, (spring,), (int, int, MATRIX)),
            Wanted(f"slack{i}", Spring.slack, (spring,), ()),
        ]
    native = problem._replace(
        system=(), part=(), springs=SpringsAt(np.zeros((1, 5), np.int64), problem.springs.samples)
    )
    found += [
        Wanted("equations", Condensed.equations, (native,), two),
        Wanted("jacobian", Condensed.stiffness, (native,), (VECTOR, MATRIX)),
        Wanted("slope", Condensed.by_parameter, (native,), two),
    ]
    out = np.zeros((2, 6)), np.zeros((2, 2)), np.zeros(5)
    arguments = drive_numbers(problem), Functions(0, 0, 0), 1.0, 2.0, 1.0, 40, 7, 63, 1
    return [*found, Wanted("answer", answer, (*arguments, *out))]


def main() -> None:
    """Make them, or with `--check` say whether they are those of the sources."""
    path = FOLDER / "kernels.json"
    if "--check" in sys.argv:
        known = json.loads(path.read_text(encoding="utf-8"))
        sys.exit(0 if stamp(known["sources"]) == known["stamp"] else "the kernels of pages are old: run tools/wasm.py")
    parts = wanted()
    made = compiled(*parts)
    code = linked(made.code, [one.name for one in parts])
    (FOLDER / "kernels.wasm.gz").write_bytes(gzip.compress(code, mtime=0))
    known = {"arguments": made.arguments, "stamp": stamp(made.sources), "sources": made.sources}
    path.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
