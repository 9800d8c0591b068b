"""
Which speeds does the vendors' rule forbid needlessly on a robot's joint?
=========================================================================

An SHG-25-100 carries an arm of 2.1 kg m², on which gravity pulls with 80 N m when it is level. The arm works within 51
degrees of level, so that at least 50 N m always load the gear. A position loop of 40 Hz drives the motor. The pointing
error may oscillate by 70 arcsec about its mean.

The vendors' rule takes the stiffness K1, that of a gear without load, and asks to avoid 30 f_n rpm. Beyond 48 N m this
gear is on its third slope, almost twice as stiff: the resonance is higher, and the arm may run at 30 f_n rpm. It must
avoid a band above that instead.

The number: the oscillation at 30 f_n rpm, the largest of three torques of gravity.
"""

import math
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import strainwave as sw

PROJECT = """
gear: SHG-25-100
motor: {inertia: 2 kg*cm^2, loop: {type: position, bandwidth: 40 Hz, damping: 0.7}}  # with the wave generator
load: {inertia: 2.1 kg*m^2}
damping: {ratio: 4 %}
speed: {from: 400 rpm, to: 1200 rpm, shaft: motor}
limit: {oscillation: 70 arcsec}
excitation:
  kinematic_error: [{order: 2, amplitude: 15 arcsec}, {order: 4, amplitude: 3 arcsec}]
  load_torque: {mean: {from: -80 N*m, to: -50 N*m}}
"""
RPM, ARCSEC = math.pi / 30.0, math.pi / 648_000.0


def main():
    with TemporaryDirectory() as folder:
        path = Path(folder, "robot_joint.yaml")
        path.write_text(PROJECT, encoding="utf-8")
        found = sw.speed_map(sw.read_project(path), loads=(-80.0, -65.0, -50.0))
    _, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    low, high = np.array(found.vendor[0].band) / RPM
    axes.axvspan(low, high, fc="none", ec="#0072B2", hatch="//", label="the rule forbids: 30 $f_n$ ± 10 %")
    styles = ({"color": "0.65", "lw": 3.5}, {"color": "k", "ls": "--"}, {"color": "k", "ls": ":", "lw": 2.0})
    for load, size, style in zip(found.loads, found.oscillation, styles, strict=True):
        axes.plot(found.speeds / RPM, size / ARCSEC, **style, label=f"gravity of {-load:.0f} N m")
    axes.axhline(70.0, color="#D55E00", ls="-.", lw=2.0, label="limit")
    axes.set(xlabel="motor speed (rpm)", ylabel="oscillation (arcsec)", xlim=(400, 1200), ylim=(0, None))
    axes.figure.legend(loc="outside lower center", ncols=2, frameon=False)
    at_rule = [np.interp(found.vendor[0].speed, found.speeds, size) for size in found.oscillation]
    return max(at_rule) / ARCSEC, found


if __name__ == "__main__":
    print(f"at 30 f_n rpm, which the rule forbids, the error oscillates by {main()[0]:.1f} arcsec")
    plt.show()
