"""The answers are about the speeds of the project, also where the curve leaves these and comes back."""

from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.app.web.views import response as view
from strainwave.base.units import ARCSEC, RPM
from strainwave.drive.train_curve import POINTS, largest_crest
from strainwave.files.reading import from_text
from strainwave.study.speed_map.avoid import speeds_to_avoid, without_stable
from strainwave.study.speed_map.error_equation import operating_point

# hardening: both speeds lie in or at a bistable band, whose upper motions go on to 1824 rpm and are largest there
BISTABLE = """\
gear: CSG-40-50
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1.2 kg*m^2}
damping: {ratio: 1 %}
limit: {oscillation: 60 arcsec}
speed: {from: 1580.5 rpm, to: 1708.4 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 60 arcsec}]}
"""
# the resonance is an instability of the stiffness that varies; its motions go on from 1583 rpm without an end
PARAMETRIC = """\
gear: CSG-40-50
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1.2 kg*m^2}
damping: {ratio: 0.1 %}
stiffness: {ripples: [{order: 2, depth: 40 %}]}
speed: {from: 1515.5 rpm, to: 1583 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 20 arcsec}]}
"""


def read(text):
    return from_text(text, Path("drive.yaml"))


@pytest.fixture(scope="module")
def bistable():
    project = read(BISTABLE)
    return project, project.response(coexisting=False, points=30)


def within(project, speeds):
    low, high = project.speeds.limits
    return all(low <= speed <= high for speed in speeds)


def test_a_response_tells_of_its_largest_oscillation_at_the_speeds_of_the_project(bistable):
    project, found = bistable
    top = int(np.argmax(found.oscillation))
    assert found.omega[top] > 1.06 * project.speeds.limits[1]  # the curve itself goes on
    visited = found.visited()
    assert within(project, found.omega[visited])
    assert f"{np.max(found.oscillation[visited]):.6g} rad" in str(found)
    assert f"{found.oscillation[top]:.6g} rad" not in str(found)


def test_the_largest_oscillation_of_a_train_and_of_a_design_are_at_the_speeds_of_the_project(bistable):
    project, found = bistable
    size = np.max(found.oscillation[found.visited()])
    at, own = largest_crest(project.whole, project.speeds.limits, 14, coexisting=False)[:2]
    assert within(project, [at])
    assert own == pytest.approx(size, rel=1e-6)
    designed = largest_crest(project.whole, project.speeds.limits, None, points=POINTS)
    assert within(project, [designed.speed])
    assert designed.size == pytest.approx(size, rel=1e-6)


@pytest.mark.slow
def test_a_comparison_counts_the_speeds_of_each_project_alone(bistable):
    project, found = bistable
    compared = sw.compare([project, project])
    assert within(project, compared.speed)
    assert compared.oscillation == pytest.approx([np.max(found.oscillation[found.visited()])] * 2, rel=1e-6)
    assert list(compared.jumps) == [1.0, 1.0]  # that at 1824 rpm is outside


def test_the_page_tells_of_the_speeds_of_the_project_over_a_shorter_period_too(bistable):
    project, found = bistable
    shown = view(project)
    low, high = (omega / RPM for omega in project.speeds.limits)
    assert max(shown["speed"]) > 1.06 * high  # the figure may go on
    told = [shown["largest"]["speed"], *(end for band in shown["avoid"] for end in band)]
    told += [band[end] for band in shown["jumps"] for end in ("low", "high")]
    assert all(low * (1.0 - 1e-9) <= speed <= high * (1.0 + 1e-9) for speed in told)
    largest = np.max(found.oscillation[found.visited()]) / ARCSEC
    assert shown["largest"]["oscillation_arcsec"] == pytest.approx(largest, rel=1e-4)


@pytest.mark.slow
def test_a_curve_that_ends_where_it_began_keeps_to_the_speeds_of_the_project_too():
    project = read(PARAMETRIC)
    found = project.response()
    assert found.omega[0] == found.omega[-1] == project.speeds.limits[1]
    assert np.min(found.omega) < 0.97 * project.speeds.limits[0]
    assert found.curve.span == project.speeds.limits
    assert within(project, found.omega[found.visited()])
    system = project.system(reduced=True)
    avoid = speeds_to_avoid(system, found, operating_point(system), 1e-6)
    assert within(project, [avoid.at, *(end for band in (*avoid.bands, *without_stable(found)) for end in band)])


def test_a_range_of_a_response_is_what_it_was_asked_for():
    # almost undamped: the upper motions at both ends meet beyond a hundred times these speeds, so that the curve ends
    # at 1.6 twice, and comes back through the fold at 1.17
    nearly = sw.Oscillator(1.0, 1e-6, sw.Cubic(1.0, 1.0), sw.Harmonic(0.1), 1.0)
    branch = sw.frequency_response(nearly, (1.5, 1.6), harmonics=3, points=40)
    assert branch.values[0] == branch.values[-1] == 1.6
    assert np.min(branch.values) < 1.2
    assert branch.span == (1.5, 1.6)
    told = sw.jumps(branch)
    for run in (told.run_up, told.run_down):
        assert (branch.values[run].min(), branch.values[run].max()) == (1.5, 1.6)
