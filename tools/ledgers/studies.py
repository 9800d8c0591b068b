"""Studies: trains, moves, compensation, speed maps, design, sweeps, spread, the gear."""

import math
from pathlib import Path

import numpy as np

import strainwave as sw

from .drives import (
    AXIS_FILE,
    BOUC_WEN,
    CLOSED,
    DRIVE,
    DUFFING,
    ERROR,
    EXACT,
    FITTED,
    GEAR,
    INTEGRATED,
    LOOP,
    SYSTEMS,
    answer,
    projects,
    trains,
)  # fmt: skip

SEARCHED = 1e-6  # an extreme over a curve, whose place is known as the square root of the error of its size
ARCMIN = math.pi / 10_800.0
SAMPLING = sw.controllers.Sampling(250e-6, 250e-6, limit=3.0)
AXIS = DRIVE.train(kinematic_error=ERROR, control=LOOP, omega=130.0)
MOVES = {
    "trapezoid": sw.Trapezoid(0.3, 0.4), "S-curve": sw.SCurve(-0.3, speed=2.0, acceleration=10.0, jerk=500.0),
    "points": sw.AngleProfile((0.0, 0.1, 0.2, 0.3, 0.4, 0.5), (0.0, 0.02, 0.1, 0.1, 0.1, 0.1)),
    "cycle": [sw.Trapezoid(0.2, 0.3), sw.study.Dwell(0.1), sw.Trapezoid(-0.2, speed=1.0, acceleration=9.0)],
}  # fmt: skip


def bode_numbers(train):
    """Sizes of a linear response, and of the poles."""
    found = sw.bode(train, [20.0, 200.0, 420.0], source="load")
    return [abs(found.motor), abs(found.load), np.sort(abs(found.poles))]


def margin_numbers(train):
    """Margins of the motor's loop."""
    found = sw.margins(train)
    return [found.gain_margin, found.phase_margin, found.delay_margin, found.stable]


def pole_numbers(train):
    """Poles about standstill, whose matrices have derivatives by differences."""
    found = sw.state_space(train)
    return [np.sort(abs(found.poles)), found.stable]


def compensated(name):
    """What one controller leaves, and its words."""
    found = sw.compensate(AXIS, name, speed=120.0, sampling=SAMPLING, robust=name == "inverse")
    values = [found.before, found.after, found.torque, found.gear_torque, found.amplitude_after, found.robustness]
    return [values, found.stable, found.gains, found.condition, found.warnings]


def predicted(project):
    """Jumps of a prediction, and what it says in the middle of its range."""
    table = sw.prediction_table(project)
    return [table.orders, table.jumps_up, table.jumps_down, table.at(0.5 * (table.omega.min() + table.omega.max()), 1)]


def mapped(project):
    """Bands, lines, cells and words of a map."""
    found = sw.speed_map(project, loads=[-60.0, 0.0], limit=3e-4, search=project.train is None)
    bands = [found.forbidden, found.windows, found.jumps, found.quasi_static, found.lines, found.vendor]
    return [bands, found.oscillation, found.torque, found.remarks, found.vendor_sentence, int(found.motions.sum())]


def scattering():
    """An axis whose numbers scatter from drive to drive."""
    Path("scattering.yaml").write_text(AXIS_FILE, encoding="utf-8")
    return sw.read_project("scattering.yaml")


def linear():
    """Bode plots, margins, matrices and operating points of every train."""
    for name, train in trains().items():
        for verb in (bode_numbers, margin_numbers, pole_numbers):
            yield f"{name}/{verb.__name__}", answer(lambda verb=verb, train=train: verb(train)), SEARCHED
        yield f"{name}/operating_state", sw.study.operating_state(train, 150.0), 1e-8
    large = sw.bode(AXIS, [300.0, 420.0], amplitude=1.0)
    yield "bode/large", [abs(large.motor), abs(large.load)], SEARCHED


def drive_run():
    """Trains in time with their energies."""
    ramp = sw.train.SpeedProfile((0.0, 0.5), (100.0, 200.0))
    for name, train in {
        "held": DRIVE.train(control=sw.train.Held(), kinematic_error=ERROR, reference=ramp),
        "loop": AXIS._replace(omega=1.0, reference=ramp),
        "Bouc-Wen": AXIS._replace(omega=1.0, reference=ramp, law=BOUC_WEN),
    }.items():
        run = sw.drive_run(train, t=np.linspace(0.0, 0.5, 6), gear=GEAR)
        yield name, [run.largest(), run.lost(), run.efficiency, run.findings, run.warnings], INTEGRATED
        yield f"{name}/ripple", [run.pointing, run.torque], INTEGRATED


def run_up():
    """Largest errors of run-ups and run-downs."""
    slow, fast = [5e-3, 5e-2], [20.0, 200.0]
    for name, system, rates, speeds in (
        ("jump", DUFFING, slow, None),
        ("backlash", SYSTEMS["backlash"], slow, (0.3, 1.5)),
        ("Bouc-Wen", SYSTEMS["Bouc-Wen"], fast, None),
        ("varying", SYSTEMS["varying"], fast, (100.0, 200.0)),
        ("loop", AXIS, fast, (100.0, 200.0)),
        ("project", scattering(), fast, None),
    ):
        found = sw.run_up(system, rates, speeds=speeds)
        yield f"{name}/largest", found.largest, INTEGRATED
        yield f"{name}/at", found.at, 1e-2  # the sample before the largest error


def move():
    """Moves of the load."""
    limits = sw.MotorLimits(3.0, 600.0)
    payload = sw.Payload(2.0, 0.4)
    for name, profile in MOVES.items():
        found = sw.move(AXIS, profile, gear=GEAR, payload=payload, limits=limits, window=3e-4, bands=[(20.0, 60.0)])
        skipped = ("imbalance", "time", "life")
        yield name, {k: v for k, v in vars(found).items() if k not in skipped}, INTEGRATED
        yield f"{name}/life", found.life, INTEGRATED


