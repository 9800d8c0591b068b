"""
What does a log of one run-up tell about a drive?
=================================================

An SHG-25-100 under a position loop turns 1.2 kg m², at which gravity pulls with 8 N m. Only encoders were logged, 20
bits on the motor and 24 bits with noise on the load. The project file guesses damping and kinematic error; what is
found goes back into it, with the uncertainty as its scatter.

The number: the identified damping in N m s/rad; the log was made with 4.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC, TURN = np.pi / 648_000.0, 2.0 * np.pi
LINE = sw.Line(2, 40.0 * ARCSEC, 0.4)
PROJECT = """
gear: SHG-25-100
motor: {inertia: 4 kg*cm^2, loop: {bandwidth: 60 Hz, damping: 0.7}}
load: {inertia: 1.2 kg*m^2, drag: {type: angle_torque, amplitude: 8 N*m}}
damping: {B: 7 N*m*s/rad}
speed: {from: 70 rad/s, to: 115 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 25 arcsec}]}
"""


def measured(train):
    """The log of a run-up of another drive: its own stiffness, damping and error."""
    own = train._replace(B=4.0, law=train.law._replace(K1=34e3, K2=47e3), error=sw.KinematicError((LINE,)))
    run = own._replace(omega=1.0, reference=sw.train.SpeedProfile((0.0, 4.0), (70.0, 115.0)))
    t = np.arange(0.0, 4.0, 1e-3)
    y = sw.simulate(run, np.zeros(4), t, method=sw.Dopri5(rtol=1e-9, atol=1e-12)).y
    motor = run.reference.value(t) + y[2]
    load = motor / run.N - y[0] + 0.5 * ARCSEC * np.random.default_rng(1).standard_normal(len(t))
    steps = {"motor_angle": (motor, TURN / 2**20), "load_angle": (load, TURN / 2**24)}
    return {"time": t} | {name: q * np.round(angle / q) for name, (angle, q) in steps.items()}


def main():
    with TemporaryDirectory() as folder:
        (path := Path(folder) / "axis.yaml").write_text(PROJECT, encoding="utf-8")
        project = sw.read_project(path)
    found = sw.identify_log(measured(project.train), project=project)
    print(found)
    for one, style, label in ((project, "0.6", "as guessed"), (found.project, "C0", "as identified")):
        curve = one.response()
        plt.plot(curve.omega, curve.oscillation / ARCSEC, style, label=label)
    plt.gca().set(xlabel="motor speed (rad/s)", ylabel="oscillation of the pointing error (arcsec)")
    plt.legend()
    return found.value("B")


if __name__ == "__main__":
    print(f"identified damping: {main():.3f} N m s/rad")
    plt.show()
