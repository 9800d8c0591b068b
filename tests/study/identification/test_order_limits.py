"""Orders that coarse angles cannot show, lines that are rounding alone, and what a frequency has beside orders."""

import numpy as np
import pytest

import strainwave as sw

LINES = ((2, 0.10, 0.3), (4, 0.05, 1.1), (7, 0.02, -2.0))
TURN = 2.0 * np.pi


def run(speed, seed, *, counts=0, frequency=0.0, turns=12, rate=500.0, noise=1e-3):
    """Value over an angle that is read in so many steps a turn, with a line of 0.05 at a frequency [Hz]."""
    time = np.arange(int(TURN * turns / speed * rate)) / rate
    angle = speed * time
    value = noise * np.random.default_rng(seed).standard_normal(len(time))
    value += sum(a * np.cos(k * angle + p) for k, a, p in LINES)
    if frequency:
        value += 0.05 * np.cos(TURN * frequency * time + seed)
    return sw.Run(time, np.round(angle * counts / TURN) * TURN / counts if counts else angle, value, "rad")


def test_an_order_is_not_taken_for_the_one_that_a_coarse_angle_confuses_it_with():
    runs = [run(5.0, 0, counts=100), run(9.0, 1, counts=100)]  # 4 and 96, 7 and 93 are the same at its places
    scan = sw.order_scan(runs)
    # the steps of the angle beat with the samples, by a few 1e-4
    found = {line.order: line.amplitude for line in scan.lines if line.amplitude > 1e-3}
    assert sorted(found) == [2.0, 4.0, 7.0]
    assert all(line.kind == "order" for line in scan.lines if line.order in found)
    # the step of the angle takes sin(x)/x of an order k, x = pi k/100, and is seen in its amplitude alone
    assert [found[k] for k, _, _ in LINES] == pytest.approx([a for _, a, _ in LINES], rel=0.02)
    with pytest.raises(ValueError, match="order 96 is too high; these samples show orders below 40"):
        sw.order_scan(runs, [4, 96])


def test_a_scan_without_noise_has_no_lines_of_rounding():
    scan = sw.order_scan([run(5.0, 0, noise=0.0), run(9.0, 1, noise=0.0)], highest=20.0)
    assert [line.order for line in scan.lines] == [2.0, 4.0, 7.0]
    assert [line.amplitude for line in scan.lines] == pytest.approx([a for _, a, _ in LINES], rel=1e-9)


def test_a_frequency_has_its_amplitude_beside_stronger_orders():
    scan = sw.order_scan([run(5.0, 0, frequency=6.3), run(9.0, 1, frequency=6.3)], highest=20.0)
    (line,) = [line for line in scan.lines if line.kind == "frequency"]
    assert line.frequency == pytest.approx(6.3, abs=0.01)
    assert line.amplitude == pytest.approx(0.05, rel=2e-3)
    assert abs(line.amplitude - 0.05) < 4.0 * line.amplitude_error + 5e-5
    assert line.amplitude_error < 1e-4


def test_a_prediction_may_turn_back_and_be_short():
    scan = sw.order_scan([run(5.0, 0), run(9.0, 1)], [k for k, _, _ in LINES])

    def truth(angle):
        return sum(a * np.cos(k * angle + p) for k, a, p in LINES)

    time = np.arange(400) / 200.0
    angle = 3.0 * np.sin(2.0 * time)
    assert scan.predict(time, angle) == pytest.approx(truth(angle), abs=3e-3)
    assert scan.predict(time[:2], angle[:2]) == pytest.approx(truth(angle[:2]), abs=3e-3)
    with pytest.raises(ValueError, match="time has 400 samples and angle 2; give equally many"):
        scan.predict(time, angle[:2])
    with pytest.raises(ValueError, match="times must ascend"):
        scan.predict(time[::-1], angle)
