"""Arguments of studies that are of no use: one sentence that names them, with the value."""

from functools import cache

import numpy as np
import pytest

import strainwave as sw

S = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.1)
T = np.arange(2000) / 1000.0
HUGE = 10**400
SPEC = {
    "load_inertias": (1.3,), "speeds": (0.5, 3.0), "limit": 4e-4, "rotor_inertias": (5e-4,), "damping_ratio": 0.03,
    "mean_torque": 40.0, "peak_torque": 60.0,
}  # fmt: skip
DRIVE = sw.Drive(4.5e-4, 1.3, 50.0, 15.4, sw.Cubic(1.089e5, 6.85e4))
ERROR = sw.KinematicError((sw.Line(2, 1e-4),))
TRAIN = DRIVE.train(kinematic_error=ERROR, control=sw.train.from_bandwidth(190.0, 9.7e-4, 0.7), omega=130.0)


def monitor(**changes):
    return sw.monitor(**{"time": T, "signal": np.cos(20 * T), "angle": 10 * T, "orders": (2,)} | changes)


def design(**changes):
    return sw.design(sw.Specification(**SPEC | changes), gears=[sw.catalogue.gear("CSG-40-50")])


LONG = "x" * 3000


@cache
def orbit():
    return sw.find_orbit(S)


LINK = sw.study.Link.rod(8.0, 0.4)


def arm(**changes):
    return sw.study.two_link(**{"first": LINK, "second": LINK, "angles": [(0.0, 1.0)]} | changes)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: monitor(angle=1.0), r"angle has the shape \(\)"),
        (lambda: monitor(signal=[HUGE] * 2000), "signal is .*; it must be an array of"),
        (lambda: monitor(signal=["1"] * 2000), "signal is .*; it must be an array of"),
        (lambda: sw.gears.order_map(50, cogging=2.5), "cogging is 2.5; it must be a whole number"),
        (lambda: sw.gears.order_map(50, cogging=-3), "cogging is -3; it must be a whole number"),
        (lambda: sw.gears.static_sources(HUGE), "orders are counted for a whole ratio"),
        (lambda: orbit().amplitude(-1), "k is -1; it must be a whole number of at least 0"),
        (lambda: orbit().state([1.0, np.inf]), r"phase \[rad\] is .*; it must be finite numbers"),
        (lambda: sw.study.two_turn_motion(OF_TWO_TURNS, 1.1, ratio=5e13), "the ratio is 5e.13; orders are counted for"),
        (lambda: sw.load(LONG), r"^cannot load 'x{59}\.\.\. \(3002 characters\); results"),
        (lambda: orbit().save(LONG), r"cannot save a Orbit as 'x{59}\.\.\. \(3002 characters\); use"),
        (lambda: sw.export(TRAIN, LONG, to="c"), r"^the file is 'x{59}\.\.\. \(3002 characters\); give"),
        (lambda: sw.gears.Arrangement("flexspline", 2).ratio(50), "fixed is 'flexspline' and output 2; give two of"),
        (lambda: sw.gears.Arrangement().turn("spline"), "member is 'spline'; it must be 'wave generator', "),
        (lambda: arm(first=LINK._replace(mass=-1.0)), "Link.mass is -1; it must be positive"),
        (
            lambda: arm(angles=[(0.0, 1.0, 2.0)]),
            r"angles \[rad\] is .*; it must be finite numbers of the shape \(n, 2\)",
        ),
        (lambda: arm(payload=-1.0), "payload is -1 kg; it must be 0 or positive"),
        (
            lambda: sw.order_scan([sw.Run(T, 10.0 * T, np.cos(20.0 * T), "rad")], orders=[5e-324], highest=10.0),
            "give positive ones, none twice",
        ),
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
            lambda: sw.compensate(OF_TRAIN, "repetitive", speed=50.0),
            r"order 2 - 2/50 is a line of the output's turn; use 'adaptive'",
        ),
        (
            lambda: sw.gears.peak_to_peak(OVAL),
            "a line of the output's turn does not repeat with .*; take on_output_turn",
        ),
        (
            lambda: sw.gears.peak_to_peak(sw.KinematicError((sw.Line(3 / 50, 1e-4),))),
            "a line of the output's turn does",
        ),
        (lambda: design(kinematic_error=OVAL), "kinematic_error has a line of the output's turn, and gears"),
    ],
)
def test_a_line_of_the_outputs_turn_is_refused_in_one_sentence_by_what_counts_on_one_turn(ask, words):
    with pytest.raises(ValueError, match=words) as refusal:
        ask()
    assert "\n" not in str(refusal.value)
