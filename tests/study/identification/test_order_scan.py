"""Orders from runs over part of a turn: made runs with known lines, a delay, coloured noise; and measured joints."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

import strainwave as sw

KINOVA = Path(__file__).resolve().parents[2] / "measured" / "kinova_gen3"
LINES = {200.0: (0.040, 0.7), 400.0: (0.020, -1.0), 700.0: (0.12, 2.0)}
DELAY, RATE = 2.3e-3, 999.0


def made(speed, duration, seed, *, noise=0.02, delay=DELAY, lines=LINES, scale=1.0, hertz=0.0, wobble=0.02):
    """Friction that depends on the angle, lines of the angle a delay ago, noise of an autoregression with .9."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(duration * RATE)) / RATE
    zero = rng.uniform(0.0, 6.0)

    def angle(s):
        return zero + speed * s + wobble * speed * np.sin(0.7 * s)

    theta = angle(t - delay)
    value = 0.5 * np.sign(speed) + 0.1 * np.sin(theta)
    for k, (amplitude, phase) in lines.items():
        value += scale * amplitude * np.cos(k * theta + phase)
    value += hertz * np.cos(2.0 * np.pi * 6.0 * t + rng.uniform(0.0, 6.0))
    coloured = lfilter([1.0], [1.0, -0.9], rng.standard_normal(len(t))) * math.sqrt(1.0 - 0.81)
    return sw.Run(t, angle(t), value + noise * coloured, "N*m")


@pytest.fixture(scope="module")
def several():
    return [made(speed, min(12.0, 2.0 / speed + 2.0), i) for i, speed in enumerate((0.15, 0.3, 0.6, 0.9))]


def test_amplitudes_phases_and_the_delay_are_those_that_the_runs_were_made_with(several):
    found = sw.order_scan(several, orders=list(LINES))
    for k, (amplitude, phase) in LINES.items():
        line = found.line(k)
        assert line.amplitude == pytest.approx(amplitude, abs=4.0 * line.amplitude_error)
        assert math.remainder(line.phase - phase, 2.0 * math.pi) == pytest.approx(0.0, abs=4.0 * line.phase_error)
        assert line.amplitude_error < 0.05 * amplitude
    assert found.delay == pytest.approx(DELAY, abs=4.0 * found.delay_error)
    assert found.delay_error < 5e-5


def test_another_speed_is_predicted_and_only_with_the_delay(several):
    found = sw.order_scan(several, orders=list(LINES))
    new = made(1.3, 3.0, 99, noise=0.0)
    at = np.exp(-1j * 200.0 * new.angle)
    truth, predicted = new.value @ at, found.predict(new.time, new.angle) @ at
    assert abs(predicted - truth) < 0.08 * abs(truth)
    undelayed = sum(a * np.cos(k * new.angle + p) for k, (a, p) in LINES.items()) @ at
    assert abs(undelayed - truth) > 0.4 * abs(truth)  # 200 * 1.3 * 2.3e-3 = .6 rad


def test_orders_are_found_without_being_named(several):
    found = sw.order_scan(several)
    assert [line.order for line in found.lines] == [200.0, 400.0, 700.0]
    assert {line.kind for line in found.lines} == {"order"}
    assert found.base == 100.0
    assert found.delay == pytest.approx(DELAY, abs=4.0 * found.delay_error)


def test_one_speed_cannot_tell_an_order_from_a_frequency_and_two_can():
    first = made(0.3, 8.0, 5, hertz=0.05, wobble=0.0)
    alone = sw.order_scan([first])
    assert {line.kind for line in alone.lines} == {"undecided"}
    assert math.isinf(alone.delay_error)
    assert "one speed" in alone.notes[0]
    both = sw.order_scan([first, made(0.5, 8.0, 6, hertz=0.05)])
    hertz = [line for line in both.lines if line.kind == "frequency"]
    assert [line.frequency for line in hertz] == pytest.approx([6.0], abs=0.02)
    assert hertz[0].amplitude == pytest.approx(0.05, abs=4.0 * hertz[0].amplitude_error)
    assert {line.order for line in both.lines if line.kind == "order"} == set(LINES)


