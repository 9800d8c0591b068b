"""Gains of `sw.tune` on ten drives: against every step of one or two gains, the rule, and differential evolution.

    python benchmarks/tune.py [--drives 0 1 ...] [--evolution SEED ...] [--unasked]

Steps and goals are computed here anew: the goal from `Project.response` under each load, the peak sensitivity from the
open loop of `strainwave.drive.loops.margins`. Differential evolution has ten times as many nonlinear responses as
`tune`.
Unasked, without goals: compliance, settling after a torque and settling of a move, recommended over those of the file,
of twelve drives, from the linear train and from `move`.
"""

import argparse
from dataclasses import replace
from itertools import combinations, product
from math import inf
from pathlib import Path
from time import process_time

import numpy as np
from scipy.optimize import differential_evolution

import strainwave as sw
from strainwave.drive.loops.margins import HALF_WIDTHS, MotorLoop
from strainwave.files.reading import from_text
from strainwave.model.train.controls import core_of, with_core

CASCADE, SPEED = (
    "{type: cascade, bandwidth: 40 Hz, damping: 1, lag: 0.5 ms}",
    "{type: speed_loop, K_p: 0.2 N*m*s/rad, K_i: 5 N*m/rad}",
)
POSITION = "{bandwidth: 30 Hz, damping: 0.7, lag: 0.3 ms}"
CUBIC, CURVE = "{ratio: 50, law: {type: cubic, K: 3e4 N*m/rad, alpha: 1e4 1/rad^2}}", "SHG-32-100"
BOUC_WEN = "hysteresis: {type: bouc_wen, K: 6e3 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}"
GRAVITY = "drag: {type: angle_torque, amplitude: 40 N*m}"
SCATTER = "scatter: {load.inertia: 10 %, damping.ratio: 20 %}"
DRIVES = (  # gear, loop, inertia of the load, its drag, more groups, units
    (CUBIC, CASCADE, 1.2, "", "", 0), (CUBIC, SPEED, 1.2, "", "", 0), (CUBIC, POSITION, 1.2, "", "", 0),
    (CUBIC, CASCADE, 1.2, GRAVITY, "", 0), (CURVE, CASCADE, 5.0, "", "", 0), (CURVE, POSITION, 5.0, GRAVITY, "", 0),
    (CUBIC, CASCADE, 1.2, "", BOUC_WEN, 0), (CUBIC, SPEED, 2.0, "", BOUC_WEN, 0), (CUBIC, CASCADE, 1.2, "", SCATTER, 8),
    (CURVE, SPEED, 3.0, GRAVITY, SCATTER, 3),
)  # fmt: skip
MOVE = "move: {profile: [{type: s_curve, angle: 90 deg, time: 0.6 s}]}"
UNASKED = (
    *((*row[:4], f"{row[4]}\n{MOVE}", 0) for row in DRIVES),
    ("CSG-40-50", "{type: cascade, bandwidth: 30 Hz, lag: 0.5 ms}", 1.3, "", MOVE, 0),
    ("CSG-32-100", "{type: cascade, K_v: 40 1/s, K_p: 0.15 N*m*s/rad, T_n: 15 ms, lag: 1 ms}", 3.0, "", MOVE, 0),
)
SIZES = [sign * size for size in (0.02, 0.05, 0.2) for sign in (1.0, -1.0)]
LARGEST = 2.0


def project_of(gear, loop, inertia, drag, more, _units):
    """Project of one drive."""
    text = f"""
gear: {gear}
motor: {{inertia: 4.5 kg*cm^2, loop: {loop}}}
load: {{inertia: {inertia} kg*m^2{", " + drag if drag else ""}}}
damping: {{ratio: 3 %}}
speed: {{from: 500 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
{more}
"""
    return from_text(text, Path("drive.yaml"))


class Judge:
    """Goal and limit of gains over all loads and units, without the classes of `tune`."""

    def __init__(self, project, units, tuning):
        self.names, self.control, self.computed = tuning.gains, tuning.control, 0
        self.cases = []
        for drive in (project, *units):
            low, high = drive.load_torques
            self.cases += [drive] if low == high else [drive.under(float(t)) for t in np.linspace(low, high, 3)]
        assumed = getattr(tuning.control, "lag", 0.0) == 0.0
        self.delay = 0.5e-3 if assumed else 0.0

    def trains(self, gains):
        core = core_of(self.control)._replace(**dict(zip(self.names, gains, strict=True)))
        control = with_core(self.control, core)
        return [(case, case.train._replace(motor=case.train.motor._replace(control=control))) for case in self.cases]

    def sensitivity(self, gains):
        worst = 0.0
        for _, train in self.trains(gains):
            loop = MotorLoop(train, sw.study.operating_state(train, train.omega), train.omega)
            if not loop.closed.stable:
                return inf
            grid = loop.frequencies(2000, HALF_WIDTHS)
            worst = max(worst, float(np.max(1.0 / np.abs(1.0 + loop(grid) * np.exp(-1j * grid * self.delay)))))
        return worst

    def goal(self, gains, enough=inf):
        worst = 0.0
        for case, train in self.trains(gains):
            self.computed += 1
            response = replace(case, subject=train).response(coexisting=False, points=24)
            worst = max(worst, float(response.oscillation[response.top]))
            if worst > enough:
                return worst
        return worst


