"""Ensembles against single integrations, closed forms and harmonic balance; bits that do not depend on the batch."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import simpson

import strainwave as sw

pytestmark = pytest.mark.slow

DUFFING = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
ALL = (sw.Peak(), sw.numerics.Extremes(), sw.Rms(), sw.numerics.Mean(), sw.Amplitude(1), sw.Final())
FEW = {"omega": np.array([0.8, 1.1]), "law.alpha": np.array([0.02, 0.08])}
METHODS = [
    # of the states, and of what is integrated or interpolated (fourth order where the motion is not periodic)
    pytest.param(sw.Dop8(steps_per_period=64), 5e-9, 1e-6, id="Dop8"),
    pytest.param(sw.Rk4(steps_per_period=200), 2e-6, 2e-6, id="Rk4"),
    pytest.param(sw.Dopri5(rtol=1e-10, atol=1e-12), 2e-8, 2e-6, id="Dopri5"),
]


def single(system, y0, periods, settle):
    """Peak, extremes, rms, mean, amplitude(1) and final state by one tight integration of the same span."""
    turn = 2.0 * np.pi / system.omega
    t = np.linspace(0.0, (settle + periods) * turn, (settle + periods) * 2000 + 1)
    run = sw.simulate(system, y0, t, method=sw.Dopri5(rtol=1e-12, atol=1e-14))
    assert run.status
    x, v, t = run.y[0, settle * 2000 :], run.y[1, settle * 2000 :], t[settle * 2000 :]
    top = [float(np.max(np.abs(x))), float(np.min(x)), float(np.max(x))]
    crossings = np.flatnonzero(v[1:] * v[:-1] < 0.0)
    s = v[crossings] / (v[crossings] - v[crossings + 1])
    inside = x[crossings] + 0.5 * s * v[crossings] * (t[1] - t[0])
    top = [max(top[0], np.max(np.abs(inside))), min(top[1], np.min(inside)), max(top[2], np.max(inside))]
    time = periods * turn
    rms = np.sqrt(simpson(x * x, x=t) / time)
    harmonic = 2.0 / time * simpson(x * np.exp(-1j * system.omega * t), x=t)
    return (*top, rms, simpson(x, x=t) / time, abs(harmonic), run.y[:, -1])


@pytest.mark.slow
@pytest.mark.parametrize(("method", "of_states", "of_sums"), METHODS)
def test_every_lane_is_the_single_integration(method, of_states, of_sums):
    biased = DUFFING._replace(
        excitation=sw.Harmonic(1.0, phase=0.3, mean=0.2), error=sw.KinematicError((sw.Line(2, 0.05, 0.4),))
    )
    found = sw.ensemble(biased, FEW, (0.1, -0.2), periods=3, settle=2, measures=ALL, method=method)
    for i in range(2):
        one = sw.replaced(biased, {path: float(values[i]) for path, values in FEW.items()})
        *wanted, final = single(one, (0.1, -0.2), 3, 2)
        names = ("peak", "lowest", "highest", "rms", "mean", "amplitude_1")
        got = [float(found[name][i]) for name in names]
        np.testing.assert_allclose(got, wanted, rtol=0.0, atol=of_sums, err_msg=str(method))
        np.testing.assert_allclose(found["final"][:, i], final, rtol=0.0, atol=of_states)


@pytest.mark.slow
def test_the_error_estimate_bounds_the_error_within_its_order():
    coarse = sw.ensemble(DUFFING, FEW, (0.0, 0.0), periods=4, measures=ALL, method=sw.Rk4(steps_per_period=40))
    exact = sw.ensemble(DUFFING, FEW, (0.0, 0.0), periods=4, measures=ALL, method=sw.Dopri5(rtol=1e-11, atol=1e-13))
    for name in ("rms", "final"):
        error = float(np.max(np.abs(coarse[name] - exact[name])))
        assert 0.5 * error < coarse[name].attrs["error_estimate"] < 2.0 * error


@pytest.mark.slow
@pytest.mark.parametrize("method", [sw.Dop8(), sw.Rk4(steps=128)])
def test_the_error_estimate_of_fixed_steps_over_kinks_is_no_smaller_than_the_error(method):
    """Errors are of second order and differ from lane to lane: near the fold they are a hundred times the median."""
    system = sw.Oscillator(1.0, 0.1, sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), sw.Harmonic(0.6), 1.0)
    lanes = {"omega": np.linspace(0.2, 2.5, 400)}
    call = {"periods": 4, "settle": 100, "measures": (sw.Peak(), sw.Rms(), sw.Amplitude(1))}
    coarse = sw.ensemble(system, lanes, (0.0, 0.0), method=method, **call)
    exact = sw.ensemble(system, lanes, (0.0, 0.0), method=sw.Dopri5(rtol=1e-12, atol=1e-14), **call)
    for name in ("peak", "rms", "amplitude_1"):
        error = float(np.max(np.abs(coarse[name] - exact[name])))
        assert error < coarse[name].attrs["error_estimate"] < 4.0 * error


def test_an_order_above_those_of_the_system_gets_its_steps():
    """In 32 steps a turn cos(33 phase) is cos(phase): order 33 would have the amplitude of order 1."""
    linear = sw.Oscillator(1.0, 0.5, sw.Linear(1.0), sw.Harmonic(1.0), 0.5)
    found = sw.ensemble(linear, {}, (0.0, 0.0), periods=1, settle=8, measures=(sw.Amplitude(1), sw.Amplitude(33)))
    assert found["amplitude_1"][0] > 1.0
    assert found["amplitude_33"][0] < 1e-6


def test_bits_do_not_depend_on_the_place_in_the_batch_or_on_threads():
    rng = np.random.default_rng(1)
    values = {"omega": rng.uniform(0.5, 2.0, 700), "law.alpha": rng.uniform(0.0, 0.2, 700)}
    whole = sw.ensemble(DUFFING, values, (0.3, 0.0), periods=5, measures=ALL, threads=2)
    part = sw.ensemble(
        DUFFING, {p: v[::-1][100:350] for p, v in values.items()}, (0.3, 0.0), periods=5, measures=ALL, threads=1
    )
    for name in ("peak", "rms", "mean", "amplitude_1", "final"):
        assert np.array_equal(whole[name].values[..., ::-1][..., 100:350], part[name].values)


def test_settled_peaks_are_those_of_harmonic_balance():
    omega = np.array([0.5, 0.9, 1.9])
    found = sw.ensemble(DUFFING, {"omega": omega}, (0.0, 0.0), periods=2, settle=120)
    for i, w in enumerate(omega):
        orbit = sw.find_orbit(sw.replaced(DUFFING, {"omega": float(w)}))
        assert float(found["peak"][i]) == pytest.approx(orbit.peak, rel=2e-6)
        assert int(found["period"][i]) == 1


def test_a_subharmonic_motion_settles_with_its_period():
    """Nayfeh & Mook 4.1.4: beside the trivial orbit a stable one of three turns."""
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.2), sw.Harmonic(6.0), 4.0)
    isola = sw.isolas(system, (3.5, 4.5))[0]
    place = int(np.flatnonzero(isola.stable)[len(np.flatnonzero(isola.stable)) // 2])
    series, omega = isola.coefficients[place], float(isola.omega[place])
    k = np.arange(1, len(series) // 2 + 1)
    start = float(series[0] + np.sum(series[1::2])), float(np.sum(k * omega / 3.0 * series[2::2]))
    found = sw.ensemble(system._replace(omega=omega), {}, start, periods=3, settle=90)
    trivial = sw.ensemble(system._replace(omega=omega), {}, (0.0, 0.0), periods=3, settle=900)
    assert (int(found["period"][0]), int(trivial["period"][0])) == (3, 1)
    assert float(found["peak"][0]) == pytest.approx(isola.peak[place], rel=1e-5)


@pytest.mark.parametrize("law", [sw.Backlash(1.0, 0.5), sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2)])
def test_laws_with_kinks_take_adaptive_steps(law):
    system = sw.Oscillator(1.0, 0.1, law, sw.Harmonic(0.6), 0.8)
    varied = {"omega": np.array([0.8, 0.7])}
    found = sw.ensemble(system, varied, (0.0, 0.0), periods=4, measures=ALL)
    finer = sw.ensemble(system, varied, (0.0, 0.0), periods=4, measures=ALL, method=sw.Dopri5(rtol=1e-11, atol=1e-14))
    assert found.attrs["method"].startswith("Dopri5(rtol=1e-09")
    for i, w in enumerate((0.8, 0.7)):
        *wanted, final = single(sw.replaced(system, {"omega": w}), (0.0, 0.0), 4, 0)
        for data, rtol in ((found, 1e-9), (finer, 1e-11)):  # some hundred steps, each wrong by up to rtol
            np.testing.assert_allclose(data["final"][:, i], final, rtol=0.0, atol=1e3 * rtol)
        assert float(found["rms"][i]) == pytest.approx(wanted[3], rel=1e-6)


def test_lanes_with_more_stiffness_get_more_steps():
    stiff = sw.ensemble(DUFFING, {"law.alpha": np.array([0.0, 400.0])}, (1.0, 0.0), periods=3)
    assert stiff["steps"][1] > 3 * stiff["steps"][0]
    assert np.all(stiff["status"] == 0)


@pytest.mark.parametrize("method", [sw.Dop8(steps_per_period=24), sw.Dopri5(rtol=1e-6, atol=1e-8)])
def test_a_lane_that_diverges_says_so_and_leaves_the_others_alone(method):
    soft = DUFFING._replace(law=sw.Cubic(1.0, -1.0), excitation=sw.Harmonic(0.1))
    found = sw.ensemble(
        soft, {}, (np.array([0.1, 3.0]), 0.0), periods=2, method=method, measures=(sw.Peak(), sw.Final())
    )
    assert found["status"].values.tolist() == [0, 1]
    assert np.isfinite(found["peak"][0])
    assert np.isnan(found["peak"][1])
    assert float(found["ended"][1]) < float(found["ended"][0])
    assert np.isfinite(found["final"].values).tolist() == [[True, False], [True, False]]


def test_a_single_number_is_shared_by_all_lanes():
    method = sw.Rk4(steps_per_period=16)
    shared = sw.ensemble(DUFFING, FEW | {"B": 0.2}, (0.0, 0.0), periods=1, method=method)
    each = sw.ensemble(DUFFING, FEW | {"B": [0.2, 0.2]}, (0.0, 0.0), periods=1, method=method)
    assert np.array_equal(shared["peak"], each["peak"])


def test_units_and_coordinates():
    found = sw.ensemble(
        DUFFING, FEW, (0.0, 0.0), periods=1, measures=(sw.Peak(), sw.Final()), method=sw.Rk4(steps_per_period=16)
    )
    assert found["omega"].attrs["units"] == "rad/s"
    assert found["peak"].attrs["units"] == "rad"
    assert list(found["state"].values) == ["x", "x'"]


def test_rows_of_a_table_are_lanes_and_then_states():
    found = sw.ensemble(DUFFING, FEW, (0.0, 0.0), periods=1, measures=(sw.Final(),), method=sw.Rk4(steps_per_period=16))
    assert found.to_dataframe().index.names == ["lane", "state"]


class OfEnd(NamedTuple):
    """A measure of one's own that gives lists or, of a sum over all lanes, one number."""

    share: bool

    def of_end(self, y):
        return {"total": float(np.sum(y[0]))} if self.share else {"last": y[0].tolist()}


