"""What a model does not explain is named, and what it explains is not."""

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from strainwave.study.identification.discrepancy import discrepancy

ROWS, SETS = 1500, 200
K = np.arange(ROWS)
MOTION = np.exp(-K / 1000.0) * np.cos(0.3 * K)
SPEED = np.exp(-K / 1000.0) * np.sin(0.3 * K)
JACOBIAN = np.column_stack([MOTION, SPEED, MOTION**3])


def left(values):
    return values - JACOBIAN @ (np.linalg.pinv(JACOBIAN) @ values)


def coloured(rng):
    return 0.01 * lfilter([1.0], [1.0, -0.8], rng.standard_normal(ROWS))


def test_white_noise_is_called_white_at_the_rate_that_is_said():
    rng = np.random.default_rng(0)
    alarms = sum(discrepancy(left(rng.standard_normal(ROWS)), JACOBIAN).white < 0.05 for _ in range(SETS))
    assert stats.binom.ppf(0.001, SETS, 0.05) <= alarms <= stats.binom.ppf(0.999, SETS, 0.05)


def test_share_that_the_past_predicts_is_that_of_the_filter():
    found = discrepancy(left(coloured(np.random.default_rng(1))), JACOBIAN)
    assert found.white < 1e-10
    assert found.coloured == pytest.approx(0.8**2, abs=0.04)


def test_a_missing_term_is_flagged_and_an_idle_one_at_its_rate():
    rng = np.random.default_rng(2)
    candidates = {"|v| v": np.abs(SPEED) * SPEED, "x^5": MOTION**5}
    flagged = {name: 0 for name in candidates}
    for _ in range(SETS):
        found = discrepancy(left(coloured(rng) + 0.05 * candidates["|v| v"]), JACOBIAN, candidates)
        for name in found.flagged:
            flagged[name] += 1
    assert flagged["|v| v"] >= 0.95 * SETS
    assert flagged["x^5"] <= stats.binom.ppf(0.999, SETS, 0.05)


def test_the_coefficient_of_a_missing_term_is_found_beside_the_others():
    found = discrepancy(
        left(coloured(np.random.default_rng(3)) + 0.3 * np.abs(SPEED) * SPEED),
        JACOBIAN,
        {"|v| v": np.abs(SPEED) * SPEED},
    )
    term = found.missing["|v| v"]
    assert abs(term.coefficient - 0.3) < 3.0 * term.deviation
    assert term.deviation < 0.1
    assert "missing in the model: |v| v" in str(found)


def test_a_term_that_the_parameters_stand_for_is_not_missing():
    residual = left(coloured(np.random.default_rng(4)))
    assert discrepancy(residual, JACOBIAN, {"x": 2.0 * MOTION}).missing["x"].probability == 1.0


def test_a_line_is_found_above_coloured_noise():
    residual = left(coloured(np.random.default_rng(5)) + 0.02 * np.cos(2.0 * np.pi * 0.2 * K))
    found = discrepancy(residual, JACOBIAN, interval=1e-3)
    assert found.line == pytest.approx(200.0, abs=0.5)
    assert found.line_amplitude == pytest.approx(0.02, rel=0.1)
    assert found.line_probability < 1e-6
    assert discrepancy(left(coloured(np.random.default_rng(5))), JACOBIAN).line_probability > 1e-3
