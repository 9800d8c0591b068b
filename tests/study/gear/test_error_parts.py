"""The error between motor and load is the pure kinematic error plus the torsion."""

import numpy as np
import pytest

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")
ERROR = sw.KinematicError((sw.Line(1, 2e-5, 0.4), sw.Line(2, 1.1e-4)))
J, B, K = 1.3, 40.0, 1e5


SECOND = sw.KinematicError((sw.Line(2, 1.1e-4),))


def linear(omega, torque=0.0):
    return sw.Oscillator(J, B, sw.Linear(K), sw.Harmonic(0.0, mean=torque), omega, SECOND)


@pytest.mark.parametrize("torque", [0.0, 30.0, 178.0, -300.0])
def test_under_a_static_torque_the_gear_adds_its_twist_and_no_ripple(torque):
    system = sw.Oscillator(J, B, GEAR.law, sw.Harmonic(0.0, mean=torque), 1.0, ERROR)
    parts = sw.study.error_parts(system)
    assert parts.wind_up == pytest.approx(GEAR.twist(torque), rel=1e-12)  # CSF/CSG catalogue, p. 50
    assert parts.torsion_peak_to_peak == 0.0
    assert parts.total_peak_to_peak == pytest.approx(sw.gears.peak_to_peak(ERROR), rel=1e-9)
    assert np.allclose(parts.total, ERROR.value(parts.phase) + parts.torsion, rtol=0.0, atol=1e-18)


def test_a_resisting_load_makes_the_vendors_error_negative():
    drive = GEAR.drive(load_inertia=1.3, B=10.0)
    system = drive.error_equation(load_torque=sw.Harmonic(0.0, mean=-178.0), kinematic_error=ERROR, motor="held")
    parts = sw.study.error_parts(system)
    assert np.all(parts.ate < 0.0)
    assert np.mean(parts.ate) == pytest.approx(-GEAR.twist(178.0), rel=1e-12)


def test_a_slowly_varying_torque_twists_the_gear_along_its_law():
    torque = sw.Harmonic(60.0, order=1, mean=20.0)
    parts = sw.study.error_parts(sw.Oscillator(J, B, GEAR.law, torque, 1.0))
    expected = [GEAR.twist(float(T)) for T in torque.torque(parts.phase)]
    assert np.allclose(parts.torsion, expected, rtol=1e-12, atol=1e-16)
    assert parts.torsion_peak_to_peak == pytest.approx(GEAR.twist(80.0) - GEAR.twist(-40.0), rel=1e-3)
    assert parts.pure_peak_to_peak == 0.0


@pytest.mark.parametrize("omega", [20.0, 100.0, 138.0, 400.0])
def test_parts_of_a_linear_drive_have_their_closed_forms(omega):
    # x'' J + B u' + K u = tau, u = x - e, e = A cos 2 phase: u = J w^2 e/(K - J w^2 + i B w), w = 2 omega
    w, A, T = 2.0 * omega, 1.1e-4, 50.0
    system = linear(omega, T)
    parts = sw.study.error_parts(system, sw.find_orbit(system))
    impedance = K - J * w * w + 1j * B * w
    assert parts.pure_peak_to_peak == pytest.approx(2.0 * A, rel=1e-12)
    assert parts.torsion_peak_to_peak == pytest.approx(2.0 * A * J * w * w / abs(impedance), rel=1e-8)
    assert parts.total_peak_to_peak == pytest.approx(2.0 * A * abs(K + 1j * B * w) / abs(impedance), rel=1e-8)
    assert parts.wind_up == pytest.approx(T / K, rel=1e-9)
    assert np.allclose(parts.total, parts.pure + parts.torsion, rtol=0.0, atol=1e-18)


def test_the_motion_tends_to_the_static_one_with_the_square_of_the_speed():
    system = sw.Oscillator(J, B, sw.Cubic(K, 6.9e4), sw.Harmonic(60.0, mean=100.0), 1.0, ERROR)
    static = sw.study.error_parts(system)
    apart = []
    for omega in (24.0, 12.0):
        slow = system._replace(omega=omega)
        apart.append(sw.study.error_parts(slow, sw.find_orbit(slow)).total_peak_to_peak - static.total_peak_to_peak)
    assert abs(apart[1]) < 1e-2 * static.total_peak_to_peak
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.1)


def test_a_line_of_output_order_on_the_motor_turn_is_refused_with_the_remedy():
    system = linear(1.0)._replace(error=sw.KinematicError((sw.Line(1 / 50, 1e-5),)))
    with pytest.raises(ValueError, match=r"the order 0\.02 is not an integer, .* the turn of its output"):
        sw.find_orbit(system)


def test_output_orders_and_wave_generator_orders_move_together_on_the_output_turn():
    # Linear, so every line answers for itself: order 2 N on the output turn at omega/N as order 2 on the motor turn.
    N, omega = 4, 120.0
    lines = (*sw.gears.on_output_turn(sw.KinematicError((sw.Line(2, 1.1e-4),)), N).lines, sw.Line(1, 3e-5))
    both = linear(omega / N)._replace(error=sw.KinematicError(lines))
    orbit = sw.find_orbit(both, harmonics=9)
    assert orbit.amplitude(2 * N) == pytest.approx(sw.find_orbit(linear(omega)).amplitude(2), rel=1e-9)
    w = omega / N
    linear_answer = 3e-5 * abs((K + 1j * B * w) / (K - J * w * w + 1j * B * w))
    assert orbit.amplitude(1) == pytest.approx(linear_answer, rel=1e-9)


def test_wrong_requests_are_refused():
    system = linear(20.0)
    orbit = sw.find_orbit(system)
    with pytest.raises(ValueError, match="the orbit belongs to omega = 20 rad/s and the system to 30"):
        sw.study.error_parts(linear(30.0), orbit)
