"""The exact response of a study and the integrations that check it."""

import numpy as np
import pytest
from direct_project import project_of

import strainwave as sw
from strainwave.drive.response import exact_response
from strainwave.study.analysis.time_domain.run_up_check import RunUp, run_up_and_down
from strainwave.study.speed_map.error_equation import operating_point

# OSCILATE's Duffing example (case T4): folds by converged harmonic balance at 1.02129 and 1.07115
DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.0)
SPEEDS = (0.9, 1.2)


def checked(system, speeds):
    exact = exact_response(system, speeds)
    return exact, run_up_and_down(system, speeds, exact, operating_point(system))


@pytest.fixture(scope="module")
def both():
    return checked(DUFFING, SPEEDS)


@pytest.mark.slow
def test_exact_response_has_the_folds_of_a_finer_balance(both):
    fine = sw.frequency_response(DUFFING, SPEEDS, harmonics=21)
    assert [f.omega for f in both[0].curve.folds] == pytest.approx([f.omega for f in fine.folds], rel=1e-9)


@pytest.mark.slow
def test_integration_confirms_the_exact_response(both):
    exact, run = both
    assert len(run.up) >= 6
    assert len(run.down) >= 6
    assert all(motion.closed and motion.stable for motion in (*run.up, *run.down))
    assert run.difference() < 1e-6
    low, high = sorted(fold.omega for fold in exact.curve.folds)
    upper = [m.peak for m in run.up if low < m.omega < high]
    lower = [m.peak for m in run.down if low < m.omega < high]
    assert upper  # a run-up stays on the high-amplitude motion between the folds, a run-down on the quiet one
    assert lower
    assert min(upper) > max(lower)


@pytest.mark.slow
def test_difference_is_told_when_the_curve_is_wrong(both):
    run = both[1]
    wrong = RunUp(run.up, run.down, 1.02 * run.curve_up, run.curve_down)
    assert wrong.difference() == pytest.approx(1.0 - 1.0 / 1.02, rel=1e-4)


def test_component_of_the_torsion_leaves_the_kinematic_error_out():
    """Linear gear: u = x - e with u_2 = (2 w)^2 e_2/(omega_0^2 - (2 w)^2 + 2 i mu w), to rounding."""
    error = sw.KinematicError((sw.Line(1, 2e-4, 0.3), sw.Line(2, 1e-3, 0.7)))
    system = sw.Oscillator(2.0, 0.3, sw.Linear(8.0), sw.Harmonic(0.0), 1.0, error)
    exact = exact_response(system, (0.6, 1.4))
    w = 2.0 * exact.curve.omega
    expected = w**2 * 1e-3 / np.abs(4.0 - w**2 + 0.15j * w)
    assert exact.torsion_amplitude(system, 2) == pytest.approx(expected, rel=1e-9)
    assert np.max(np.abs(exact.curve.amplitude(2) - expected)) > 1e-4


@pytest.mark.slow
def test_narrow_superharmonic_gets_a_curve_of_its_own():
    """At 3 omega = omega_0 the band is a hundred times narrower than the range; first order is right there to 1 %."""
    system = DUFFING._replace(B=0.0005, excitation=sw.Harmonic(0.02))
    drive = sw.Drive(1.0, system.J, 50.0, system.B, system.law)
    found = project_of(drive, (0.2, 0.6), load_torque=sw.Harmonics((sw.Harmonic(-0.02),))).analyze()
    (regime,) = [r for r in found.regimes if r.name == "superharmonic 3:1"]
    near = found.close[regime.resonance]
    top = float(np.max(near.torsion_amplitude(system, 3)))
    assert top == pytest.approx(regime.response.peak[1], rel=0.01)


@pytest.mark.slow
def test_without_damping_nothing_is_followed_and_the_speeds_are_even():
    _, run = checked(DUFFING._replace(B=0.0), (0.3, 0.6))
    assert [m.omega for m in run.up] == pytest.approx(np.linspace(0.3, 0.6, 8))
    assert run.difference() is None
