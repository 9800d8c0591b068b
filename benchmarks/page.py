"""Pages against Python: `python benchmarks/page.py [PROJECTS] [POSITIONS] [SEED]`, with node.

Random drives at the numbers of their files, and one cascade at random positions of its sliders: no trap, no NaN, no
memory that grows. It prints what differs by more than 1e-9, and CPU times of the kernel.
"""

import gzip
import json
import subprocess
import sys
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from random_projects import drive_at_random

from strainwave.app.report.page import page
from strainwave.app.report.page.sliders import sliders
from strainwave.base.results import SolveError
from strainwave.files.reading import from_text, read_project
from strainwave.numerics.labels import DECAYS, FOLD

FIRST = Path(page.__file__).parents[1] / "projects" / "CSG-40-50.yaml"
NODE = """
const { readFileSync } = require("fs"), [kernels, pages] = JSON.parse(readFileSync(0)), out = [];
for (const [data, own, positions] of pages) {
  const machine = start(bytes(kernels), data.kinds, bytes(own));
  for (const [values, points] of positions) {
    let found, begun = process.cpuUsage();
    try {
      found = answered(machine, data, values, points);
    } catch (error) {
      found = { count: -99, rows: [], error: `${error}` };
    }
    const { user, system } = process.cpuUsage(begun);
    const finite = found.rows.every((row) => row.every(Number.isFinite));
    const kept = positions.length > 100 ? {} : { rows: found.rows };
    const memory = machine.main.memory.buffer.byteLength;
    out.push({ count: found.count, finite, memory, ms: (user + system) / 1e3, error: found.error, ...kept });
  }
}
console.log(JSON.stringify(out));
"""


def in_node(pages: list[Any]) -> list[Any]:
    """Answers of pages (data, code, positions), one after another."""
    script = page._text("machine.js") + page._text("page.js") + NODE
    kernels = gzip.decompress((page.HERE / "kernels.wasm.gz").read_bytes())
    given = json.dumps([page._packed(kernels), [(data, page._packed(own), at) for data, own, at in pages]])
    with tempfile.NamedTemporaryFile("w", suffix=".js") as file:
        file.write(script)
        file.flush()
        done = subprocess.run(["node", file.name], input=given, capture_output=True, text=True, check=True)
    answers: list[Any] = json.loads(done.stdout)
    return answers


def difference(project: Any, answer: Any) -> float:
    """Largest difference of a motion from that of the page, of the largest; infinite without it or its stability."""
    response = project.response(coexisting=False)
    branch, rows = response.curve, np.array(answer["rows"])
    keep = np.ones(len(branch), bool)
    for one in (*branch.doublings, *branch.branch_points, *branch.tori):  # located by Python alone, beside a point
        keep[np.flatnonzero(keep & (response.omega == one.omega))[:1]] = False
    wanted = np.column_stack([response.omega, response.oscillation, response.peak, response.torque])[keep]
    fold = rows[:, 5] == FOLD  # a multiplier is 1
    if len(rows) != len(wanted) or np.any((rows[:, 3] < DECAYS)[~fold] != response.stable[keep][~fold]):
        return np.inf
    return float(np.max(np.abs(rows[:, [0, 1, 2, 4]] - wanted) / np.max(wanted, axis=0)))


def projects(number: int, seed: int) -> None:
    """Random drives at the numbers of their files."""
    page._functions = _once(page._functions)
    rng, pages, kept, refused = np.random.default_rng(seed), [], [], Counter[str]()
    while len(kept) < number:
        text = drive_at_random(rng)
        project = from_text(text, Path("random.yaml"))
        try:
            data, own = page.data_of(project)
        except ValueError as error:
            refused[str(error).partition("this drive has ")[2].partition(":")[0] or str(error)] += 1
            continue
        kept.append(project)
        pages.append((data, own, [[[one["value"] for one in data["sliders"]], data["points"]]]))
    print(f"{number} drives; refused: {dict(refused)}")
    worst, missed = [], Counter[str]()
    for i, (project, answer) in enumerate(zip(kept, in_node(pages), strict=True)):
        if answer["count"] <= 0:
            missed[f"answer {answer['count']}"] += 1
            print(f"drive {i}: answer {answer['count']}")
            continue
        try:
            away = difference(project, answer)
        except SolveError:  # no motion is stable
            stable = any(row[3] < DECAYS for row in answer["rows"])
            missed["stable on the page alone" if stable else "none stable, as in Python"] += 1
            continue
        within_gap = sum(row[5] != FOLD and abs(row[3] - 1.0) < 1.0 - DECAYS for row in answer["rows"]) > 2
        if away > 1e-9 and within_gap:
            missed["any mean within a gap, as the page says"] += 1
        elif away > 1e-9:
            missed["other points or stability" if away == np.inf else "other numbers"] += 1
            print(f"drive {i}: {away:.2g}, {answer['count']} points")
        else:
            worst.append(away)
    print(f"{len(worst)} equal to {max(worst):.2g}, median {np.median(worst):.2g}; others: {dict(missed)}")


def _once(function: Any) -> Any:
    known = cache(lambda key: function(*key))
    return lambda laws, kinds: known((tuple(laws), tuple(kinds)))


def positions(number: int, seed: int) -> None:
    """One cascade at random positions of its sliders, and CPU times at its own."""
    project = read_project(FIRST)
    data, own = page.data_of(project)
    _, rows, _ = sliders(project)
    rng, home = np.random.default_rng(seed), [row.value for row in rows]
    at = [[[float(rng.uniform(row.low, row.high)) for row in rows], data["points"]] for _ in range(number)]
    answers = in_node([(data, own, at)])
    counts = Counter("curves" if one["count"] > 0 else str(one["count"]) for one in answers)
    memory = [one["memory"] for one in answers]
    finite = all(one["finite"] for one in answers)
    print(f"{number} positions: {dict(counts)}, all finite {finite}")
    errors = [one["error"] for one in answers if one.get("error")]
    print(f"memory {memory[number // 2]} at half, {memory[-1]} at the end; errors {errors[:3]}")
    for points in (40, 220, 400):
        found = in_node([(data, own, [[home, points]] * 30)])
        times, on_curve = [one["ms"] for one in found], found[0]["count"]
        print(f"{points} points asked, {on_curve} on the curve: first {times[0]:.1f} ms, ", end="")
        print(f"least {min(times):.1f}, median {np.median(times):.1f} ms")


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:]]
    drives, places, first = (*given, *(200, 10_000, 37)[len(given) :])
    projects(drives, first)
    positions(places, first)
