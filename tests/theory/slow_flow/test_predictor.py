"""The predictor follows the slow flow, along sweeps and through jumps, compiled and as Python, and never says NaN."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.compile import jit, numba_import
from strainwave.compile.tree import classes, leaves
from strainwave.theory.slow_flow.predictor.predictor import BEYOND, INVALID, JUMP, OK, OUT, PredictorState

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.05), sw.Harmonic(0.05, phase=0.4), 1.05)
BIASED = DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.1, 0.05)))
ERROR = sw.KinematicError((sw.Line(1, 0.04, 0.3),))
FIFTH = DUFFING._replace(law=sw.Polynomial((0.0, 1.0, 0.0, 0.03, 0.0, 0.005)), B=0.1)
GEAR = sw.Oscillator(
    0.6030927835, 9.82317898446, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 205.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)  # fmt: skip
FORMULAS = {
    "primary": (DUFFING, sw.PRIMARY),
    "primary by kinematic error": (DUFFING._replace(excitation=sw.Harmonic(0.0, mean=0.0), error=ERROR), sw.PRIMARY),
    "primary of order 2": (DUFFING._replace(excitation=sw.Harmonic(0.05, order=2), omega=0.525), sw.Resonance(2, 1)),
    "superharmonic": (DUFFING._replace(excitation=sw.Harmonic(0.3, phase=0.4), omega=0.34), sw.SUPERHARMONIC),
    "subharmonic": (DUFFING._replace(B=0.005, excitation=sw.Harmonic(4.0, phase=0.4), omega=3.2), sw.SUBHARMONIC),
    "no resonance": (DUFFING._replace(omega=0.2, excitation=sw.Harmonic(0.3)), sw.NONRESONANT),
}
SECOND = {
    "square and cube, primary": (BIASED, sw.PRIMARY),
    "square, 2:1": (BIASED._replace(excitation=sw.Harmonic(0.2), omega=0.51), sw.Resonance(2, 1)),
    "square, 1:2": (BIASED._replace(excitation=sw.Harmonic(0.8), omega=2.02), sw.Resonance(1, 2)),
}
SAMPLED = {
    "square and cube": (BIASED, sw.PRIMARY),
    "fifth power": (FIFTH, sw.PRIMARY),
    "two lines": (DUFFING._replace(error=sw.KinematicError((sw.Line(2, 0.01),))), sw.PRIMARY),
}
WHICH = [(FORMULAS, 1), (FORMULAS, 2), (SECOND, 2), (SAMPLED, 1)]
EXACT = [pytest.param(*case, n, id=f"{name}, order {n}") for cases, n in WHICH for name, case in cases.items()]
NAMED = {param.id: param for param in EXACT}
SAMPLE, COARSE = 0.02, 0.05


def near(system):
    return 0.97 * system.omega, 1.03 * system.omega


def followed(predictor, state, speeds, amplitude=1.0):
    """Predictions along speeds, one a sample."""
    found = []
    for omega in speeds:
        found.append(predictor.update(float(omega), amplitude, state))
        state = found[-1].state
    return found


@pytest.mark.parametrize(("system", "resonance", "order"), EXACT)
def test_along_a_sweep_it_is_the_slow_flow_integrated_by_scipy(system, resonance, order):
    flow = sw.slow_flow(system, resonance, order=order)
    low, high = near(system)
    predictor = flow.predictor(SAMPLE, speeds=(low, high))
    steps = 600
    z0, by = 0.3 * predictor.drive.size * complex(math.cos(1.0), math.sin(1.0)), (high - low) / steps
    state = predictor.start(low, 1.0, z0)
    last = followed(predictor, state, low + by * np.arange(1, steps + 1))[-1]

    def rhs(t, y):
        rate = complex(flow._flow.at(low + by * t / SAMPLE).rates(complex(*y)))
        return rate.real, rate.imag

    end = steps * SAMPLE
    reference = solve_ivp(rhs, (0.0, end), (z0.real, z0.imag), method="DOP853", rtol=1e-9, atol=1e-12 * abs(z0))
    z = complex(*reference.y[:, -1])
    assert abs(complex(last.state.re, last.state.im) - z) < 1e-6 * max(abs(z), abs(z0))
    assert last.amplitude == pytest.approx(abs(z), rel=2e-6)
    theta = low * end + 0.5 * (high - low) * end
    turns = 2.0 * math.pi * resonance.q if resonance.q else 2.0 * math.pi
    assert math.remainder(last.state.angle - theta, turns) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("system", "resonance", "order"), EXACT)
def test_at_one_speed_x_and_its_rate_are_those_of_evolve(system, resonance, order):
    flow = sw.slow_flow(system, resonance, order=order)
    predictor = flow.predictor(SAMPLE, speeds=near(system))
    start = predictor.start(system.omega, 1.0, 0.3 * predictor.drive.size)
    path = followed(predictor, start, [system.omega] * 400)
    first, last = path[0], path[-1]
    begin = SAMPLE  # the base angle there is omega times it
    known = flow.evolve((first.x, first.rate), [begin, begin + 399 * SAMPLE])
    size = max(abs(p.x) for p in path)
    assert abs(last.x - known.x[-1]) < 2e-6 * size
    assert abs(last.rate - known.rate[-1]) < 2e-6 * size * max(flow.omega_0, system.omega)


def test_a_steady_state_stays_and_has_the_waveform_of_the_flow():
    for order in (1, 2):
        flow = sw.slow_flow(FIFTH, sw.PRIMARY, order=order)
        steady = flow.steady_states()[0]
        predictor = flow.predictor(SAMPLE, speeds=near(FIFTH))
        path = followed(predictor, predictor.start(FIFTH.omega, 1.0, steady.z), [FIFTH.omega] * 2000)
        assert path[-1].amplitude == pytest.approx(steady.amplitude, rel=1e-8)
        assert path[-1].phase == pytest.approx(steady.phase, abs=1e-8)
        t = SAMPLE * np.arange(1, 2001)
        assert [p.x for p in path] == pytest.approx(flow.steady_x(steady.z, t), abs=1e-7 * steady.amplitude)


def test_samples_of_second_order_differ_from_the_flow_by_the_third_order():
    differences = []
    for eps in (0.04, 0.02, 0.01):  # nonlinearity, damping, forcing and detuning of the size of eps
        law = sw.Polynomial((0.0, 1.0, 0.0, eps, 0.0, 0.2 * eps))
        system = sw.Oscillator(1.0, eps, law, sw.Harmonic(eps), 1.0 + 0.3 * eps)
        flow = sw.slow_flow(system, sw.PRIMARY, order=2)
        predictor = flow.predictor(SAMPLE, speeds=near(system))
        z = 0.6 - 0.3j
        found, _ = predictor.force.rate(predictor.drive, system.omega, 1.0, z)
        differences.append(abs(found - complex(flow.rates(z))))
    slopes = np.log2(np.array(differences[:-1]) / np.array(differences[1:]))
    assert np.all(slopes > 2.85)


def test_a_gear_with_kinks_is_predicted_within_its_accuracy():
    for order in (1, 2):
        flow = sw.slow_flow(GEAR, sw.Resonance(2, 1), order=order)
        predictor = flow.predictor(1e-4, speeds=(200.0, 210.0))
        state = flow.steady_states()[0]
        path = followed(predictor, predictor.start(205.0, 1.0, state.z), [205.0] * 10000)
        assert path[-1].amplitude == pytest.approx(state.amplitude, rel=0.01)
        assert path[-1].flag == OK


def run_up(system, speeds, duration, y0):
    """x of the full equation while the speed rises evenly, by DOP853, at equal times."""
    low, high = speeds
    t = np.arange(1, round(duration / COARSE) + 1) * COARSE
    rate = (high - low) / duration

    def rhs(now, y):
        theta = low * now + 0.5 * rate * now * now
        return system._replace(omega=low + rate * now).rhs(theta, y)

    return t, solve_ivp(rhs, (0.0, t[-1]), y0, method="DOP853", t_eval=t, rtol=1e-9, atol=1e-11).y[0]


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_a_slow_run_up_jumps_where_the_full_equation_jumps(order):
    # Hardening: the amplitude follows the upper branch and falls at its end. Independent: DOP853 in the full equation.
    system = DUFFING._replace(B=0.02, law=sw.Cubic(1.0, 0.1), excitation=sw.Harmonic(0.03), omega=1.0)
    speeds, duration = (0.85, 1.15), 3000.0
    flow = sw.slow_flow(system, sw.PRIMARY, order=order)
    predictor = flow.predictor(COARSE, speeds=speeds)
    path = followed(predictor, predictor.start(speeds[0]), np.linspace(*speeds, round(duration / COARSE) + 1)[1:])
    t, true = run_up(system, speeds, duration, (0.0, 0.0))
    omega, x = speeds[0] + (speeds[1] - speeds[0]) * t / duration, np.array([p.x for p in path])
    peak = system._replace(omega=flow.response(speeds).peak[0])
    certificate = sw.slow_flow(peak, sw.PRIMARY, order=order).certificate()

    mine, its = (np.array([piece.max() for piece in np.array_split(np.abs(a), 400)]) for a in (x, true))
    places = np.array([piece.mean() for piece in np.array_split(omega, 400)])
    falls = [float(places[np.argmax(a[:-3] - a[3:])]) for a in (mine, its)]
    assert its.max() > 5.0 * its[-20:].max()  # it does jump
    assert {p.flag for p in path} == {OK}
    late, high = falls[0] / falls[1] - 1.0, mine.max() / its.max() - 1.0
    assert late == pytest.approx(certificate.speed, rel=0.25, abs=0.001)  # a piece is 0.0007 of the speed
    assert high == pytest.approx(certificate.amplitude, rel=0.25, abs=0.001)
    if order == 2:
        before = omega < min(falls) - 0.01
        error = np.sqrt(np.mean((x - true)[before] ** 2) / np.mean(true[before] ** 2))
        assert error < 0.0025


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "resonance", "order"),
    [
        *(NAMED[f"{name}, order 2"] for name in ("primary", "superharmonic", "no resonance", "square, 2:1")),
        NAMED["two lines, order 1"],
        pytest.param(FIFTH, sw.PRIMARY, 2, id="fifth power, order 2"),
    ],
)
def test_compiled_it_gives_what_python_gives_and_allocates_nothing(system, resonance, order):
    predictor = sw.slow_flow(system, resonance, order=order).predictor(SAMPLE, speeds=near(system))
    state = predictor.start(system.omega, 1.0, 0.2 * predictor.drive.size)
    jit.expose(*classes((predictor, state)))
    compiled = numba_import.numba_module().njit(**jit.OPTIONS)(last_of)
    there, here = compiled(predictor, state, 300), last_of(predictor, state, 300)
    assert leaves(there) == pytest.approx(leaves(here), rel=1e-11, abs=1e-12 * predictor.drive.size)
    assert there.flag == here.flag
    assert compiled(predictor, state._replace(re=math.nan), 0).flag == INVALID
    code = compiled.inspect_llvm(compiled.signatures[0])
    assert "NRT_Allocate" not in code
    assert "NRT_MemInfo_alloc" not in code


def last_of(predictor, state, calls):
    omega = state.omega
    found = predictor.update(omega, 1.0, state)
    for _ in range(calls):
        omega *= 1.00001
        found = predictor.update(omega, 0.9, found.state)
    return found


@pytest.fixture(scope="module")
def predictor():
    return sw.slow_flow(DUFFING, sw.PRIMARY, order=2).predictor(SAMPLE, speeds=(1.0, 1.1), amplitudes=(0.0, 1.0))


def all_finite(prediction):
    return all(math.isfinite(leaf) for leaf in leaves(prediction))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_said_and_the_last_value_held(predictor, bad):
    state = predictor.update(1.04, 0.8, predictor.start(1.04, 0.8, 0.3j)).state
    for omega, amplitude in ((bad, 0.8), (1.04, bad), (bad, bad)):
        found = predictor.update(omega, amplitude, state)
        assert found.flag == INVALID
        assert found == predictor.update(1.04, 0.8, state)._replace(flag=INVALID)
    for name in PredictorState._fields:
        found = predictor.update(1.04, 0.8, state._replace(**{name: bad}))
        assert found.flag == INVALID
        assert all_finite(found)


def test_outside_its_range_the_nearest_end_serves(predictor):
    state = predictor.start(1.09, 1.0, 0.3j)
    high = predictor.update(7.0, 3.0, state)
    assert high.flag == OUT
    assert high == predictor.update(1.1, 1.0, state)._replace(flag=OUT)
    low = predictor.update(-2.0, -1.0, state)
    assert (low.flag, low.state.omega, low.state.amplitude) == (OUT, 1.0, 0.0)
    assert predictor.start(9.0).omega == 1.1


def test_a_jump_of_the_speed_is_said(predictor):
    assert predictor.update(1.1, 1.0, predictor.start(1.0)).flag == JUMP
    assert predictor.update(1.02, 1.0, predictor.start(1.0)).flag == OK


def test_a_vibration_beyond_the_certificate_is_said_and_one_out_of_all_reach_is_not_followed(predictor):
    large = predictor.update(1.05, 1.0, predictor.start(1.05, 1.0, 1.2 * predictor.reach))
    assert large.flag == BEYOND
    wild = predictor.start(1.05)._replace(re=1e9)
    assert predictor.update(1.05, 1.0, wild).flag == INVALID
    thrown = predictor.start(1.05)._replace(re_rate=1e6)
    found = predictor.update(1.05, 1.0, thrown)
    assert found.flag == BEYOND
    assert all_finite(found)
    assert (found.state.re, found.state.re_rate) == (0.0, 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_whatever_it_is_given_it_never_answers_nan(predictor, seed):
    random = np.random.default_rng(seed)
    state = predictor.start(1.05)
    values = [math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300, -1e300, 1.05, 1.04, 1.06, 0.5]
    for _ in range(2000):
        omega, amplitude = random.choice(values, 2)
        if random.random() < 0.05:
            place = random.choice(PredictorState._fields)
            state = state._replace(**{str(place): float(random.choice(values))})
        found = predictor.update(omega, amplitude, state)
        assert all_finite(found)
        state = found.state


REFUSED = [
    (DUFFING._replace(B=0.0), sw.PRIMARY, {}, "mu = 0 1/s; a predictor needs damping"),
    (DUFFING, sw.PRIMARY, {"sample": 0.0}, "sample"),
    (DUFFING, sw.PRIMARY, {"sample": math.nan}, "sample"),
    (DUFFING, sw.PRIMARY, {"sample": 50.0}, "too long"),
    (DUFFING, sw.PRIMARY, {"speeds": (1.1, 1.0)}, "range of speeds"),
    (DUFFING, sw.PRIMARY, {"amplitudes": (1.0, 0.5)}, "two finite numbers"),
    (DUFFING, sw.PRIMARY, {"amplitudes": (0.0, 400.0), "speeds": (1.5, 1.6)}, "no steady state of this range is valid"),
    (FIFTH._replace(omega=0.2), sw.NONRESONANT, {}, "without resonance a predictor is there for a cubic"),
]


@pytest.mark.parametrize(("system", "resonance", "given", "words"), REFUSED)
def test_what_cannot_be_predicted_is_refused_in_a_sentence(system, resonance, given, words):
    with pytest.raises(ValueError, match=words):
        sw.slow_flow(system, resonance).predictor(**given)


def test_without_arguments_it_serves_around_the_speed_of_the_system():
    predictor = sw.slow_flow(DUFFING, sw.PRIMARY).predictor()
    assert predictor.speeds == (0.5 * DUFFING.omega, 1.5 * DUFFING.omega)
    assert predictor.sample == pytest.approx(2.0 * math.pi / (32.0 * 1.5 * DUFFING.omega))


@pytest.mark.parametrize("omega", [123.0, 124.0])
def test_a_loaded_gear_with_kinks_settles_on_the_steady_state_beside_its_peak(omega):
    gear = sw.catalogue.gear("CSG-32-100")
    error = sw.KinematicError((sw.Line(2, 9.696e-5),))
    B = 0.06 * (gear.law.K2 * 1.6) ** 0.5
    system = sw.Oscillator(1.6, B, gear.law, sw.Harmonic(0.0, mean=40.0), omega, error)
    flow = sw.slow_flow(system, sw.Resonance(2, 1), order=2)
    predictor = flow.predictor(1e-3, speeds=(105.0, 150.0))
    state = max((s for s in flow.steady_states() if s.stable), key=lambda s: s.amplitude)
    now = predictor.start(omega, 1.0, state.z)
    for _ in range(2500):
        found = predictor.update(omega, 1.0, now)
        now = found.state
    assert found.amplitude == pytest.approx(state.amplitude, rel=0.01)
