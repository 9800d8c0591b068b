"""A measured Bode plot from files as drives export them: names, units, phases, records, and what is asked."""

import numpy as np
import pytest
import scipy.io
from bode_machine import plant, records

import strainwave as sw
from strainwave.files.yaml_text import FileError

HZ = np.geomspace(3.0, 300.0, 40)
OMEGA = 2.0 * np.pi * HZ
VALUE = plant(OMEGA)
DB, SIZE = 20.0 * np.log10(np.abs(VALUE)), np.abs(VALUE)
RAD, DEGREES = np.unwrap(np.angle(VALUE)), np.degrees(np.unwrap(np.angle(VALUE)))


def written(path, head, *columns, delimiter=",", comma=False):
    """A text table of these columns below a line of names."""
    rows = [delimiter.join(f"{x:.12g}" for x in row) for row in zip(*columns, strict=True)]
    body = "\n".join(rows).replace(".", ",") if comma else "\n".join(rows)
    path.write_text(f"{head}\n{body}\n", encoding="utf-8")
    return path


TABLES = {
    "drive": ("Frequency [Hz],Magnitude [dB],Phase [deg]", HZ, DB, DEGREES),
    "names alone": ("freq_Hz,mag_dB,phase_deg", HZ, DB, DEGREES),
    "units below": ("Frequency,Gain,Phase\nHz,dB,°", HZ, DB, DEGREES),
    "radians": ("omega [rad/s],gain [-],phase [rad]", OMEGA, SIZE, RAD),
    "pairs": ("Frequency (kHz),Real,Imag", HZ / 1e3, VALUE.real, VALUE.imag),
    "slashes": ("f/Hz,Betrag/dB,Phase/°", HZ, DB, DEGREES),
    "a dash and a number": ("Frequency [Hz],Magnitude - axis 1 [dB],Phase [deg]", HZ, DB, DEGREES),
    "a number last": ("freq_Hz,mag_1_dB,phase_deg", HZ, DB, DEGREES),
    "guessed": ("w,mag,phase", OMEGA, DB - 100.0, DEGREES - 720.0),
}


@pytest.mark.parametrize("name", TABLES)
def test_names_and_units_are_recognised(tmp_path, name):
    head, *columns = TABLES[name]
    found = sw.read_frd(written(tmp_path / "bode.csv", head, *columns))
    value = VALUE if name != "guessed" else 1e-5 * VALUE
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-9)
    np.testing.assert_allclose(found.value, value, rtol=1e-9)
    assert found.phased
    assert any("taken as that of the plant" in note for note in found.notes)


def test_a_german_table_says_what_it_is_of(tmp_path):
    file = written(
        tmp_path / "b.csv",
        "Frequenz [Hz];Open loop Amplitude [dB];Phase [°]",
        HZ,
        DB,
        DEGREES,
        delimiter=";",
        comma=True,
    )
    found = sw.read_frd(file)
    np.testing.assert_allclose(found.value, VALUE, rtol=1e-9)
    assert found.quantity == "open loop"


def test_without_a_phase_and_with_a_line_at_no_frequency(tmp_path):
    file = written(tmp_path / "b.csv", "f [Hz],H1 magnitude [dB]", np.append(0.0, HZ), np.append(DB[0], DB))
    found = sw.read_frd(file)
    assert not found.phased
    np.testing.assert_allclose(np.abs(found.value), SIZE, rtol=1e-9)
    told = " ".join(str(found).split())
    for words in ("no phase was measured", "1 lines without frequency or value", "it is the plain H1"):
        assert words in told


def test_a_matlab_file_with_complex_values(tmp_path):
    scipy.io.savemat(tmp_path / "b.mat", {"freq": HZ, "response": VALUE})
    found = sw.read_frd(tmp_path / "b.mat", units={"frequency": "Hz"}, quantity="plant")
    np.testing.assert_allclose(found.value, VALUE, rtol=1e-12)
    assert found.notes[:-1] == ()


def test_records_of_reference_torque_and_speed_are_estimated_by_the_instrument(tmp_path):
    t, r, u, y = records([0], periods=3)
    file = written(
        tmp_path / "r.csv", "time [s],speed reference [rpm],torque [N*m],speed [rpm]", t, r, u[:, 0], y[:, 0]
    )
    found = sw.read_frd(file)
    same = sw.fit.bode_of_records(t, r, u[:, 0], y[:, 0] * np.pi / 30.0)
    np.testing.assert_allclose(found.value, same.value, rtol=1e-6)
    np.testing.assert_allclose(found.omega, same.omega, rtol=1e-9)
    with pytest.raises(FileError, match="leave quantity and estimator out"):
        sw.read_frd(file, quantity="closed loop")


@pytest.mark.parametrize(
    ("head", "columns", "words"),
    [
        ("Frequency,Magnitude [dB]", (HZ, DB), "is it Hz or rad/s? units={'frequency': 'Hz'}"),
        ("Frequency [Hz],Magnitude", (HZ, SIZE), "is it dB or gain? units={'size': 'dB'}"),
        ("Frequency [Hz],Gain [dB],Phase", (HZ, DB, RAD), "is it deg or rad? units={'phase': 'deg'}"),
        ("Frequency [Hz],gain a [dB],gain b [dB]", (HZ, DB, DB), "2 columns of the size, gain a [dB], gain b [dB]; "),
        ("Frequency [Hz],Real", (HZ, DB), "no size and no real and imaginary part"),
        ("time [s],torque [N*m],speed [rpm]", (HZ, DB, DB), "records need a reference, of which there is none"),
        ("Frequency [Hz],Magnitude [dB]", (HZ[:4], DB[:4]), "give 8 or more"),
        ("Frequency [Hz],Magnitude [N*m]", (HZ, DB + 100.0), "is it dB or gain?"),
    ],
)  # fmt: skip
def test_what_is_not_clear_is_asked_in_one_sentence(tmp_path, head, columns, words):
    with pytest.raises(FileError) as error:
        sw.read_frd(written(tmp_path / "b.csv", head, *columns))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("given", [{"columns": {"gain": "b"}}, {"units": {"real": "1"}}])
def test_an_argument_that_does_not_count_is_refused(tmp_path, given):
    file = written(tmp_path / "b.csv", "Frequency [Hz],Magnitude [dB],Phase [deg]", HZ, DB, DEGREES)
    with pytest.raises(FileError, match=r"holds a table of frequencies, and .* accepted:"):
        sw.read_frd(file, **given)
