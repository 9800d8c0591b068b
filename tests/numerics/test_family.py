"""Families of response curves."""

import numpy as np
import pytest

import strainwave as sw

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)


def test_every_member_has_the_curve_it_has_alone():
    alphas = np.array([0.03, 0.05])
    family = sw.response_family(SYSTEM, (0.5, 2.5), {"law.alpha": alphas, "B": [0.1, 0.2]}, harmonics=3, threads=2)
    for branch, alpha, B in zip(family, alphas, (0.1, 0.2), strict=True):
        alone = sw.frequency_response(SYSTEM._replace(law=sw.Cubic(1.0, float(alpha)), B=B), (0.5, 2.5), harmonics=3)
        assert np.array_equal(branch.coefficients, alone.coefficients)
        assert branch.status


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"law.alpha": [0.1, 0.2], "B": [0.1]}, "one length"),
        ({}, "dict of path to values"),
        ([0.1], "dict of path to values"),
        ({"B": "abc"}, "finite numbers"),
        ({"law.beta": [0.1]}, "no parameter 'beta'"),
    ],
)
def test_wrong_families_are_refused_in_one_sentence(values, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        sw.response_family(SYSTEM, (0.5, 2.5), values)
