"""Identification: what records tell of a law, a drive, orders and friction."""

from pathlib import Path

import numpy as np

import strainwave as sw

from .drives import ARCSEC, ERROR, EXACT, FITTED

INTERVALS = 1e-4  # widths of intervals: derivatives by differences


AXIS = """
gear: SHG-25-100
motor: {inertia: 4 kg*cm^2, loop: {bandwidth: 60 Hz, damping: 0.7}}
load: {inertia: 1.2 kg*m^2, drag: {type: angle_torque, amplitude: 8 N*m}}
damping: {B: 7 N*m*s/rad}
speed: {from: 70 rad/s, to: 115 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 25 arcsec}]}
"""


def guessed():
    """The drive of which a log is taken, as it is guessed."""
    Path("guessed.yaml").write_text(AXIS, encoding="utf-8")
    return sw.read_project("guessed.yaml")


def loop_record():
    """Torsion and torque of a gear with hysteresis on a bench, with noise."""
    law = sw.Parallel(sw.catalogue.gear("SHG-25-100").law, sw.BoucWen(4.5e4, 0.0, 8e-5))
    loop, rng = sw.hysteresis_loop(law, 110.0), np.random.default_rng(0)
    return loop.torsion[::3] + 1e-6 * rng.normal(size=400), loop.torque[::3] + 0.3 * rng.normal(size=400)


def drive_record(project):
    """Angles of motor and load in a run-up of another drive than the project says."""
    own = project.train._replace(B=4.0, error=sw.KinematicError((sw.Line(2, 40.0 * ARCSEC, 0.4),)))
    run = own._replace(omega=1.0, reference=sw.train.SpeedProfile((0.0, 2.0), (70.0, 115.0)))
    t = np.arange(0.0, 2.0, 2e-3)
    y = sw.simulate(run, np.zeros(len(run.state_names())), t).y
    motor = run.reference.value(t) + y[2]
    load = motor / run.N - y[0] + 0.5 * ARCSEC * np.random.default_rng(1).standard_normal(len(t))
    return {"time": t, "motor_angle": motor, "load_angle": load}


def noisy_run(speed, seed):
    """A torque with two orders and a line of its own frequency, logged at one speed."""
    t = np.arange(0.0, 4.0, 2e-3)
    noise = 0.2 * np.random.default_rng(seed).normal(size=len(t))
    return sw.Run(
        t, speed * t, np.cos(2.0 * speed * t) + 0.3 * np.cos(4.0 * speed * t) + 0.5 * np.cos(77.0 * t) + noise
    )


def scan_record():
    """Angle of the motor, and kinematic error forward and backward, over two turns."""
    angle, rng = np.linspace(0.0, 4.0 * np.pi, 720, endpoint=False), np.random.default_rng(7)
    way = ERROR.value(angle)
    return angle, way + 1.5e-5 + 5e-6 * rng.normal(size=720), way - 1.5e-5 + 5e-6 * rng.normal(size=720)


def fitted(found, names):
    """Values of a fit, with their intervals."""
    return {name: found.value(name) for name in names}, {name: found.interval(name) for name in names}


def fit_loop():
    """The torsion law of a loop."""
    found = sw.fit_loop(*loop_record(), rated_torque=87.0, ratio=100)
    values, intervals = fitted(found, ("K1", "K2", "K3", "T1", "T2"))
    yield "values", [values, found.lost_motion, found.hysteresis_loss], FITTED
    yield "intervals", intervals, INTERVALS
    yield "candidates", [(row.name, row.unknowns, row.chosen) for row in found.comparison], EXACT
    yield "errors", [row.error for row in found.comparison], INTERVALS
    yield "yaml", found.yaml.splitlines()[0] if isinstance(found.yaml, str) else "", EXACT


def identify():
    """Numbers of a system and of a drive from logs; laws compared; what a log cannot tell."""
    t = 0.02 * np.arange(600)
    force = np.cos(2.1 * t) + 0.6 * np.cos(5.3 * t + 1.0)
    held = sw.Oscillator(
        1.0, 0.3, sw.Cubic(9.0, 0.4), sw.Harmonics((sw.Harmonic(1.0, 21), sw.Harmonic(0.6, 53, 1.0))), 0.1
    )
    x = sw.simulate(held, (0.1, 0.0), t).y[0] + 1e-3 * np.random.default_rng(2).standard_normal(len(t))
    log = {"time": t, "input": force, "output": x}
    guess = sw.Oscillator(1.0, 0.5, sw.Cubic(7.0, 0.1), sw.Harmonic(0.0), 1.0)
    names = ("B", "law.K", "law.alpha")
    values, intervals = fitted(sw.identify(guess, log, names, between="linear"), names)
    yield "values", values, FITTED
    yield "intervals", intervals, INTERVALS
    laws = {"cubic": (guess, names), "linear": (guess._replace(law=sw.Linear(7.0)), names[:2])}
    found = sw.fit.compare_laws(laws, log, between="linear")
    yield "compare_laws", [found.names, found.fitted, found.held_out], INTERVALS
    project = guessed()
    one = sw.identify_log(drive_record(project), project=project)
    yield "drive", one.values, FITTED
    yield "drive/intervals", {name: one.interval(name) for name in one.values}, INTERVALS
    table = np.column_stack([np.cos(t), np.sin(t), np.cos(t) + 2.0 * np.sin(t)])
    yield "unidentifiable", sw.fit.unidentifiable(table, ["a", "b", "c"], [1.0, 2.0, 3.0]), EXACT
    left = np.random.default_rng(3).standard_normal(600)
    yield "spread", sw.fit.spread(table[:, :2], left).covariance, 1e-8
    yield "sandwich", sw.fit.sandwich(table[:, :2], left), 1e-8
    yield "bootstrap", sw.fit.bootstrap(table[:, :2], left, block=20, draws=200), 1e-8
    missing = sw.fit.discrepancy(left + 0.5 * table[:, 0] ** 3, table[:, :2], {"x^3": table[:, 0] ** 3}, interval=0.02)
    yield "discrepancy", [missing.flagged, missing.missing["x^3"].coefficient], 1e-8


def order_scan():
    """Orders of a torque at two speeds, and of a slow scan of the error."""
    found = sw.order_scan([noisy_run(60.0, 0), noisy_run(90.0, 1)], highest=10)
    yield "lines", [(line.kind, line.order, line.amplitude, line.interval()) for line in found.lines], FITTED
    yield "residual", found.residual, FITTED
    angle, forward, back = scan_record()
    scan = sw.error_scan(angle, forward, backward=(angle, back))
    yield "error_scan", [scan.lines, scan.reversal, scan.residual, scan.threshold, scan.samples], FITTED
