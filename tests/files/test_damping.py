"""A damping ratio means one thing: B = 2 zeta sqrt(K1 J), whatever hysteresis lies beside the spring."""

import math
from pathlib import Path

import pytest

from strainwave.drive.equation.gear_torque import settling_time
from strainwave.files.reading import from_text
from strainwave.numerics.steady import settled
from strainwave.study.gear.hysteresis_loop import gear_loop
from strainwave.study.speed_map.error_equation import operating_point

K, J, ZETA, ERROR = 4e4, 1.0, 0.02, 1e-4  # omega_0 = 200 rad/s, met by order 2 at 100 rad/s
FRICTION = 0.8  # N*m: as much loss at resonance as a damping ratio of 0.005
DRIVE = f"""\
gear: {{ratio: 100, rated_torque: 60 N*m, law: {{type: linear, K: {K} N*m/rad}}}}
motor: {{inertia: 5 kg*cm^2}}
load: {{inertia: {J} kg*m^2}}
damping: {{ratio: {ZETA}}}
speed: {{from: 700 rpm, to: 1200 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: {ERROR} rad}}]}}
"""


def drive(friction, yield_twist):
    hysteresis = f"{{type: bouc_wen, K: {friction / yield_twist} N*m/rad, ratio: 0, yield_twist: {yield_twist} rad}}"
    return from_text(f"{DRIVE}hysteresis: {hysteresis}\n", Path("project.yaml"))


def loss(project):
    """Energy [J] that the law takes in a slow cycle to the torsion of the resonance."""
    return gear_loop(project.drive.law, 1.8e-3 * K, rated=False).full.energy


def peak(project):
    """Largest |x| [rad] over speeds around the resonance."""
    system = project.system()
    speeds = [system._replace(omega=omega) for omega in (99.5, 100.0, 100.5)]
    return max(settled(here, operating_point(here).start, time=settling_time(here)).peak for here in speeds)


@pytest.mark.slow
def test_a_yield_sharper_by_100_at_constant_loss_keeps_B_and_the_peak():
    soft, sharp = drive(FRICTION, 2e-5), drive(FRICTION, 2e-7)
    sharp = drive(FRICTION * loss(soft) / loss(sharp), 2e-7)
    assert loss(sharp) == pytest.approx(loss(soft), rel=1e-3)
    assert soft.drive.B == sharp.drive.B == pytest.approx(2.0 * ZETA * math.sqrt(K * J), rel=1e-12)
    reached = peak(soft), peak(sharp)
    assert reached[1] == pytest.approx(reached[0], rel=0.03)
    # One harmonic at resonance: pi K e a = pi B omega a^2 + 4 T_y a (Den Hartog 1931: a block of dry friction).
    expected = (K * ERROR - 4.0 * FRICTION / math.pi) / (sharp.drive.B * 200.0)
    assert reached[1] == pytest.approx(expected, rel=0.02)
