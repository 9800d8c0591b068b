"""Which verb answers which question, and what it costs: prints the table of docs/command-line.md.

    python benchmarks/verbs.py [--rounds 3]

Each verb answers its question about a CSG-40-50 that turns 1.3 kg m^2. The first call, which may compile, does not
count. The cost is the smallest wall-clock time of the rounds, to one digit: this is the time that a user waits.
"""

import argparse
import math
import time
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import strainwave as sw

RPM, ARCSEC = math.pi / 30.0, math.pi / 648_000.0
AXIS = """
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}, max_torque: 3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 1000 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 100 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
scatter: {load.inertia: 3 %, gear.K1: 5 %, damping.ratio: 10 %}
"""
GEAR = sw.catalogue.gear("CSG-40-50")
DRIVE = GEAR.drive(load_inertia=1.3, motor_inertia=4.5e-4, B=21.6)
ERROR = sw.KinematicError((sw.Line(2, 23.0 * ARCSEC),))
SYSTEM = DRIVE.error_equation(kinematic_error=ERROR, omega=1250.0 * RPM, motor="held")
SMOOTH = SYSTEM._replace(law=GEAR.cubic)
BAND = (100.0, 200.0)
LOOP = sw.train.from_bandwidth(2.0 * math.pi * 30.0, DRIVE.J_m + DRIVE.J_l / DRIVE.N**2, 0.7)
SCATTER = {"law.K": sw.Normal(GEAR.cubic.K, 0.05 * GEAR.cubic.K), "B": sw.Normal(21.6, 2.0)}
GRID = {"B": np.linspace(15.0, 40.0, 100), "omega": np.linspace(*BAND, 100)}


def bench_loop():
    """Torsion and torque of a gear on a bench."""
    rng = np.random.default_rng(0)
    loop = sw.hysteresis_loop(sw.Parallel(GEAR.law, sw.BoucWen(4.5e4, 0.0, 8e-5)), 300.0)
    return loop.torsion + 1e-6 * rng.normal(size=len(loop.torsion)), loop.torque + rng.normal(size=len(loop.torque))


def slow_scan():
    """Angle of the motor and kinematic error over two turns."""
    angle = np.linspace(0.0, 4.0 * math.pi, 1440, endpoint=False)
    return angle, ERROR.value(angle) + ARCSEC * np.random.default_rng(0).normal(size=1440)


def two_runs():
    """Torques with the orders 2 and 4, logged at two constant speeds."""
    runs, rng = [], np.random.default_rng(0)
    for speed in (60.0, 90.0):
        t = np.arange(0.0, 5.0, 1e-3)
        value = np.cos(2.0 * speed * t) + 0.3 * np.cos(4.0 * speed * t) + 0.2 * rng.normal(size=len(t))
        runs.append(sw.Run(t, speed * t, value))
    return runs


def logged(train):
    """Angles of motor and load, logged on a run-up of a drive with other numbers."""
    own = train._replace(B=30.0, law=train.law._replace(K1=1.1e5))
    own = own._replace(omega=1.0, reference=sw.train.SpeedProfile((0.0, 4.0), (100.0, 180.0)))
    t = np.arange(0.0, 4.0, 1e-3)
    y = sw.simulate(own, np.zeros(4), t, method=sw.Dopri5(rtol=1e-8)).y
    motor = own.reference.value(t) + y[2]
    load = motor / own.N - y[0] + 0.5 * ARCSEC * np.random.default_rng(1).standard_normal(len(t))
    return {"time": t, "motor_angle": motor, "load_angle": load}


