"""Drives of every kind that the ledger asks, and the errors that its numbers may have."""

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import strainwave as sw

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from twelve_projects import PROJECTS

EXACT = 0.0  # labels, verdicts, and ensembles, which are the same to the bit
CLOSED = 1e-9  # closed forms, and harmonic balance at its solution
INTEGRATED = 1e-8  # ten times the usual relative tolerance of the integration, 1e-9
FITTED = 1e-6  # least squares stop where a step gains less than about 1e-8 of the sum

ARCSEC = np.pi / 648_000.0
ERROR = sw.KinematicError((sw.Line(2, 23.0 * ARCSEC, 0.3), sw.Line(4, 3.0 * ARCSEC)))
GEAR = sw.catalogue.gear("CSG-40-50")
DRIVE = GEAR.drive(load_inertia=1.3, motor_inertia=4.5e-4, B=21.6)
LOOP = sw.train.from_bandwidth(60.0 * np.pi, DRIVE.J_m + DRIVE.J_l / DRIVE.N**2, 0.7)
BOUC_WEN = sw.Parallel(GEAR.law, sw.BoucWen(6e4, 0.0, 8e-5))

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.2)
BIASED = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0, mean=0.6), 1.0)
SYSTEMS = {
    "cubic": DUFFING,
    "biased": BIASED,
    "softening": sw.Oscillator(1.0, 0.1, sw.Cubic(2.0, -0.1), sw.Harmonic(0.3), 1.1),
    "polynomial": sw.Oscillator(0.7, 0.1, sw.Polynomial((0.0, 1.0, -0.2, 0.5)), sw.Harmonic(0.2, 2, 0.4, 0.1), 0.9),
    "piecewise": sw.Oscillator(1.3, 21.6, GEAR.law, sw.Harmonic(0.0), 130.0, ERROR),
    "rounded": sw.Oscillator(1.3, 21.6, GEAR.rounded(1e-4), sw.Harmonic(30.0, mean=40.0), 130.0, ERROR),
    "backlash": sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.5), sw.Harmonic(0.6), 0.8),
    "play": sw.Oscillator(1.0, 0.1, sw.Play(0.1, sw.Cubic(1.0, 0.1)), sw.Harmonic(0.3), 1.1),
    "Bouc-Wen": sw.Oscillator(1.3, 10.0, BOUC_WEN, sw.Harmonic(20.0), 250.0),
    "Coulomb": sw.Oscillator(
        1.0, 0.05, sw.Parallel(sw.Cubic(1.0, 0.1), sw.laws.Coulomb(0.02, 0.05)), sw.Harmonic(0.3), 1.1
    ),
    "LuGre": sw.Oscillator(
        1.0, 0.05, sw.Parallel(sw.Cubic(1.0, 0.1), sw.laws.LuGre(3.0, 0.1, 0.1, 0.03, 0.05, 0.3)), sw.Harmonic(0.3), 1.1
    ),
    "varying": sw.gears.VaryingOscillator(
        1.3,
        sw.gears.GearDamping(10.8, sw.gears.Variation((sw.gears.Ripple(2, 0.3),)), 5.0, fast=0.6, v_fast=0.2),
        GEAR.cubic,
        sw.Harmonic(0.0),
        150.0,
        ERROR,
        sw.gears.Variation((sw.gears.Ripple(1, 0.02), sw.gears.Ripple(2, 0.05))),
    ),
}


AXIS_FILE = """
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}, max_torque: 3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 1000 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 100 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
scatter: {load.inertia: 3 %, gear.K1: 5 %, damping.ratio: 10 %}
"""


def answer(ask: Callable[[], Any]) -> Any:
    """What a verb returns, or the sentence with which it refuses."""
    try:
        return ask()
    except (ValueError, TypeError, sw.SolveError) as refusal:
        return f"refused: {refusal}"


@cache
def projects() -> dict[str, sw.Project]:
    """The twelve projects by name, written into the folder where the ledger works."""
    found = {}
    for i, (name, text) in enumerate(PROJECTS.items()):
        path = Path(f"project-{i}.yaml")
        path.write_text(text, encoding="utf-8")
        found[name] = sw.read_project(path)
    return found


def trains() -> dict[str, sw.DriveTrain]:
    """Whole trains: of the projects, and with friction, cogging and a sampled loop in place of those of a file."""
    found = {name: project.whole for name, project in projects().items() if project.whole is not None}
    rough = DRIVE._replace(law=GEAR.cubic).train(
        control=sw.train.SpeedLoop(0.5, 20.0), kinematic_error=ERROR, motor_drag=sw.laws.Viscous(2e-4), omega=150.0
    )
    return found | {"speed loop, viscous": rough}
