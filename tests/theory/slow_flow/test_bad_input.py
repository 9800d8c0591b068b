"""What cannot be meant is answered in one sentence; a nearly linear drive keeps its one steady state."""

import math
import warnings
from typing import NamedTuple

import exact_duffing
import numpy as np
import pytest

import strainwave as sw

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.2), sw.Harmonic(0.05), 1.05)
FLOWS = [sw.slow_flow(DUFFING, sw.PRIMARY, order=order) for order in (1, 2)]


@pytest.mark.parametrize("flow", FLOWS, ids=["first", "second"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e200, complex(0.0, math.nan)])
def test_a_state_that_is_no_finite_number_is_refused(flow, bad):
    for ask in (flow.rates, flow.attractor, lambda z: flow.steady_x(z, 0.0)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(ValueError, match=r"z \[rad\] is .*; it must be .*finite"):
                ask(bad)


def test_a_predictor_starts_from_finite_numbers_and_knows_its_flags():
    predictor = FLOWS[0].predictor(0.02, speeds=np.array([1.0, 1.1]))
    for start in ((math.nan,), (1.05, math.inf), (1.05, 1.0, math.nan), (1.05, 1.0, 1e200), (1.05, 1.0, 0j, math.nan)):
        with pytest.raises(ValueError, match=r"the start of a predictor .*; give finite numbers"):
            predictor.start(*start)
    for flag in (9, math.nan):
        with pytest.raises(ValueError, match="a prediction has one of 0, 1, 2, 3, 4"):
            predictor.meaning(flag)


@pytest.mark.parametrize("omega", [0.01, 0.34])
@pytest.mark.parametrize("law", [sw.Cubic(1.0, 1e-8), sw.Polynomial((0.0, 1.0, 0.0, 1e-8, 0.0, 1e-8))])
def test_a_nearly_linear_superharmonic_has_the_state_of_the_first_step_of_its_balance(law, omega):
    """The cube of the forced motion drives 3 omega through the linear response of the drive."""
    system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.05), omega)
    states = sw.slow_flow(system, sw.SUPERHARMONIC, order=2).steady_states()
    forced, third = 0.05 / complex(1.0 - omega**2, 0.05 * omega), 3.0 * omega
    expected = 0.25e-8 * abs(forced) ** 3 / abs(complex(1.0 - third**2, 0.05 * third))
    assert [s.amplitude for s in states] == pytest.approx([expected], rel=1e-2)
    assert states[0].stable


def test_the_motion_without_a_superharmonic_is_no_second_state_of_a_cubic():
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 1e-12), sw.Harmonic(0.05), 0.34)
    (state,) = sw.slow_flow(system, sw.SUPERHARMONIC).steady_states()
    forced = 0.05 / (1.0 - 0.34**2)
    assert state.amplitude == pytest.approx(0.125e-12 * forced**3 / abs(complex(0.025, 0.02)), rel=1e-9)


@pytest.mark.parametrize(("release", "valid"), [(1.0, True), (2.0, True), (3.2, False), (5.0, False)])
def test_a_transient_says_how_far_its_frequency_is_from_that_of_elliptic_functions(release, valid):
    free = sw.Oscillator(1.0, 0.0, sw.Cubic(1.0, 0.2), sw.Harmonic(0.0), 1.0)
    (true,) = exact_duffing.frequency(free, [release])
    damped = free._replace(B=1e-4)
    found = sw.slow_flow(damped, sw.NONRESONANT).evolve((release, 0.0), np.linspace(0.0, 20.0, 201))
    off = abs((1.0 + 0.075 * release**2) / true - 1.0)
    assert 0.5 < off / found.error < 1.5
    assert found.valid == valid
    assert ("start closer to equilibrium, or integrate" in found.message) == (not valid)
    assert found.message in str(found)


class Sinh(NamedTuple):
    """T = K sinh x."""

    K: float

    def torque(self, x):
        return self.K * np.sinh(x)

    def stiffness(self, x):
        return self.K * np.cosh(x)


