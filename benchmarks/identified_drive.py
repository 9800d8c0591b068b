"""Identify a drive from one run-up, and predict its jump speeds with their intervals.

An SHG-25-100 with the hysteresis loss of its datasheet turns 1.2 kg m^2 under a stiff loop, 80 to 115 rad/s in 20 s;
a line of 40 arcsec meets the resonance. The log has 1000 samples a second: the motor's encoder of 20 bits and the
load's of 24 bits with 0.5 arcsec of noise. The loop is not known to the identification: the measured angle is the
motion of a held motor. Jump speeds are the folds of the curve of the drive, by harmonic balance.

What is wrong with an input is not in the intervals: with 16 bits on the motor the line is off by 3 deviations.
"""

import math
import time

import numpy as np

import strainwave as sw

ARCSEC, TURN = math.pi / 648_000.0, 2.0 * math.pi
GEAR = sw.catalogue.gear("SHG-25-100")
PLAIN = GEAR.drive(load_inertia=1.2, motor_inertia=4e-4, B=4.0)
LAW = sw.fit.fit_hysteresis(PLAIN.law, GEAR.hysteresis_loss, rated_torque=GEAR.rated_torque).law
LOOP = sw.train.from_bandwidth(TURN * 120.0, PLAIN.J_m + PLAIN.J_l / PLAIN.N**2, 0.7)
TRUTH = {
    "law.first.K1": LAW.first.K1,
    "law.first.K2": LAW.first.K2,
    "law.first.K3": LAW.first.K3,
    "law.second.K": LAW.second.K,
    "law.second.yield_twist": LAW.second.yield_twist,
    "B": 4.0,
    "error.lines.0.amplitude": 40.0 * ARCSEC,
    "error.lines.0.phase": 0.4,
}


def train(law, B, line, **options):
    return PLAIN._replace(law=law, B=B).train(kinematic_error=sw.KinematicError((line,)), **options)


def measured():
    """A log of the run-up."""
    line = sw.Line(2, 40.0 * ARCSEC, 0.4)
    run = train(LAW, 4.0, line, control=LOOP, reference=sw.train.SpeedProfile((0.0, 20.0), (80.0, 115.0)))
    t = np.arange(0.0, 20.0, 1e-3)
    y = sw.simulate(run, np.zeros(len(run.state_names())), t, method=sw.Dopri5(rtol=1e-9, atol=1e-12)).y
    motor = run.reference.value(t) + y[2]
    load = motor / PLAIN.N - y[0] + 0.5 * ARCSEC * np.random.default_rng(1).standard_normal(len(t))
    motor, load = (q * np.round(angle / q) for angle, q in ((motor, TURN / 2**20), (load, TURN / 2**24)))
    return {"time": t, "motor_angle": motor, "torsion": motor / PLAIN.N - load}


def jump(which):
    """Speed [rad/s] of the lower or the upper fold, of a train with the loop."""

    def speed(system):
        steady = train(system.law, system.B, system.error.lines[0], control=LOOP, omega=100.0)
        return sorted(fold.omega for fold in sw.frequency_response(steady, (96.0, 112.0), harmonics=9).folds)[which]

    return speed


def main():
    softer = LAW._replace(
        first=LAW.first._replace(K1=28e3, K2=45e3, K3=60e3), second=LAW.second._replace(K=5e4, yield_twist=6e-5)
    )
    guess = train(softer, 6.0, sw.Line(2, 30.0 * ARCSEC, 0.2), control=sw.train.Held())
    started = time.thread_time()
    found = sw.identify(guess, measured(), tuple(TRUTH), inputs={"reference": "motor_angle"}, outputs={"x": "torsion"})
    print(found, f"\n{time.thread_time() - started:.1f} s of one core, compilation and the run-up in it")
    for path, value in TRUTH.items():
        low, high = found.interval(path)
        print(f"{path}: truth {value:.6g} {'in' if low <= value <= high else 'NOT in'} {low:.6g} to {high:.6g}")
    truth = train(LAW, 4.0, sw.Line(2, 40.0 * ARCSEC, 0.4))
    for which, name in ((0, "down"), (-1, "up")):
        low, high = found.interval_of(jump(which))
        value = jump(which)(truth)
        print(
            f"jump {name}: truth {value:.4f} {'in' if low <= value <= high else 'NOT in'} {low:.4f} to {high:.4f} rad/s"
        )


if __name__ == "__main__":
    main()