def questions(folder):
    """Rows: question, verb, command, and what is timed."""
    (path := folder / "axis.yaml").write_text(AXIS, encoding="utf-8")
    project = sw.read_project(path)
    elbow = sw.read_specification(Path(__file__).parent.parent / "examples" / "projects" / "elbow.yaml")
    loop, scan, runs, log = bench_loop(), slow_scan(), two_runs(), logged(project.train)
    counts = np.linspace(0.0, 9.0 * 2**24, 5000)
    omega = np.geomspace(20.0, 1500.0, 80)
    bode = sw.fit.measured_bode(omega, 1.1 * sw.bode(DRIVE.train(), omega).motor * np.exp(-4e-4j * omega))
    measure = sw.EnsembleMeasure((0.0, 0.0), periods=1, settle=40, measures=(sw.Peak(),))
    lanes = {"omega": np.linspace(*BAND, 10_000)}
    train = DRIVE.train(kinematic_error=ERROR, control=LOOP)
    return [
        ("Is the drive all right, and what would help?", "sw.report.write(project, folder)", "analyze",
         lambda: sw.report.write(project, folder / "report")),
        ("Which speeds must I avoid?", "sw.speed_map(project)", "speed-map",
         lambda: sw.speed_map(project, loads=np.linspace(-180.0, 0.0, 5))),
        ("How large is the error at each speed, and where does the drive jump?", "project.response()", "response",
         lambda: project.response()),
        ("How large is it by the error equation alone?", "sw.frequency_response(system, (low, high))", "",
         lambda: sw.frequency_response(SYSTEM, BAND)),
        ("How large is it by a formula in each of the four regimes, and how good is the formula?",
         "sw.slow_flow(system, resonance, order=2).response((low, high))", "",
         lambda: sw.slow_flow(SMOOTH, sw.Resonance(2, 1), order=2).response(BAND)),
        ("How large is the error at one speed?", "sw.find_orbit(system)", "", lambda: sw.find_orbit(SYSTEM)),
        ("How does the error of my drive move at one speed?", "sw.drive_motion(project, omega)", "",
         lambda: sw.drive_motion(project, 140.0)),
        ("How does the error move in time?", "sw.simulate(system, start, time)", "",
         lambda: sw.simulate(SYSTEM, (0.0, 0.0), 2.0)),
        ("Does every motion decay without excitation?", "sw.lyapunov(system)", "", lambda: sw.lyapunov(SYSTEM)),
        ("How does the error equation follow from Lagrange, and the four regimes from it?", "sw.theory.derive()",
         "derive", lambda: sw.theory.derive()),
        ("What does a stiffer law gain at the primary resonance, and cost at the superharmonic?",
         "sw.study.hardening(system, alphas, (low, high))", "",
         lambda: sw.study.hardening(sw.HDC_40_050.error_equation(motor_torque=sw.Harmonic(10.0), omega=385.5),
                                    (0.0, 0.1, 1.0), (100.0, 450.0))),
        ("Where does the drive come to rest after a disturbance?", "sw.basins(system, errors, rates, samples=10_000)",
         "", lambda: sw.basins(SMOOTH, (-4e-3, 4e-3), (-1.2, 1.2), samples=10_000)),
        ("What is the worst error in this move, and when has it settled?", "sw.move(project, profile)", "move",
         lambda: sw.move(project, sw.Trapezoid(0.5 * math.pi, 0.6))),
        ("How fast must I pass the resonance?", "sw.run_up(project, rates)", "",
         lambda: sw.run_up(project, np.geomspace(4.0, 400.0, 10))),
        ("How much does a compensator gain?", "sw.compensate(project, controller, speed=speed)", "compensate",
         lambda: sw.compensate(project, "inverse", speed=150.0)),
        ("Is the motor's loop stable, with which margins?", "sw.margins(train)", "", lambda: sw.margins(train)),
        ("Which gains should the motor's loop have?", "sw.tune(project)", "tune", lambda: sw.tune(project)),
        ("Which gear of the catalogue does my joint need?", "sw.design(specification)", "design",
         lambda: sw.design(elbow)),
        ("How much do drives of one type differ?", "sw.sweep(measure, system, sample).quantile(shares)", "sweep",
         lambda: sw.sweep(measure, SMOOTH, sw.sample.Sobol(1024, SCATTER)).quantile((0.05, 0.5, 0.95))),
        ("How likely does a drive exceed its limit?", "sw.exceedance(project, count=200)", "exceedance",
         lambda: sw.exceedance(project, count=200)),
        ("How do two numbers act together, on 10 000 points?", "sw.sweep(measure, system, grid)", "sweep",
         lambda: sw.sweep(measure, SMOOTH, GRID)),
        ("What do 10 000 variants do in 50 turns?", "sw.ensemble(system, values, start, periods=50)", "",
         lambda: sw.ensemble(SMOOTH, lanes, (0.0, 0.0), periods=50)),
        ("What is the stiffness of my gear, from a loop on a bench?", "sw.fit_loop(torsion, torque)", "fit-loop",
         lambda: sw.fit_loop(*loop)),
        ("What are inertias, stiffness, damping and delay, from a Bode plot?", "sw.fit.fit_bode(measured, project)",
         "fit-bode", lambda: sw.fit.fit_bode(bode, train)),
        ("What are stiffness, damping and error of my drive, from a log?", "sw.identify_log(logs, gear=...)",
         "identify", lambda: sw.identify_log(log, project=project)),
        ("Which orders does my gear's error have, from a slow scan?", "sw.error_scan(angle, error)", "order-scan",
         lambda: sw.error_scan(*scan)),
        ("Which ratio and arrangement does a joint have, from both encoders?", "sw.fit.arrangement(motor, load)", "",
         lambda: sw.fit.arrangement(counts, counts / 51)),
        ("Which orders does a logged torque have, from several speeds?", "sw.order_scan(runs)", "order-scan",
         lambda: sw.order_scan(runs)),
        ("How does the model run on a controller?", 'sw.export(train, "axis.c", to="c")', "export",
         lambda: sw.export(train, folder / "axis.c", to="c", step=1e-4)),
    ]  # fmt: skip


def seconds(task, rounds):
    """Smallest wall-clock time of a task that has run once before."""
    task()
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        task()
        taken.append(time.perf_counter() - start)
    return min(taken)


def shown(time_taken):
    """Seconds to one digit, in s or ms."""
    value, unit = (time_taken, "s") if time_taken >= 0.95 else (1e3 * time_taken, "ms")
    digits = 10.0 ** math.floor(math.log10(value))
    return f"{round(value / digits) * digits:g}\N{NO-BREAK SPACE}{unit}"


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    print("| question | in Python | `strainwave ...` | cost |\n|---|---|---|---|")
    with TemporaryDirectory() as folder, chdir(folder):
        for question, verb, command, task in questions(Path(folder)):
            name = f"`{command}`" if command else ""
            print(f"| {question} | `{verb}` | {name} | {shown(seconds(task, rounds))} |", flush=True)


if __name__ == "__main__":
    main()