def test_noise_alone_has_no_lines():
    none = [sw.order_scan([made(0.4, 8.0, 100 + i, lines={})]).lines for i in range(40)]
    assert sum(map(len, none)) <= 3  # 1 % of 40 scans is expected; four or more has a probability of 1e-3


def test_backward_runs_have_their_own_lines():
    back = {k: (a, p + 0.5) for k, (a, p) in LINES.items()}
    runs = [made(0.3, 8.0, 1), made(0.5, 6.0, 2), made(-0.3, 8.0, 3, lines=back), made(-0.5, 6.0, 4, lines=back)]
    found = sw.order_scan(runs, orders=list(LINES))
    for one, other, k in zip(found.forward, found.backward, LINES, strict=True):
        assert one.order == other.order == k
        # a delay that fits both directions takes a share of the difference; the amplitudes it leaves alone
        assert one.amplitude == pytest.approx(LINES[k][0], abs=4.0 * one.amplitude_error)
        assert other.amplitude == pytest.approx(LINES[k][0], abs=4.0 * other.amplitude_error)


def test_a_growing_amplitude_is_said_with_its_frequency(several):
    found = sw.order_scan([*several, made(0.45, 6.0, 9, scale=4.0)], orders=[700.0])
    assert found.line(700.0).same < 1e-6
    told = next(note for note in found.notes if "resonance may lie near" in note)
    assert float(told.split()[-2]) == pytest.approx(700.0 * 0.45 / (2.0 * math.pi), rel=0.01)


def held(rpm, zero=0.0, seconds=10.0, lines=((1, 6.0), (2, 27.0), (4, 6.0)), hertz=12.0):
    """Error of a load on a spring, 3 % damped, behind a held motor: each line [arcsec] over 1 - s^2 + 2i z s."""
    t = np.arange(int(1000 * seconds)) / 1000.0
    angle, ripple = rpm * np.pi / 30.0 * t, 0.4 * np.random.default_rng(int(rpm)).standard_normal(int(1000 * seconds))
    for k, amplitude in lines:
        s = k * rpm / 60.0 / hertz
        ripple = ripple + amplitude * np.real(np.exp(1j * k * (angle + 0.3)) / (1.0 - s * s + 0.06j * s))
    return sw.Run(t, angle + zero, ripple * np.pi / 648000.0, "rad")


def test_a_resonance_between_two_speeds_is_no_other_zero_of_angle():
    scan = sw.order_scan([held(60.0), held(300.0)], [1, 2, 4])
    assert [line.order for line in scan.varying] == [1.0, 2.0, 4.0]
    assert "of the orders 1, 2, 4: towards a resonance they grow with the speed; scan the slowest" in str(scan.notes)
    assert "one zero" not in str(scan.notes)
    slow = sw.order_scan([held(15.0), held(30.0)], [1, 2, 4])
    assert slow.varying == ()
    assert slow.line(2).amplitude == pytest.approx(27.0 * np.pi / 648000.0, rel=0.01)
    other = sw.order_scan([held(15.0), held(30.0, zero=0.7)], [1, 2, 4])
    assert other.varying == ()
    assert "give runs of one shaft, with one zero of angle" in str(other.notes)
    one = sw.order_scan([held(60.0), held(60.5, lines=((1, 6.0), (2, 20.0), (4, 6.0)))], [1, 2, 4])
    assert [line.order for line in one.varying] == [2.0]
    assert "of one speed by more than their errors, of the orders 2: give runs of one shaft under one load" in str(
        one.notes
    )


