"""The words of the verdict where no change was found."""

from types import SimpleNamespace

from strainwave.app.report.verdict import _remedy
from strainwave.study.analysis.avoid import Avoid
from strainwave.study.analysis.remedies import Remedy
from strainwave.study.analysis.verdict import Answer, Verdict
from strainwave.units import ARCSEC

AVOID = Avoid(((100.0, 120.0),), 80.0 * ARCSEC, 110.0, 5.0 * ARCSEC, limit=60.0 * ARCSEC)
VERDICT = Verdict(Answer.NOT, ((100.0, 120.0),), (), ())


def words(ratio, exceeds):
    best = Remedy("damping of the loop", 0.3, 0.0, ratio, 110.0, 1.0, 1.3, "", exceeds=exceeds)
    view = SimpleNamespace(analysis=SimpleNamespace(avoid=AVOID, remedies=(best,), verdict=VERDICT))
    return str(_remedy(view, VERDICT))


def test_a_remedy_that_serves_at_the_worst_torque_alone_is_not_said_to_miss_the_limit():
    said = words(0.5, exceeds=False)
    assert "within its limit under every load torque; the best, 30 % more damping of the loop, leaves" in said
    assert " rad at the torque of the largest oscillation." in said


def test_a_remedy_that_misses_the_limit_is_the_best_of_no_change():
    said = words(0.9, exceeds=True)
    assert "within its limit; the best, 30 % more damping of the loop, leaves " in said
    assert "torque of the largest oscillation" not in said
