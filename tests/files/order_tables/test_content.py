"""What an order table says: its value, its other forms, what it is made of and what it refuses."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from order_machines import ANGLE, ARCSEC, TORQUE, TWO_WAYS

import strainwave as sw

ANGLES = np.linspace(-7.0, 7.0, 701)


def test_value_is_the_sum_of_the_lines_read_ahead():
    table = dataclasses.replace(TWO_WAYS, delay=1e-3)
    led = ANGLES + 0.25
    forward = 5 * ARCSEC + 20 * ARCSEC * np.cos(2 * led + 0.3)
    assert np.allclose(table.value(ANGLES, 250.0), forward, rtol=0.0, atol=1e-18)
    led = ANGLES - 0.25
    backward = -5 * ARCSEC + 17 * ARCSEC * np.cos(2 * led + 0.5) + ARCSEC * np.cos(3 * led)
    assert np.allclose(table.value(ANGLES, -250.0), backward, rtol=0.0, atol=1e-18)
    both = table.value(ANGLES[:, None], np.array([250.0, -250.0]))
    assert both.shape == (701, 2)
    assert isinstance(table.value(0.3), float)
    assert table.value(0.3) == pytest.approx(5 * ARCSEC + 20 * ARCSEC * math.cos(0.9))


def test_a_table_of_one_direction_is_silent_in_the_other():
    assert dataclasses.replace(ANGLE, direction="forward").value(1.0, -1.0) == 0.0
    assert dataclasses.replace(ANGLE, direction="backward").value(1.0, 1.0) == 0.0
    assert dataclasses.replace(ANGLE, direction="backward").value(1.0, -1.0) == ANGLE.value(1.0)


@given(
    speed=st.just(0.0) | st.floats(1e-3, 500.0) | st.floats(-500.0, -1e-3), delay=st.just(0.0) | st.floats(1e-9, 5e-3)
)
def test_the_table_of_one_speed_is_the_table_at_that_speed(speed, delay):
    for table in (ANGLE, TWO_WAYS):
        table = dataclasses.replace(table, delay=delay)
        fixed = table.at_speed(abs(speed))
        assert fixed.delay == 0.0
        got, expected = fixed.value(ANGLES, speed), table.value(ANGLES, speed)
        assert np.allclose(got, expected, rtol=0.0, atol=1e-12 * table.rms)


def test_the_other_turn_counts_the_same_orders():
    output = ANGLE.on_turn("output")
    assert output.orders == (120, 240, 480)
    assert np.allclose(output.value(ANGLES / 120.0), ANGLE.value(ANGLES), rtol=0.0, atol=1e-16)
    assert output.zero * 120.0 == pytest.approx(ANGLE.zero)
    back = output.on_turn("motor")
    assert back.lines == ANGLE.lines
    with pytest.raises(ValueError, match=r"order 7 is 0\.14 on the motor turn at the ratio 50, no whole number"):
        sw.OrderTable((sw.Line(7, 1e-5),), turn="output", ratio=50.0).on_turn("motor")
    with pytest.raises(ValueError, match="give the table its ratio"):
        TORQUE.on_turn("output")


def test_one_way_keeps_a_set_or_the_mean_of_the_two():
    for way, speed in (("forward", 1.0), ("backward", -1.0)):
        one = TWO_WAYS.one_way(way)
        assert np.array_equal(one.value(ANGLES, -speed), TWO_WAYS.value(ANGLES, speed))
    mean = 0.5 * (TWO_WAYS.value(ANGLES, 1.0) + TWO_WAYS.value(ANGLES, -1.0))
    assert np.allclose(TWO_WAYS.one_way("mean").value(ANGLES, -3.0), mean, rtol=0.0, atol=1e-18)
    with pytest.raises(ValueError, match="holds in the direction 'forward' alone; it has no lines backward"):
        dataclasses.replace(ANGLE, direction="forward").one_way("backward")


def test_the_correction_of_an_angle_is_the_error_and_of_a_torque_its_negative():
    error = dataclasses.replace(ANGLE, sign="error")
    assert np.array_equal(error.correction().value(ANGLES), ANGLE.value(ANGLES))
    torque = dataclasses.replace(TORQUE, sign="error", mean=0.2)
    assert np.allclose(torque.correction().value(ANGLES), -torque.value(ANGLES), rtol=0.0, atol=1e-16)
    assert torque.correction().correction() == torque.correction()


def test_a_kinematic_error_goes_in_and_comes_out():
    error = sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(1, -2e-5, -1.0), sw.Line(2, 1e-5, 0.0)))
    table = sw.OrderTable.of(error, ratio=50.0, sign="error")
    assert np.allclose(table.value(ANGLES), error.value(ANGLES), rtol=0.0, atol=1e-18)
    assert np.allclose(table.kinematic_error().value(ANGLES), error.value(ANGLES), rtol=0.0, atol=1e-18)
    assert sw.OrderTable.of(ANGLE.kinematic_error()).lines == ANGLE.lines
    with pytest.raises(ValueError, match="the table is a torque"):
        TORQUE.kinematic_error()
    with pytest.raises(ValueError, match="differs between forward and backward"):
        TWO_WAYS.kinematic_error()
    with pytest.raises(TypeError, match="has no lines of orders; give a KinematicError, an ErrorScan, or lines"):
        sw.OrderTable.of(3.0)


def test_a_torque_over_the_angle_goes_in_and_comes_out():
    torque = sw.Harmonics((sw.Harmonic(0.02, 2, 0.3, mean=0.1), sw.Harmonic(-0.01, 12, 1.0)))
    table = sw.OrderTable.of(torque, delay=1e-3)
    assert table.unit == "N*m"
    assert np.allclose(table.value(ANGLES), torque.torque(ANGLES), rtol=0.0, atol=1e-16)
    assert sw.OrderTable.of(torque.terms[0]).lines == (sw.Line(2, 0.02, 0.3),)
    # as a controller adds it: at the angle that the motor reaches a lead later
    loop = sw.controllers.SampledPD(1.0, 0.1, 1e-3)
    controller = sw.controllers.TorqueTable(loop, table.torque(), table.delay)
    for speed in (200.0, -200.0):
        sample = sw.controllers.Measurement(0.7, speed, 0.0, 0.69, math.nan, 0.0, 0.0)
        added = controller.update(controller.start(), sample)[1] - loop.update(loop.start(), sample)[1]
        assert added == pytest.approx(table.value(0.7, speed), abs=1e-15)
    disturbance = dataclasses.replace(table, sign="error")
    assert np.allclose(disturbance.torque().torque(ANGLES), -torque.torque(ANGLES), rtol=0.0, atol=1e-16)
    with pytest.raises(ValueError, match="the table is an angle in rad, no torque"):
        ANGLE.torque()
    with pytest.raises(ValueError, match="has no lines, a torque over an angle needs one"):
        sw.OrderTable((), unit="N*m").torque()
    with pytest.raises(ValueError, match="a torque over an angle does not; choose with one_way"):
        dataclasses.replace(TORQUE, direction="forward").torque()


def test_error_scans_of_two_directions_make_a_table():
    angle = np.linspace(0.0, 4.0 * math.pi, 720, endpoint=False)
    scans = [sw.error_scan(angle, TWO_WAYS.value(angle, way), orders=[2, 3]) for way in (1.0, -1.0)]
    table = sw.OrderTable.of(scans[0], backward=scans[1], sign="error", source="rig")
    assert table.keep([2]).lines[0].amplitude == pytest.approx(20 * ARCSEC, rel=1e-9)
    assert table.backward[1].amplitude == pytest.approx(ARCSEC, rel=1e-9)


def test_the_range_of_validity_is_told():
    table = dataclasses.replace(ANGLE, speeds=(10, 200), load=-50)
    assert table.covers(-100.0)
    assert table.covers(100.0, -50.0)
    assert not table.covers(201.0)
    assert not table.covers(9.9)
    assert not table.covers(100.0, 0.0)
    assert ANGLE.covers(1e6, 3.0)
    assert "holds for 10 .. 200 rad/s of the motor, -50 N*m on the load" in str(table)


def test_rms_is_that_of_the_values():
    angle = np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False)
    for table in (ANGLE, TORQUE, TWO_WAYS):
        values = [np.sqrt(np.mean(table.value(angle, way) ** 2)) for way in (1.0, -1.0)]
        assert table.rms == pytest.approx(max(values), rel=1e-12)


def test_strongest_and_keep():
    assert ANGLE.strongest(1).orders == (2,)
    assert ANGLE.keep((1, 4, 9)).orders == (1, 4)
    assert TWO_WAYS.strongest(1).backward == TWO_WAYS.backward[:1]


LINE = sw.Line(2, 1e-4, 0.0)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"lines": LINE}, "write .Line"),
        ({"lines": (LINE, LINE)}, "order 2 is twice in the lines of an order table; add the two to one line"),
        ({"lines": (3.0,)}, "hold 3.0; write Line"),
        ({"lines": (sw.Line(0, 1e-4),)}, "an order of an order table is 0; it must be a whole number of at least 1"),
        ({"lines": (sw.Line(1.5, 1e-4),)}, "is 1.5; it must be a whole number"),
        ({"lines": (sw.Line(20_000, 1e-4),)}, "at most 10000"),
        ({"lines": (sw.Line(2, -1e-4),)}, "amplitude of order 2 is -0.0001; give it 0-to-peak and half a turn"),
        ({"lines": (sw.Line(2, math.nan),)}, "amplitude of order 2 is nan; it must be a finite number"),
        ({"lines": (sw.Line(2, 1e-4, math.inf),)}, "phase of order 2 is inf; it must be a finite number"),
        ({"unit": "deg"}, "unit of an order table is 'deg'; it must be one of 'rad', 'N.m'"),
        ({"turn": "load"}, "must be one of 'motor', 'output'"),
        ({"sign": "plus"}, "must be one of 'correction', 'error'"),
        ({"direction": 1}, "must be one of 'both', 'forward', 'backward'"),
        ({"ratio": 0.0}, "ratio of an order table is 0.0; it must be a positive finite number"),
        ({"delay": -1e-3}, "delay of an order table is -0.001 s; it must not be negative"),
        ({"speeds": (3.0, 1.0)}, "speeds of an order table are 3 .. 1 rad/s"),
        ({"speeds": 3.0}, "give the lowest and the highest"),
        ({"mean_backward": 1.0}, "has mean_backward and no backward lines"),
        ({"backward": (LINE,), "direction": "forward"}, "with backward lines has the direction 'forward'"),
        ({"source": 3}, "source of an order table is 3; write it as text"),
        ({"source": "x" * 2001}, "source of an order table has 2001 letters; it may have 2000"),
        ({"zero": "0"}, "zero of an order table is '0'; it must be a finite number"),
    ],
)
def test_a_wrong_table_is_refused_in_one_sentence(fields, said):
    with pytest.raises((ValueError, TypeError), match=said) as refusal:
        sw.OrderTable(**{"lines": (LINE,)} | fields)
    assert "\n" not in str(refusal.value)


BEATING = (sw.Line(2, 20e-6, 0.3), sw.Line(1.96, 17e-6, -1.0), sw.Line(4, 3e-6, 0.1))


def test_lines_of_both_turns_count_on_the_output_whose_pairs_are_said():
    table = sw.OrderTable.of(BEATING, ratio=50.0)
    assert (table.turn, table.orders, table.pairs) == ("output", (98, 100, 200), ((2, -2), (2, 0), (4, 0)))
    error = sw.KinematicError(BEATING)
    angle = np.linspace(0.0, 400.0, 1001)  # of the motor, more than a turn of the output
    assert table.value(angle / 50.0) == pytest.approx(error.value(angle), abs=1e-17)
    assert "ratio 50, pairs (motor, output)" in str(table)
    assert "(2, -2)" in str(table)
    assert table.keep((100, 200)).on_turn("motor").orders == (2, 4)
    assert sw.OrderTable.of(BEATING[::2], ratio=50.0).turn == "motor"


def test_lines_of_one_pair_are_added_and_pairs_of_no_table_are_refused():
    twice = sw.OrderTable.of((*BEATING, sw.Line(1.96 + 1e-12, 17e-6, -1.0)), ratio=50.0)
    assert twice.orders == (98, 100, 200)
    assert twice.lines[0].amplitude == pytest.approx(34e-6)
    for fields, said in (
        ({}, "order 1.96 is a line of the output's turn; give the ratio, and the table counts there"),
        ({"ratio": 50.0, "turn": "motor"}, "an order of an order table is 1.96; it must be a whole number"),
        ({"ratio": 50.3}, "order 2 is 100.6 on the output turn at the ratio 50.3, no whole number"),
        ({"ratio": 1.02}, "order 2 is 2.04 on the output turn at the ratio 1.02, no whole number"),
        ({"ratio": -50.0}, "ratio of an order table is -50.0; it must be a positive finite number"),
    ):
        with pytest.raises(ValueError, match=said):
            sw.OrderTable.of(BEATING, **fields)


def test_a_value_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="not finite; hold the last value"):
        ANGLE.value(np.array([0.0, math.nan]))
    with pytest.raises(ValueError, match="not finite"):
        ANGLE.value(0.0, math.inf)
