"""What every model object promises, checked on one instance of every class (`tests/canonical.py`)."""

import math
import pickle
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest
import sympy
from canonical import (
    DISSIPATIVE,
    DISSIPATIVE_SYSTEMS,
    ERRORS,
    EXCITATIONS,
    LAWS,
    MODELS,
    ODD,
    PROFILES,
    REFERENCES,
    SMOOTH,
    SYSTEMS,
    TRAIN_FORMS,
    TRAINS,
    VARIATIONS,
    classes_of,
)

import strainwave as sw
from strainwave.base.law import energy_of, losses_of, share, torque_of, z_rate_of
from strainwave.base.quantities import checked, floated, parameters
from strainwave.compile import jit
from strainwave.files.fields.kinds import Entry
from strainwave.files.fields.rows import LAW
from strainwave.files.yaml_text import read

EPS = np.finfo(float).eps
ANGLES = np.linspace(-7.0, 7.0, 29)
ALL_CLASSES = sorted({cls for model in MODELS.values() for cls in classes_of(model)}, key=lambda cls: cls.__name__)


def breakpoints(law):
    return law.breakpoints() if hasattr(law, "breakpoints") else ()


def torsions(law, margin=0.0):
    """Torsions on both sides of every breakpoint, none closer to it than `margin` scales, and the scale."""
    scale = max((abs(b) for b in breakpoints(law)), default=1.0)
    x = scale * np.linspace(-1.71, 1.73, 58)
    near = [np.abs(x - b) < margin * scale for b in breakpoints(law)]
    return (x[~np.any(near, axis=0)] if near else x), scale


def slope(function, x, h):
    """Central difference of fourth order."""
    return (8 * (function(x + h) - function(x - h)) - (function(x + 2 * h) - function(x - 2 * h))) / (12 * h)


each_law = pytest.mark.parametrize("name", LAWS)
each_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS.keys())
each_class = pytest.mark.parametrize("cls", ALL_CLASSES, ids=lambda cls: cls.__name__)
each_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS.keys())


@each_law
def test_stiffness_is_the_slope_of_the_torque(name):
    law = LAWS[name]
    x, scale = torsions(law, margin=0.01)
    largest = np.max(np.abs(law.stiffness(x)))
    np.testing.assert_allclose(slope(law.torque, x, 1e-3 * scale), law.stiffness(x), rtol=0, atol=1e-9 * largest)


@each_law
def test_torque_is_the_slope_of_the_energy(name):
    law = LAWS[name]
    x, scale = torsions(law, margin=0.01)
    largest = np.max(np.abs(law.torque(x)))
    np.testing.assert_allclose(slope(law.energy, x, 1e-3 * scale), law.torque(x), rtol=0, atol=1e-9 * largest)


@each_law
def test_energy_is_zero_at_rest(name):
    assert LAWS[name].energy(0.0) == 0.0


@each_law
def test_law_is_odd_exactly_where_it_is_said_to_be(name):
    law = LAWS[name]
    x, _ = torsions(law)
    assert np.array_equal(law.torque(-x), -law.torque(x)) == (name in ODD)
    if name in ODD:
        assert law.torque(0.0) == 0.0


@each_law
def test_breakpoints_are_the_places_where_the_slope_jumps(name):
    law = LAWS[name]
    x, scale = torsions(law, margin=0.01)
    h = 1e-3 * scale

    def jump(at):
        return np.abs(law.torque(at + h) - 2.0 * law.torque(at) + law.torque(at - h)) / h

    largest = np.max(np.abs(law.stiffness(x)))
    assert np.all(jump(x) < 0.01 * largest)
    assert all(jump(b) > 0.1 * largest for b in breakpoints(law))
    assert (len(breakpoints(law)) == 0) == (name in SMOOTH)
    assert list(breakpoints(law)) == sorted(breakpoints(law))


@pytest.mark.parametrize("name", sorted(SMOOTH))
def test_smooth_law_takes_symbols(name):
    law = LAWS[name]
    x = sympy.Symbol("x", real=True)
    torque, stiffness, energy = law.torque(x), law.stiffness(x), law.energy(x)
    assert float(torque.subs(x, 0.3)) == pytest.approx(law.torque(0.3), rel=1e-14)
    assert float(stiffness.subs(x, 0.3)) == pytest.approx(law.stiffness(0.3), rel=1e-14)
    assert float(energy.subs(x, 0.3)) == pytest.approx(law.energy(0.3), rel=1e-14)
    assert float((sympy.diff(torque, x) - stiffness).subs(x, 0.3)) == pytest.approx(0.0, abs=1e-14 * law.stiffness(0.3))