def test_a_measure_of_ones_own_may_give_lists_and_is_refused_without_a_value_for_every_lane():
    how = {"periods": 1, "method": sw.Rk4(steps_per_period=16)}
    own = sw.ensemble(DUFFING, FEW, (0.0, 0.0), measures=(OfEnd(share=False), sw.Final()), **how)
    assert own["last"].values.tolist() == own["final"].values[0].tolist()
    with pytest.raises(ValueError, match=r"OfEnd\.of_end gives 'total' without a value for every lane"):
        sw.ensemble(DUFFING, FEW, (0.0, 0.0), measures=(OfEnd(share=True),), **how)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"parameters": {"omega": [1.0, 2.0], "B": [0.1, 0.2, 0.3]}}, "lengths"),
        ({"parameters": {"omga": [1.0]}}, "no parameter 'omga'"),
        ({"parameters": {"excitation.order": [1.0]}}, "whole number"),
        ({"parameters": {"omega": [1.0, np.nan]}}, "finite"),
        ({"parameters": {"omega": [1.0, 0.0]}}, "lane 1: omega is 0 rad/s; it must be positive"),
        ({"parameters": {"omega": [1.0, -1.0]}}, "lane 1: omega is -1 rad/s; it must be positive"),
        ({"parameters": {"J": [1.0, -1.0]}}, "inertia"),
        ({"y0": (0.0,)}, "1 states"),
        ({"periods": 0}, "periods is 0"),
        ({"settle": -1}, "settle is -1"),
        ({"measures": ()}, "measures"),
        ({"periods": 10**30}, "it must be at most 1000000000"),
        ({"threads": 0}, "threads is 0"),
        ({"method": "rk4"}, "method is 'rk4'"),
        ({"measures": (sw.Amplitude(1.5),)}, "Amplitude.k is 1.5; it must be a whole number of at least 1"),
        ({"measures": (sw.Amplitude(10**7),)}, "orders up to 2500000 .* takes more than"),
        (
            {"parameters": {"omega": [1.0, 1e-9]}},
            "lane 1: a period at omega = 1e-09 rad/s, with .* takes more than 10000000 steps",
        ),
        (
            {"measures": (sw.Amplitude(9),), "method": sw.Dop8(steps_per_period=32)},
            r"Amplitude\(9\) is of an order that the steps of Dop8\(.*\) do not resolve; take steps_per_period=36",
        ),
        (
            {"measures": (sw.Amplitude(5),), "method": sw.Rk4(steps_per_period=32)},
            r"Amplitude\(5\) is of an order .* take steps_per_period=40",
        ),
        ({"measures": (sw.Amplitude(100),), "method": sw.Dopri5()}, r"take a smaller rtol, or Dop8\("),
    ],
)
def test_bad_input_is_one_sentence(change, sentence):
    arguments = {"parameters": FEW, "y0": (0.0, 0.0), "periods": 1} | change
    with pytest.raises((ValueError, TypeError), match=sentence):
        sw.ensemble(DUFFING, arguments.pop("parameters"), arguments.pop("y0"), **arguments)


