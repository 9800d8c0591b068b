"""
Where does a disturbed drive come to rest?
==========================================

Between the speeds of its jumps a gear has two motions, one of low and one of high amplitude. Their basins of attraction
say to which one a disturbed drive returns. The figure has 14400 initial states of a CSG-40-50 with a load of 1.3 kg m²
and a damping of 3 %, at a motor speed of 1510 rpm. Each is integrated until it has settled.

The number: share of the states within ±4 mrad and ±1.2 rad/s that end on the high-amplitude motion.
"""

import math

import matplotlib.pyplot as plt

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")
ARCSEC, RPM = math.pi / 180 / 3600, math.pi / 30


def drive():
    """The error equation with the motor held at 1510 rpm and a kinematic error of 23 arcsec, twice a motor turn."""
    law = GEAR.cubic
    damping = 2 * 0.03 * math.sqrt(law.K * 1.3)
    gear = GEAR.drive(load_inertia=1.3, motor_inertia=GEAR.input_inertia, B=damping)._replace(law=law)
    error = sw.KinematicError((sw.Line(order=2, amplitude=23 * ARCSEC),))
    return gear.error_equation(kinematic_error=error, omega=1510 * RPM, motor="held")


def main():
    found = sw.basins(drive(), (-4e-3, 4e-3), (-1.2, 1.2), resolution=120)
    _, axes = plt.subplots(figsize=(6, 5.5), layout="constrained")
    sw.draw(found, axes)
    axes.set_title("where 14400 initial states end")
    high = max(range(len(found.attractors)), key=lambda i: found.attractors[i].amplitude)
    share, error = found.share(high)
    return share, error


if __name__ == "__main__":
    print("share that ends on the high-amplitude motion: {:.3f} +- {:.3f}".format(*main()))
    plt.show()
