"""Results: peaks between samples, printing, and files that appear only when they are complete."""

import os

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.results import SolveError, Trajectory, atomic


def cosine(t, omega=3.0):
    y = np.array([np.cos(omega * t), -omega * np.sin(omega * t)])
    rate = np.array([y[1], -omega * omega * y[0]])
    return Trajectory(t, y, rate, sw.Status.OK, sw.Status.OK.value, len(t) - 1, 0, 0)


def test_peak_is_found_between_the_samples_with_fourth_order():
    for n in (41, 81, 161, 321):
        t = np.linspace(0.3, 10.0, n)
        assert np.max(np.abs(cosine(t).y[0])) < 1.0
        # Cubic Hermite interpolation errs by h^4/384 times the largest fourth derivative at most.
        assert abs(cosine(t).peak() - 1.0) <= (3.0 * (t[1] - t[0])) ** 4 / 384


def test_peak_looks_at_one_component_and_after_a_time():
    t = np.linspace(0.0, 10.0, 401)
    assert cosine(t).peak(1) == pytest.approx(3.0, rel=1e-6)
    assert cosine(t).peak(0, after=9.9) == pytest.approx(np.max(np.abs(np.cos(3.0 * t[t >= 9.9]))), abs=1e-12)
    with pytest.raises(ValueError, match="no sample at t >= 11"):
        cosine(t).peak(after=11.0)


def test_peak_of_one_sample_and_of_rest_are_exact():
    assert cosine(np.array([0.0])).peak() == 1.0
    rest = np.zeros((2, 5))
    assert Trajectory(np.arange(5.0), rest, rest, sw.Status.OK, "", 4, 0, 0).peak() == 0.0


@pytest.mark.parametrize("scale", [1e-300, 1e30])
def test_peak_of_tiny_and_huge_values_is_finite(scale):
    one = cosine(np.linspace(0.0, 10.0, 400))
    scaled = Trajectory(one.t, scale * one.y, scale * one.rate, one.status, one.message, 0, 0, 0)
    assert scaled.peak() == pytest.approx(scale, rel=1e-5)


def test_status_is_true_only_when_all_is_well():
    assert [status for status in sw.Status if status] == [sw.Status.OK]
    assert all(len(status.value.split()) > 3 for status in sw.Status if not status)
    assert issubclass(SolveError, RuntimeError)


def test_trajectory_prints_its_status():
    text = str(cosine(np.linspace(0.0, 1.0, 11)))
    assert "11 samples, t = 0 .. 1 s" in text
    assert "status: finished" in text


def test_saved_trajectory_reads_back(tmp_path):
    saved = cosine(np.linspace(0.0, 1.0, 11))
    path = saved.save(tmp_path / "run.csv")
    assert path.read_text(encoding="utf-8").splitlines()[0] == "t_s,x_rad,v_rad_per_s"
    t, *y = np.loadtxt(path, delimiter=",", skiprows=1).T
    np.testing.assert_allclose(y, saved.y, rtol=1e-11)
    np.testing.assert_allclose(t, saved.t, rtol=1e-11)
    assert os.listdir(tmp_path) == ["run.csv"]


def test_interrupted_save_keeps_the_old_file_and_leaves_no_other(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")

    def half_written():
        with atomic(path) as part, open(part, "w", encoding="utf-8") as stream:
            stream.write("ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half_written()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["run.csv"]


@pytest.mark.skipif(os.name == "nt", reason="POSIX permissions")
def test_saved_file_has_the_permissions_of_any_new_file(tmp_path):
    (tmp_path / "plain").write_text("")
    saved = cosine(np.linspace(0.0, 1.0, 3)).save(tmp_path / "run.nc")
    assert saved.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_peak_takes_the_largest_values_between_samples_where_they_are_known():
    y, rest = np.array([[1.0, 0.5, -0.2]]), np.zeros((1, 3))
    run = Trajectory(np.arange(3.0), y, rest, sw.Status.OK, "", 9, 0, 0, np.array([[0.0, 3.0, 0.7]]))
    assert run.peak() == 3.0
    assert run.peak(after=1.0) == 0.7
    assert run.peak(after=2.0) == 0.2
