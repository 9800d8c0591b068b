"""
When has a robot joint settled after a move?
============================================

An SHG-25-100 turns a load of 0.5 kg m² by 90 degrees in 0.6 s against gravity, which pulls with 60 N m when the arm is
level. A position loop of 30 Hz drives the motor, which has the wave generator on it. The trapezoid of the speed ends
with a jump of the acceleration and leaves a vibration; the S-curve of the same duration and the same largest speed
leaves next to none.

The pointing error stays at 483 arcsec after both moves: gravity twists the gear, and the loop gives way. Waiting does
not remove that, so that the window of a settled load is about the error at rest.

The number: the time in which the load settles to 5 arcsec after the trapezoid.
"""

import math

import matplotlib.pyplot as plt

import strainwave as sw

GEAR = sw.catalogue.gear("SHG-25-100")
ARCSEC = math.pi / 648_000.0
MOTOR, LOAD = GEAR.input_inertia + 2e-5, 0.5  # kg m^2
LOOP = sw.train.from_bandwidth(2.0 * math.pi * 30.0, MOTOR + LOAD / GEAR.ratio**2, 0.7)
JOINT = sw.DriveTrain(
    motor=sw.train.Motor(MOTOR, control=LOOP),
    N=float(GEAR.ratio),
    B=5.0,
    law=GEAR.law,
    load=sw.train.Load(LOAD, drag=sw.train.AngleTorque(60.0)),
    error=sw.KinematicError((sw.Line(order=2, amplitude=5e-5),)),
)
PROFILES = {"trapezoid": sw.Trapezoid(0.5 * math.pi, 0.6), "S-curve": sw.SCurve(0.5 * math.pi, 0.6)}


def main():
    moves = {name: sw.move(JOINT, part, gear=GEAR, window=5.0 * ARCSEC) for name, part in PROFILES.items()}
    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for (name, move), dash in zip(moves.items(), ("-", "--"), strict=True):
        settled = f"{name}: settled in {1e3 * move.settling_time:.1f} ms"
        axes.plot(move.time, move.pointing_error / ARCSEC, dash, lw=1.2, label=settled)
    axes.axvline(0.6, color="#777777", ls=":", lw=1.0)
    axes.set(xlabel="time (s)", ylabel="pointing error (arcsec)", xlim=(0.0, 0.7))
    axes.set_title("90° in 0.6 s against gravity")
    axes.legend(loc="lower right")
    return moves["trapezoid"].settling_time


if __name__ == "__main__":
    print(f"the load settles to 5 arcsec {1e3 * main():.2f} ms after the trapezoid")
    plt.show()
