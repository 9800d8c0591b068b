"""Arguments of studies that are of no use: one sentence that names them, with the value."""

from functools import cache

import numpy as np
import pytest

import strainwave as sw

S = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.1)
SPEC = {
    "load_inertias": (1.3,), "speeds": (0.5, 3.0), "limit": 4e-4, "rotor_inertias": (5e-4,), "damping_ratio": 0.03,
    "mean_torque": 40.0, "peak_torque": 60.0,
}  # fmt: skip
DRIVE = sw.Drive(4.5e-4, 1.3, 50.0, 15.4, sw.Cubic(1.089e5, 6.85e4))
ERROR = sw.KinematicError((sw.Line(2, 1e-4),))
TRAIN = DRIVE.train(kinematic_error=ERROR, control=sw.train.from_bandwidth(190.0, 9.7e-4, 0.7), omega=130.0)


def design(**changes):
    return sw.design(sw.Specification(**SPEC | changes), gears=[sw.catalogue.gear("CSG-40-50")])


@cache
def orbit():
    return sw.find_orbit(S)


LINK = sw.study.Link.rod(8.0, 0.4)


def arm(**changes):
    return sw.study.two_link(**{"first": LINK, "second": LINK, "angles": [(0.0, 1.0)]} | changes)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: sw.gears.order_map(50, cogging=-3), "cogging is -3; it must be a whole number"),
        (lambda: orbit().amplitude(-1), "k is -1; it must be a whole number of at least 0"),
        (lambda: orbit().state([1.0, np.inf]), r"phase \[rad\] is .*; it must be finite numbers"),
        (lambda: sw.study.two_turn_motion(OF_TWO_TURNS, 1.1, ratio=5e13), "the ratio is 5e.13; orders are counted for"),
        (lambda: orbit().save("x" * 3000), r"cannot save a Orbit as 'x{59}\.\.\. \(3002 characters\); use"),
        (lambda: sw.gears.Arrangement("flexspline", 2).ratio(50), "fixed is 'flexspline' and output 2; give two of"),
        (lambda: sw.gears.Arrangement().turn("spline"), "member is 'spline'; it must be 'wave generator', "),
        (lambda: arm(first=LINK._replace(mass=-1.0)), "Link.mass is -1; it must be positive"),
        (
            lambda: arm(angles=[(0.0, 1.0, 2.0)]),
            r"angles \[rad\] is .*; it must be finite numbers of the shape \(n, 2\)",
        ),
        (lambda: arm(payload=-1.0), "payload is -1 kg; it must be 0 or positive"),
    ],
)
def test_what_is_no_input_is_refused_by_its_name(ask, words):
    with pytest.raises(ValueError, match=words):
        ask()


OVAL = sw.KinematicError((sw.Line(2, 1e-4), sw.Line(2 - 2 / 50, 5e-5)))
OF_TWO_TURNS, OF_TRAIN = S._replace(error=OVAL), TRAIN._replace(error=OVAL)
BROKEN = r"the order 1\.96 is not an integer, so the motion does not repeat"


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: sw.ensemble(OF_TWO_TURNS, {"omega": [1.0, 1.1]}, (0.0, 0.0), periods=9), BROKEN),
        (lambda: sw.basins(OF_TWO_TURNS, [0.0, 0.1], [0.0, 0.1]), BROKEN),
        (
            lambda: sw.gears.peak_to_peak(OVAL),
            "a line of the output's turn does not repeat with .*; take on_output_turn",
        ),
        (lambda: design(kinematic_error=OVAL), "kinematic_error has an order of the output shaft, but the gears"),
    ],
)
def test_a_line_of_the_outputs_turn_is_refused_in_one_sentence_by_what_counts_on_one_turn(ask, words):
    with pytest.raises(ValueError, match=words) as refusal:
        ask()
    assert "\n" not in str(refusal.value)
