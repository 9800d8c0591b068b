"""Lines of two turns that beat: found and named, refused where a record is too short; other speeds; counts."""

import gzip
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

import strainwave as sw
from strainwave.base.units import ARCSEC

TURN, RATIO = 2.0 * np.pi, 101
SECOND = 2.0 - 2.0 / RATIO
BOTH = {2.0: (2.1, 0.4), SECOND: (2.4, -1.3)}


def record(lines, turns, seed=0, *, noise=10.0, colour=0.5, wind_up=1050.0, hertz=(), sway=(0.1, 0.3)):
    """Sizes in arcsec; 250 samples a second whose steps differ by a fifth; wind-up is a sine of the output's angle."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(0.004 * (1.0 + 0.2 * rng.uniform(-1.0, 1.0, int(turns * TURN / 17.0 / 0.004))))
    angle = 17.0 * t + sway[0] * np.sin(sway[1] * t)
    drawn = lfilter([1.0], [1.0, -colour], rng.standard_normal(len(t) + 200))[200:]
    value = noise * np.sqrt(1.0 - colour**2) * drawn + 0.5 * wind_up * np.cos(angle / RATIO + 1.0)
    value += sum(size * np.cos(order * angle + phase) for order, (size, phase) in lines.items())
    value += sum(size * np.cos(TURN * f * t) for f, size in hertz)
    return sw.Run(t, angle, ARCSEC * value, unit="rad")


def over_angle(scan):
    return [line for line in scan.lines if line.kind != "frequency"]


@pytest.fixture(scope="module")
def beating():
    return record(BOTH, 75.0, hertz=((68.0, 3.0), (73.0, 2.0)))


@pytest.mark.parametrize("ratio", [None, RATIO])
def test_two_lines_that_beat_are_found_with_and_without_the_ratio(beating, ratio):
    scan = sw.order_scan([beating], ratio=ratio)
    one, other = over_angle(scan)
    for line, order in ((one, SECOND), (other, 2.0)):
        size, phase = BOTH[order]
        assert line.interval("order").low - 1e-9 <= order <= line.interval("order").high + 1e-9
        assert line.order_error < 0.01
        assert line.amplitude == pytest.approx(ARCSEC * size, abs=3.0 * line.amplitude_error)
        assert np.angle(np.exp(1j * (line.phase - phase))) == pytest.approx(0.0, abs=3.0 * line.phase_error)
    assert [line.pair for line in (one, other)] == ([(2, -2), (2, 0)] if ratio else [None, None])
    assert sorted(round(line.frequency) for line in scan.lines if line.kind == "frequency") == [68, 73]


@pytest.mark.parametrize(("order", "noise", "wind_up", "seed"), [(2.0, 10.0, 1050.0, 114), (2.0, 10.0, 1050.0, 116),
                                                                  (2.003, 2.0, 0.0, 0)])  # fmt: skip
def test_phases_are_those_of_a_whole_order_where_noise_moved_it(order, noise, wind_up, seed):
    """Noise and wind-up move it by 2.0 and 2.4 deviations with these seeds; 2.003 is ten deviations from 2."""
    lines = {SECOND: BOTH[SECOND], order: BOTH[2.0]}
    scan = sw.order_scan([record(lines, 75.0, seed, noise=noise, wind_up=wind_up)], highest=20.0)
    for line, (_, phase) in zip(over_angle(scan), lines.values(), strict=True):
        assert line.interval("phase").low < phase < line.interval("phase").high
    last = over_angle(scan)[-1]
    assert (last.order == 2.0) == (order == 2.0)
    assert abs(last.order - order) < max(1.5 * last.order_error, 1e-9)


def test_wind_up_of_any_size_moves_no_line():
    still, wound = (over_angle(sw.order_scan([record(BOTH, 75.0, 3, wind_up=size)])) for size in (0.0, 6000.0))
    for one, other in zip(still, wound, strict=True):
        assert other.amplitude == pytest.approx(one.amplitude, abs=0.05 * one.amplitude_error)
        assert other.amplitude_error == pytest.approx(one.amplitude_error, rel=0.05)


@pytest.mark.parametrize("ratio", [None, RATIO])
def test_one_of_two_that_passed_for_a_frequency_leaves_no_third_line(ratio):
    """The search takes order 2 for a frequency, and a third line for what that leaves."""
    lines = {2.0: (14.1, 0.1), SECOND: (14.1, -1.3)}
    run = record(lines, 51.2, noise=4.0, colour=0.8, sway=(0.2, 0.5))
    scan = sw.order_scan([run], ratio=ratio, highest=20.0)
    assert [line.order for line in scan.lines] == pytest.approx([SECOND, 2.0], abs=1e-3)
    assert {line.kind for line in scan.lines} <= {"order", "undecided"}


@pytest.mark.parametrize("order", [2.0, SECOND])
@pytest.mark.parametrize("ratio", [None, RATIO])
def test_one_line_alone_is_one(order, ratio):
    (line,) = over_angle(sw.order_scan([record({order: (4.0, 0.3)}, 75.0, 1)], ratio=ratio))
    assert line.order == pytest.approx(order, abs=0.003)
    assert line.pair == (((2, 0) if order == 2.0 else (2, -2)) if ratio else None)


@pytest.mark.parametrize("phase", [0.0, 1.5, 3.0])
@pytest.mark.parametrize("ratio", [None, RATIO, -100])
def test_a_record_shorter_than_half_a_beat_cannot_tell(phase, ratio):
    run = record({2.0: (8.0, 0.0), SECOND: (8.0, phase)}, 20.0, 2, noise=2.0)
    scan = sw.order_scan([run], ratio=ratio)
    (line,) = over_angle(scan)
    assert line.pair is None
    assert "cannot separate" in str(scan.notes)
    if ratio:
        assert set(line.pairs) == {(2, 0), (2, -2), (2, 2)}
        assert f"the pairs beat every {abs(ratio) / 2.0:.4g} turns" in str(scan.notes)


def test_pairs_of_given_orders_and_of_the_output_angle_are_named():
    run = record(BOTH, 75.0, noise=1.0)
    scan = sw.order_scan([run], [SECOND, 2.0], RATIO)
    assert [line.pair for line in scan.lines] == [(2, -2), (2, 0)]
    turned = sw.Run(run.time, run.angle / RATIO, run.value, "rad")
    scan = sw.order_scan([turned], [200.0, 202.0], RATIO, shaft="output")
    assert [line.pair for line in scan.lines] == [(2, -2), (2, 0)]


BAD = [
    (dict(ratio=100.5), "whole ratio"),
    (dict(ratio=1), "whole ratio"),
    (dict(ratio=50, shaft="wave generator"), "it is 'motor' or 'output'"),
    (dict(shaft="output"), "shaft is 'output', which counts with a ratio alone; give the ratio"),
]


@pytest.mark.parametrize(("given", "sentence"), BAD)
def test_a_ratio_that_teeth_cannot_have_is_refused(given, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.order_scan([record({}, 2.0)], **given)


def at_speeds(speeds, size, seed=3):
    """Runs with order 320 of an output's angle, whose amplitude is a function of the speed."""
    rng, runs = np.random.default_rng(seed), []
    for speed in speeds:
        t = np.arange(2000) / 1000.0
        value = size(abs(speed)) * np.cos(320.0 * speed * t + 0.3) + 1e-3 * rng.standard_normal(len(t))
        runs.append(sw.Run(t, speed * t, value, "N*m"))
    return sw.order_scan(runs, [320.0])