def compensate():
    """Every controller in closed loop, and predictions."""
    for name in sw.study.COMPENSATORS:
        yield name, answer(lambda name=name: compensated(name)), 1e-5  # what is left is a small difference
    units = sw.compensate(AXIS, "inverse", speed=120.0, sampling=SAMPLING, robust=False, units=16).units
    yield "units", [units.stiffness, units.amplitude, units.unstable], EXACT
    bench = sw.study.compensation_bench(AXIS, ["inverse", "adaptive"], speeds=[60.0, 130.0], sampling=SAMPLING)
    yield "bench", [bench.reduction, [one.before.rms for one in bench.results[0]]], 1e-5
    for name in ("article", "two couplings, gravity", "catalogue gear, motor not named"):
        yield f"prediction/{name}", answer(lambda name=name: predicted(projects()[name])), SEARCHED


def speed_map():
    """Speeds that are allowed, of projects with loads, an elastic load, and units that scatter."""
    for name in ("antenna", "loop by bandwidth, payload", "position loop, coupling", "backlash"):
        yield name, answer(lambda name=name: mapped(projects()[name])), SEARCHED


def design():
    """Gears and motors for a joint."""
    elbow = sw.Specification(
        load_inertias=(0.8, 1.3),
        speeds=(0.5, 3.0),
        limit=4e-4,
        rotor_inertias=(5e-5, 5e-4),
        damping_ratio=0.03,
        mean_torque=40.0,
        peak_torque=60.0,
        life=10_000.0,
        loop=sw.train.Tuning(190.0),
        largest_size=32,
        ratios=(50, 100),
    )
    found = sw.design(elbow)
    yield "feasible", found.feasible[:6], SEARCHED
    yield "words", [len(found.feasible), len(found.pareto), found.rejected, found.nearest, found.remarks], EXACT
    yield "sensitivities", found.sensitivities, 1e-4  # differences of two responses
    yield "text", sw.design_text(elbow, found.feasible[0]) if found.feasible else "", EXACT


def sweep():
    """Sweeps over a grid, a sample and a project."""

    def orbit(system):
        found = sw.find_orbit(system, harmonics=7)
        return {"peak": found.peak, "stable": found.stable}

    grid = {"law.alpha": [0.02, 0.1], "omega": np.linspace(0.5, 2.0, 4)}
    yield "grid", sw.sweep(orbit, DUFFING._replace(B=0.2), grid), CLOSED
    measure = sw.EnsembleMeasure((0.0, 0.0), periods=4, settle=60, measures=(sw.Peak(), sw.Rms()))
    for name, kind in (("Sobol", sw.sample.Sobol), ("Latin", sw.sample.LatinHypercube)):
        sample = kind(16, {"law.alpha": sw.Normal(0.05, 0.005), "B": sw.sample.LogUniform(0.08, 0.12)})
        yield name, sw.sweep(measure, DUFFING, sample), EXACT
    table = sw.sweep(
        sw.sample.largest, projects()["position loop, coupling"], {"load.inertia": ["1 kg*m^2", "1.2 kg*m^2"]}
    )
    yield "project", {name: table[name].values for name in table if table[name].dtype.kind in "fib"}, SEARCHED


def variants():
    """How probably a drive of a type exceeds its limit; a project with another number, and beside itself."""
    likely = sw.exceedance(scattering(), count=32)
    yield "exceedance", [likely.probability, likely.interval, likely.exceeding, likely.failed], EXACT
    yield "exceedance/numbers", [likely.oscillation, likely.at, likely.ranking], SEARCHED
    text = projects()["position loop, coupling"]
    varied = sw.replaced(text, {"load.inertia": "1.1 kg*m^2"})
    yield "replaced", [varied.J, varied.omega_0, varied.text], CLOSED
    compared = sw.compare([text, varied])
    yield "compare_projects", {k: v for k, (_, v, _) in compared.variables().items()}, SEARCHED


def gear():
    """Hysteresis, efficiency, energy, error parts, budgets."""
    loop = sw.hysteresis_loop(BOUC_WEN, 110.0)
    yield "hysteresis_loop", [loop.loss, loop.middle, loop.torsion.max()], INTEGRATED
    yield "lost_motion", sw.study.lost_motion(BOUC_WEN, 178.0), INTEGRATED
    fit = sw.fit.fit_hysteresis(GEAR.law, 0.5 * ARCMIN, lost_motion=0.3 * ARCMIN, rated_torque=178.0)
    yield "fit_hysteresis", [fit.loss, fit.lost_motion, fit.law], FITTED
    real = sw.catalogue.gear("RT1-H-CS-25-100")
    rigid = sw.Drive(2e-4, 1.0, 100.0, 30.0, sw.Linear(4e4))
    lossy = rigid.train(control=sw.train.Held(), friction=real.friction, motor_drag=real.drag, omega=209.4)
    yield "efficiency", sw.study.efficiency(lossy, torque=[10.0, 40.0, 87.0], speed=[50.0, 209.4]), 1e-8
    for name in ("Bouc-Wen", "Coulomb", "cubic"):
        found = sw.study.energy_balance(SYSTEMS[name], sw.find_orbit(SYSTEMS[name]))
        yield f"energy_balance/{name}", [found.work, found.losses], INTEGRATED
    loaded = DRIVE.error_equation(
        load_torque=sw.Harmonic(0.0, mean=-100.0), kinematic_error=ERROR, omega=60.0, motor="held"
    )
    parts = sw.study.error_parts(loaded)
    yield "error_parts", [parts.ate, parts.wind_up], 1e-8
