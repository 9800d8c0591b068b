"""The move of a project beside goals that are none of it: what is told of its settling.

The times are those of a two-inertia model by hand, integrated by SciPy (LSODA, 1e-8): cascade, lag 0.8 ms, speed
feedforward, kinematic error of 15 arcsec.
"""

from pathlib import Path

import pytest

import strainwave as sw
from strainwave.files.reading import from_text

TEXT = """
gear: {ratio: 100, law: {type: linear, K: 4e4 N*m/rad}}
motor: {inertia: 2 kg*cm^2, loop: {type: cascade, K_v: {K_v} 1/s, K_p: 0.1 N*m*s/rad, T_n: 20 ms, lag: 0.8 ms}}
load: {inertia: 3 kg*m^2}
damping: {B: 20 N*m*s/rad}
speed: {from: 300 rpm, to: 2500 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 15 arcsec}]}
move:
  profile:
    - {type: trapezoid, angle: 30 deg, speed: 60 deg/s, acceleration: 400 deg/s^2}
    - {type: dwell, time: 0.6 s}
    - {type: s_curve, angle: -3 deg, time: 0.15 s}
    - {type: dwell, time: 0.6 s}
  window: {window} deg
"""


def tuned(K_v, window, **given):
    text = TEXT.replace("{K_v}", K_v).replace("{window}", window)
    return sw.tune(from_text(text, Path("axis.yaml")), goals=("pointing",), **given)


@pytest.mark.slow
def test_five_percent_of_a_gain_cost_settling_of_the_move_where_no_goal_is_one_of_it():
    found = tuned("30", "0.012", gains=("K_v", "K_p"))
    assert found.recommended.gains == pytest.approx((8.04, 0.01883), rel=0.01)
    assert found.recommended.settlings == pytest.approx((0.2813, 0.2614), rel=0.02)
    assert found.cost[:3] == ("K_v", -0.05, "settling of the move")
    assert (found.cost.before, found.cost.after) == pytest.approx((0.2813, 0.3542), rel=0.02)
    assert "5 % less K_v makes settling of the move" in " ".join(str(found).split())


@pytest.mark.slow
def test_a_move_that_does_not_settle_is_told():
    found = tuned("3", "0.01")
    assert "The move does not settle with the recommended gains." in found.remarks
    assert "note: The move does not settle with the recommended gains." in str(found)
    assert not any("does not settle" in remark for remark in tuned("30", "0.01").remarks)
