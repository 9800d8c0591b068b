"""Facts are told once: JSON and text are made of them, each number in the unit of its key."""

import pytest

from strainwave.base.facts import Fact, data, lines
from strainwave.base.units import ARCSEC, RPM

FACTS = (
    Fact("failures", ("The gear breaks.", "The motor stalls."), "FAIL: {}"),
    Fact("passes", False),
    Fact("motor.peak_speed_rpm", 3000.0 * RPM, "up to {}"),
    Fact("motor.peak_torque_N_m", 0.25, "at most {}"),
    Fact("motor.mean_torque_N_m", 0.1),
    Fact("error_rad.peak", 1e-3, "at most {}"),
    Fact("error_rad.rest", None, "at rest {}"),
    Fact("turn_rad", 1.0, "turned by {}"),
    Fact("settling_times_s", (0.5, None), "settled after {}"),
    Fact("passes_of", ((Fact("order", 2), Fact("time_s", 0.1)), (Fact("order", 4), Fact("time_s", 0.2)))),
    Fact("", (), "note: {}"),
)


def test_data_has_every_key_in_its_group_and_unit():
    assert data(FACTS) == {
        "failures": ["The gear breaks.", "The motor stalls."],
        "passes": False,
        "motor": {"peak_speed_rpm": pytest.approx(3000.0), "peak_torque_N_m": 0.25, "mean_torque_N_m": 0.1},
        "error_rad": {"peak": 1e-3, "rest": None},
        "turn_rad": 1.0,
        "settling_times_s": [0.5, None],
        "passes_of": [{"order": 2, "time_s": 0.1}, {"order": 4, "time_s": 0.2}],
    }


def test_facts_of_a_group_share_a_line_and_angles_have_the_unit_of_their_size():
    assert list(lines(FACTS)) == [
        "FAIL: The gear breaks.",
        "FAIL: The motor stalls.",
        "motor: up to 3000 rpm, at most 0.25 N·m",
        "error: at most 206.3 arcsec, at rest –",
        "turned by 1 rad",
        "settled after 0.5 s, –",
    ]


def test_rows_of_facts_are_a_table_in_text_and_a_list_in_data():
    rows = (
        (Fact("name", "loop", "controller"), Fact("time_s", None, "settling"), Fact("rms_arcsec", 20.0 * ARCSEC, "rms"),
         Fact("limited", 0.0)),
        (Fact("name", "inverse", "controller"), Fact("time_s", 0.25, "settling"), Fact("rms_arcsec", -ARCSEC, "rms"),
         Fact("limited", 0.5)),
    )  # fmt: skip
    assert list(lines([Fact("controllers", rows, "{}")])) == [
        "controller  settling [s]  rms [arcsec]",
        "loop                   –            20",
        "inverse             0.25            −1",
    ]
    assert data([Fact("controllers", rows, "{}")])["controllers"] == [
        {"name": "loop", "time_s": None, "rms_arcsec": pytest.approx(20.0), "limited": 0.0},
        {"name": "inverse", "time_s": 0.25, "rms_arcsec": pytest.approx(-1.0), "limited": 0.5},
    ]
    assert list(lines([Fact("controllers", (), "{}")])) == []
