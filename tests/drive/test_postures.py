"""Postures of an arm of two links against Lagrange's equations, and rows of a project file."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import strainwave as sw
from strainwave.drive.demands.payload import WEIGHT
from strainwave.study.analysis.analyze import decided_bands, judged_postures
from strainwave.study.analysis.verdict import Answer, judged
from strainwave.study.analysis.words import posture_sentence
from strainwave.study.speed_map.decide import decide
from strainwave.study.speed_map.rules import Rules

PROJECT = """\
title: Arm
gear: CSG-40-50
motor: {{inertia: 6 kg*cm^2, loop: {{bandwidth: 30 Hz}}}}
load: {{inertia: 1.3 kg*m^2{load}}}
damping: {{ratio: 5 %}}
speed: {{from: 600 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}], load_torque: {{mean: -3 N*m}}}}
postures: {postures}
"""
COUPLING = ", coupling: {inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}"
TABLE = "inertia [kg*cm^2],torque [N*m],coupling [N*m/mrad]\n20000,-40,100\n15000,10,250\n"


def project(folder, postures, load="", table=TABLE):
    (folder / "rows.csv").write_text(table, encoding="utf-8")
    (folder / "arm.yaml").write_text(PROJECT.format(postures=postures, load=load), encoding="utf-8")
    return sw.read_project(folder / "arm.yaml")


@pytest.mark.parametrize("joint", [1, 2])
def test_two_links_have_the_inertia_and_gravity_of_lagranges_equations(joint):
    q = sp.symbols("q1 q2")
    rate, time = sp.symbols("v1 v2"), sp.Symbol("t")
    masses, lengths, centres, inertias, payload = (6.0, 4.0), (0.4, 0.35), (0.17, 0.2), (0.09, 0.05), 2.0
    angles = (q[0], q[0] + q[1])
    joints = [sp.Matrix([0, 0])]
    for length, angle in zip(lengths, angles, strict=True):
        joints.append(joints[-1] + length * sp.Matrix([sp.cos(angle), sp.sin(angle)]))
    points = [(payload, joints[2])]
    for i, angle in enumerate(angles):
        points.append((masses[i], joints[i] + centres[i] * sp.Matrix([sp.cos(angle), sp.sin(angle)])))
    kinetic = sum(m * (p.jacobian(q) * sp.Matrix(rate)).dot(p.jacobian(q) * sp.Matrix(rate)) / 2 for m, p in points)
    kinetic += inertias[0] * rate[0] ** 2 / 2 + inertias[1] * (rate[0] + rate[1]) ** 2 / 2
    potential = sum(m * WEIGHT * p[1] for m, p in points)
    moved, held = joint - 1, 2 - joint
    alone = kinetic.subs(rate[held], 0)
    inertia = sp.diff(alone, rate[moved], 2)
    gravity = -sp.diff(potential, q[moved])
    rows = [(0.3, 1.1), (-1.2, 2.4), (1.5, -0.6)]
    links = [sw.study.Link(*parts) for parts in zip(masses, lengths, centres, inertias, strict=True)]
    for posture, (a, b) in zip(sw.study.two_link(*links, rows, joint=joint, payload=payload), rows, strict=True):
        there = {q[0]: a, q[1]: b}
        assert posture.inertia == pytest.approx(float(inertia.subs(there)), rel=1e-12)
        assert posture.torque == pytest.approx(float(gravity.subs(there)), rel=1e-12)
    assert time not in inertia.free_symbols


def test_a_link_may_be_balanced_about_its_joint_by_a_weight():
    links = sw.study.Link.rod(6.0, 0.4), sw.study.Link(4.0, 0.35, -0.1, 0.05)
    (posture,) = sw.study.two_link(*links, [(0.3, 1.1)], joint=2)
    assert posture.torque == pytest.approx(4.0 * WEIGHT * 0.1 * np.cos(1.4), rel=1e-12)
    assert posture.inertia == pytest.approx(0.05 + 4.0 * 0.1**2, rel=1e-12)


def test_postures_are_rows_of_the_file_of_a_table_or_of_an_arm_and_are_written_back(tmp_path):
    inline = project(tmp_path, "[{name: out, inertia: 2 kg*m^2, torque: -40 N*m}, {inertia: 1 kg*m^2}]")
    assert inline.postures == (sw.Posture(2.0, -40.0, None, "out"), sw.Posture(1.0))
    table = project(tmp_path, "rows.csv", COUPLING)
    np.testing.assert_allclose([row[:3] for row in table.postures], [(2.0, -40.0, 1e5), (1.5, 10.0, 2.5e5)])
    arm = project(
        tmp_path,
        "{links: [{mass: 6 kg, length: 0.4 m}, {mass: 4 kg, length: 0.35 m, centre: 0.2 m, inertia: 0.05 kg*m^2}], "
        "payload: 2 kg, joint: 2, angles: [[0 deg, 90 deg], [30 deg, 0 deg]]}",
    )
    links = sw.study.Link.rod(6.0, 0.4), sw.study.Link(4.0, 0.35, 0.2, 0.05)
    rows = sw.study.two_link(*links, np.radians([[0.0, 90.0], [30.0, 0.0]]), joint=2, payload=2.0)
    np.testing.assert_allclose([row[:2] for row in arm.postures], [row[:2] for row in rows], rtol=1e-12, atol=1e-12)
    assert arm.postures[0].name == "0 and 90 deg"
    assert any("2 postures" in note and "the nominal load alone" in note for note in arm.notes)
    for found in (inline, table, arm):
        (tmp_path / "again.yaml").write_text(sw.project_text(replace(found, title="Changed")), encoding="utf-8")
        assert sw.read_project(tmp_path / "again.yaml").postures == found.postures


def test_the_verdict_counts_every_posture_and_names_the_worst(tmp_path):
    rows = "[{inertia: 1 kg*m^2}, {name: out, inertia: 4 kg*m^2, torque: -60 N*m}, {name: in, inertia: 2 kg*m^2}]"
    arm = project(tmp_path, rows)
    found = [drive.response() for drive in (arm, *(row.on(arm) for row in arm.postures))]
    sizes = [float(response.oscillation[response.top]) for response in found]
    arm = replace(arm, limit=(sizes[0] * sizes[2]) ** 0.5)
    before = judged(arm, found[0]).verdict
    assert before.answer is Answer.ALL_RIGHT
    decided = decide(arm, Rules(arm.limit), search=False)
    rows = judged_postures(decided)
    worst = max(rows, key=lambda row: row.rank)
    assert [(row.number, row.name, row.inertia, row.torque) for row in rows] == [
        (1, "", 1.0, -3.0), (2, "out", 4.0, -60.0), (3, "in", 2.0, -3.0),
    ]  # fmt: skip
    assert worst.number == 2
    assert worst.peak == pytest.approx(max(sizes), rel=1e-3)
    assert worst.answer is Answer.BUT
    assert any(low <= found[2].omega[found[2].top] <= high for low, high in decided_bands(decided))
    names = ["posture 1", "posture 2 (out)", "posture 3 (in)", "nominal load, -3 N*m"]
    assert [case.name for case in arm.cases] == [case.name for case in decided.load_cases] == names
    assert [(case.inertia, case.torque) for case in arm.cases] == [(1.0, -3.0), (4.0, -60.0), (2.0, -3.0), (1.3, -3.0)]
    for case in arm.cases:
        end = case.on(arm).whole.load.end()
        assert (end.J, float(end.excitation.torque(0.3))) == pytest.approx((case.inertia, case.torque))
    assert "postures: posture 2 (out)" in posture_sentence(SimpleNamespace(posture=worst, postures=rows))
    assert judged_postures(decide(replace(arm, postures=()), Rules(arm.limit), search=False)) == ()


def test_a_posture_changes_the_load_and_keeps_loop_and_damping(tmp_path):
    found = project(tmp_path, "rows.csv", COUPLING)
    moved = found.postures[0].on(found)
    assert moved.whole.motor == found.whole.motor
    assert moved.drive.B == found.drive.B
    end = moved.whole.load.end()
    assert (end.J, float(end.excitation.torque(0.3)), moved.whole.load.law.K) == pytest.approx((2.0, -40.0, 1e5))
    assert sw.Posture(2.0).on(found).mean_load_torque == -3.0


@pytest.mark.parametrize(
    ("postures", "table", "said"),
    [
        ("rows.csv", TABLE, "postures: a posture gives a coupling stiffness, but the project has no coupling"),
        ("rows.csv", "inertia [kg*m^2],torque [N*m]\n2,3\n-1,3\n", "rows.csv:3:1: inertia: is -1; write a value above"),
        ("rows.csv", "torque [N*m]\n2\n3\n", "rows.csv:1:1: file: has no single column 'inertia'"),
        ("rows.csv", "inertia,torque [N*m]\n2,3\n3,4\n", "column 'inertia' has no unit"),
        ("gone.csv", TABLE, "gone.csv:1:1: file: does not exist"),
        ("[]", TABLE, "postures: has 0 items"),
        ("[{torque: 3 N*m}]", TABLE, "postures[0].inertia: is missing"),
        ("[{inertia: 0 kg*m^2}]", TABLE, "postures[0].inertia: '0 kg*m^2' is not positive"),
        ("[{name: out, inertia: 1 kg*m^2}, {name: out, inertia: 2 kg*m^2}]", TABLE,
         "postures: two postures have the name 'out'; give them different names"),
        ("{links: [{mass: 6 kg, length: 0.4 m}], angles: [[0 deg, 0 deg]]}", TABLE, "postures.links: has 1 items"),
        ("{links: [{mass: 6 kg, length: 1 m}, {mass: 6 kg, length: 1 m}], joint: 3, angles: [[0 deg, 0 deg]]}", TABLE,
         "postures.joint: '3' is not a joint of two links"),
        ("{links: [{mass: 6 kg, length: 1 m}, {mass: 6 kg, length: 1 m}], angles: []}", TABLE,
         "postures.angles: is empty; write for example"),
    ],
)  # fmt: skip
def test_wrong_postures_are_refused_in_one_sentence(tmp_path, postures, table, said):
    with pytest.raises(ValueError, match=re.escape(said)) as caught:
        project(tmp_path, postures, "", table)
    assert len(str(caught.value).splitlines()) == 1
