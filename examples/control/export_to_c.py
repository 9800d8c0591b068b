"""
How does the model of a joint run on a controller, without Python?
==================================================================

The motor, the gear and the load of a joint are written as C without dependencies, built with the compiler `cc` and
stepped 10 000 times a second, as a bench would. A constant torque takes the joint up through the resonance of order 2.
The C holds the library's own equations: Python's adaptive integrator gives the same motion.

The number: the largest pointing error of the run-up, in arcsec.
"""

import ctypes
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

ARCSEC = np.pi / 648_000.0
TORQUE, STEP, STEPS = 0.35, 1e-4, 8000  # N m, s
JOINT = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=40.0, law=sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 20.0, 80.0)).train(
    motor_torque=sw.Harmonic(0.0, mean=TORQUE),
    kinematic_error=sw.KinematicError((sw.Line(2, 1.1e-4),)),
    reference=sw.train.AtRest(),
)


def run_in_c(folder):
    source = sw.export(JOINT, folder / "joint.c", to="c", step=STEP).path
    library = source.with_suffix(".so")
    subprocess.run(["cc", "-std=c99", "-O2", "-shared", "-fPIC", source, "-lm", "-o", library], check=True)
    joint = ctypes.CDLL(library)
    state, inputs, outputs = (ctypes.c_double * 4)(), (ctypes.c_double * 2)(TORQUE, 0.0), (ctypes.c_double * 6)()
    numbers = ctypes.byref(ctypes.c_double.in_dll(joint, "joint_default"))  # the exported values
    joint.joint_init(state)
    found = np.zeros((6, STEPS + 1))
    for i in range(STEPS):
        joint.joint_step(numbers, state, inputs, outputs)
        found[:, i + 1] = outputs
    return found


def main():
    with TemporaryDirectory() as folder:
        _, speed, *_, error, _ = run_in_c(Path(folder))
    run = sw.simulate(JOINT, np.zeros(4), STEP * np.arange(STEPS + 1))
    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    axes.plot(speed, error / ARCSEC, lw=1.0, label="C, 0.1 ms steps")
    axes.plot(run.y[3], run.y[0] / ARCSEC, "--", lw=1.0, label="Python, adaptive steps")
    axes.set(xlabel="motor speed (rad/s)", ylabel="pointing error (arcsec)", title="Run-up under a constant torque")
    axes.legend()
    return float(np.max(np.abs(error))) / ARCSEC


if __name__ == "__main__":
    print(f"largest pointing error of the run-up: {main():.3f} arcsec")
    plt.show()