@pytest.mark.parametrize("joint", [5, 6, 7])
def test_measured_joints_have_the_orders_of_their_wave_generator(joint):
    """Against the largest value of a plain Fourier sum within an order's resolution, a running mean taken away."""
    table = np.genfromtxt(KINOVA / f"joint_{joint}.csv", delimiter=",", names=True)
    fast = np.flatnonzero(table["velocity_rad_per_s"] > 0.33)
    rows = slice(fast[0], fast[-1])
    t, angle, torque = (table[name][rows] for name in ("time_ms", "position_rad", "torque_from_current_Nm"))
    found = sw.order_scan([sw.Run(t * 1e-3, angle, torque, "N*m")])
    window = int(2.0 * np.pi / 40.0 / np.mean(np.diff(angle)))  # an order of 40 and slower ones
    rest = torque - np.convolve(torque, np.ones(window) / window, "same")
    inner, resolution = slice(window, -window), 2.0 * np.pi / np.ptp(angle)
    for k in (200.0, 400.0, 700.0):
        near = [line for line in found.lines if line.interval("order").low <= k <= line.interval("order").high]
        orders = np.linspace(k - resolution, k + resolution, 81)
        sums = np.exp(-1j * np.outer(orders, angle[inner])) @ rest[inner]
        largest = np.max(np.abs(2.0 / len(rest[inner]) * sums))
        assert [line.amplitude for line in near] == [pytest.approx(largest, rel=0.25)]


T = np.arange(100) * 0.01
BAD = [
    (lambda: sw.Run(T, 0.0 * T, T), "stays at"),
    (lambda: sw.Run(T, np.sin(9.0 * T), T), "goes back"),
    (lambda: sw.Run(T[::-1], T, T), "must ascend"),
    (lambda: sw.Run(T, T, T[1:]), "give one length"),
    (lambda: sw.Run(T, T, np.where(T[3] == T, np.nan, T)), "sample 3"),
    (lambda: sw.Run(T[:9], T[:9], T[:9]), "give 32"),
    (lambda: sw.order_scan([]), "runs is empty"),
    (lambda: sw.order_scan([sw.Run(T, T, T, "A"), sw.Run(T, T, T, "N*m")]), "one quantity"),
    (lambda: sw.order_scan([sw.Run(T, T, T)], orders=[1e5]), "too high"),
    (lambda: sw.order_scan([sw.Run(T, T, T)], orders=[3.0, 3.0]), "none twice"),
    (lambda: sw.order_scan([sw.Run(T, T, T)], orders=[40.0, 40.0001]), "cannot separate the orders"),
    (lambda: sw.order_scan([sw.Run(T, 1e-3 * T, T)], highest=100.0), "orders"),
    (lambda: sw.order_scan([sw.Run(T, T, T)], false_alarm=2.0), "false_alarm"),
]


@pytest.mark.parametrize(("call", "sentence"), BAD)
def test_what_tells_nothing_is_one_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


RESONANCE = [1.0, -2.0 * 0.95 * math.cos(2.0 * math.pi * 40.0 / RATE), 0.95**2]
COVERED = {
    "white": lambda rng, clean: clean + 0.03 * rng.standard_normal(len(clean)),
    "coloured": lambda rng, clean: clean + 0.03 * lfilter([0.44], [1.0, -0.9], rng.standard_normal(len(clean))),
    "resonant": lambda rng, clean: clean + 0.003 * lfilter([1.0], RESONANCE, rng.standard_normal(len(clean))),
    "quantised": lambda rng, clean: 0.03 * np.round((clean + 0.01 * rng.standard_normal(len(clean))) / 0.03),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(COVERED))
def test_intervals_cover(kind):
    """95 % intervals hold amplitude, phase and delay as often as they say, neither less nor more."""
    sets, hits, rng = 200, np.zeros(3), np.random.default_rng(50_000)
    for i in range(sets):
        runs = []
        for j, speed in enumerate((0.3, 0.5, 0.8)):
            clean = made(speed, 1.5, 3 * i + j, noise=0.0, lines={200.0: (0.05, 0.7)})
            runs.append(sw.Run(clean.time, clean.angle, COVERED[kind](rng, clean.value)))
        found = sw.order_scan(runs, orders=[200.0])
        low, high = found.lines[0].interval("amplitude")
        first, last = found.lines[0].interval("phase")
        begin, end = found.delay_interval()
        hits += [low <= 0.05 <= high, first <= 0.7 <= last, begin <= DELAY <= end]
    # fewer than these have a probability of 5e-4, and so have more
    fewest, most = binom.ppf([5e-4, 1.0 - 5e-4], sets, 0.95)
    assert np.all((hits >= fewest) & (hits <= most)), hits


