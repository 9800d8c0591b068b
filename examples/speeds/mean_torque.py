"""
Does a real gear jump, and how does its load change that?
=========================================================

A CSG-40-50 turns 1.3 kg m² at constant motor speed; its kinematic error is 23 arcsec at twice the motor speed, its
damping ratio 3 %. The resonance bends by 9 %, more than it is wide: speeding up and slowing down jump at different
speeds. The rated torque ends that, and moves the drive to where the datasheet's slopes and their cubic fit differ.

The number: motor speed at which the run-up drops, with the datasheet's three slopes and no mean torque, 1538 rpm;
the motion is checked by an integration on both sides of it.
"""

import math

import matplotlib.pyplot as plt

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")
ARCSEC, RPM = math.pi / 180 / 3600, math.pi / 30
ERROR = sw.KinematicError((sw.Line(order=2, amplitude=23 * ARCSEC),))
TORQUES = {0.0: "C0", 50.0: "C2", 100.0: "C1", 178.0: "C3"}  # N m


def drive_at(law, mean_torque, speed=140.0):
    """The error equation with the motor held at a speed [rad/s], the load resisting by a mean torque [N m]."""
    damping = 2 * 0.03 * math.sqrt(law.stiffness(0.0) * 1.3)
    drive = GEAR.drive(load_inertia=1.3, motor_inertia=GEAR.input_inertia, B=damping)._replace(law=law)
    resisting = sw.Harmonic(0.0, mean=-mean_torque)
    return drive.error_equation(kinematic_error=ERROR, load_torque=resisting, omega=speed, motor="held")


def main():
    _, panels = plt.subplots(1, 2, figsize=(9, 4), sharey=True, layout="constrained")
    drop = math.nan
    for axes, name, law in zip(panels, ("datasheet", "cubic fit"), (GEAR.law, GEAR.cubic), strict=True):
        for torque, colour in TORQUES.items():
            curve = sw.frequency_response(drive_at(law, torque), (120.0, 210.0), harmonics=15)
            x, y = curve.omega / RPM, curve.amplitude(2) / (23 * ARCSEC)
            axes.plot(x, y, ":", color=colour, lw=1.0)
            y[~curve.stable] = math.nan
            axes.plot(x, y, color=colour, label=f"{torque:.0f} N m")
            if name == "datasheet" and torque == 0.0:
                drop = sw.jumps(curve).jump_down / RPM
        axes.set(xlabel="motor speed (rpm)", title=f"{GEAR.name}, {name}")
    panels[0].set_ylabel("dynamic error over kinematic error (order 2)")
    panels[0].axhline(1 / 0.06, color="0.6", lw=0.8, ls="--")
    panels[0].annotate("1/(2 × 3 %)", (1790, 17.0), color="0.4")
    panels[1].legend(title="mean torque")
    return drop


if __name__ == "__main__":
    print(f"the run-up drops at {main():.0f} rpm")
    plt.show()