def best_step(judge, tuning):
    """Largest relative gain of a step of one or two gains that keeps the limit."""
    gains = np.array(tuning.recommended.gains)
    goal, unit, gained = judge.goal(gains), np.eye(len(gains)), 0.0
    steps = [1.0 + size * row for row in unit for size in SIZES]
    steps += [(1.0 + a * one) * (1.0 + b * two) for one, two in combinations(unit, 2) for a, b in product(SIZES, SIZES)]
    for step in steps:
        there = gains * step
        if judge.sensitivity(there) <= LARGEST:
            gained = max(gained, 1.0 - judge.goal(there, goal) / goal)
    return gained


def evolution(judge, tuning, seed):
    """By how much differential evolution is better, with ten times the nonlinear responses."""
    budget, best, box = 10 * tuning.computed, [inf], np.log(tuning.ranges)
    judge.computed = 0

    def goal(x):
        if judge.computed >= budget:
            return inf
        broken = judge.sensitivity(np.exp(x))
        if broken > LARGEST:
            return 1e3 + min(broken, 1e3)
        best[0] = min(best[0], value := judge.goal(np.exp(x)))
        return value

    differential_evolution(
        goal, box, seed=seed, maxiter=10_000, polish=False, tol=0.0, callback=lambda *_, **__: judge.computed >= budget
    )
    return 1.0 - best[0] / judge.goal(tuning.recommended.gains)


def of_a_torque(train):
    """Compliance [rad/(N*m)] of the load, and settling [s] after a step of torque on it."""
    linear = sw.state_space(train, at=sw.study.operating_state(train, train.omega), speed=train.omega)
    load, torque = linear.outputs.index("load speed"), linear.inputs.index("load torque")
    grid = np.geomspace(1.0, 1e4, 4001)
    poles, vectors = np.linalg.eig(linear.A)
    moving = np.abs(poles) > 1e-9 * np.max(np.abs(poles))
    parts = (linear.C[load] @ vectors * np.linalg.solve(vectors, linear.B[:, torque]))[moving] / poles[
        moving
    ] ** 2  # a step, and an angle
    time = np.linspace(0.0, 10.0 / np.min(np.abs(poles[moving].real)), 20_001)
    off = np.abs((np.exp(np.multiply.outer(time, poles[moving])) @ parts).real)
    compliance = np.max(np.abs(linear.response(grid)[load, torque] / grid))
    return np.array([compliance, time[np.flatnonzero(off > 0.02 * np.max(off))[-1]]])


def unasked():
    """Print what becomes worse where no goal is given."""
    print("drive  seconds  compliance  settling  of the move  oscillation")
    for i, row in enumerate(UNASKED):
        project = project_of(*row)
        begin = process_time()
        tuning = sw.tune(project)
        seconds, better = process_time() - begin, tuning.applied(project)
        cases = [[p.under(float(t)) for t in np.linspace(*p.load_torques, 3)] for p in (project, better)]
        before, after = [np.max([of_a_torque(case.train) for case in some], axis=0) for some in cases]
        moves = [max(sw.move(p).settling_times[-1] or 0.0, 1e-3) for p in (project, better)]
        peaks = [max(np.max(r.oscillation) for r in (c.response(coexisting=False) for c in some)) for some in cases]
        ratios = [*(after / before), moves[1] / moves[0], peaks[1] / peaks[0]]
        print(f"{i:5d} {seconds:8.1f}  {'  '.join(f'{ratio:10.4f}' for ratio in ratios)}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, nargs="*", default=range(len(DRIVES)))
    parser.add_argument("--evolution", type=int, nargs="*", default=[], metavar="SEED")
    parser.add_argument("--unasked", action="store_true")
    given = parser.parse_args()
    if given.unasked:
        unasked()
        return
    print("drive  seconds  responses  rule, arcsec  best, arcsec  best step  evolution")
    for i in given.drives:
        project = project_of(*DRIVES[i])
        count = DRIVES[i][-1]
        units = tuple(sw.sample.scattered(project, count)) if count else ()
        sw.tune(project, goals=("compliance",))  # compiles
        begin = process_time()
        tuning = sw.tune(project, goals=("pointing",), units=units)
        seconds, judge, arcsec = process_time() - begin, Judge(project, units, tuning), np.pi / 648_000
        rule, best = judge.goal(tuning.rule.gains) / arcsec, judge.goal(tuning.recommended.gains) / arcsec
        step, found = best_step(judge, tuning), [evolution(judge, tuning, seed) for seed in given.evolution]
        print(
            f"{i:5d} {seconds:8.1f} {tuning.computed:10d} {rule:13.2f} {best:13.2f} {100 * step:8.2f} %  "
            f"{', '.join(f'{100 * gain:+.2f} %' for gain in found)}",
            flush=True,
        )


if __name__ == "__main__":
    main()