@pytest.mark.parametrize("excitation", EXCITATIONS.values(), ids=EXCITATIONS.keys())
def test_excitation_repeats_every_turn_and_has_the_orders_it_says(excitation):
    angle = np.arange(64) * 2.0 * np.pi / 64
    np.testing.assert_allclose(excitation.torque(angle + 2.0 * np.pi), excitation.torque(angle), rtol=0, atol=1e-14)
    spectrum = np.abs(np.fft.rfft(excitation.torque(angle)))
    assert tuple(np.flatnonzero(spectrum[1:] > 1e-9) + 1) == excitation.orders()


def test_harmonic_is_its_mean_plus_amplitude_times_cosine():
    torque = sw.Harmonic(amplitude=0.18, order=2, phase=0.3, mean=0.1).torque(0.7)
    assert torque == pytest.approx(0.1 + 0.18 * math.cos(2 * 0.7 + 0.3), rel=1e-15)


def test_kinematic_error_is_the_sum_of_its_lines():
    error = sw.KinematicError((sw.Line(2, 0.1), sw.Line(4, 0.02, 0.7)))
    assert error.value(0.4) == pytest.approx(0.1 * math.cos(0.8) + 0.02 * math.cos(1.6 + 0.7), rel=1e-15)
    assert error.orders() == (2, 4)


@pytest.mark.parametrize("error", (ERRORS | VARIATIONS).values(), ids=(ERRORS | VARIATIONS).keys())
def test_slope_of_the_kinematic_error_and_of_a_variation_is_its_derivative(error):
    np.testing.assert_allclose(slope(error.value, ANGLES, 1e-3), error.slope(ANGLES), rtol=0, atol=1e-11)


@each_system
def test_jacobian_is_the_derivative_of_the_rhs(system):
    rng = np.random.default_rng(1)
    for phase, x, v in rng.uniform(-1.4, 1.4, (20, 3)):
        rows = np.array(system.jacobian(phase, (x, v)), float)
        for j in range(2):
            if min((abs(system.torsion(phase, (x, v)) - b) for b in system.breakpoints()), default=1.0) < 0.01:
                continue

            def moved(d, phase=phase, x=x, v=v, j=j):
                return np.array(system.rhs(phase, (x + d * (j == 0), v + d * (j == 1))))

            np.testing.assert_allclose(slope(moved, 0.0, 1e-3), rows[:, j], rtol=0, atol=1e-9)


def test_rhs_is_the_equation_of_motion_in_the_torsion():
    system = SYSTEMS["everything"]
    phase, x, v = 0.6, 0.2, -0.5
    u = x - system.error.value(phase)
    du = v - system.omega * system.error.slope(phase)
    dx, dv = system.rhs(phase, (x, v))
    assert dx == v
    inertia = system.J * dv
    assert inertia + system.B * du + system.law.torque(u) == pytest.approx(system.excitation.torque(phase), rel=1e-14)
    assert system.torsion(phase, (x, v)) == u
    assert system.orders() == (1, 2, 3, 4)


def of_law(law, x):
    return law.torque(x), law.stiffness(x), law.energy(x)


def of_excitation(excitation, x):
    return (excitation.torque(x),)


def of_error(error, x):
    return error.value(x), error.slope(x)


def of_system(system, x):
    y = (0.4 * x, 0.1 - 0.2 * x)
    rhs, jacobian = system.rhs(x, y), system.jacobian(x, y)
    return rhs[0], rhs[1], jacobian[0][0], jacobian[0][1], jacobian[1][0], jacobian[1][1], system.torsion(x, y)


def of_dissipative(law, x):
    v = 0.3 - 0.1 * x
    z = share(law, (0.05 * x, 0.02 - 0.01 * x))
    known = (torque_of(law, x, v, z), law.stiffness(x), energy_of(law, x, z))
    return known + z_rate_of(law, x, v, z) + losses_of(law, x, v, z)


