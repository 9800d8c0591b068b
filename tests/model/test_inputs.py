"""Bad parameters end in one sentence that names the field, wherever a verb takes a model."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.quantities import checked, floated

GOOD = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)
LINE = sw.Line(2, 1e-4)


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        (GOOD._replace(J=0.0), r"Oscillator\.J is 0"),
        (GOOD._replace(J=-1.0), r"Oscillator\.J is -1"),
        (GOOD._replace(omega=math.inf), r"Oscillator\.omega is inf; it must be finite"),
        (GOOD._replace(law=sw.Cubic(1.0, math.nan)), r"Cubic\.alpha is nan"),
        (GOOD._replace(law=sw.Polynomial(())), r"Polynomial\.coefficients is empty"),
        (GOOD._replace(law=sw.Polynomial((0.0, math.nan))), r"Polynomial\.coefficients is \(0\.0, nan\)"),
        (GOOD._replace(law=sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 196.0, 54.0)), "it needs 0 < T1 < T2"),
        (GOOD._replace(law=sw.PiecewiseLinear(1e5, -1.4e5, 1.8e5, 54.0, 196.0)), "all must be positive"),
        (GOOD._replace(law=sw.Backlash(1.0, -0.5)), r"Backlash\.half_gap is -0\.5"),
        (GOOD._replace(excitation=sw.Harmonic(0.18, order=0)), r"Harmonic\.order is 0; it must be at least 1"),
        (GOOD._replace(excitation=sw.Harmonic(0.18, order=1.5)), r"Harmonic\.order must be a whole number, not 1\.5"),
        (
            GOOD._replace(excitation=sw.Harmonic(0.18, order=10**9)),
            r"Harmonic\.order is 1000000000; it must be at most",
        ),
        (GOOD._replace(J=1e-300), r"Oscillator\.J is 1e-300 .* 1e-60 up"),
        (GOOD._replace(excitation=sw.Harmonics(())), r"Harmonics\.terms is empty"),
        (GOOD._replace(error=sw.KinematicError(())), r"KinematicError\.lines is empty"),
        (GOOD._replace(error=sw.KinematicError((sw.Line(-2, 1e-4),))), r"Line\.order is -2"),
        (sw.Drive(-5e-4, 0.05, 50.0, 0.017, sw.Linear(7160.0)), r"Drive\.J_m is -0\.0005; it must be positive"),
        (sw.HDC_40_050.train()._replace(B=-1.0), r"DriveTrain\.B is -1 N\*m\*s/rad; a damping must not be negative"),
        (
            sw.train.Elastic(0.01, -1.0, sw.Linear(1.0), sw.train.Load(0.05)),
            r"Elastic\.B is -1 N\*m\*s/rad; a damping must not be",
        ),
        (sw.gears.GearDamping(1.0, warming=-1e6), r"GearDamping\.warming is -1e\+06 K"),
        (sw.Drive(5e-4, 0.05, 0.0, 0.017, sw.Linear(7160.0)), r"Drive\.N is 0; it must be positive"),
    ],
)
def test_value_out_of_range_is_refused_in_one_sentence(model, sentence):
    with pytest.raises(ValueError, match=sentence) as error:
        checked(model)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        (GOOD._replace(J="1 kg"), r"Oscillator\.J must be a number, not '1 kg'"),
        (GOOD._replace(law=sw.Play(0.1, sw.Cubic)), r"Play\.law is the class Cubic; give an object of it"),
        (
            sw.Parallel(sw.Linear(1.0), sw.HDC_40_050.train()),
            r"Parallel\.second is a DriveTrain, a system that moves by itself; give a law",
        ),
        (GOOD._replace(law=7160.0), r"Oscillator\.law is 7160\.0; it must be an object with a method torque"),
        (GOOD._replace(excitation=LINE), r"Oscillator\.excitation is Line"),
        (GOOD._replace(error=sw.KinematicError(LINE)), r"KinematicError\.lines must be a tuple, not Line"),
    ],
)
def test_part_of_the_wrong_kind_is_refused_in_one_sentence(model, sentence):
    with pytest.raises(TypeError, match=sentence) as error:
        checked(model)
    assert "\n" not in str(error.value)


def test_verbs_check_their_models():
    with pytest.raises(ValueError, match=r"Oscillator\.J is 0"):
        sw.simulate(GOOD._replace(J=0), (0, 0), 1.0)
    with pytest.raises(ValueError, match=r"Drive\.J_l is 0"):
        sw.HDC_40_050._replace(J_l=0.0).error_equation(motor_torque=sw.Harmonic(10.0))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"motor_torque": 3.0}, r"motor_torque is 3\.0; it must be a Harmonic"),
        ({"motor_torque": sw.Harmonic(math.nan)}, r"Harmonic\.amplitude is nan; it must be finite"),
        ({"kinematic_error": LINE}, r"Oscillator\.error is Line.*; it must be an object with a method value"),
        ({"omega": math.nan}, r"Oscillator\.omega is nan; it must be finite"),
    ],
)
def test_error_equation_checks_everything_that_it_puts_together(arguments, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        sw.HDC_40_050.error_equation(**arguments)


@pytest.mark.parametrize("name", ["J", "mu", "omega_0", "omega_0_held"])
def test_derived_quantities_of_a_drive_without_inertia_name_the_field(name):
    with pytest.raises(ValueError, match=r"Drive\.J_l is 0; it must be positive"):
        getattr(sw.HDC_40_050._replace(J_l=0.0), name)


def test_negative_damping_and_stiffness_are_allowed():
    unusual = GOOD._replace(B=-0.1, law=sw.Cubic(-1.0, -2.0), omega=-3.0)
    assert checked(unusual) == unusual


def test_ints_become_floats_and_whole_orders_become_ints_at_any_depth():
    model = sw.Oscillator(1, 0, sw.Cubic(1, 0), sw.Harmonic(1, 2.0), 1, sw.KinematicError([sw.Line(np.int64(2), 1)]))
    text = "Oscillator(J=1.0, B=0.0, law=Cubic(K=1.0, alpha=0.0), excitation=Harmonic(amplitude=1.0, order=2, "
    text += "phase=0.0, mean=0.0), omega=1.0, error=KinematicError(lines=(Line(order=2, amplitude=1.0, phase=0.0),)))"
    assert repr(floated(model)) == text


def test_replace_says_what_a_model_has():
    assert sw.replaced(GOOD, {"law.alpha": 2.0, "omega": 3.0}) == GOOD._replace(omega=3.0, law=sw.Cubic(1.0, 2.0))
    two = GOOD._replace(error=sw.KinematicError((LINE, LINE)))
    assert sw.replaced(two, {"error.lines.1.amplitude": 3e-4}).error.lines == (LINE, sw.Line(2, 3e-4))
    with pytest.raises(ValueError, match=r"Cubic has no parameter 'k9' \(in 'law\.k9'\); it has K, alpha"):
        sw.replaced(GOOD, {"law.k9": 1.0})
    with pytest.raises(ValueError, match=r"'J' in 'J\.x' is a number"):
        sw.replaced(GOOD, {"J.x": 1.0})
    with pytest.raises(ValueError, match="it has 0, 1"):
        sw.replaced(two, {"error.lines.2.amplitude": 1.0})
