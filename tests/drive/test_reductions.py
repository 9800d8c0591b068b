"""The error equation with a free motor against the whole drive train, with kinematic error."""

from itertools import pairwise

import numpy as np
import pytest
from direct_project import project_of

import strainwave as sw
from strainwave.drive.equation.reductions import Reductions, compare_with_train

LAW = sw.Cubic(1.089e5, 6.85e4)  # cubic fit of a CSG-40-50
DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=15.4, law=LAW)


def error(amplitude):
    return sw.KinematicError((sw.Line(2, amplitude),))


def compared(amplitude):
    train, free = (make(kinematic_error=error(amplitude)) for make in (DRIVE.train, DRIVE.error_equation))
    return compare_with_train(train, free, np.array([150.0]), 30)


@pytest.mark.slow
def test_what_is_dropped_grows_with_n_times_the_error_slope():
    # relative difference and ripple are of first order in the error's amplitude
    found = [compared(amplitude) for amplitude in (1e-5, 2e-5, 4e-5)]
    for small, large in pairwise(found):
        assert large.ripple[0] / small.ripple[0] == pytest.approx(2.0, rel=0.02)
    assert found[2].error_slope == pytest.approx(50.0 * 2 * 4e-5, rel=1e-4)
    assert 0.0 < abs(found[2].difference[0]) < found[2].error_slope


@pytest.mark.slow
def test_columns_are_the_orbits_of_their_equations():
    found = compared(1e-4)
    orbit = sw.find_orbit(DRIVE.error_equation(kinematic_error=error(1e-4), omega=150.0))
    assert found.free[0] == pytest.approx(orbit.peak, rel=1e-12)
    whole = sw.find_orbit(sw.train.SteadyTrain(DRIVE.train(kinematic_error=error(1e-4)), 150.0))
    assert found.exact[0] == pytest.approx(whole.peak, rel=1e-12)


def test_sentence_says_how_much_where_and_why():
    found = Reductions(
        np.array([100.0, 200.0, 210.0]), np.array([1e-4, 1e-3, 5e-4]), np.array([1e-4, 1.02e-3, 2e-3]), 0.011,
        np.array([0.01, 0.05, 0.02]),
    )  # fmt: skip
    said = found.sentence()
    assert "N e' up to 0.011" in said
    assert "speed ripple, up to 0.05 of the speed" in said
    assert "by up to 2 % (200 rad/s)" in said
    assert "at 210 rad/s only one of the two has jumped" in said


def test_without_any_orbit_the_sentence_says_so():
    nothing = np.array([np.nan])
    found = Reductions(np.array([1.0]), nothing, nothing, 0.0, nothing)
    assert found.sentence().startswith("No periodic motion of the whole drive train was found")


@pytest.mark.slow
def test_analysis_of_a_free_drive_says_what_its_error_equation_leaves_out():
    lines = error(1e-4)
    found = project_of(DRIVE, (90.0, 250.0), motor="free", kinematic_error=lines).analyze()
    assert "With a free motor the error equation neglects" in found.warnings[-1]
    assert "N e' up to 0.01" in found.warnings[-1]