def of_dissipative_system(system, x):
    return system.rhs(x, (0.4 * x, 0.1 - 0.2 * x, *share(system.law, (0.05 * x, 0.02 - 0.01 * x))))


def of_reference(reference, x):
    return reference.value(x), reference.slope(x), reference.curvature(x)


def of_train(train, x):
    a, b = 0.03 - 0.004 * x, 0.05 + 0.002 * x
    four = a, b, 0.1 - a, b - a
    y = four + four + four + four + four  # a train looks at its own states alone
    return (*train.rhs(x, y), *train.losses(x, y), train.torque(x, y), train.energy(x, y), train.torsion(x, y))


def of_train_form(train, x):
    a, b = 0.03 - 0.004 * x, 0.05 + 0.002 * x
    four = a, b, 0.1 - a, b - a
    y = four + four + four + four + four
    return (*train.rhs(x, y), train.torsion(x, y))


GROUPS = (
    (of_law, LAWS),
    (of_dissipative, DISSIPATIVE),
    (of_excitation, EXCITATIONS),
    (of_error, ERRORS | VARIATIONS),
    (of_system, SYSTEMS),
    (of_dissipative_system, DISSIPATIVE_SYSTEMS),
    (of_reference, REFERENCES),
    (of_excitation, PROFILES),
    (of_train, TRAINS),
    (of_train_form, TRAIN_FORMS),
)
CASES = [pytest.param(kind, model, id=name) for kind, group in GROUPS for name, model in group.items()]


def places(kind, model):
    return torsions(model)[0] if kind is of_law else ANGLES


@pytest.mark.parametrize(("kind", "model"), CASES)
def test_arrays_give_the_same_as_numbers(kind, model):
    x = places(kind, model)
    one_by_one = np.array([kind(model, float(v)) for v in x]).T
    together = np.array([np.broadcast_to(part, x.shape) for part in kind(model, x)])
    largest = np.max(np.abs(one_by_one), axis=1, keepdims=True)
    assert np.all(np.abs(together - one_by_one) <= 4 * EPS * largest)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "model"), CASES)
def test_compiled_code_gives_the_same_as_python(kind, model):
    x = places(kind, model)
    python = np.array([kind(model, float(v)) for v in x]).T
    compiled = np.array([jit.run(kind, model, float(v)) for v in x]).T
    largest = np.max(np.abs(python), axis=1, keepdims=True)
    assert np.all(np.abs(compiled - python) <= 4 * EPS * largest)


@each_model
def test_model_survives_pickling(model):
    copy = pickle.loads(pickle.dumps(model))
    assert copy == model
    assert classes_of(copy) == classes_of(model)


@pytest.mark.parametrize("law", (LAWS | DISSIPATIVE).values(), ids=(LAWS | DISSIPATIVE).keys())
def test_law_survives_a_project_file(law):
    if not type(law).__module__.startswith("strainwave."):
        with pytest.raises(ValueError, match="is not among the laws of a project file"):
            sw.project_entry(law)
        return
    written = read(f"law: {sw.project_entry(law)}")
    assert not written.problems
    again = LAW.read(written.content["law"], Entry((), []))
    assert again == law
    assert classes_of(again) == classes_of(law)


def test_a_polynomial_of_high_degree_is_written_and_read_back():
    law = sw.Polynomial(tuple(0.1 * i for i in range(1, 17)))
    content = read(f"law: {sw.project_entry(law)}").content["law"]
    assert LAW.read(content, Entry((), [])) == law


@pytest.mark.parametrize("law", [sw.Cubic(-1.0, -1.0), sw.Linear(1e40), sw.Polynomial((1.0,))])
def test_what_a_project_file_refuses_is_not_written(law):
    with pytest.raises(ValueError, match=r"^a project file does not take this law: "):
        sw.project_entry(law)


@each_model
def test_model_passes_its_own_check(model):
    assert checked(model) == model


@each_model
def test_floated_changes_nothing_the_second_time(model):
    once = floated(model)
    assert repr(floated(once)) == repr(once)
    assert once == model


