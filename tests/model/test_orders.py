"""The order map of a gear: counted again tooth by tooth, and met by a published period."""

import math
from fractions import Fraction

import numpy as np
import pytest

import strainwave as sw
from strainwave.model.orders import BY_FIXED, on_output_turn, order_map

SIDEREAL_DAY, SOLAR_DAY = 86164.0905, 86400.0  # s


def lobe_passages(turning, z, tooth_turns):
    """How often one of two lobes passes a tooth of a ring while the wave generator turns `turning` times."""
    wave_generator = np.linspace(0.0, turning, 400_001)
    relative = (wave_generator - tooth_turns * wave_generator) * 2.0 + 0.1 / z
    return int(np.floor(relative[-1]) - np.floor(relative[0]))


@pytest.mark.parametrize("N", [30, 50, 100, 160])
def test_orders_are_those_of_turning_the_gear(N):
    gear = order_map(N)
    z1, z2 = 2 * N, 2 * N + 2
    assert (gear.z1, gear.z2) == (z1, z2)
    # N motor turns: the flexspline, with z2 - z1 = 2 teeth less, has turned back by one turn.
    assert gear.order("output turn").per_output_turn == 1
    assert gear.order("wave generator 2").per_output_turn == lobe_passages(N, z2, 0.0) == 2 * N
    assert gear.order("flexspline tooth engagement").per_output_turn == lobe_passages(N, z1, -1.0 / N) == z2
    # teeth of the circular spline passed by a lobe, and teeth of the flexspline, which comes the other way
    assert gear.order("tooth mesh").per_output_turn == N * z2 == (N + 1) * z1


MEMBERS = ("wave generator", "flexspline", "circular spline")


@pytest.mark.parametrize("fixed", MEMBERS)
@pytest.mark.parametrize("output", MEMBERS)
@pytest.mark.parametrize("N", [30, 100])
def test_arrangements_turn_as_their_teeth_pass(fixed, output, N):
    """Seen from the flexspline, the circular spline goes on by two of its teeth while the wave generator turns once."""
    gear = sw.gears.Arrangement(fixed, output)
    if fixed == output:
        with pytest.raises(ValueError, match="give two of wave generator, flexspline, circular spline"):
            order_map(N, gear)
        return
    turns = {"wave generator": Fraction(1), "flexspline": Fraction(0), "circular spline": Fraction(2, 2 * N + 2)}
    turns = {member: turn - turns[fixed] for member, turn in turns.items()}  # seen from the housing
    motor = turns[gear.driven]
    assert gear.ratio(N) == motor / turns[output]
    per_turn = {
        "output turn": turns[output],
        "wave generator 1": turns["wave generator"],
        "flexspline tooth engagement": 2 * (turns["wave generator"] - turns["flexspline"]),
        "circular spline tooth engagement": 2 * (turns["wave generator"] - turns["circular spline"]),
        "tooth mesh": (2 * N) * (turns["wave generator"] - turns["flexspline"]),
    }
    for line in order_map(N, gear).orders:
        j, k = line.pair
        assert line.per_motor_turn == abs(j + k * turns[output] / motor)
        assert line.per_output_turn == line.per_motor_turn * abs(motor / turns[output])
        if line.name in per_turn:
            assert line.per_motor_turn == abs(per_turn[line.name] / motor)


def test_the_two_usual_arrangements_have_opposite_senses_and_one_tooth_pair_between_their_ratios():
    assert sw.gears.Arrangement().ratio(100) == -100
    turning = order_map(100, sw.gears.Arrangement("flexspline", "circular spline"), cogging=24)
    assert turning.arrangement.ratio(100) == 101
    assert turning.order("circular spline tooth engagement").pair == (2, -2)
    assert turning.order("circular spline tooth engagement").per_motor_turn == 2 - Fraction(2, 101)
    assert turning.order("wave generator 2").pair == (2, 0)
    assert turning.order("motor cogging").per_output_turn == 24 * 101


def test_orders_on_the_output_turn_are_whole_and_ascend():
    gear = order_map(80)
    assert all(o.per_output_turn == o.per_motor_turn * 80 for o in gear.orders)
    assert [o.per_output_turn for o in gear.orders] == sorted(o.per_output_turn for o in gear.orders)
    assert gear.order("flexspline tooth engagement").per_motor_turn == Fraction(81, 40)


