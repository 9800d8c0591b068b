"""Error budgets: Monte Carlo against closed forms of random phasors."""

import json
import math

import numpy as np
import pytest
from scipy.special import ellipe

import strainwave as sw
from strainwave.study.kinematic_error.budget import span

QUANTILES = (0.1, 0.5, 0.9, 0.99)
DRAWS = 40_000


def of_order_two(*amplitudes, phases=None):
    phases = phases or [None] * len(amplitudes)
    pairs = enumerate(zip(amplitudes, phases, strict=True))
    return [sw.gears.Source(f"source {i}", "manufacture", 2, A, phase) for i, (A, phase) in pairs]


def drawn(sources, **options):
    return sw.study.error_budget(sources, quantiles=QUANTILES, draws=DRAWS, **options).total.quantiles


def test_two_sources_of_one_order_have_the_quantiles_of_two_random_phasors():
    # |A1 + A2 exp(i d)|^2 = A1^2 + A2^2 + 2 A1 A2 cos d with d uniform: below its value at d = pi (1 - q) with chance q
    A1, A2 = 3e-5, 2e-5
    for q, found in drawn(of_order_two(A1, A2)):
        slack = 4.0 * math.sqrt(q * (1.0 - q) / DRAWS)
        low, high = (
            2.0 * math.sqrt(A1**2 + A2**2 + 2.0 * A1 * A2 * math.cos(math.pi * (1.0 - p)))
            for p in (max(q - slack, 0.0), min(q + slack, 1.0))
        )
        assert low <= found <= high


def test_many_equal_sources_of_one_order_have_rayleighs_quantiles():
    # The resultant of n random phasors tends to Rayleigh's distribution: P(R < r) = 1 - exp(-r^2/(n A^2)).
    n, A = 60, 1e-6
    for q, found in drawn(of_order_two(*[A] * n)):
        assert found == pytest.approx(2.0 * A * math.sqrt(-n * math.log(1.0 - q)), rel=0.02)


def test_two_sources_of_orders_one_and_two_have_the_quantiles_over_their_phase():
    # Only the phase of order 2 against order 1 matters: cos t + r cos(2 t + d) on a fine grid of d and t.
    r = 0.5
    d = np.linspace(0.0, 2.0 * math.pi, 721)
    t = np.linspace(0.0, 2.0 * math.pi, 3601)
    values = np.cos(t) + r * np.cos(2.0 * t + d[:, None])
    spans = np.sort(np.ptp(values, axis=1))
    sources = [sw.gears.Source("one", "assembly", 1, 1.0), sw.gears.Source("two", "manufacture", 2, r)]
    for q, found in drawn(sources):
        assert found == pytest.approx(spans[int(q * len(spans))], rel=3e-3)


def test_mean_resultant_of_two_phasors_is_the_elliptic_integral():
    # Mean of |A1 + A2 exp(i d)| over d, and its root mean square, which is the root sum square.
    d = np.random.default_rng(0).uniform(0.0, 2.0 * math.pi, 40_000)
    spans = span(np.array([2]), (1.0 + 0.4 * np.exp(1j * d))[:, None])
    m = 4.0 * 0.4 / 1.4**2
    assert np.mean(spans) == pytest.approx(2.0 * 2.0 / math.pi * 1.4 * ellipe(m), rel=3e-3)
    assert math.sqrt(np.mean(spans**2)) == pytest.approx(2.0 * math.hypot(1.0, 0.4), rel=3e-3)


def test_known_phases_add_up_as_phasors():
    budget = sw.study.error_budget(of_order_two(3e-5, 4e-5, phases=[0.0, 0.5 * math.pi]))
    assert budget.draws == 1
    assert all(value == pytest.approx(1e-4, rel=1e-12) for _, value in budget.total.quantiles)
    (line,) = budget.error().lines
    assert (line.order, line.amplitude) == (2, pytest.approx(5e-5, rel=1e-12))
    assert line.phase == pytest.approx(math.atan2(4.0, 3.0), rel=1e-12)


def test_spans_are_those_of_the_exact_peak_to_peak():
    rng = np.random.default_rng(3)
    orders = np.array([1, 50, 100, 102, 200])
    amplitudes = rng.normal(size=(20, 5)) + 1j * rng.normal(size=(20, 5))
    for c, found in zip(amplitudes, span(orders, amplitudes), strict=True):
        lines = [sw.Line(int(k), abs(z), float(np.angle(z))) for k, z in zip(orders, c, strict=True)]
        assert found == pytest.approx(sw.gears.peak_to_peak(sw.KinematicError(tuple(lines))), rel=1e-3)


def filled(N=50):
    sizes = {
        "wave generator ellipticity": 6e-5,
        "wave generator eccentricity": 2e-5,
        "circular spline ovality": 4e-5,
        "flexspline ovality": 1e-5,
        "output bearing run-out": 3e-5,
    }
    known = sw.gears.static_sources(N)
    return [known[name]._replace(amplitude=size) for name, size in sizes.items()]