@pytest.mark.parametrize("speed", [25.0, 31.0, 33.0, 40.0])
@pytest.mark.parametrize("lines", [((2.0, 2e-4, 0.3),), ((2.0, 2e-4, 0.3), (4.0, 5e-5, -1.0), (6.02, 2e-5, 1.0))])
def test_strong_lines_leave_no_others_and_predict_a_third_speed(speed, lines):
    """Lines 200 times the noise, over parts of turns: what leaks from them is no line."""
    rng = np.random.default_rng(int(speed))

    def run(v, noise=1e-6):
        t = np.arange(6000) / 1000.0
        late = v * (t - 1e-3)
        value = sum(a * np.cos(k * late + p) for k, a, p in lines) + noise * rng.standard_normal(len(t))
        return sw.Run(t, v * t, value, "rad")

    found = sw.order_scan([run(20.0), run(speed)], highest=20.0)
    assert [line.kind for line in found.lines] == ["order"] * len(lines)
    for line, (order, amplitude, phase) in zip(found.lines, lines, strict=True):
        assert line.order == pytest.approx(order, abs=5e-4)
        assert abs(line.amplitude - amplitude) < 4.0 * line.amplitude_error < 4e-7
        # an order that is not known exactly turns the phase over the travel
        assert line.phase == pytest.approx(phase, abs=0.02)
    third = run(27.0, 0.0)
    left = found.predict(third.time, third.angle) - third.value
    assert np.std(left) < 3e-7


@pytest.mark.parametrize("beside", [0.05, 0.2, 0.6])
def test_a_frequency_next_to_an_order_of_one_run_is_told_from_it(beside):
    """Hz beside order 4 at 20 rad/s; 0.17 Hz are resolved."""
    rng, f = np.random.default_rng(0), 4.0 * 20.0 / (2.0 * np.pi) + beside
    t, runs = np.arange(6000) / 1000.0, []
    for v in (20.0, 33.0):
        value = 2e-4 * np.cos(2.0 * v * t + 0.3) + 5e-5 * np.cos(4.0 * v * t - 1.0) + 3e-5 * np.cos(2.0 * np.pi * f * t)
        runs.append(sw.Run(t, v * t, value + 1e-6 * rng.standard_normal(6000), "rad"))
    found = sw.order_scan(runs, highest=20.0)
    assert [line.kind for line in found.lines] == ["order", "order", "frequency"]
    assert found.lines[2].frequency == pytest.approx(f, abs=1e-2)
    assert found.lines[1].amplitude == pytest.approx(5e-5, rel=0.01)


@pytest.mark.parametrize("seed", [1, 2, 19])
def test_strong_lines_beside_an_order_of_the_wave_generator_are_not_taken_for_it(seed):
    rng = np.random.default_rng(seed)
    turns, angle = 60.0, np.linspace(0.0, 2.0 * np.pi * 60.0, 6000)
    beside = [2.0 + shift / turns for shift in (-3.0, -1.5, 1.5, 3.0)]
    value = sum(2e-5 * np.cos(k * angle + i) for i, k in enumerate(beside, start=0)) + 1e-6 * rng.normal(size=6000)
    found = sw.order_scan([sw.Run(np.linspace(0.0, 6.0, 6000), angle, value, "rad")], highest=6.0)
    assert [line.order for line in found.lines] == pytest.approx(beside, abs=0.02 / turns)


def test_a_slow_channel_counts_at_its_own_times(tmp_path):
    """Straight lines between 50 samples a second weaken a line at 16 Hz by sinc(16/50)^2 = .70 and make images."""
    t, s = np.arange(0.0, 8.0, 0.004), np.arange(0.0, 8.0, 0.02)
    torque = 20.0 + 2.0 * np.cos(200.0 * 0.5 * s)
    np.savez(tmp_path / "two.npz", time=t, load_angle=0.5 * t, load_torque=torque, load_torque_time=s)
    log = sw.read_log(tmp_path / "two.npz", trim=0)
    scan = sw.order_scan([log.run("load_torque")])
    (line,) = scan.lines
    slow = np.column_stack([np.ones_like(s), np.cos(100.0 * s), np.sin(100.0 * s)])
    assert np.hypot(*np.linalg.lstsq(slow, torque, rcond=None)[0][1:]) == pytest.approx(2.0, abs=1e-9)
    assert line.order == pytest.approx(200.0, abs=0.01)
    assert line.amplitude == pytest.approx(2.0, abs=1e-3)


