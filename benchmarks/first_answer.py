"""How long does a first answer take? Processor time of whole processes, one thread, with code on disk and without.

    python benchmarks/first_answer.py [demo] [readme] [twelve] [warm] [law] [orders] [response] [cascade] [curve]

`demo`: `demo` with an empty cache, then with its code on disk what is first: `analyze` of the README's drive, and a
user's law in two processes. `readme`: `analyze` of the README's drive with an empty cache, then again. `twelve`: the
first `analyze` of the twelve project files of the tests, one process each, one cache that is empty at first. `warm`:
`analyze` with all code on disk, of the README's drive and of one with loop, coupling and hysteresis. `law`: a user's
law with two kinks, simulated, in 64 lanes and as a response, with an empty cache, then in a second process. `orders`:
a thousand sets of orders, amplitudes and integers for one kind of drive in one process: functions and memory.
`response`: `strainwave response` and `--help`, and `response` of the elbow without and with hysteresis. `cascade`:
`analyze` of a cascade with filters that this cache has never seen, after one without filters; and its
`Project.response` in one process, warm. `curve`: a Duffing curve, 7 and 15 harmonics.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

HYSTERESIS = "hysteresis: {type: bouc_wen, K: 5e4 N*m/rad, ratio: 0, yield_twist: 0.1 mrad}\n"
ELBOW = """\
gear: SHG-32-100
motor:
  inertia: 4.5 kg*cm^2
  loop: {type: speed, bandwidth: 40 Hz, damping: 1, lag: 0.5 ms}
  drag: {type: coulomb, T_c: 0.10 N*m}
load:
  inertia: 5 kg*m^2
  drag: {type: angle_torque, amplitude: 110 N*m}
damping: {ratio: 2.5 %}
speed: {from: 0 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation:
  kinematic_error:
    - {order: 1, amplitude: 8 arcsec, phase: 40 deg}
    - {order: 2, amplitude: 25 arcsec}
    - {order: 4, amplitude: 5 arcsec, phase: -60 deg}
"""
COUPLED = """\
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}}
load:
  inertia: 1 kg*m^2
  coupling: {inertia: 0.3 kg*m^2, B: 5 N*m*s/rad, law: {type: linear, K: 4e5 N*m/rad}}
damping: {ratio: 3 %}
speed: {from: 1000 rpm, to: 2500 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
hysteresis: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}
"""
CASCADE = """\
gear: CSG-40-50
motor:
  inertia: 4.5 kg*cm^2
  loop: {type: cascade, K_v: 30 1/s, K_p: 0.12 N*m*s/rad, T_n: 16 ms, lag: 0.5 msFILTERS}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 500 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
FILTERS = (
    ", filters: [{type: notch, frequency: 150 Hz, width: 50 Hz, depth: 0.1}, "
    "{type: low_pass, frequency: 600 Hz, damping: 0.7}]"
)
RESPONSES = """
import time, strainwave as sw
project, times = sw.read_project("drive.yaml"), []
for _ in range(40):
    begun = time.thread_time()
    project.response()
    times.append(1e3 * (time.thread_time() - begun))
print(f"{times[0]:.0f} ms, then {min(times):.1f} ms")
"""
LAW = """
import numpy as np, strainwave as sw
from typing import NamedTuple

class Kinked(NamedTuple):
    K: float
    slope: float
    at: float
    def torque(self, x): return self.K * x + 0.5 * self.slope * (abs(x - self.at) - abs(x + self.at))
    def stiffness(self, x): return self.K + 0.5 * self.slope * (np.sign(x - self.at) - np.sign(x + self.at))
    def breakpoints(self): return -self.at, self.at

drive = sw.Oscillator(1.0, 0.05, Kinked(1.0, 0.5, 0.3), sw.Harmonic(0.18), 0.9)
print(sw.simulate(drive, (0.0, 0.0), 200.0).peak())
print(float(sw.ensemble(drive, {"omega": np.linspace(0.6, 1.4, 64)}, (0.0, 0.0), periods=50).peak.max()))
print(sw.frequency_response(drive, (0.5, 1.6)).peak.max())
"""
ORDERS = """
import resource, numpy as np, strainwave as sw
from strainwave.compile import jit
gear = sw.catalogue.gear("CSG-40-50")
drive, random = gear.drive(load_inertia=1.3, motor_inertia=4.5e-4, B=21.6), np.random.default_rng(1)
def answer():
    orders = sorted(random.choice(np.arange(1, 12), 3, replace=False).tolist())
    error = sw.KinematicError(tuple(sw.Line(order, float(random.uniform(1e-6, 1e-4))) for order in orders))
    system = drive.error_equation(kinematic_error=error, omega=130.0, motor="held")
    sw.simulate(system, (0.0, 0.0), 0.05)
    sw.frequency_response(system, (100.0, 110.0), harmonics=24)
answer()
def state(): return len(jit._entries), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
first = state()
for _ in range(1000): answer()
print("functions and MiB after the first:", *first, "; after 1000 more:", *state())
"""