def test_fixed_steps_cannot_be_chosen_for_a_law_with_memory():
    system = sw.Oscillator(1.0, 0.1, sw.BoucWen(1.0, 0.4, 0.3), sw.Harmonic(1.0), 1.0)
    with pytest.raises(
        TypeError, match="a law with friction or memory has no rate to choose a step from; give steps_per"
    ):
        sw.ensemble(system, {}, (0.0, 0.0, 0.0), periods=1, method=sw.Dop8())


OVERDAMPED = sw.Oscillator(1.0, 20.0, sw.Backlash(1.0, 0.1), sw.Harmonic(0.0), 1.0)


@pytest.mark.parametrize("law", [sw.Backlash(1.0, 0.1), sw.Cubic(1.0, 0.05)])
@pytest.mark.parametrize(("y0", "name", "wanted"), [((1.0, -10.0), "highest", 1.0), ((0.05, 1.0), "lowest", 0.05)])
def test_the_first_state_of_adaptive_lanes_counts(law, y0, name, wanted):
    system = OVERDAMPED._replace(law=law)
    found = sw.ensemble(system, {}, y0, periods=1, measures=(sw.numerics.Extremes(), sw.Peak()), method=sw.Dopri5())
    assert float(found[name][0]) == wanted
    assert float(found["peak"][0]) >= abs(wanted)


