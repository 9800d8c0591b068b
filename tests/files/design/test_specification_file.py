"""A specification in YAML: what a right one resolves to, and one line with its place for everything that is wrong."""

import math
from pathlib import Path

import pytest

import strainwave as sw
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import ProjectError

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "projects" / "elbow.yaml"
GOOD = """\
load: {inertia: 1.3 kg*m^2}
speed: {from: 2 rpm, to: 40 rpm}
limit: {oscillation: 90 arcsec}
motor: {rotor_inertias: [0.5 kg*cm^2]}
damping: {ratio: 3 %}
torque: {mean: 40 N*m, peak: 90 N*m}
"""


def read(tmp_path, text):
    path = tmp_path / "joint.yaml"
    path.write_text(text)
    return sw.read_specification(path)


def test_the_example_resolves_to_si():
    spec = sw.read_specification(EXAMPLE)
    assert spec.title == "Elbow of a robot"
    assert spec.load_inertias == (0.8, 1.3)
    assert spec.speeds == pytest.approx((2.0 * RPM, 40.0 * RPM))
    assert spec.limit == pytest.approx(90.0 * ARCSEC)
    assert spec.rotor_inertias == pytest.approx((5e-5, 1e-4, 2e-4, 5e-4))
    assert spec.duty[0] == pytest.approx((60.0, 20.0 * RPM, 2.0))
    assert spec.loop.bandwidth == pytest.approx(60.0 * math.pi)
    assert (spec.life, spec.largest_size, spec.damping_ratio) == pytest.approx((10_000.0, 50.0, 0.03))


def test_a_range_from_standstill_begins_where_that_of_a_project_does(tmp_path):
    spec = read(tmp_path, GOOD.replace("from: 2 rpm", "from: 0 rpm"))
    assert spec.speeds == pytest.approx((0.4 * RPM, 40.0 * RPM))
    path = tmp_path / "project.yaml"
    path.write_text(
        "gear: CSG-40-50\nload: {inertia: 1.3 kg*m^2}\nspeed: {from: 0 rpm, to: 40 rpm, shaft: load}\n"
        "damping: {ratio: 3 %}\nexcitation: {accuracy: catalogue}\n"
    )
    project = sw.read_project(path)
    assert project.speeds.limits == pytest.approx([50.0 * speed for speed in spec.speeds])
    assert set(spec.remarks) <= set(project.notes)


def test_every_field_reaches_the_specification(tmp_path):
    more = (
        "life: 7000 h\nlargest: {size: 40, mass: 3 kg}\nratios: [50, 80]\nseries: [csg]\n"
        "excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec, phase: 90 deg}]}\ntitle: Joint\n"
    )
    text = GOOD.replace("peak: 90 N*m", "peak: 90 N*m, momentary: 200 N*m, preload: 5 N*m, average_speed: 15 rpm")
    spec = read(tmp_path, text + more)
    assert (spec.mean_torque, spec.peak_torque, spec.momentary_torque, spec.preload) == (40.0, 90.0, 200.0, 5.0)
    assert (spec.largest_mass, spec.ratios, spec.series, spec.title) == (3.0, (50, 80), ("CSG",), "Joint")
    assert spec.average_speed == pytest.approx(15.0 * RPM)
    assert spec.kinematic_error.lines[0] == pytest.approx((2, 23.0 * ARCSEC, 0.5 * math.pi))
    assert read(tmp_path, GOOD + "excitation: {accuracy: catalogue}\n").accuracy is None
    assert read(tmp_path, GOOD + "excitation: {accuracy: 1 arcmin}\n").accuracy == pytest.approx(60.0 * ARCSEC)


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("{inertia: 1.3 kg*m^2}", "{}", "1:7", "needs either one 'inertia' or a list"),
        ("to: 40 rpm", "to: 2 rpm", "2:26", "does not ascend"),
        ("limit:", "limits:", "3:1", "unknown field; did you mean 'limit'?"),
        ("[0.5 kg*cm^2]", "0.5 kg*cm^2", "4:25", "is not a list; write for example 'rotor_inertias: ["),
        ("[0.5 kg*cm^2]", "[-1 kg*cm^2]", "4:26", "is not positive"),
        ("ratio: 3 %", "ratio: 0", "5:18", "is not positive"),
        (", peak: 90 N*m", "", "6:9", "write both"),
        ("peak: 90", "peak: 30", "6:16", "larger than the peak"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(tmp_path, old, new, place, said):
    assert old in GOOD
    with pytest.raises(ProjectError) as error:
        read(tmp_path, GOOD.replace(old, new))
    lines = str(error.value).splitlines()
    assert any(f"joint.yaml:{place}: " in line and said in line for line in lines), lines


def test_a_duty_cycle_and_a_mean_are_one_too_many(tmp_path):
    with pytest.raises(ProjectError, match="but the duty cycle defines both"):
        read(tmp_path, GOOD + "duty: [{torque: 60 N*m, speed: 20 rpm, duration: 2 s}]\n")
    text = GOOD.replace("torque: {mean: 40 N*m, peak: 90 N*m}\n", "")
    with pytest.raises(ProjectError, match="all speeds are zero"):
        read(tmp_path, text + "duty: [{torque: 60 N*m, speed: 0 rpm, duration: 2 s}]\n")


def test_an_empty_or_missing_file_is_told(tmp_path):
    with pytest.raises(ProjectError, match="is empty; begin with a line such as 'load:"):
        read(tmp_path, "# nothing\n")
    with pytest.raises(ProjectError, match="does not exist"):
        sw.read_specification(tmp_path / "other.yaml")
