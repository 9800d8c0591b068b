"""Poincaré sections and orbit diagrams against closed forms, harmonic balance and period doublings."""

import numpy as np
import pytest

import strainwave as sw

LINEAR = sw.Oscillator(1.0, 0.4, sw.Linear(2.0), sw.Harmonic(1.0), 1.3)
GAIN = 1.0 / (2.0 - 1.3**2 + 0.4j * 1.3)  # x = Re(GAIN exp(i phase))


@pytest.mark.compiled
def test_a_strobed_periodic_motion_is_one_point():
    found = sw.numerics.poincare_section(LINEAR, (0.0, 0.0), turns=5, settle=40, phase=0.7)
    z = GAIN * np.exp(0.7j)
    np.testing.assert_allclose(found.y, np.repeat([[z.real], [(1.3j * z).real]], 5, axis=1), atol=1e-7)
    assert "phase 0.7" in str(found)


@pytest.mark.compiled
def test_crossings_of_a_torsion_lie_on_it_and_rise():
    found = sw.numerics.poincare_section(LINEAR, (0.0, 0.0), turns=6, settle=40, torsion_level=0.3)
    assert len(found.t) == 6
    np.testing.assert_allclose(found.y[0], 0.3, atol=1e-9)
    rate = 1.3 * np.sqrt(abs(GAIN) ** 2 - 0.09)
    np.testing.assert_allclose(found.y[1], rate, rtol=1e-6)
    np.testing.assert_allclose(np.diff(found.t), 2.0 * np.pi / 1.3, rtol=1e-7)


@pytest.mark.compiled
def test_no_crossing_is_an_empty_section():
    found = sw.numerics.poincare_section(LINEAR, (0.0, 0.0), turns=3, settle=40, torsion_level=9.0)
    assert len(found.t) == 0
    assert str(found) == "Poincare section at torsion rising through 9 rad: no crossings"


@pytest.mark.parametrize("method", [sw.Dopri5(), sw.Rk4(steps_per_period=100), sw.Dop8(steps_per_period=100)])
def test_a_motion_that_leaves_every_bound_is_one_sentence_without_warnings(method):
    soft = sw.Oscillator(1.0, 0.3, sw.Cubic(1.0, -0.3), sw.Harmonic(0.2), 0.5)
    with pytest.raises(sw.SolveError, match=r"the motion ended: .* left every bound"):
        sw.numerics.poincare_section(soft, (5.0, 0.0), turns=5, settle=1, method=method)


@pytest.mark.compiled
def test_a_start_far_away_takes_more_steps_than_a_diagram_may():
    stiff = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 1.0), sw.Harmonic(0.3), 1.0)
    with pytest.raises(sw.SolveError, match=r"5 turns at omega = 1 rad/s .* of 1e\+16 take more than 40000 steps;"):
        sw.numerics.orbit_diagram(stiff, "B", (0.1, 0.2), (0.0, 1e16), settle=3, points=2)


@pytest.mark.slow
def test_sweeps_up_and_down_jump_where_the_response_curve_folds():
    system = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
    values = np.arange(1.0, 2.2, 0.02)
    found = sw.numerics.orbit_diagram(system, "omega", values, settle=150, points=8)
    said = sw.jumps(sw.frequency_response(system, (0.9, 2.3)))
    drop = values[np.argmax(found.peak_up[:-1, 0] - found.peak_up[1:, 0])]
    rise = values[np.argmax(found.peak_down[:-1, 0] - found.peak_down[1:, 0])]
    assert drop <= said.jump_down < drop + 0.0201
    assert rise <= said.jump_up < rise + 0.0201
    assert np.mean(found.period_up == 1) > 0.9
    assert found.dataset()["x"].sizes == {"direction": 2, "omega": len(values), "point": 8, "start": 1}


@pytest.mark.slow
def test_a_period_doubling_lies_where_harmonic_balance_has_it():
    system = sw.Oscillator(1.0, 0.15, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.15), 1.2)
    settled = sw.simulate(system, (-0.8, 0.0), 200.0 * np.pi / 1.2).y[:, -1]
    start = sw.find_orbit(system, guess=sw.numerics.shoot(system, settled).coefficients[:31])
    assert start.stable
    values = np.arange(0.15, 0.215, 0.01)
    found = sw.numerics.orbit_diagram(
        system, "excitation.amplitude", values, tuple(start.state(0.0)), settle=300, points=16
    )
    curve = sw.numerics.parameter_response(system, "excitation.amplitude", (0.14, 0.25), start=start)
    first = int(np.flatnonzero(found.period_up[:, 0] != 1)[0])
    assert values[first - 1] < curve.doublings[0].value < values[first]
    assert found.period_up[first, 0] == 2


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"values": [1.0]}, "two or more rising"),
        ({"values": [2.0, 1.0]}, "two or more rising"),
        ({"path": "excitation.order"}, "can be swept"),
        ({"path": "omga"}, "no parameter 'omga'"),
        ({"points": 0}, "points is 0"),
        ({"settle": 0}, "settle is 0"),
        ({"threads": 0}, "threads is 0"),
        ({"y0": 3.0}, "y0 is 3.0"),
        ({"values": [-1.0, 1.0], "path": "J"}, "inertia"),
    ],
)
def test_bad_input_of_an_orbit_diagram_is_one_sentence(change, sentence):
    arguments = {"path": "omega", "values": [1.0, 2.0]} | change
    with pytest.raises(ValueError, match=sentence):
        sw.numerics.orbit_diagram(LINEAR, **arguments)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"turns": 0}, "turns is 0"),
        ({"phase": np.inf}, "phase is inf"),
        ({"torsion_level": "a"}, "torsion_level"),
        ({"phase": 0.0, "torsion_level": 0.0}, "one of them"),
    ],
)
def test_bad_input_of_a_section_is_one_sentence(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.numerics.poincare_section(LINEAR, (0.0, 0.0), **change)