def test_a_stiff_lane_stops_alone_and_says_why():
    speeds = {"law.K": np.array([1.0, 2.0, 1e8])}
    system = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.0), 1.0)
    method = sw.Dopri5(max_steps=1000)
    found = sw.ensemble(system, speeds, (0.2, 0.1), periods=3, method=method)
    alone = sw.ensemble(system, {"law.K": speeds["law.K"][:2]}, (0.2, 0.1), periods=3, method=method)
    assert found["status"].values.tolist() == [0, 0, 2]
    assert np.array_equal(found["peak"].values[:2], alone["peak"].values)
    assert np.isnan(found["peak"].values[2])
    assert float(found["ended"][2]) == 0.0


def test_harmonics_of_a_motion_that_hardly_moves_are_those_of_the_motion():
    still = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.0, mean=1.0), 1.0)
    at_rest = sw.ensemble(still, {}, (1.0, 0.0), periods=3, measures=(sw.Amplitude(3),), method=sw.Dopri5())
    assert float(at_rest["amplitude_3"][0]) < 1e-14
    fast = sw.Oscillator(1.0, 0.05, sw.Backlash(1.0, 0.1), sw.Harmonic(0.1), 1000.0)
    kept = tuple(sw.Amplitude(k) for k in (1, 2, 3))
    adaptive = sw.ensemble(fast, {}, (1.0, 0.0), periods=4, measures=kept)
    fixed = sw.ensemble(fast, {}, (1.0, 0.0), periods=4, measures=kept, method=sw.Dop8(steps_per_period=256))
    for k in (1, 2, 3):
        assert float(adaptive[f"amplitude_{k}"][0]) == pytest.approx(float(fixed[f"amplitude_{k}"][0]), abs=1e-9)


