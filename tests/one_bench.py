"""The bench that tests of sampled loops and of compensation share: CSG-40-50 with a heavy load and a PD loop."""

import math

import strainwave as sw
from strainwave.base.units import ARCSEC

GEAR = sw.catalogue.gear("CSG-40-50")
N, J_M, J_L, PERIOD = 50.0, 1.45e-3, 10.0, 250e-6  # motor of 1e-3 kg m^2 and the wave generator's 4.5e-4
OMEGA_A = math.sqrt(GEAR.K1 / J_L)  # held-motor resonance, 100 rad/s
B = 2.0 * 0.03 * math.sqrt(GEAR.K1 * J_L)
LOOP = sw.train.from_bandwidth(60.0 * math.pi, J_M + J_L / N**2)
ERROR = sw.KinematicError((sw.Line(2, 23.0 * ARCSEC),))
DRIVE = sw.DriveTrain(sw.train.Motor(J_M, control=LOOP), N, B, GEAR.law, sw.train.Load(J_L), omega=50.0, error=ERROR)
# one stiffness, 1e5 N m/rad, by the same law: it runs the machine code of the drive
LINEAR = DRIVE._replace(law=sw.PiecewiseLinear(GEAR.K1, GEAR.K1, GEAR.K1, GEAR.law.T1, GEAR.law.T2))
SAMPLING = sw.controllers.Sampling(PERIOD, PERIOD, 3.0, 2.0 * math.pi / 2**16, 0.0, 2.0 * math.pi / 2**24)
PD = sw.controllers.SampledPD(LOOP.K_p, LOOP.K_d, PERIOD)


def loop(controller=PD, speed=50.0, sampling=SAMPLING, **changes):
    """The drive at a motor speed under a controller."""
    motor = DRIVE.motor._replace(control=sw.train.Commanded())
    return sw.controllers.ClosedLoop(DRIVE._replace(motor=motor, omega=speed, **changes), controller, sampling)
