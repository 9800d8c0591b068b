"""What assumed numbers leave open, against drives whose files have the other numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from strainwave.app.commands.cli import cli
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text
from strainwave.files.variants.sureness import POINTS

AXIS = """\
title: axis
gear: CSG-40-50
motor: {loop: {type: cascade, bandwidth: BAND}}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: RATIO}
speed: {from: 250 rpm, to: 3000 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
ASSUMED = "sources: {motor.loop: assumed, damping: assumed, load.inertia: measured}\n"


def axis(ratio="3 %", band="30 Hz", more=ASSUMED):
    return from_text(AXIS.replace("RATIO", ratio).replace("BAND", band) + more, Path("axis.yaml"))


def largest(project):
    found = project.response(coexisting=False)
    return float(found.oscillation[found.top])


@pytest.mark.slow
def test_the_ends_are_those_of_drives_whose_files_have_the_other_numbers():
    sure, nominal = axis().sureness, largest(axis())
    damping, band = sure.doubts
    assert (damping.ends, band.ends) == (("2 %", "5 %"), ("20 Hz", "45 Hz"))
    ratios = [nominal, *(largest(axis(ratio, more="")) for ratio in damping.ends)]
    bands = [nominal, *(largest(axis(band=one, more="")) for one in band.ends)]
    both = [largest(axis(ratio, one, more="")) for ratio in damping.ends for one in band.ends]
    assert damping.sizes == pytest.approx((min(ratios), max(ratios)), rel=1e-6)
    assert band.sizes == pytest.approx((min(bands), max(bands)), rel=1e-6)
    assert sure.largest == pytest.approx((min(*bands, *ratios, *both), max(*bands, *ratios, *both)), rel=1e-6)
    assert sure.drives == 9
    curve = axis().response(coexisting=False, points=POINTS)
    size = np.interp(sure.omega, curve.omega, curve.oscillation)
    assert np.all(sure.low <= size * (1 + 1e-9))
    assert np.all(size <= sure.high * (1 + 1e-9))
    assert np.max(sure.high) == pytest.approx(sure.largest[1], rel=0.01)


def test_nothing_is_open_where_nothing_is_assumed():
    project = from_text(AXIS.replace("RATIO", "3 %").replace("BAND", "30 Hz, damping: 0.7"), Path("axis.yaml"))
    assert (project.assumed, project.digits(), project.digits(5)) == ((), 4, 5)
    assert project.sureness.sentences(project.limit) == ()
    assert project.sureness.drives == 0


@pytest.mark.slow
def test_a_drive_that_no_file_may_have_is_left_out_and_said():
    fast = axis(band="60 Hz, lag: 1 ms").sureness
    assert fast.lost
    assert "bandwidth" in fast.lost[0]
    assert np.isfinite(fast.largest).all()


@pytest.mark.slow
def test_the_response_prints_three_digits_and_rows_and_json_has_all_digits(tmp_path):
    path = tmp_path / "axis.yaml"
    path.write_text(axis().text, encoding="utf-8")
    printed = CliRunner().invoke(cli, ["response", str(path)]).stdout
    size = largest(axis()) / ARCSEC
    assert f"largest oscillation: {size:.3g} arcsec at" in printed
    assert "how sure: damping 3 % is assumed: 2 % to 5 % gives" in printed
    assert "on both sides of the limit of 60 arcsec" in printed
    assert "assumed: motor.loop.damping 0.7, motor.loop.bandwidth 30 Hz, damping.ratio 3 %; measured: load" in printed
    data = json.loads(CliRunner().invoke(cli, ["response", str(path), "--json"]).stdout)
    assert data["oscillation"]["oscillation_arcsec"] == pytest.approx(size, rel=1e-9)
    assert [row["what"] for row in data["how_sure"]["rows"]] == ["damping", "bandwidth"]
    assert {row["source"] for row in data["sources"]} == {"catalogue", "assumed", "yours", "measured"}
