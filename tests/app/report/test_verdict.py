"""The words of the verdict where no change was found."""

import math
from types import SimpleNamespace

import pytest

from strainwave.base.units import ARCSEC
from strainwave.model.gears.limits import Finding
from strainwave.study.analysis.remedies import Remedy
from strainwave.study.analysis.verdict import Answer, JudgedPosture, Verdict
from strainwave.study.analysis.verdict_words import _headline, _remedy
from strainwave.study.speed_map.avoid import Avoid

AVOID = Avoid(((100.0, 120.0),), 80.0 * ARCSEC, 110.0, 5.0 * ARCSEC, limit=60.0 * ARCSEC)
VERDICT = Verdict(Answer.NOT, ((100.0, 120.0),), (), ())


def words(ratio, exceeds):
    best = Remedy("damping of the loop", 0.3, 0.0, ratio, 110.0, 1.0, 1.3, "", exceeds=exceeds)
    analysis = SimpleNamespace(avoid=AVOID, remedies=(best,), verdict=VERDICT, moved=None)
    return str(_remedy(analysis, VERDICT))


def test_a_remedy_that_serves_at_the_worst_torque_alone_is_not_said_to_miss_the_limit():
    said = words(0.5, exceeds=False)
    assert "within its limit under every load torque; the best one, 30 % more damping of the loop, gives" in said
    assert " rad under the load torque of the largest oscillation." in said


def test_a_remedy_that_misses_the_limit_is_the_best_of_no_change():
    said = words(0.9, exceeds=True)
    assert "within its limit; the best one, 30 % more damping of the loop, gives " in said
    assert "load torque of the largest oscillation" not in said


def headline(
    answer, peak, exceeded=(), unstable=(), limit=100.0, jumping=(), postures=(), run_up=None, moved=None, apart=None
):
    passed = ((100.0, 120.0),) if run_up else ()
    avoid = Avoid(
        unstable, peak, 110.0, 1.0, (), limit, passed, run_up and (110.0, run_up), unstable, apart and (110.0, apart)
    )
    analysis = SimpleNamespace(
        train=None,
        avoid=avoid,
        posture=max(postures, key=lambda row: row.rank, default=None),
        postures=postures,
        moved=moved,
        jumping=jumping,
        largest_oscillation=lambda: SimpleNamespace(peak=peak),
    )
    return _headline(analysis, Verdict(answer, unstable, (), exceeded))


TORQUE = Finding("repeated_peak_torque", 616.8, 523.0, "N*m", "")
BAND = ((100.0, 120.0),)
IN = JudgedPosture(1, "in", 1.0, 0.0, Answer.ALL_RIGHT, 15.0, 110.0)
OUT = JudgedPosture(2, "out", 2.0, 0.0, Answer.BUT, 120.0, 100.0)
FAR = JudgedPosture(2, "far", 3.0, 0.0, Answer.NOT, math.nan, math.nan)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((Answer.ALL_RIGHT, 14.0), "Pass; the oscillation is 86 % below its limit"),
        ((Answer.NOT, 14.0, (TORQUE,)), "Fail; 616.8 N·m exceeds the repeated peak torque of 523 N·m"),
        ((Answer.BUT, 100.18), "Fail at some speeds; the oscillation is 0.18 % above its limit"),
        ((Answer.BUT, 340.0), "Fail at some speeds; the oscillation is 3.4 times its limit"),
        (
            (Answer.BUT, 14.0, (), (), 100.0, (), (IN, OUT)),
            "Fail at some speeds; the oscillation in posture 2 (out) is 20 % above its limit; "
            "1 of 2 postures fails, posture 2 (out)",
        ),
        (
            (Answer.BUT, 14.0, (), (), 100.0, (), (IN, OUT._replace(peak=13.0))),
            "Fail at some speeds; 1 of 2 postures fails, posture 2 (out)",
        ),
        (
            (Answer.NOT, 14.0, (), (), 100.0, (), (OUT._replace(number=1), FAR)),
            "Fail; the oscillation in posture 1 (out) is 20 % above its limit; 2 of 2 postures fail, "
            "posture 2 (far) by the most",
        ),
        ((Answer.BUT, 14.0, (), BAND), "Fail at some speeds; the steady motion is unstable at some speeds"),
        ((Answer.BUT, 14.0, (), (), 100.0, (1,)), "Fail at some speeds; the oscillation jumps"),
        (
            (Answer.BUT, 92.0, (), (), 100.0, (), (), None, None, 116.0),
            "Fail at some speeds; the oscillation of another periodic motion at the same speed is 16 % above its limit",
        ),
        (
            (Answer.ALL_RIGHT, 92.0, (), (), 100.0, (), (), 116.0),
            "Pass; the oscillation is 8 % below its limit; but in a run-up avoid 100 to 120 rad/s",
        ),
        (
            (Answer.NOT, 14.0, (), (), 100.0, (), (), None, SimpleNamespace(findings=(TORQUE,))),
            "Fail; in the move of the project file, 616.8 N·m exceeds the repeated peak torque of 523 N·m",
        ),
        ((Answer.ALL_RIGHT, 14.0, (), (), None), "Pass; the project file has no oscillation limit"),
    ],
)
def test_the_headline_gives_the_reason_of_its_answer(given, said):
    assert headline(*given) == said