def test_a_budget_of_a_gear_adds_up():
    budget = sw.study.error_budget(filled(), N=50, draws=1000)
    total, rest = budget.total, budget.rest
    assert budget.turn == "output"
    assert total.worst_case == pytest.approx(2.0 * 16e-5, rel=1e-12)
    assert total.root_sum_square == pytest.approx(2.0 * math.sqrt(6**2 + 2**2 + 4**2 + 1 + 3**2) * 1e-5, rel=1e-12)
    assert sum(row.share for row in budget.rows) == pytest.approx(1.0, rel=1e-12)
    assert sum(row.square_share for row in budget.rows) == pytest.approx(1.0, rel=1e-12)
    assert [row.amplitude for row in budget.rows] == sorted((row.amplitude for row in budget.rows), reverse=True)
    values = [value for _, value in total.quantiles]
    assert values == sorted(values)
    assert values[-1] <= total.worst_case
    # what repeats with the wave generator can be compensated over the motor angle, the flexspline's turn cannot
    assert {row.name for row in budget.rows if not row.compensable} == {"flexspline ovality", "output bearing run-out"}
    assert rest.worst_case == pytest.approx(2.0 * 4e-5, rel=1e-12)
    # orders 1 and 102 on the output turn: nearly every pair of phases lets their peaks meet
    assert rest.quantiles[0][1] == pytest.approx(rest.worst_case, rel=2e-3)


def test_the_error_at_a_quantile_has_that_peak_to_peak():
    budget = sw.study.error_budget(filled(), N=50, draws=1000)
    for q, value in budget.total.quantiles:
        error = budget.error(q)
        assert sw.gears.peak_to_peak(error) == pytest.approx(value, rel=5e-3)
        assert error.orders() == (1, 50, 100, 102)


def test_budgets_repeat_with_their_seed_and_scale_with_their_sources():
    one, again = (sw.study.error_budget(of_order_two(1e-5, 2e-5, 3e-5), seed=7, draws=500) for _ in range(2))
    other = sw.study.error_budget(of_order_two(1e-5, 2e-5, 3e-5), seed=8, draws=500)
    twice = sw.study.error_budget(of_order_two(2e-5, 4e-5, 6e-5), seed=7, draws=500)
    assert one.total == again.total
    assert one.total.quantiles != other.total.quantiles
    for (_, a), (_, b) in zip(one.total.quantiles, twice.total.quantiles, strict=True):
        assert b == pytest.approx(2.0 * a, rel=1e-12)


def test_sources_of_a_gear_have_the_orders_of_its_map():
    known, orders = sw.gears.static_sources(80), sw.gears.order_map(80)
    assert known["flexspline ovality"].order == orders.order("flexspline tooth engagement").per_output_turn
    assert {source.kind for source in known.values()} == {"design", "manufacture", "assembly", "deformation"}
    assert all(source.amplitude == 0.0 for source in known.values())


def test_budgets_print_and_go_to_json():
    budget = sw.study.error_budget(filled(), N=50, draws=100)
    rows = str(budget).splitlines()
    assert len(rows) == 1 + 5 + 2
    assert rows[1].startswith("wave generator ellipticity")
    back = json.loads(json.dumps(budget.as_dict(), allow_nan=False))
    assert back["total"]["worst_case"] == budget.total.worst_case
    assert [row["name"] for row in back["sources"]] == [row.name for row in budget.rows]
    assert back["total"]["quantiles"][1]["probability"] == 0.95


GOOD = sw.gears.Source("a", "design", 2, 1e-5)


@pytest.mark.parametrize(
    ("sources", "options", "words"),
    [
        ([], {}, "no source has an amplitude"),
        ([GOOD._replace(amplitude=0.0)], {}, "no source has an amplitude"),
        ([GOOD, GOOD], {}, "'a' is the name of two sources"),
        ([GOOD._replace(amplitude=-1e-5)], {}, "the amplitude of 'a' is -1e-05"),
        ([GOOD._replace(amplitude=math.nan)], {}, "the amplitude of 'a' is nan"),
        ([GOOD._replace(phase=math.inf)], {}, "the phase of 'a' is inf"),
        ([GOOD._replace(order=0)], {}, "the order of 'a' is 0"),
        ([GOOD._replace(order=2.5)], {}, "the order of 'a' is 2.5"),
        ([GOOD._replace(kind="magic")], {}, "known are design, manufacture, assembly, deformation"),
        ([GOOD._replace(turn="load")], {}, "motor or output"),
        ([GOOD._replace(turn="output")], {}, "'a' repeats with the output; give the ratio N"),
        ([GOOD], {"N": 50.5}, "whole ratio"),
        ([GOOD], {"quantiles": [95]}, "probability between 0 and 1"),
        ([GOOD], {"quantiles": "x"}, "quantiles is 'x'; it must be one or more finite numbers"),
        ([GOOD], {"quantiles": []}, "quantiles is"),
        ([GOOD], {"draws": 0}, "draws is 0"),
        ([GOOD], {"seed": -1}, "seed is -1; it must be a whole number from 0"),
        ([GOOD], {"seed": "x"}, "seed is 'x'"),
        ([GOOD._replace(amplitude=1e-200)], {}, "the amplitude of 'a' is 1e-200"),
        ([GOOD._replace(amplitude=1e200)], {}, r"the amplitude of 'a' is 1e\+200"),
        (
            [GOOD._replace(order=5000), sw.gears.Source("b", "design", 1, 1e-5, turn="output")],
            {"N": 160},
            "'a' repeats 800000 times on the output turn that all share; orders go up to 10000",
        ),
    ],
)
def test_wrong_budgets_are_refused_in_one_sentence(sources, options, words):
    with pytest.raises(ValueError, match=words) as refusal:
        sw.study.error_budget(sources, **options)
    assert "\n" not in str(refusal.value)


def test_what_is_no_source_is_refused():
    with pytest.raises(TypeError, match="is no source"):
        sw.study.error_budget([("a", 2, 1e-5)])
    with pytest.raises(TypeError, match="the sources are None; write"):
        sw.study.error_budget(None)
    with pytest.raises(TypeError, match="a source has the name 3; write it as text"):
        sw.study.error_budget([GOOD._replace(name=3)])
    with pytest.raises(ValueError, match="probability between 0 and 1"):
        sw.study.error_budget([GOOD]).error(1.0)