def test_another_speed_is_told_by_runs_near_it_or_by_many():
    scan = at_speeds((0.2, 0.28, 0.4, 0.55, -0.4), lambda speed: 0.02 + 0.002 * np.sin(9.0 * speed))
    near, half = scan.amplitude_at(320, 0.41)
    assert near == pytest.approx(0.02 + 0.002 * np.sin(3.6), abs=half)
    assert half < 2e-4
    for speed in (0.34, 0.75):
        value, half = scan.amplitude_at(320, speed)
        assert abs(value - 0.02 - 0.002 * np.sin(9.0 * speed)) < half < 0.01


@pytest.mark.parametrize("speed", [0.4, 0.8, 0.0])
def test_a_speed_between_two_far_ones_is_refused(speed):
    scan = at_speeds((0.2, 0.6), lambda _: 0.02)
    with pytest.raises(ValueError, match=r"order 320 was measured at 0.2, 0.6 rad/s, .* a resonance may change it"):
        scan.amplitude_at(320, speed)
    with pytest.raises(ValueError, match="no line at order 100"):
        scan.amplitude_at(100, 0.2)


@pytest.mark.parametrize(("ratio", "N", "fixed"), [(121, 120, "flexspline"), (-50, 50, "circular spline"),
                                                   (151, 150, "flexspline"), (100, 100, None)])  # fmt: skip
