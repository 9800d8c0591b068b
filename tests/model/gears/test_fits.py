"""Cubic fits of the catalogue's stiffness, against a published table of them and against integrals done by hand."""

import csv
import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.model.gears.catalogue import DATA

with (DATA / "catalogue_stiffness.csv").open(encoding="utf-8", newline="") as stream:
    ROWS = list(csv.DictReader(stream))
each_row = pytest.mark.parametrize("row", ROWS, ids=lambda r: f"{r['family']}-{r['size']}-{r['ratio']}")

# K [N*m/rad] and alpha [1/rad^2] by size and ratio, by a separate least-squares program from the vendors' slopes.
FITS = {
    ("14", "30"): (1964.0, 1.67e4), ("14", "50"): (3700.0, 5.39e4), ("14", ">=80"): (5075.0, 6.97e4),
    ("17", "30"): (3429.0, 2.29e4), ("17", "50"): (8646.0, 9.2e4), ("17", ">=80"): (1.081e4, 1.46e5),
    ("20", "30"): (5809.0, 1.27e4), ("20", "50"): (1.409e4, 6.76e4), ("20", ">=80"): (1.816e4, 1.32e5),
    ("25", "30"): (1.017e4, 1.35e4), ("25", "50"): (2.672e4, 6.6e4), ("25", ">=80"): (3.51e4, 1.49e5),
    ("32", "30"): (2.441e4, 1.33e4), ("32", "50"): (5.983e4, 6.98e4), ("32", ">=80"): (7.876e4, 1.26e5),
    ("40", "50"): (1.089e5, 6.85e4), ("40", ">=80"): (1.48e5, 1.29e5),
    ("50", "50"): (2.193e5, 6.36e4), ("50", ">=80"): (2.878e5, 1.33e5),
    ("65", "50"): (4.775e5, 6.84e4), ("65", ">=80"): (6.24e5, 1.41e5),
    ("90", "50"): (1.283e6, 6.45e4), ("90", ">=80"): (1.666e6, 1.34e5),
}  # fmt: skip


def slopes(row):
    return sw.PiecewiseLinear(
        *(float(row[f"K{i}_Nm_per_rad"]) for i in (1, 2, 3)), float(row["T1_Nm"]), float(row["T2_Nm"])
    )


def reach(law):
    """Torsion at 1.5 T2."""
    return law.breakpoints()[3] + 0.5 * law.T2 / law.K3


@each_row
def test_every_row_of_the_catalogue_is_a_weakly_hardening_spring(row):
    law = slopes(row)
    fit = sw.gears.fit_odd(law, reach(law))
    assert 0.10 <= fit.law.alpha * law.breakpoints()[3] ** 2 <= 0.25
    assert fit.relative < 0.017
    if (row["size"], row["ratio"]) in FITS:
        assert fit.law == pytest.approx(FITS[row["size"], row["ratio"]], rel=0.01)


def test_the_published_fits_all_belong_to_rows():
    assert set(FITS) <= {(row["size"], row["ratio"]) for row in ROWS}


def test_a_fit_of_a_polynomial_is_the_polynomial():
    law = sw.Polynomial((0.0, 3.0, 0.0, -0.4, 0.0, 0.2))
    fit = sw.gears.fit_odd(law, 1.3, 5)
    assert fit.law.coefficients == pytest.approx(law.coefficients, abs=1e-12)
    assert fit.rms < 1e-13


def test_the_fit_of_a_straight_line_to_play_is_the_integral_done_by_hand():
    # minimise the integral of (k s - p(s - b))^2 over 0..1, p positive part: k = 3 (1/3 - b/2 + b^3/6)
    b = 0.25
    fit = sw.gears.fit_odd(sw.Backlash(1.0, b), 1.0, 1)
    assert fit.law.coefficients[1] == pytest.approx(3.0 * (1.0 / 3.0 - b / 2.0 + b**3 / 6.0), rel=1e-3)
    x = np.linspace(0.0, 1.0, 100001)
    error = fit.law.torque(x) - sw.Backlash(1.0, b).torque(x)
    assert fit.rms == pytest.approx(math.sqrt(np.mean(error**2)), rel=1e-3)
    assert fit.largest == pytest.approx(np.max(np.abs(error)), rel=1e-9)
    assert fit.relative == pytest.approx(fit.rms / 0.75, rel=1e-12)


def test_more_terms_fit_better():
    law = slopes(ROWS[15])
    errors = [sw.gears.fit_odd(law, reach(law), degree).rms for degree in (1, 3, 5, 7, 9)]
    assert errors == sorted(errors, reverse=True)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((sw.Linear(1.0), 1.0, 4), "degree is 4; an odd polynomial has one of 1, 3, 5 to 15"),
        ((sw.Linear(1.0), 1.0, 17), "degree is 17"),
        (
            (sw.Linear(1.0), 1e-300),
            r"reach \[rad\] is 1e-300; it must be from 1e-60 to 1e\+60 in size",
        ),
        (
            (sw.Linear(1.0), 1e-40),
            r"reach \[rad\] is 1e-40, outside the supported range: the coefficients of degree 3 exceed",
        ),
        ((sw.Linear(1.0), 1e50, 15), r"reach \[rad\] is 1e\+50, outside the supported range"),
        ((sw.Linear(1.0), 0.0), r"reach \[rad\] is 0"),
        ((sw.Linear(1.0), math.inf), r"reach \[rad\] is inf"),
        ((sw.Backlash(1.0, 1.0), 1.5, 3), "has the stiffness -0.*fit a law without backlash"),
    ],
)
def test_a_fit_that_makes_no_sense_is_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.gears.fit_odd(*arguments)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (sw.Polynomial((0.0, 1.0, 0.0, -1.0)), "no torque at the reach"),
        (sw.PiecewiseLinear(1e4, 2e4, 3e4, 10.0, 5.0), "0 < T1 < T2"),
    ],
)
def test_a_law_that_cannot_be_fitted_is_refused(law, said):
    with pytest.raises(ValueError, match=said):
        sw.gears.fit_odd(law, 1.0)
