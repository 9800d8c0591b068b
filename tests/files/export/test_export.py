"""The verb `export` and its bad inputs: one sentence each, and no half-written file."""

import math
import os

import pytest

import strainwave as sw

DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=40.0, law=sw.Linear(1e5))


def test_a_drive_and_its_train_are_the_same_plant(tmp_path):
    for name, source in (("a", DRIVE), ("b", DRIVE.train(control=sw.train.Held(), motor_torque=sw.Harmonic(1.0)))):
        (tmp_path / name).mkdir()
        found = sw.export(source, tmp_path / name / "axis.c", to="c")
        assert str(found).startswith("Exported: ")
    assert (tmp_path / "a" / "axis.c").read_text() == (tmp_path / "b" / "axis.c").read_text()
    assert sorted(os.listdir(tmp_path / "a")) == ["axis.c", "axis.h"]


@pytest.mark.parametrize(("to", "name"), [("c", "axis.c"), ("fmu2", "axis.fmu")])
def test_the_step_that_was_chosen_is_said(to, name, tmp_path):
    """A sixteenth of a period of the free train's vibration; a step that was given needs no word."""
    resonance = math.sqrt(DRIVE.law.K * (1.0 / DRIVE.J_l + 1.0 / (DRIVE.N**2 * DRIVE.J_m)))
    (said, *_) = sw.export(DRIVE, tmp_path / name, to=to).notes
    step = float(said.removeprefix("step size ").split(" s, ")[0])
    assert step == pytest.approx(2.0 * math.pi / resonance / 16.0, rel=0.05)
    assert not any("steps of" in note for note in sw.export(DRIVE, tmp_path / name, to=to, step=1e-5).notes)


@pytest.mark.parametrize(
    ("given", "name", "error", "sentence"),
    [
        ({"to": "modelica"}, "axis.mo", ValueError, "to is 'modelica'; it must be 'c', 'fmu2', 'fmu3' or 'mjcf'"),
        ({"to": "c"}, "axis.cpp", ValueError, "the file is 'axis.cpp'; give it a name that ends in .c"),
        ({"to": "c", "step": -1.0}, "axis.c", ValueError, "step [s] is -1.0; it must be a positive finite number"),
        ({"to": "c", "method": sw.Dopri5()}, "axis.c", TypeError, "C code takes fixed steps: give Rk4() or Dop8()"),
    ],
)
def test_bad_input_is_one_sentence(given, name, error, sentence, tmp_path):
    with pytest.raises(error) as said:
        sw.export(DRIVE, tmp_path / name, **given)
    assert sentence in str(said.value)
    assert os.listdir(tmp_path) == []


def test_a_folder_that_cannot_be_written_is_named_and_nothing_is_left(tmp_path, monkeypatch):
    def refused(self, *_args, **_options):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr("pathlib.Path.write_text", refused)
    with pytest.raises(PermissionError) as said:
        sw.export(DRIVE, tmp_path / "axis.c", to="c")
    assert said.value.filename == str(tmp_path / "axis.h")
    assert os.listdir(tmp_path) == []