def test_counts_of_both_encoders_tell_ratio_and_arrangement(ratio, N, fixed):
    motor = np.linspace(0.0, 9.0 * 2**24, 2000)
    load = motor / ratio + 500.0 * np.sin(motor / 2**24)
    told = sw.fit.arrangement(np.round(motor) % 2**24, np.round(load + 1e7) % 2**24)
    assert (told.ratio, told.N) == (ratio, N)
    assert abs(told.measured - ratio) < told.error < 0.5
    assert (told.arrangement.fixed if told.arrangement else None) == fixed


@pytest.mark.parametrize(("ratio", "turns", "sentence"), [(100.5, 90.0, "impossible for the teeth of a strain wave"),
                                                          (100, 1.0, "use counts of a longer motion")])  # fmt: skip
def test_counts_that_tell_no_ratio_are_refused(ratio, turns, sentence):
    motor = np.linspace(0.0, turns * 2**24, 2000)
    with pytest.raises(ValueError, match=sentence):
        sw.fit.arrangement(motor, motor / ratio)


MEASURED = Path(__file__).resolve().parents[2] / "measured" / "iiwa14"


def strokes(number):
    """Whole strokes of one speed, of a joint that moves to and fro; angle of the output."""
    with gzip.open(MEASURED / f"joint4_vel_p{number}.csv.gz", "rt") as file:
        time, angle, speed, torque = np.genfromtxt(file, delimiter=",", skip_header=1).T
    smooth = np.convolve(speed, np.ones(21) / 21, "same")
    top = np.quantile(np.abs(smooth), 0.7)
    steady = np.sign(smooth) * (np.abs(np.abs(smooth) / top - 1.0) < 0.08)
    edges = np.concatenate([[0], 1 + np.flatnonzero(np.diff(steady)), [len(steady)]])
    pieces = [slice(a, b) for a, b in pairwise(edges.tolist()) if steady[a] and b - a > 32]
    runs = [sw.Run(time[part], angle[part], torque[part], "N*m") for part in pieces]
    return [run for run in runs if run.turns > 0.12]


def test_a_measured_torque_has_two_per_turn_of_its_wave_generator():
    """Ratio 160; by plain least squares 21 and 19 mN m at 0.202 and 0.607 rad/s. At 0.4 rad/s it is 12."""
    slow, fast = strokes(2), strokes(6)
    for run in slow:
        (line,) = [line for line in sw.order_scan([run]).lines if abs(line.order - 320.0) < 20.0]
        assert line.order == pytest.approx(320.5, abs=1.0)
    assert sw.order_scan(slow, [320.0]).lines[0].amplitude == pytest.approx(21e-3, abs=1e-3)
    assert sw.order_scan(fast, [320.0]).lines[0].amplitude == pytest.approx(19e-3, abs=1e-3)
    scan = sw.order_scan([slow[0], fast[0]])
    for speed in (0.4, 0.8):
        with pytest.raises(ValueError, match="a resonance may change it"):
            scan.amplitude_at(320, speed)


@pytest.mark.parametrize("ratio", [None, RATIO])
def test_a_sideband_over_the_output_turn_is_a_line_of_its_own(ratio):
    lines = {2.0: (4.0, 0.4), 2.0 + 1.0 / RATIO: (1.5, 2.0)}
    scan = sw.order_scan([record(lines, 3.0 * RATIO, noise=3.0)], ratio=ratio, highest=20.0)
    one, other = over_angle(scan)
    for line, (order, (size, _)) in zip((one, other), lines.items(), strict=True):
        assert line.order == pytest.approx(order, abs=3.0 * line.order_error + 1e-9)
        assert line.amplitude == pytest.approx(ARCSEC * size, abs=3.0 * line.amplitude_error)
