"""The response of laws with memory by integration: equal to harmonic balance, and up and down apart where it jumps."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.study.response.by_integration import response_through
from strainwave.study.response.gear_forces import gear_torque

pytestmark = pytest.mark.compiled

BOUC_WEN = sw.Parallel(sw.Linear(1.0), sw.BoucWen(0.5, 0.0, 0.2))


def test_response_of_hysteresis_is_that_of_harmonic_balance():
    system = sw.Oscillator(1.0, 0.05, BOUC_WEN, sw.Harmonic(0.1), 1.0)
    found = response_through(system, (0.9, 1.3))
    assert found.method == "integration"
    assert found.back is None
    assert np.all(found.curve.stable)
    for omega in (0.9, 1.1, 1.3):
        orbit = sw.find_orbit(system._replace(omega=omega), harmonics=31)
        at = int(np.argmin(np.abs(found.curve.omega - omega)))
        assert found.curve.omega[at] == pytest.approx(omega)
        # the series of the balance falls with the cube of the order, as the force has corners
        assert found.curve.peak[at] == pytest.approx(orbit.peak, rel=1e-3)


def test_torque_of_the_curve_is_the_torque_of_the_law():
    system = sw.Oscillator(1.0, 0.05, BOUC_WEN, sw.Harmonic(0.1), 1.0)
    found = response_through(system, (1.0, 1.05))
    orbit = sw.find_orbit(system._replace(omega=float(found.curve.omega[0])), harmonics=31)
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    state = orbit.state(angle)
    torque = gear_torque(system, angle, state[0], state[1], tuple(state[2:]))
    assert np.max(found.torque(system)[0]) == pytest.approx(np.max(torque), rel=5e-3)


def test_a_hardening_law_with_friction_jumps_apart_up_and_down():
    law = sw.Parallel(sw.Cubic(1.0, 1.0), sw.Coulomb(0.01, 0.01))
    system = sw.Oscillator(1.0, 0.04, law, sw.Harmonic(0.1), 1.0)
    found = response_through(system, (0.9, 2.2))
    assert found.back is not None
    assert found.sweep.jump_down > found.sweep.jump_up + 0.05
    assert [jump.after < jump.before for jump in found.sweep.on_run_up] == [True]
    assert [jump.after > jump.before for jump in found.sweep.on_run_down] == [True]
