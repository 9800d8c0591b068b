"""Where the numbers of a project come from."""

from pathlib import Path

import pytest
from assumed_axis import AXIS, axis

import strainwave as sw
from strainwave.app.web.first_project import first_text
from strainwave.files.reading import ProjectError, from_text


def test_every_number_says_where_it_comes_from():
    words = {one.name: one.word for one in axis().sources}
    assert words == {
        "gear": "catalogue", "motor.inertia": "catalogue", "motor.loop.damping": "assumed",
        "motor.loop.bandwidth": "assumed", "load.inertia": "measured", "damping.ratio": "assumed",
        "speed.from": "yours", "speed.to": "yours", "limit.oscillation": "yours",
        "excitation.kinematic_error.0.order": "yours", "excitation.kinematic_error.0.amplitude": "yours",
    }  # fmt: skip
    changed = sw.replaced(axis(), {"damping.ratio": "2 %", "load.inertia": "2 kg*m^2"}, retune=True)
    again = {one.name: one.word for one in changed.sources}
    assert again == words | {"damping.ratio": "yours", "load.inertia": "yours"}
    assert {one.name for one in changed.assumed} == {"motor.loop.damping", "motor.loop.bandwidth"}
    same = sw.replaced(axis(), {"damping.ratio": "3.0 %", "load.inertia": "1.3 kg*m^2"}, retune=True)
    assert {one.name: one.word for one in same.sources} == words
    said = sw.replaced(axis(), {"load.inertia": "2 kg*m^2", "sources.load.inertia": "assumed"}, retune=True)
    assert {one.name: one.word for one in said.sources} == words | {"load.inertia": "assumed"}
    first = {one.word for one in from_text(first_text("CSG-40-50"), Path("first.yaml")).sources}
    assert first == {"catalogue", "assumed"}


def test_what_stands_in_for_a_number_is_assumed_and_a_rewritten_file_keeps_the_words():
    text = AXIS.replace("{loop: {type: cascade, bandwidth: BAND}}", "{inertia: 5 kg*cm^2}").replace("RATIO", "3 %")
    text = text.replace("kinematic_error: [{order: 2, amplitude: 23 arcsec}]", "accuracy: catalogue")
    unnamed = from_text(text, Path("axis.yaml"))
    assert {one.name: one.value for one in unnamed.assumed} == {
        "motor.mode": "held", "excitation.accuracy": "59.82 arcsec",
    }  # fmt: skip
    heavier = axis().with_load_inertia(2.0)
    kept = {one.name: one.word for one in from_text(sw.project_text(heavier), Path("axis.yaml")).sources}
    assert (kept["damping.B"], kept["motor.loop.K_p"], kept["load.inertia"]) == ("assumed", "assumed", "measured")


def test_every_line_of_a_long_file_has_a_source_and_a_rewritten_file_keeps_it():
    lines = ", ".join(f"{{order: {n}, amplitude: 1 arcsec, phase: {n} deg}}" for n in range(1, 41))
    text = AXIS.replace("{order: 2, amplitude: 23 arcsec}", lines).replace("RATIO", "3 %").replace("BAND", "30 Hz")
    words = "sources: {excitation: assumed, load.inertia: catalogue, motor.loop: assumed}\n"
    project = from_text(f"revision: 2026-11-26 A. Meier\n{text.replace('axis', '3-axis robot')}{words}", Path("a.yaml"))
    assert not {"title", "revision"} & {one.name for one in project.sources}
    again = from_text(sw.project_text(project.with_load_inertia(2.0)), Path("a.yaml"))
    found = {one.name: one.word for one in again.sources}
    assert (found["load.inertia"], found["excitation.kinematic_error.39.phase"]) == ("catalogue", "assumed")


@pytest.mark.parametrize(
    ("sources", "said"),
    [
        ("{damping: guessed}", "sources.damping: 'guessed' is not known; write one of yours, assumed, measured"),
        ("{daming: assumed}", "sources.daming: the project file has no 'daming'"),
        ("{load.inertias: assumed}", "sources.load.inertias: is no field of this project file"),
    ],
)
def test_a_wrong_source_is_refused_at_its_place(sources, said):
    with pytest.raises(ProjectError) as complaint:
        axis(more=f"sources: {sources}\n")
    assert said in str(complaint.value)