@pytest.mark.parametrize(
    ("system", "resonance", "start", "end"),
    [
        (DUFFING._replace(law=Sinh(1.0)), sw.PRIMARY, 2000.0, 20.0),
        (DUFFING._replace(B=-0.05, omega=0.4), sw.NONRESONANT, 0.1, 3e4),
    ],
    ids=["sinh", "negative damping"],
)
def test_a_transient_that_leaves_all_finite_numbers_is_refused_without_warning(system, resonance, start, end):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sw.SolveError, match="closer to equilibrium"):
            sw.slow_flow(system, resonance).evolve((start, 0.0), [0.0, 0.5 * end, end])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("omega", [2.0, 3.01])
def test_a_forced_motion_that_pumps_the_free_one_is_not_called_valid(order, omega):
    """Beside 1:2 of a square law the Floquet multipliers of the true motion leave the unit circle."""
    system = sw.Oscillator(1.0, 0.02, sw.Polynomial((0.0, 1.0, 0.3, 0.1)), sw.Harmonic(2.0), omega)
    verdict = sw.slow_flow(system, sw.NONRESONANT, order=order).certificate()
    stable = bool(np.max(np.abs(sw.find_orbit(system).multipliers)) < 1.0)
    assert verdict.valid == stable
    assert ("beside a resonance" in verdict.sentence) == (not stable)


@pytest.mark.parametrize("states", [lambda flow: flow.steady_states(), lambda flow: flow.states_at([3.0])])
def test_a_continuum_of_states_without_damping_is_refused(states):
    # below 0.5 rad the law is linear, and every free vibration of a third of the forcing's frequency is a motion
    law = sw.PiecewiseLinear(1.0, 2.0, 3.0, 0.5, 1.0)
    flow = sw.slow_flow(sw.Oscillator(1.0, 0.0, law, sw.Harmonic(0.5), 3.0), sw.SUBHARMONIC)
    with pytest.raises(sw.SolveError, match="without damping every small amplitude is a steady state at omega = 3 rad"):
        states(flow)


@pytest.mark.parametrize("name", ["subharmonik", "primary", None, 3, (1,)])
def test_what_is_no_resonance_is_refused_with_the_names_of_the_four(name):
    for ask in (sw.slow_flow, lambda system, name: sw.isolas(system, (0.5, 2.0), resonance=name)):
        with pytest.raises(ValueError, match="PRIMARY, SUPERHARMONIC, SUBHARMONIC, NONRESONANT or a Resonance"):
            ask(DUFFING, name)


def test_a_list_of_two_zeros_is_no_resonance_as_the_tuple_is():
    assert sw.Resonance.of([0, 0]) == sw.Resonance.of((0, 0)) == sw.NONRESONANT


@pytest.mark.parametrize("order", [1, 2])
def test_no_state_is_stable_past_the_saddles_of_a_softening_law(order):
    """T = x - x^3/5 turns over at x = sqrt 5, from where integration leaves every bound."""
    past = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, -0.2), sw.Harmonic(3.0), 0.7)
    assert not sw.simulate(past, (0.0, 0.0), 60.0).status
    flow = sw.slow_flow(past, sw.PRIMARY, order=order)
    states = [state for state in flow.steady_states() if state.amplitude > math.sqrt(5.0)]
    assert states
    assert not any(state.stable for state in states)
    assert not flow.certificate().valid
    assert f"it passes a saddle of the law, {math.sqrt(5.0):.6g} rad from rest" in flow.certificate().sentence
    before = sw.slow_flow(past._replace(excitation=sw.Harmonic(0.005), omega=0.98), sw.PRIMARY, order=order)
    assert before.steady_states()[-1].stable
    assert before.certificate().valid
    branch = flow.response((0.5, 0.9)).branches[0]
    assert not np.any(branch.stable & (branch.amplitude > math.sqrt(5.0)))
