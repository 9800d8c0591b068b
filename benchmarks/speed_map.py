"""Speed map: how long it takes, and its bands against brute force.

The map is that of a CSG-40-50 with a kinematic error of six orders: 2000 speeds, 20 load torques. CPU time of all
threads and wall time, compiled code warm, the machine quiet.

The check draws drives at random (ratio, stiffness, mean torque, damping, orders and phases of the kinematic error, a
loop for every third one) and a limit for each, and points of speed and load. At every point 16 starts of its own are
integrated until their transients have died, with the ensemble integrator; the largest oscillation of what they reach
says whether the point is safe. Points within 0.5 % of an edge of a band are left out. A speed is unsafe where any
start reaches an oscillation above the limit. A motion that few states lead to, as the far end of a high branch, is
stable and forbids its speed: where no start reaches it, the point counts as safe and called unsafe.

With `--postures 200` the loads are so many postures of an arm of two links, and 300 points of these are checked.

    python benchmarks/speed_map.py [--rounds 3] [--drives 10] [--points 30] [--postures 0]
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

import strainwave as sw
from strainwave.model.train.train_forms import AtLoad

EDGE = 0.005  # relative distance from an edge below which a point is left out
STARTS, DECAY = 16, 12.0  # at a point; transients die by exp(-12)
ORDERS = (1, 2, 4, 6, 8, 12)
SIX = ((1, 10.0), (2, 23.0), (4, 5.0), (6, 3.0), (8, 2.0), (12, 1.0))
PROJECT = """
gear: {gear}
motor: {motor}
load: {{inertia: {inertia} kg*m^2}}
damping: {{ratio: {damping}}}
speed: {{from: {low} rad/s, to: {high} rad/s, shaft: motor}}
excitation:
  kinematic_error:
{lines}
"""
LINE = "    - {{order: {}, amplitude: {} arcsec, phase: {} rad}}\n"


def project(folder: str, **values: object) -> sw.Project:
    """Read a project of these values."""
    path = Path(folder, "drive.yaml")
    path.write_text(PROJECT.format(**values))
    return sw.read_project(path)


def timed(rounds: int) -> dict[str, float]:
    """Print and return times [s] of the map with twenty loads and with one."""
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        lines = "".join(LINE.format(k, a, 0) for k, a in SIX)
        drive = project(
            folder, gear="CSG-40-50", motor="{mode: held}", inertia=1.3, damping="3 %", low=50, high=420, lines=lines
        )
        for loads in (np.linspace(-190.0, 0.0, 20), np.array([-100.0])):
            wall, cpu = [], []
            for _ in range(rounds + 1):
                begun, used = time.perf_counter(), time.process_time()
                found = sw.speed_map(drive, speeds=np.linspace(50.0, 420.0, 2000), loads=loads, limit=3e-4)
                wall.append(time.perf_counter() - begun)
                cpu.append(time.process_time() - used)
            figures[f"wall_{len(loads)}"] = statistics.median(wall[1:])
            figures[f"cpu_{len(loads)}"] = statistics.median(cpu[1:])
            print(
                f"{found.oscillation.size} cells, {len(loads)} loads, {len(ORDERS)} orders: wall "
                f"{figures[f'wall_{len(loads)}']:.2f} s, CPU {figures[f'cpu_{len(loads)}']:.2f} s"
            )
    return figures


def random_drive(folder: str, rng: np.random.Generator, number: int) -> tuple[sw.Project, np.ndarray]:
    """A random drive and loads [N*m] for it."""
    gear = sw.catalogue.gear(rng.choice(["CSG-40-50", "CSG-25-100", "CSG-20-80", "CSG-32-50", "SHG-25-100"]))
    stiffness = gear.law.K1
    natural = rng.uniform(80.0, 400.0)
    inertia = stiffness / natural**2
    chosen = rng.choice(ORDERS, rng.integers(1, 4), replace=False)
    chosen = np.union1d(chosen, [2])
    lines = "".join(LINE.format(k, rng.uniform(8.0, 40.0) / k**0.7, rng.uniform(0.0, 6.28)) for k in chosen)
    law = gear.name
    if number % 2:  # a smooth law, harder than the catalogue's
        alpha = rng.uniform(2e4, 3e5)
        law = f"{{ratio: {gear.ratio}, law: {{type: cubic, K: {stiffness} N*m/rad, alpha: {alpha} 1/rad^2}}}}"
    J_m = gear.input_inertia * 3.0
    motor = f"{{inertia: {J_m} kg*m^2, mode: held}}"
    if number % 3 == 2:
        motor = f"{{inertia: {J_m} kg*m^2, loop: {{bandwidth: {natural / 12.0:.3f} Hz, damping: 0.7}}}}"
    own = project(
        folder, gear=law, motor=motor, inertia=inertia, damping=rng.uniform(0.004, 0.04), low=0.12 * natural,
        high=1.3 * natural, lines=lines,
    )  # fmt: skip
    return own, np.sort(rng.uniform(-1.0, 0.2, 3)) * gear.rated_torque


def largest(system: object, omega: np.ndarray, x0: float, reach: float, rng: np.random.Generator) -> np.ndarray:
    """Largest oscillation (n,) [rad] that 16 random starts reach at each of the speeds (n,) [rad/s]."""
    train = None if isinstance(system, sw.Oscillator) else system.train
    inertia, damping = (system.J, system.B) if train is None else (train.load.J, train.B)
    settle = int(np.clip(np.ceil(DECAY * 2.0 * inertia / damping * np.max(omega) / (2.0 * np.pi)), 60, 6000))
    count = STARTS * len(omega)
    size, angle = reach * 10.0 ** rng.uniform(-1.5, 0.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    secant = (system.law.torque(x0 + size) - system.law.torque(x0 - size)) / (2.0 * size)
    states = [x0 + size * np.cos(angle), size * np.sin(angle) * np.sqrt(secant / inertia)]
    states += [np.zeros(count)] * (0 if train is None else len(train.state_names()) - 2)
    found = sw.ensemble(
        system, {"omega": np.repeat(omega, STARTS)}, states, periods=24, settle=settle,
        measures=(sw.numerics.Extremes(), sw.numerics.Mean()), method=sw.Dopri5(rtol=1e-7, atol=1e-11), threads=2,
    )  # fmt: skip
    assert np.all(found["status"] == 0)
    high, low, mean = (found[name].values for name in ("highest", "lowest", "mean"))
    return np.max(np.maximum(high - mean, mean - low).reshape(-1, STARTS), axis=1)


def check_drive(folder: str, rng: np.random.Generator, number: int, points: int) -> dict[str, int]:
    """Print and return how often map and brute force differ for one drive."""
    counts = dict.fromkeys(("safe", "unsafe", "called safe", "called unsafe", "at an edge"), 0)
    drive, loads = random_drive(folder, rng, number)
    slow = sw.speed_map(drive, loads=loads, search=False).quasi_static.max()
    limit = slow * rng.uniform(1.2, 4.0)
    begun = time.process_time()
    found = sw.speed_map(drive, loads=loads, limit=limit)
    took = time.process_time() - begun
    which, every, wrong = rng.integers(len(loads), size=points), rng.uniform(*drive.speeds.limits, points), []
    for i, load in enumerate(loads.tolist()):
        edges = np.append(found.forbidden[i].ravel(), np.inf)
        near = np.min(np.abs(edges / every[:, None] - 1.0), axis=1) < EDGE
        counts["at an edge"] += int(np.sum(near & (which == i)))
        omega = every[~near & (which == i)]
        under = drive.under(load)
        equation = under.system(1.0, reduced=True)
        system = equation if under.train is None else AtLoad(under.train, 1.0)
        if not len(omega):
            continue
        sizes = largest(system, omega, found_equilibrium(equation), 20.0 * limit, rng)
        for w, size in zip(omega.tolist(), sizes.tolist(), strict=True):
            safe, allowed = size <= limit, found.is_allowed(w, load)
            counts["safe" if safe else "unsafe"] += 1
            if safe != allowed:
                counts["called unsafe" if safe else "called safe"] += 1
                wrong.append((round(w, 3), round(load, 2), round(size / limit, 3)))
    print(f"drive {number}: {drive}\n  map {took:.1f} s CPU; {found.motions.max()} motions; {counts}; differ: {wrong}")
    return counts


def checked(drives: range, points: int, seed: int = 3) -> dict[str, int]:
    """Print and return how often map and brute force differ."""
    with tempfile.TemporaryDirectory() as folder:
        each = [check_drive(folder, np.random.default_rng([seed, i]), i, points) for i in drives]
    counts = {name: sum(one[name] for one in each) for name in each[0]}
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    return counts


ARM = """
gear: CSG-40-50
motor: {inertia: 6 kg*cm^2, loop: {type: cascade, K_v: 30 1/s, K_p: 0.12 N*m*s/rad, T_n: 16 ms}}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 4 %}
speed: {from: 400 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}, {order: 4, amplitude: 5 arcsec, phase: 40 deg}]}
"""


def postures(count: int, points: int = 300, seed: int = 5) -> dict[str, int]:
    """Print and return how often the map of an arm's postures and brute force differ, and the map's time."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "arm.yaml")
        path.write_text(ARM)
        drive = sw.read_project(path)
    links = sw.study.Link.rod(5.0, 0.4), sw.study.Link.rod(3.0, 0.35)
    rows = sw.study.two_link(*links, rng.uniform(-np.pi, np.pi, (count, 2)), payload=1.5)
    limit = 1.3 * float(sw.speed_map(drive, postures=rows[:3], search=False).quasi_static.max())
    for _ in range(2):
        begun = time.process_time()
        found = sw.speed_map(drive, postures=rows, limit=limit)
        print(f"{count} postures: {time.process_time() - begun:.1f} s CPU")
    counts = dict.fromkeys(("safe", "unsafe", "called safe", "called unsafe", "at an edge"), 0)
    which, every = rng.integers(count, size=points), rng.uniform(*drive.speeds.limits, points)
    for i in np.unique(which).tolist():
        edges = np.append(found.forbidden[i].ravel(), np.inf)
        near = np.min(np.abs(edges / every[:, None] - 1.0), axis=1) < EDGE
        counts["at an edge"] += int(np.sum(near & (which == i)))
        omega = every[~near & (which == i)]
        if not len(omega):
            continue
        under = rows[i].on(drive)
        sizes = largest(AtLoad(under.train, 1.0), omega, found_equilibrium(under.system(1.0, reduced=True)), limit, rng)
        for w, size in zip(omega.tolist(), sizes.tolist(), strict=True):
            safe, allowed = size <= limit, found.is_allowed(w, i + 1)
            counts["safe" if safe else "unsafe"] += 1
            if safe != allowed:
                counts["called unsafe" if safe else "called safe"] += 1
                print(f"  differs: posture {i + 1}, {w:.4g} rad/s, {size / limit:.4g} of the limit")
    print(", ".join(f"{name} {number}" for name, number in counts.items()))
    return counts


def found_equilibrium(equation: sw.Oscillator) -> float:
    """Error [rad] at which the law carries the mean torque, by bisection."""
    angles = 2.0 * np.pi * np.arange(64) / 64
    mean = float(np.mean(equation.excitation.torque(angles) + 0.0 * angles))
    low, high = -1.0, 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if equation.law.torque(middle) < mean else (low, middle)
    return 0.5 * (low + high)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--drives", type=int, default=10)
    parser.add_argument("--points", type=int, default=30)
    parser.add_argument("--postures", type=int, default=0)
    given = parser.parse_args()
    if given.postures:
        postures(given.postures)
        raise SystemExit
    timed(given.rounds)
    checked(range(given.drives), given.points)
