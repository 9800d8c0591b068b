"""Orders that a drive has and its file has not, in logs that SciPy made: named where they are, and nowhere else."""

from types import SimpleNamespace

import numpy as np
import pytest
from measured_axis import PROJECT, measured

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text
from strainwave.files.variants import missing_orders
from strainwave.files.variants.identify_drive import with_torsion
from strainwave.files.variants.missing_orders import Place, missing_lines

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return from_text(PROJECT, tmp_path_factory.mktemp("axis") / "axis.yaml")


def of_orders(found):
    return [remark for remark in found.remarks if "order" in remark]


@pytest.mark.parametrize(("order", "arcsec"), [(4.0, 5.0), (1.0, 5.0), (1.0, 12.0), (5.05, 3.0)])
def test_a_line_that_the_file_lacks_is_named_with_its_amplitude(project, order, arcsec):
    log = measured(line=(order, arcsec * ARCSEC))
    found = sw.identify_drive(project, log)
    (said,) = of_orders(found)
    assert f"kinematic error of order {order:g} (" in said
    assert "which the file lacks" in said
    (line,) = missing_lines(found.found, [with_torsion(log, 100.0)])
    assert line.amplitude == pytest.approx(arcsec * ARCSEC, rel=0.03)
    assert not line.in_reading


def test_a_line_that_hides_beside_a_gap_is_said_to_hide(project):
    found = sw.identify_drive(project, measured(line=(4.0, 5.0 * ARCSEC), gap=9e-5))
    assert of_orders(found) == []
    assert "What the model leaves is no noise" in found.remarks[-1]


def test_a_line_of_a_sensor_is_none_of_the_gear(project):
    log = measured()
    log["load_angle"] -= 3e-5 * np.cos(5.05 * log["motor_angle"] + 1.0)
    (said,) = of_orders(sw.identify_drive(project, log))
    assert "order 5.05 (6.19 arcsec) of the motor's angle: a sensor may have it" in said


@pytest.mark.parametrize(
    "machine",
    [{"gap": 3e-5}, {"gap": 2e-6}, {"softer": 0.06}, {"dry": 0.6}, {"square": 15.0}, {}],
    ids=["gap", "small gap", "softer one way", "dry friction", "quadratic damping", "right"],
)  # fmt: skip
def test_what_else_a_file_lacks_is_no_order(project, machine):
    found = sw.identify_drive(project, measured(**machine))
    assert of_orders(found) == []
    assert missing_lines(found.found, [with_torsion(measured(**machine), 100.0)]) == []
    hides = any("lines of the kinematic error that the file lacks may hide in it" in said for said in found.remarks)
    assert hides is (found.unexplained > 0.02)


@pytest.mark.parametrize(("hidden", "named"), [(0.0, True), (0.6, False)], ids=["the line alone", "its shadow too"])
def test_a_line_that_another_term_resembles_is_told_by_what_it_leaves(monkeypatch, hidden, named):
    """The term explains 62 % of what the line does. Beside it the residual may have a part that neither explains."""
    rng = np.random.default_rng(3)
    directions = np.linalg.qr(rng.standard_normal((4000, 7)))[0].T
    columns, term = directions[:2].T[:, None, :], np.sqrt(0.62) * directions[0] + np.sqrt(0.38) * directions[2]
    share = np.array([np.sqrt(1.0 - hidden**2), 0.0])
    residual = -hidden * directions[6] - 1e-4 * rng.standard_normal(4000)
    point = SimpleNamespace(reduced=lambda: (directions[3:6].T, residual), values=np.append(np.ones(3), share))
    left = SimpleNamespace(places=(Place(4.0, False),), columns=lambda _: columns, point=point, problem=None)
    monkeypatch.setattr(missing_orders, "candidate_columns", lambda *_: {"a term": term})
    lines = missing_orders._confirmed(left, 60)
    assert [line.order for line in lines] == [4.0] * named
    assert all(line.amplitude == pytest.approx(1.0, rel=1e-3) for line in lines)
