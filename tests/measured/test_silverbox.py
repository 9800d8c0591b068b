"""The measured Silverbox, where its record is at hand: STRAINWAVE_SILVERBOX is the path of SNLS80mV.csv."""

import importlib.util
import os
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

matplotlib.use("Agg")
RECORD = os.environ.get("STRAINWAVE_SILVERBOX", "")
SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "silverbox.py"
PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation.md"


def script():
    spec = importlib.util.spec_from_file_location("silverbox", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.skipif(not RECORD, reason="the record is not shipped; STRAINWAVE_SILVERBOX names its path")
def test_free_runs_leave_what_the_page_says(capsys):
    module = script()
    errors = module.main(RECORD)
    # a cubic spring with linear damping and an offset leaves .351, .452 and .354 mV
    assert [errors[name] < limit for name, limit in zip(module.TESTS, (0.25, 0.32, 0.25), strict=True)] == [True] * 3
    said = PAGE.read_text(encoding="utf-8")
    for line in capsys.readouterr().out.splitlines():
        assert line in said, line


@pytest.mark.slow
def test_a_computed_record_gives_back_its_numbers(tmp_path):
    # A record of the same kind, from the equation by DOP853 with an input that is linear between samples: the numbers
    # are those of the equation, and a free run leaves little more than what the input does between samples.
    silverbox = script()
    assert silverbox.main() is None
    rng = np.random.default_rng(4)
    k = np.arange(2001)
    t = np.arange(4000) / silverbox.RATE
    u = np.fft.irfft(np.where((k > 0) & (k < 600), np.exp(2j * np.pi * rng.random(2001)), 0.0), 4000)
    u *= 0.02 / np.std(u)
    fine = CubicSpline(np.arange(4000 * 16 + 1) / (16 * silverbox.RATE), np.append(fourier(u, 16), u[0]))

    def rhs(s, y):
        return y[1], (fine(s) - 2.2e-4 * y[1] - 1e-7 * abs(y[1]) * y[1] - y[0] - 4.0 * y[0] ** 3) / 5.4e-6

    x = solve_ivp(rhs, (0.0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-9, atol=1e-11, max_step=1.0 / silverbox.RATE).y[0]
    path = tmp_path / "record.csv"
    np.savetxt(path, np.c_[u, x], delimiter=",", header="V1,V2", comments="")
    found = silverbox.fit(path, slice(0, 3000))
    assert found.value("J") == pytest.approx(5.4e-6, rel=2e-4)
    assert found.value("law.second.D") == pytest.approx(1e-7, rel=0.1)
    run = silverbox.free_run(found, u[3000:], x[3000:3050])
    assert np.std(run - x[3000:]) < 5e-3 * np.std(x)


def fourier(u, times):
    """A periodic signal at `times` as many samples."""
    spectrum = np.fft.rfft(u)
    return np.fft.irfft(np.append(spectrum, np.zeros(len(u) * (times - 1) // 2)), len(u) * times) * times