@each_model
def test_parameters_and_replace_are_inverse(model):
    before = {p.path: p.value for p in parameters(model)}
    assert all(math.isfinite(value) for value in before.values())
    assert sw.replaced(model, before) == model
    for path, value in before.items():
        after = {p.path: p.value for p in parameters(sw.replaced(model, {path: value + 1}))}
        assert after == before | {path: value + 1}


def test_no_field_of_a_law_has_the_name_of_a_method_of_laws():
    laws = {cls for law in LAWS.values() for cls in classes_of(law)}
    methods = {name for cls in laws for name in jit.methods_of(cls)}
    assert [cls for cls in laws if set(cls._fields) & methods] == []


@each_class
def test_every_number_has_a_unit(cls):
    for name, hint in get_type_hints(cls, include_extras=True).items():
        is_number_with_unit = get_origin(hint) is Annotated and isinstance(get_args(hint)[1], str)
        is_part = hint in (Any, int) or get_origin(hint) is tuple or hasattr(hint, "_fields")
        assert is_number_with_unit or is_part, f"{cls.__name__}.{name}: {hint}"


@pytest.mark.parametrize("name", sorted({**SYSTEMS, **DISSIPATIVE_SYSTEMS}))
def test_prepared_system_is_the_system(name):
    system = {**SYSTEMS, **DISSIPATIVE_SYSTEMS}[name]
    if not hasattr(system, "prepared"):
        pytest.skip("has no prepared form")
    prepared = system.prepared()
    for phase in ANGLES:
        y = (0.4 * phase, 0.1 - 0.2 * phase, *share(system.law, (0.05 * phase, 0.02 - 0.01 * phase)))
        wanted, got = system.rhs(float(phase), y), prepared.rhs(float(phase), y)
        np.testing.assert_allclose(got, wanted, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if hasattr(law, "scaled")])
def test_scaled_law_has_the_torque_times_the_factor(name):
    x, _ = torsions(LAWS[name])
    expected = 0.3 * LAWS[name].torque(x)
    np.testing.assert_allclose(LAWS[name].scaled(0.3).torque(x), expected, rtol=0, atol=8 * EPS * np.max(abs(expected)))


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if hasattr(law, "rounded")])
def test_rounded_law_is_the_law_away_from_its_corners(name):
    law, round_ = LAWS[name], LAWS[name].rounded()
    assert round_.breakpoints() == ()
    assert round_.rounded() is round_
    x, _ = torsions(law)
    near = [abs(x - corner) < 0.5 * round_.width for corner in law.breakpoints()]
    away = ~np.any(near, axis=0) if near else np.ones(len(x), bool)
    np.testing.assert_allclose(round_.torque(x[away]), law.torque(x[away]), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("excitation", EXCITATIONS.values(), ids=EXCITATIONS.keys())
def test_scaled_excitation_has_the_torque_times_the_factor(excitation):
    np.testing.assert_allclose(excitation.scaled(0.3).torque(ANGLES), 0.3 * excitation.torque(ANGLES), atol=1e-15)


def test_scaled_kinematic_error_is_the_error_times_the_factor():
    error = ERRORS["KinematicError"]
    np.testing.assert_allclose(error.scaled(0.3).value(ANGLES), 0.3 * error.value(ANGLES), atol=1e-15)
    np.testing.assert_allclose(error.scaled(0.3).slope(ANGLES), 0.3 * error.slope(ANGLES), atol=1e-15)


@pytest.mark.parametrize(
    "law", [sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), sw.BoucWen(2.0, 0.4, 0.1, 1.2, 0.6, -0.3, 3)]
)
def test_prepared_system_may_hold_arrays(law):
    system = sw.Oscillator(0.7, 0.1, law, sw.Harmonic(0.3, 2, 0.4, 0.1), 1.3, ERRORS["KinematicError"])
    path = law._fields[0]
    values = np.array([1.0, 1.5, 2.0])
    together = sw.replaced(system, {f"law.{path}": values}).prepared()
    y = (0.2, -0.1, 0.03)[: 2 + len(share(law, (0.0, 0.0)))]
    got = np.array([np.broadcast_to(part, (3,)) for part in together.rhs(0.7, y)])
    for i, value in enumerate(values):
        one = sw.replaced(system, {f"law.{path}": float(value)})
        np.testing.assert_allclose(got[:, i], one.rhs(0.7, y), rtol=1e-12)