def refreshed(speed, seconds, seed):
    """A torque refreshed every 4 ms under 999 Hz, with jitter: two delays, and a line that grows with the speed."""
    rng, t = np.random.default_rng(seed), np.arange(int(seconds * RATE)) / RATE
    at = np.cumsum(4e-3 * (1.0 + 0.1 * rng.standard_normal(int(seconds / 4e-3) + 20))) - 0.05
    zero, true = rng.uniform(0.0, 6.0), 0.0
    for k, amplitude, phase, delay in ((200, 0.044, 0.7, 2.4e-3), (400, 0.023, -1.0, 2.4e-3), (700, 0.1, 2.0, 1.5e-3)):
        grown = abs(speed) if k == 700 else 1.0
        true = true + grown * amplitude * np.cos(k * (zero + speed * (at - delay + 2e-3)) + phase)
    value = (true + 4e-3 * rng.standard_normal(len(at)))[np.searchsorted(at, t, side="right") - 1]
    return sw.Run(t, zero + speed * t, value, "N*m")


def test_a_refreshed_channel_is_predicted_at_unseen_speeds(several):
    runs = [refreshed(v * way, 2.0 / v + 2.0, i) for i, v in enumerate((0.12, 0.25, 0.45, 0.7, 0.9)) for way in (1, -1)]
    scan = sw.order_scan(runs, orders=[200, 400, 700])
    assert scan.responses.hold == pytest.approx(4e-3, abs=4e-4)
    assert [line.delay for line in scan.responses.lines] == pytest.approx([2.4e-3, 2.4e-3, 1.5e-3], abs=2.5e-4)
    assert [bool(line.gain) for line in scan.responses.lines] == [False, False, True]
    assert scan.line(400).amplitude == pytest.approx(0.023, abs=4.0 * scan.line(400).amplitude_error)
    new = refreshed(1.3, 6.0, 99)
    columns = np.column_stack([f(k * new.angle) for k in (200, 400, 700) for f in (np.cos, np.sin)])
    left = np.linalg.lstsq(columns, new.value - scan.predict(new.time, new.angle), rcond=None)[0].reshape(-1, 2)
    whole = np.linalg.lstsq(columns, new.value, rcond=None)[0].reshape(-1, 2)
    assert np.all(np.linalg.norm(whole, axis=1) > [0.035, 0.01, 0.05])
    assert np.all(np.linalg.norm(left, axis=1) < 6e-3)
    assert sw.order_scan(several, orders=list(LINES)).responses is None  # one delay, no hold


def test_two_speeds_of_a_measured_joint_have_no_line_that_neither_has():
    """Two a turn of the wave generator at 160:1, its double, and the 14.8 Hz that is order 459 at .202 rad/s."""
    logs = [sw.read_log(KINOVA.parent / "iiwa14" / f"joint4_vel_p{i}.csv.gz") for i in (2, 6)]
    runs = [log.run("torque", part=p) for log in logs for p in log.segments() if p.kind == "constant speed"]
    lines = sw.order_scan(runs).lines
    found = sorted(459.3 if line.kind == "frequency" else line.order for line in lines)
    assert found == pytest.approx([320.0, 459.3, 640.0], abs=8.0)
    (steady,) = (line.frequency for line in lines if line.kind == "frequency")
    assert steady == pytest.approx(459.3 * 0.2022 / (2.0 * math.pi), abs=0.2)
    assert 0.018 < lines[[line.kind for line in lines].index("order")].amplitude < 0.022  # 21 to 22 and 19.3 mN m alone