def cpu(arguments: list[str], cache: str, folder: str) -> tuple[float, str]:
    """Processor time [s] of a process, and what it prints."""
    env = os.environ | {"STRAINWAVE_CACHE_DIR": cache, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([sys.executable, *arguments], env=env, cwd=folder, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode:
        sys.exit(f"{arguments} ended with {run.returncode}: {run.stderr[-2000:]}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, run.stdout


def analyze(text: str, cache: str, folder: str) -> float:
    """Processor time [s] of `analyze` of a project file."""
    (Path(folder) / "drive.yaml").write_text(text, encoding="utf-8")
    return cpu(["-m", "strainwave", "analyze", "drive.yaml", "-o", "out"], cache, folder)[0]


def response(text: str, cache: str, folder: str, rounds: int = 5) -> float:
    """Processor time [s] of `response`, the median of some runs after one."""
    (Path(folder) / "drive.yaml").write_text(text, encoding="utf-8")
    command = ["-m", "strainwave", "response", "drive.yaml"]
    return statistics.median([cpu(command, cache, folder)[0] for _ in range(rounds + 1)][1:])


def curve() -> None:
    """Print thread time [ms] of a Duffing curve with 270 points."""
    import strainwave as sw

    system = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
    for harmonics in (7, 15):
        times = []
        for i in range(60):
            begun = time.thread_time()
            branch = sw.frequency_response(system, (0.25, 3.0), harmonics=harmonics, points=205)
            times += [1e3 * (time.thread_time() - begun)] * (i >= 20)
        print(f"{harmonics} harmonics, {len(branch)} points: {statistics.median(times):.2f} ms ({min(times):.2f})")


def main() -> None:
    """Measure what is asked for."""
    every = ("demo", "readme", "twelve", "warm", "law", "orders", "response", "cascade", "curve")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", choices=[*every, []])
    asked = parser.parse_args().what or every
    readme = (ROOT / "benchmarks" / "readme_drive.yaml").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        cache = f"{folder}/cache"
        if "demo" in asked:
            print(f"demo, cold: {cpu(['-m', 'strainwave', 'demo'], f'{folder}/demo', folder)[0]:.1f} s")
            print(f"README's drive after it: {analyze(readme, f'{folder}/demo', folder):.1f} s")
            print(
                "a user's law after it:", *(f"{cpu(['-c', LAW], f'{folder}/demo', folder)[0]:.1f} s" for _ in range(2))
            )
        if "readme" in asked:
            print("README's drive, cold and again:", *(f"{analyze(readme, cache, folder):.1f} s" for _ in range(2)))
        if "twelve" in asked:
            from twelve_projects import PROJECTS

            times = [analyze(text, f"{folder}/twelve", folder) for text in PROJECTS.values()]
            print(f"twelve files: {sum(times):.1f} s, each {' '.join(f'{time:.1f}' for time in times)}")
        if "warm" in asked:
            for name, text in (("README's drive", readme), ("loop, coupling and hysteresis", COUPLED)):
                times = [analyze(text, cache, folder) for _ in range(4)]
                print(f"{name}, warm: {statistics.median(times[1:]):.2f} s (first {times[0]:.1f})")
        if "law" in asked:
            print("a user's law:", *(f"{cpu(['-c', LAW], f'{folder}/law', folder)[0]:.1f} s" for _ in range(2)))
        if "orders" in asked:
            print(cpu(["-c", ORDERS], cache, folder)[1].strip())
        if "response" in asked:
            for name, text in (("README's", readme), ("elbow", ELBOW), ("elbow with hysteresis", ELBOW + HYSTERESIS)):
                print(f"response, {name}: {response(text, cache, folder):.2f} s")
            helps = statistics.median(cpu(["-m", "strainwave", "--help"], cache, folder)[0] for _ in range(9))
            print(f"--help: {1e3 * helps:.0f} ms")
        if "cascade" in asked:
            texts = [CASCADE.replace("FILTERS", filters) for filters in ("", FILTERS, FILTERS)]
            print("a cascade, one with filters, again:", *(f"{analyze(text, cache, folder):.1f} s" for text in texts))
            print("Project.response with filters:", cpu(["-c", RESPONSES], cache, folder)[1].strip())
        if "curve" in asked:
            curve()


if __name__ == "__main__":
    main()
