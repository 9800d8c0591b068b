"""Families of response curves."""

import numpy as np
import pytest

import strainwave as sw

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)


def test_curves_described_together_are_those_described_alone():
    """Members of different symmetry and numbers of harmonics, with and without folds, one with a remark."""
    values = {"law.alpha": [0.0, 0.05, 0.4], "excitation.mean": [0.0, 0.0, 0.3], "B": [0.2, 0.1, 0.3]}
    family = sw.numerics.response_family(SYSTEM, (0.6, 2.0), values, points=50, threads=2)
    for i, branch in enumerate(family):
        alone = sw.frequency_response(sw.replaced(SYSTEM, {p: v[i] for p, v in values.items()}), (0.6, 2.0), points=50)
        for name in ("values", "omega", "coefficients", "peak", "multipliers", "stable"):
            assert np.array_equal(getattr(branch, name), getattr(alone, name))
        assert [f.omega for f in branch.folds] == [f.omega for f in alone.folds]
        assert (branch.message, branch.origin, branch.tail) == (alone.message, alone.origin, alone.tail)


@pytest.mark.parametrize("excitation", [sw.Harmonic(1.0), sw.Harmonic(1.0, mean=0.3)], ids=["odd", "all harmonics"])
def test_what_too_few_harmonics_leave_out_is_estimated_for_each_member(excitation):
    """Of the same share that far more harmonics have beyond the third."""
    values = {"law.alpha": [0.02, 0.4], "B": [0.2, 0.3]}
    system = SYSTEM._replace(excitation=excitation)
    few = sw.numerics.response_family(system, (0.6, 2.0), values, harmonics=3, points=60, threads=1)
    many = sw.numerics.response_family(system, (0.6, 2.0), values, harmonics=25, points=60, threads=1)
    for i, (branch, better) in enumerate(zip(few, many, strict=True)):
        member = sw.replaced(system, {path: value[i] for path, value in values.items()})
        alone = sw.frequency_response(member, (0.6, 2.0), harmonics=3, points=60)
        assert branch.tail == pytest.approx(alone.tail, rel=1e-9)
        squares = better.coefficients**2
        assert branch.tail == pytest.approx(np.max(np.sqrt(squares[:, 7:].sum(axis=1) / squares.sum(axis=1))), rel=0.3)
    assert few[1].tail > 3.0 * few[0].tail


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"law.alpha": [0.1, 0.2], "B": [0.1]}, "one length"),
        ({}, "parameters are empty"),
        ({"law.beta": [0.1]}, "no parameter 'beta'"),
    ],
)
def test_wrong_families_are_refused_in_one_sentence(values, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        sw.numerics.response_family(SYSTEM, (0.5, 2.5), values)