def test_even_harmonics_of_a_ring_pass_two_lobes_and_odd_ones_cancel():
    lobes = np.linspace(0.0, 2.0 * math.pi, 721)
    for n in range(1, 9):
        both = np.cos(n * lobes) + np.cos(n * (lobes + math.pi))
        assert np.max(np.abs(both)) == pytest.approx(2.0 if n % 2 == 0 else 0.0, abs=1e-12)


@pytest.mark.parametrize(("day", "printed"), [(SOLAR_DAY, 432.0), (SIDEREAL_DAY, 430.82)])
def test_period_of_a_telescope_mount_is_the_published_one(day, printed):
    # CSF-17-100 at one output turn per day, two per wave-generator turn: 432 s in github.com/polvinc/DHEM,
    # 430.82 s for the Rainbow RST-135 in the PHD2 wiki.
    motor_speed = 100 * 2.0 * math.pi / day
    period = 1.0 / order_map(100).order("wave generator 2").frequency_hz(motor_speed)
    assert period == pytest.approx(printed, abs=0.005)


def test_vendors_resonance_rule_is_order_two():
    # Harmonic Drive, CSF-3 manual, ch. 8: a load resonance of 15 Hz is met at 450 rpm of the input.
    speed = 450.0 * 2.0 * math.pi / 60.0
    assert order_map(50).order("wave generator 2").frequency_hz(speed) == pytest.approx(15.0, rel=1e-12)


def test_lines_move_to_the_output_turn():
    error = sw.KinematicError((sw.Line(1, 2e-5, 0.3), sw.Line(2, 1e-4, -0.4)))
    moved = on_output_turn(error, 50)
    theta_m = np.linspace(0.0, 100.0 * math.pi, 1001)
    assert np.allclose(moved.value(theta_m / 50), error.value(theta_m), rtol=0.0, atol=1e-16)
    torque = sw.Harmonics((sw.Harmonic(1.0, 2, 0.1, 3.0), sw.Harmonic(0.5, 1)))
    assert on_output_turn(torque, 50).orders() == (100, 50)
    assert on_output_turn(torque.terms[0], 50) == sw.Harmonic(1.0, 100, 0.1, 3.0)


@pytest.mark.parametrize("N", [0, -50, 1, 50.5, math.nan, math.inf, 10_001])
def test_a_ratio_without_an_order_map_is_refused(N):
    with pytest.raises(ValueError, match="whole ratio"):
        order_map(N)


def test_wrong_requests_are_refused():
    with pytest.raises(ValueError, match="the order map has no 'wave generator 3'; it has output turn"):
        order_map(50).order("wave generator 3")
    with pytest.raises(ValueError, match="at most 10000"):
        on_output_turn(sw.KinematicError((sw.Line(200, 1e-4),)), 100)


def test_sources_of_a_gear_have_the_orders_of_its_map():
    known, orders = sw.gears.static_sources(80), sw.gears.order_map(80)
    assert known["flexspline ovality"].order == orders.order("flexspline tooth engagement").per_output_turn
    assert {source.kind for source in known.values()} == {"design", "manufacture", "assembly", "deformation"}
    assert all(source.amplitude == 0.0 for source in known.values())


@pytest.mark.parametrize(("fixed", "output"), [(a, b) for a in MEMBERS for b in MEMBERS if a != b])
def test_torques_on_the_members_have_no_sum_and_no_power(fixed, output):
    arrangement = sw.gears.Arrangement(fixed, output)
    torques, R = arrangement.torques(50), arrangement.ratio(50)
    assert sum(torques.values()) == 0
    assert torques[output] == 1
    assert torques[arrangement.driven] * R + torques[output] == 0  # the output turns once, the motor R times


@pytest.mark.parametrize("fixed", ["circular_spline", "flexspline", "wave_generator"])
@pytest.mark.parametrize("N", [2, 3, 50, 160])
def test_the_teeth_of_a_ratio_are_those_that_give_it(fixed, N):
    arrangement = BY_FIXED[fixed]
    ratio = abs(float(arrangement.ratio(N)))
    assert arrangement.teeth(ratio) == N
    with pytest.raises(ValueError, match=f"is no ratio with the {fixed.replace('_', ' ')} fixed"):
        arrangement.teeth(ratio + 0.004)