@pytest.mark.parametrize("method", [sw.Dop8(), sw.Dopri5()])
def test_a_motion_at_rest_or_at_its_turning_points_has_period_one(method):
    decayed = sw.Oscillator(1.0, 0.5, sw.Cubic(1.0, 0.1), sw.Harmonic(0.0), 1.0)
    undamped = sw.Oscillator(1.0, 0.0, sw.Linear(4.0), sw.Harmonic(3.0), 1.0)  # x = cos t: v = 0 after every turn
    for system, settle in ((decayed, 40), (undamped, 1)):
        found = sw.ensemble(system, {}, (1.0, 0.0), periods=9, settle=settle, method=method)
        assert found["period"].values.tolist() == [1]


class Crossed(NamedTuple):
    """A system whose first rate is the second state at the state (2, 3), and nowhere else."""

    omega: float

    def rhs(self, phase, y):
        return 1.5 * y[1] - 0.5 * y[0] - 0.5, -2.0 * y[0] - 0.3 * y[1]


def test_a_rate_that_is_the_second_state_by_chance_is_not_taken_for_it():
    found = sw.ensemble(
        Crossed(1.0), {}, (1.0, 0.0), periods=2, measures=(sw.numerics.Extremes(),), method=sw.Dopri5(rtol=1e-11)
    )
    run = sw.simulate(Crossed(1.0), (1.0, 0.0), np.linspace(0.0, 4.0 * np.pi, 200_001), method=sw.Dopri5(rtol=1e-11))
    assert float(found["lowest"][0]) == pytest.approx(float(run.y[0].min()), abs=1e-9)


class Kick(NamedTuple):
    """A torque for 1/25 of every turn, from the angle `at` on."""

    amplitude: float
    at: float

    def torque(self, angle):
        sign = sw.maths.sign
        return 0.5 * self.amplitude * (sign(angle - self.at) - sign(angle - self.at - 2.0 * np.pi / 25.0))


def test_adaptive_lanes_meet_a_kick_after_a_rest():
    # in the gap J x'' + B x' = A for the length d of the kick, else 0: x comes to rest at A d/B, within exp(-3.5 B)
    system = sw.Oscillator(1.0, 4.0, sw.Backlash(1e4, 1.0), Kick(4.0, 2.5), 1.0)
    B = np.array([4.0, 6.0])
    found = sw.ensemble(system, {"B": B}, (0.0, 0.0), periods=1, method=sw.Dopri5(rtol=1e-7), measures=(sw.Peak(),))
    np.testing.assert_allclose(found.peak, 4.0 * 2.0 * np.pi / 25.0 / B, rtol=2e-5)


def test_largest_step_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match=r"Dopri5\.largest_step is 0\.1 s; steps of an ensemble are at most 1/16 of a"):
        sw.ensemble(DUFFING, FEW, (0.0, 0.0), periods=1, method=sw.Dopri5(largest_step=0.1))
