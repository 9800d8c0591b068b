"""One response curve with stability: strainwave against AUTO-07p, a family of curves, and a curve from a cold process.

x'' + 0.1 x' + x + 0.05 x^3 = cos(omega t), omega from 3.0 down to 0.25. AUTO runs its Fortran equations with analytic
Jacobians (`auto/duffing.f90`, `auto/c.duffing`: NTST 20, DSMAX 0.05) as a child process; its CPU time less that of a
run of one step counts. Ours is thread CPU time of the library's own call, compiled code warm, at equal number of
points. Contenders take turns; medians. The process is cold, its byte code is there as after an installation.

Needs the Debian packages auto-07p and gfortran for the comparison; without them only our own figures are printed.

    python benchmarks/response.py [--rounds 9]
"""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import strainwave as sw

HERE = Path(__file__).parent / "auto"
SPAN = (0.25, 3.0)
SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
COLD = (
    "import strainwave as sw; b = sw.frequency_response(sw.Oscillator(1, .1, sw.Cubic(1, .05), sw.Harmonic(1), 1), "
    "(.25, 3.), harmonics=7); print(len(b), [f.omega for f in b.folds])"
)


def child_cpu(command: list[str], stdin: str, folder: str, env: dict[str, str]) -> float:
    """CPU time [s] of a child process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, input=stdin, cwd=folder, env=env, text=True, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def build_auto(folder: str) -> list[str] | None:
    """Compile AUTO's executable for the benchmark equations; None if AUTO or the compiler is missing."""
    objects = sorted(str(p) for p in Path("/usr/lib/auto-07p/lib").glob("*.o"))
    if not objects or not shutil.which("gfortran"):
        return None
    command = ["gfortran", "-O3", "-march=native", "-std=legacy", "-fopenmp", str(HERE / "duffing.f90")]
    subprocess.run([*command, "-o", "duffing", *objects], cwd=folder, check=True, capture_output=True)
    return ["./duffing"]


def own(harmonics: int, points: int) -> tuple[float, sw.Branch]:
    """Thread CPU time [s] of one curve, and the curve."""
    start = time.thread_time()
    branch = sw.frequency_response(SYSTEM, SPAN, harmonics=harmonics, points=points)
    return time.thread_time() - start, branch


def points_for(wanted: int, harmonics: int) -> int:
    """Setting of `points` that places at least the wanted number on the curve."""
    points = wanted // 2
    while len(own(harmonics, points)[1]) < wanted:
        points += 4
    return points


def main(rounds: int = 9) -> dict[str, float]:
    """Print the table and return the figures."""
    figures: dict[str, float] = {}
    env = os.environ | {"OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        # An installed package has its byte code, which a checkout need not have: the first, unmeasured run makes it.
        installed = dict(os.environ) | {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        child_cpu([sys.executable, "-c", COLD], "", folder, installed)
        auto = build_auto(folder)
        constants = (HERE / "c.duffing").read_text()
        empty = constants.replace("NMX= 5000", "NMX= 1")
        count, times = 367, {"AUTO": [], 7: [], 15: [], "cold": [], "empty": []}
        if auto:
            shown = subprocess.run(
                auto, input=constants, cwd=folder, env=env, text=True, check=True, capture_output=True
            )
            count = max(int(line.split()[1]) for line in shown.stdout.splitlines() if line.startswith("   1 "))
        settings = {h: points_for(count, h) for h in (7, 15)}
        for _ in range(rounds):
            if auto:
                times["AUTO"].append(child_cpu(auto, constants, folder, env))
                times["empty"].append(child_cpu(auto, empty, folder, env))
            for h in (7, 15):
                times[h].append(own(h, settings[h])[0])
            times["cold"].append(child_cpu([sys.executable, "-c", COLD], "", folder, installed))
    if auto:
        figures["auto"] = statistics.median(times["AUTO"]) - statistics.median(times["empty"])
        figures["auto_whole"] = statistics.median(times["AUTO"])
        whole = 1e3 * figures["auto_whole"]
        print(f"AUTO-07p, {count} points: {1e3 * figures['auto']:.1f} ms (whole process {whole:.1f} ms)")
    for h in (7, 15):
        figures[f"own_{h}"] = statistics.median(times[h])
        branch = own(h, settings[h])[1]
        ratio = f", {figures['auto'] / figures[f'own_{h}']:.1f} times faster than AUTO" if auto else ""
        folds = ", ".join(f"{f.omega:.7f}" for f in branch.folds)
        speed = f"{1e3 * figures[f'own_{h}']:.2f} ms{ratio}"
        print(f"strainwave, {h} harmonics, {len(branch)} points: {speed}; folds {folds}")
    figures["cold"] = statistics.median(times["cold"])
    ratio = f", {figures['cold'] / figures['auto_whole']:.2f} times AUTO's executable" if auto else ""
    print(f"one curve from a cold process: {1e3 * figures['cold']:.0f} ms CPU{ratio}")
    figures["family"] = family(rounds)
    print(f"a family of curves, 7 harmonics, 250 points, one core: {figures['family']:.0f} curves/s")
    return figures


def family(rounds: int) -> float:
    """Curves per second and core for a family over the hardening, at 250 points each or more."""
    points = points_for(250, 7)
    alphas = np.linspace(0.04, 0.06, 40)
    rates = []
    for _ in range(rounds):
        start = time.thread_time()
        branches = sw.numerics.response_family(
            SYSTEM, SPAN, {"law.alpha": alphas}, harmonics=7, points=points, threads=1
        )
        rates.append(len(branches) / (time.thread_time() - start))
    return statistics.median(rates)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    main(parser.parse_args().rounds)
