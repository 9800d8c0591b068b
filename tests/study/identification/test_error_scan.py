"""Lines of a measured error: against exact scans, Fourier transform, scatter over seeds, and SciPy's Lomb-Scargle."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter, lombscargle

import strainwave as sw
from strainwave.study.identification.orders.order_fit import power

TURN = 2.0 * math.pi
TRUE = ((1, 2.0e-5, -1.0), (2, 1.0e-4, 0.3), (4, 1.0e-5, 2.0))


def lines_at(theta, lines=TRUE):
    return sum(A * np.cos(k * theta + phi) for k, A, phi in lines)


def uniform(n, turns=1.0):
    return np.linspace(0.0, TURN * turns, n, endpoint=False)


def uneven(rng, n, turns):
    return np.sort(rng.uniform(0.0, TURN * turns, n))


def coloured(rng, n, rho):
    """A unit first-order autoregressive sequence."""
    return lfilter([math.sqrt(1.0 - rho * rho)], [1.0, -rho], rng.normal(size=n + 500))[500:]


def test_an_exact_scan_gives_its_lines_mean_and_drift():
    theta = uneven(np.random.default_rng(1), 500, 3.3) + 0.4
    scan = sw.error_scan(theta, lines_at(theta) + 1e-3 + 2e-5 * (theta - np.mean(theta[[0, -1]])))
    assert [line.order for line in scan.lines] == [1, 2, 4]
    for line, (_, amplitude, phase) in zip(scan.lines, TRUE, strict=True):
        assert line.amplitude == pytest.approx(amplitude, abs=1e-16)
        assert line.phase == pytest.approx(phase, abs=1e-10)
    assert scan.mean == pytest.approx(1e-3, rel=1e-12)
    assert scan.drift == pytest.approx(2e-5, rel=1e-10)
    assert scan.residual < 1e-16
    error = sw.KinematicError(tuple(sw.Line(*line) for line in TRUE))
    assert scan.peak_to_peak == pytest.approx(sw.gears.peak_to_peak(error), rel=1e-10)
    assert scan.error.value(0.7) == pytest.approx(error.value(0.7), rel=1e-10)


def test_on_uniform_whole_turns_least_squares_is_the_fourier_transform():
    theta = uniform(720, 2)
    e = lines_at(theta) + 1e-5 * np.random.default_rng(2).normal(size=720)
    scan = sw.error_scan(theta, e, orders=[1, 2, 3, 4], drift=False)
    spectrum = np.fft.rfft(e)[2 * np.array([1, 2, 3, 4])] * 2.0 / 720
    found = [line.amplitude * np.exp(1j * line.phase) for line in scan.lines]
    assert np.allclose(found, spectrum, rtol=0.0, atol=1e-19)
    assert scan.mean == pytest.approx(np.mean(e), abs=1e-18)


@pytest.mark.parametrize(
    ("rho", "n", "turns", "even", "noise"),
    [
        (0.0, 720, 1.0, True, "white"),
        (0.8, 720, 1.0, True, "autocorrelated"),
        (0.8, 1000, 3.3, True, "autocorrelated"),
        (0.0, 300, 1.5, False, "white"),
    ],
)
def test_standard_errors_are_the_scatter_over_seeds(rho, n, turns, even, noise):
    seeds, sigma = 200, 3e-6
    found = np.empty((seeds, 4))
    stated = np.empty((seeds, 4))
    kinds = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        theta = uniform(n, turns) if even else uneven(rng, n, turns)
        scan = sw.error_scan(theta, lines_at(theta) + sigma * coloured(rng, n, rho), orders=[1, 2, 4])
        kinds.append(scan.noise)
        two, four = scan.lines[1:]
        found[seed] = two.amplitude, two.phase, four.amplitude, four.phase
        stated[seed] = two.amplitude_error, two.phase_error, four.amplitude_error, four.phase_error
    # The scatter of 200 seeds is itself known to 5 % (one standard deviation), the local noise to about 10 %.
    ratio = np.sqrt(np.mean(stated**2, axis=0)) / np.std(found, axis=0)
    assert np.all((ratio > 0.85) & (ratio < 1.17)), ratio
    assert kinds.count(noise) > 0.97 * seeds
    assert np.mean(found[:, 0]) == pytest.approx(1e-4, abs=4.0 * np.std(found[:, 0]) / math.sqrt(seeds))


def test_taking_coloured_noise_for_white_understates_the_error():
    stated = {}
    theta = uniform(720)
    e = lines_at(theta) + 3e-6 * coloured(np.random.default_rng(5), 720, 0.8)
    for noise in ("white", "autocorrelated"):
        stated[noise] = sw.error_scan(theta, e, orders=[1, 2, 4], noise=noise).lines[1].amplitude_error
    # power of the sequence at low orders over its variance: (1 + rho)/(1 - rho) = 9, so 3 in amplitude
    assert stated["autocorrelated"] / stated["white"] == pytest.approx(3.0, rel=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(("rho", "even"), [(0.0, True), (0.8, True), (0.0, False)])
def test_noise_alone_gives_lines_no_oftener_than_stated(rho, even):
    alarms, seeds = 0, 100
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        theta = uniform(400) if even else uneven(rng, 400, 2.2)
        alarms += bool(sw.error_scan(theta, coloured(rng, 400, rho), false_alarm=0.05, highest=50).lines)
    assert alarms <= 11  # 5 expected, 11 or more by chance in 1 of 70


def coverage(turns, drift, rho, lines, n=128, sigma=1e-5, seeds=300):
    """Scans with a false line, scans with all lines, amplitudes over the true ones, and scores of the errors stated."""
    false, complete, ratios, scores = 0, 0, [], []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, int(100 * turns), int(10 * rho)])
        theta = uniform(int(n * turns), turns)
        true = {k: (A, rng.uniform(-math.pi, math.pi)) for k, A in lines}
        e = lines_at(theta, [(k, *line) for k, line in true.items()]) + sigma * coloured(rng, len(theta), rho)
        scan = sw.error_scan(theta, e + 2e-5 * theta * drift, drift=drift, highest=40)
        found = {line.order: line for line in scan.lines}
        assert all(line.false_alarm < 0.01 for line in scan.lines)
        false += bool(set(found) - set(true))
        complete += set(true) <= set(found)
        for k in set(true) & set(found):
            ratios.append(found[k].amplitude / true[k][0])
            scores.append((found[k].amplitude - true[k][0]) / found[k].amplitude_error)
    return false, complete, np.array(ratios), np.array(scores)


def test_a_clean_order_over_one_turn_gets_no_other_line():
    # before it is fitted the drift takes part of it and leaves a ramp with lines of every order
    false, complete, *_ = coverage(1.0, True, 0.0, [(2, 1e-4)])
    assert false <= 9  # 3 of 300 expected, 10 or more by chance in 1 of 900
    assert complete == 300


@pytest.mark.slow
@pytest.mark.parametrize("rho", [0.0, 0.8])
@pytest.mark.parametrize("drift", [True, False])
@pytest.mark.parametrize(("turns", "lines"), [(1.0, [(2, 1e-4)]), (1.37, [(1, 2e-4), (2, 1e-4)])])
def test_no_more_scans_than_promised_get_a_false_line_and_true_ones_are_found_with_their_errors(
    turns, drift, rho, lines
):
    false, complete, ratios, scores = coverage(turns, drift, rho, lines)
    assert false <= 9
    assert complete == 300
    assert np.mean(ratios) == pytest.approx(1.0, abs=5.0 * np.std(ratios) / math.sqrt(len(ratios)) + 0.01)
    # 95 % of normal scores lie within 1.96. This coloured noise falls to a quarter up to order 8, which a straight line
    # through 64 orders rounds off: standard errors are down to half the scatter, as documented.
    assert np.mean(np.abs(scores) < (1.96 if rho == 0.0 else 1.96 / 0.5)) > 0.91


def test_lines_that_leak_into_each_other_by_the_drift_are_all_found():
    # far above the noise, but each hidden by the ramp that the drift makes of the others
    false, complete, ratios, _ = coverage(1.0, True, 0.0, [(1, 2e-5), (2, 1e-4), (4, 1e-5)], sigma=3e-8, seeds=60)
    assert complete == 60
    assert false <= 4
    assert np.max(np.abs(ratios - 1.0)) < 0.01


@pytest.mark.slow
def test_lines_above_the_threshold_are_found_and_weaker_ones_are_not():
    found = {}
    theta = uniform(1000)
    for times in (0.4, 1.6):
        found[times] = 0
        for seed in range(20):
            noise = 1e-5 * np.random.default_rng(seed).normal(size=1000)
            threshold = sw.error_scan(theta, noise).threshold
            scan = sw.error_scan(theta, noise + lines_at(theta, [(60, times * threshold, 0.2)]))
            found[times] += 60 in [line.order for line in scan.lines]
    assert found[0.4] <= 2
    assert found[1.6] >= 18


def test_search_agrees_with_scipys_lomb_scargle():
    rng = np.random.default_rng(8)
    theta = uneven(rng, 600, 2.7)
    e = lines_at(theta, [(2, 1e-4, 0.3), (17, 3e-5, 1.0)]) + 2e-5 * rng.normal(size=600)
    scan = sw.error_scan(theta, e)
    power = lombscargle(theta, e, np.arange(1.0, 41.0), floating_mean=True)
    assert [line.order for line in scan.lines] == sorted(1 + np.argsort(power)[-2:])


@pytest.mark.parametrize(
    ("turns", "even", "spacing"), [(2.0, True, 1.0), (3.3, True, 1.0 / 3.3), (3.3, True, 1.0), (2.0, False, 1.0)]
)
def test_power_is_the_squared_amplitude_of_its_definition(turns, even, spacing):
    rng = np.random.default_rng(6)
    runs = [((uniform(150, turns) if even else uneven(rng, 150, turns)) + 0.2, rng.normal(size=150)) for _ in range(2)]
    q = spacing * np.arange(1, 31)
    sums = sum(np.exp(-1j * np.outer(q, theta)) @ r for theta, r in runs)
    assert np.allclose(power(runs, spacing, 30), np.abs(2.0 / 300.0 * sums) ** 2, rtol=1e-9, atol=1e-12)


def test_both_directions_give_lost_motion_and_the_mean_lines():
    rng = np.random.default_rng(3)
    forth, back = uniform(720), uneven(rng, 900, 1.4)
    half = 2e-5  # friction winds the gear up by so much either way
    extra = [(2, 4e-6, 1.0)]  # part of the hysteresis that varies with the angle
    e_forth = lines_at(forth) + lines_at(forth, extra) + half + 2e-6 * rng.normal(size=720)
    e_back = lines_at(back) - lines_at(back, extra) - half + 2e-6 * rng.normal(size=900)
    scan = sw.error_scan(forth, e_forth, backward=(back, e_back))
    r = scan.reversal
    assert r.lost_motion == pytest.approx(2.0 * half, abs=4.0 * r.lost_motion_error)
    assert r.lost_motion_error == pytest.approx(2e-6 * math.sqrt(1 / 720 + 1 / 900), rel=0.3)
    assert r.peak_to_peak == pytest.approx(2.0 * 2.0 * 4e-6, rel=0.1)
    assert [line.order for line in scan.lines] == [1, 2, 4]
    for line, (_, amplitude, phase) in zip(scan.lines, TRUE, strict=True):
        assert line.amplitude == pytest.approx(amplitude, abs=4.0 * line.amplitude_error)
        assert line.phase == pytest.approx(phase, abs=4.0 * line.phase_error)
    assert "lost motion" in str(scan)


def test_one_direction_says_nothing_about_reversal():
    assert sw.error_scan(uniform(100), lines_at(uniform(100))).reversal is None


def test_vendors_sign_turns_every_phase_by_half_a_turn():
    theta = uniform(100)
    ours, theirs = (sw.error_scan(theta, s * lines_at(theta), ate=s < 0.0) for s in (1.0, -1.0))
    assert np.allclose(ours.error.value(theta), theirs.error.value(theta), rtol=0.0, atol=1e-17)


def test_a_scan_of_noise_has_no_lines_and_says_so():
    scan = sw.error_scan(uniform(400), 1e-5 * np.random.default_rng(0).normal(size=400), false_alarm=1e-3)
    assert scan.lines == ()
    assert scan.peak_to_peak == 0.0
    with pytest.raises(ValueError, match="no line above"):
        _ = scan.error


def test_a_scan_prints_a_row_per_line():
    noise = 1e-7 * np.random.default_rng(4).normal(size=200)
    text = str(sw.error_scan(uniform(200), lines_at(uniform(200)) + noise))
    assert [row.split()[0] for row in text.splitlines()[1:4]] == ["1", "2", "4"]
    assert "arcsec rms, white noise" in text


THETA = uniform(100)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"angle": THETA[:50], "error": THETA[:50]}, "over 0.5 turns of the base angle; scan at least one whole turn"),
        ({"angle": THETA[::-1]}, "sample 1 stands after .*; angles must ascend"),
        ({"angle": np.where(THETA[7] == THETA, THETA[6], THETA)}, "sample 7 stands after"),
        ({"angle": np.where(THETA[7] == THETA, np.nan, THETA)}, "angle of sample 7 is nan; remove the sample"),
        ({"error": np.where(THETA[9] == THETA, np.inf, THETA)}, "error of sample 9 is inf"),
        ({"error": THETA[1:]}, r"shapes \(100,\) and \(99,\)"),
        ({"angle": THETA[:3], "error": THETA[:3]}, "4 at least"),
        ({"orders": [50]}, "order 50 is too high for these samples, which resolve orders below 50"),
        ({"orders": list(range(1, 50))}, None),
        (
            {"orders": list(range(1, 50)), "angle": THETA[:99] * 100 / 99, "error": THETA[:99]},
            "99 samples are given for",
        ),
        ({"orders": []}, "at least one"),
        ({"orders": [2, 2]}, "none twice"),
        ({"orders": [2.5]}, "whole number"),
        ({"orders": [0]}, "at least 1"),
        ({"highest": 60}, "orders below 50 can be resolved"),
        ({"false_alarm": 0.0}, "probability between 0 and 1"),
        ({"noise": "pink"}, "must be 'auto', 'white' or 'autocorrelated'"),
        ({"error": np.where(THETA[9] == THETA, 1e300, THETA)}, "error of sample 9 is 1e.300; remove the sample"),
        ({"backward": (THETA[::-1], THETA)}, "backward angle .* angles must ascend"),
    ],
)
def test_wrong_scans_are_refused_in_one_sentence(change, words):
    given = {"angle": THETA, "error": lines_at(THETA)} | change
    angle, error = given.pop("angle"), given.pop("error")
    if words is None:  # 100 samples, 100 unknowns
        words = "100 samples are given for 100 unknowns"
    with pytest.raises(ValueError, match=words) as refusal:
        sw.error_scan(angle, error, **given)
    assert "\n" not in str(refusal.value)


def test_samples_with_a_gap_that_hides_a_line_are_refused():
    theta = np.concatenate([np.linspace(0.0, 0.02, 50), [TURN]])
    with pytest.raises(ValueError, match="cannot separate the orders 1, 2, 3"):
        sw.error_scan(theta, theta, orders=[1, 2, 3])


def test_steps_of_a_coarse_reading_are_no_lines():
    # Without noise the steps of 1 arcsec repeat with order 2 and have lines of their own at 6, 10, 14 ...
    step = math.pi / 648_000.0
    theta = uniform(360, 2.0)
    scan = sw.error_scan(theta, np.round(lines_at(theta, TRUE[1:2]) / step) * step)
    assert [line.order for line in scan.lines] == [2]
    (line,) = scan.lines
    assert line.amplitude == pytest.approx(1e-4, abs=4.0 * line.amplitude_error)
    assert line.amplitude_error == pytest.approx(step / math.sqrt(12.0) * math.sqrt(2.0 / 360.0), rel=0.8)


def test_a_scan_of_zeros_has_no_lines():
    assert sw.error_scan(uniform(100), np.zeros(100)).lines == ()


@pytest.mark.parametrize("drift", [True, False])
@pytest.mark.parametrize("n", [64, 360, 1000])
def test_rounding_of_a_scan_without_noise_is_no_line(n, drift):
    angle = 2.0 * np.pi * np.arange(n) / n
    for order in (2, 3, 7, 20):
        scan = sw.error_scan(angle, 1e-4 * np.cos(order * angle + 0.7), drift=drift)
        assert [line.order for line in scan.lines] == [order]


def test_orders_that_even_targets_do_not_tell_apart_are_named():
    """At 72 targets a turn order 200 is 3 * 72 - 16, and 304 and 704 of a ratio of 100 look alike too."""
    angle = np.arange(72) * np.pi / 36.0
    error = 6e-5 * np.cos(200.0 * angle) + 1e-6 * np.random.default_rng(0).normal(size=72)
    scan = sw.error_scan(angle, error, ratio=100, turn="output")
    assert [line.order for line in scan.lines] == [16]
    exact = [k for j in range(1, 9) for k in range(100 * j - 4, 100 * j + 5) if k % 72 in (16, 56)]
    assert scan.aliases[16].tolist() == exact == [200, 304, 704]
    assert "order 16 may be order 200, 304, 704" in str(scan)
    assert "resolve orders below 36; higher orders appear as lower ones" in str(sw.error_scan(angle, error))
    uneven = 1.1 * (angle + np.random.default_rng(1).uniform(-0.04, 0.04, 72))
    assert not sw.error_scan(uneven, 6e-5 * np.cos(16 * uneven), orders=[16], ratio=100, turn="output").aliases
    with pytest.raises(ValueError, match=r"the angles stand 1\.39 turns apart, too far to resolve any order"):
        sw.error_scan(100.0 * angle, error, ratio=100)


def test_a_line_between_whole_orders_is_told_as_such():
    angle = np.linspace(0.0, 40.0 * np.pi, 4500)
    rng = np.random.default_rng(2)
    error = lines_at(angle, [(2, 7e-5, 0.3)]) + lines_at(angle, [(3.75, 1.5e-5, -0.4)]) + 2.4e-6 * rng.normal(size=4500)
    scan = sw.error_scan(angle, error)
    assert [line.order for line in scan.lines] == [2]
    (line,) = scan.between
    assert line.order == pytest.approx(3.75, abs=1e-3)
    assert line.amplitude == pytest.approx(1.5e-5, abs=4 * line.amplitude_error)
    assert "between whole orders: 3.75; a project file cannot contain them" in str(scan)


def test_errors_of_a_line_between_whole_orders_hold_what_its_place_may_be_off_by():
    angle, scores = uniform(750, 5.0), []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        order, phase = rng.uniform(3.3, 3.7), rng.uniform(-3.0, 3.0)
        error = lines_at(angle, [(2, 7e-5, 0.3), (order, 3e-5, phase)]) + 1e-5 * rng.normal(size=750)
        (line,) = sw.error_scan(angle, error).between
        scores.append(math.remainder(line.phase - phase, TURN) / line.phase_error)
    assert np.sum(np.abs(scores) < 1.96) >= 52  # 57 of 60 expected, 51 or fewer by chance in 1 of 350
    assert np.std(scores) > 0.7


def test_dense_scans_have_no_aliases_and_are_read():
    angle = uniform(20_001, 2.0)
    scan = sw.error_scan(angle, lines_at(angle) + 1e-7 * np.random.default_rng(0).normal(size=20_001))
    assert [line.order for line in scan.lines] == [1, 2, 4]
    assert scan.aliases == {}
