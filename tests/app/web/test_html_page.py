"""The page of a drive: its numbers are Python's at all positions of its sliders, in node and in Chromium."""

import gzip
import inspect
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from app_page import PATIENCE
from click.testing import CliRunner
from test_extension import Dogleg

from strainwave.app.commands.cli import cli
from strainwave.app.report.page import page as html
from strainwave.app.report.page import sliders as page_sliders
from strainwave.app.report.page.sliders import _quantity, sliders
from strainwave.app.report.report import write, write_view
from strainwave.app.view import View
from strainwave.app.web.state import first_text
from strainwave.app.web.views import folded, response, solved
from strainwave.base.results import SolveError
from strainwave.base.units import ARCSEC, RPM
from strainwave.compile.wasm import stamp
from strainwave.files.reading import from_text, read_project
from strainwave.files.variants.replaced import replaced
from strainwave.model.gears.catalogue import gear as gear_of
from strainwave.numerics.labels import DECAYS, FOLD

NODE = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
MACHINE = """
const { readFileSync } = require("fs"), [data, kernels, own, positions] = JSON.parse(readFileSync(0));
const machine = start(bytes(kernels), data.kinds, bytes(own));
const answer = ([values, ...chosen]) => answered(machine, data, values, data.points, chosen);
const print = (thing) => console.log(JSON.stringify(thing));
"""
ANSWERS = "print(positions.map((position) => [answer(position), machine.main.memory.buffer.byteLength]));"
ROWS = """
print(positions.map((position) => {
  const [values, ...chosen] = position;
  return [answer(position), rowOf(machine, data, values, ...chosen), projectOf(data, values, chosen)];
}));
"""
TRAPS = """
const traps = [() => { throw new WebAssembly.RuntimeError("unreachable"); }, () => 1]; // 1 is the code of an exception
print(traps.map((trap) => {
  machine.functions.answer = trap;
  const lost = answer(positions[0]);
  return [lost, told(data, lost), answer(positions[0])];
}));
"""
HELDS = "print(positions.map(([values]) => answered(machine, { ...data, ...data.held }, values, data.held.points)));"
MAPS = """
const loads = [-2, 0, 2];
print(positions.map(([found, ...answers]) => {
  const of = { found, answers, loads, held: answers.find((one) => one.count > 0) };
  return [toldLater(data, of), mapped(data, of, 600, 1)];
}));
"""
FILES = "print(positions.map((position) => [answer(position), fileOf(data, position[0])]));"
TOLD = "print(positions.map((position) => told(data, answer(position))));"
CURVES = """
print(positions.map((found) => [allowed(found), told(data, { ...found, top: 0, harmonics: 9, tail: 0, count: 9 })]));
"""
PICTURE = """
const axis = { column: 1, size: 1, name: "", limit: 9 };
print(positions.map(([found, width]) => drawn(data, found, width, [], axis)));
"""
HELD = """\
title: page
gear: {ratio: 50, law: LAW}
motor: {inertia: 1 kg*cm^2, mode: held}
load: {inertia: 1 kg*m^2}
damping: {B: 15 N*m*s/rad}
speed: {from: 300 rpm, to: 2000 rpm, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: 20 arcsec}, {order: 4, amplitude: 6 arcsec, phase: 40 deg}]
  load_torque: {mean: -4 N*m}
limit: {oscillation: 120 arcsec}
"""
LAWS = {
    "hardening": "{type: cubic, K: 2e4 N*m/rad, alpha: 4e5 1/rad^2}",
    "three slopes": "{type: piecewise_linear, K1: 2e4 N*m/rad, K2: 2.6e4 N*m/rad, K3: 3.2e4 N*m/rad, T1: 8 N*m, "
    "T2: 20 N*m}",
    "own": "{python: dogleg.py:Dogleg, K: 2e4 N*m/rad, more: 1.2e4 N*m/rad, at: 4e-4 rad}",
}
OWN = """from typing import Annotated, NamedTuple
from strainwave.maths import sign

"""


def project_of(folder, law):
    code = inspect.getsource(Dogleg)
    for name, unit in (("K", "N*m/rad"), ("more", "N*m/rad"), ("at", "rad")):
        code = code.replace(f"{name}: float", f'{name}: Annotated[float, "{unit}"]')
    (folder / "dogleg.py").write_text(OWN + code, encoding="utf-8")
    return from_text(HELD.replace("LAW", LAWS[law]), folder / "project.yaml")


def in_node(project, positions):
    return of_page(*html.data_of(project), [[values] for values in positions])


def of_page(data, own, positions, *scripts, asked=ANSWERS):
    kernels = gzip.decompress((html.HERE / "kernels.wasm.gz").read_bytes())
    given = [data, html._packed(kernels), html._packed(own), positions]
    script = "".join(map(html._text, ("machine.js", *scripts, "page.js"))) + MACHINE + asked
    done = subprocess.run(["node", "-e", script], input=json.dumps(given), capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def test_the_kernels_of_the_package_are_those_of_its_sources():
    known = json.loads((html.HERE / "kernels.json").read_text(encoding="utf-8"))
    assert stamp(known["sources"]) == known["stamp"], "run tools/wasm.py"


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
@pytest.mark.parametrize("law", LAWS)
def test_a_page_has_the_numbers_of_python_at_random_positions(law, tmp_path):
    rng = np.random.default_rng(4)
    project = project_of(tmp_path, law)
    base, moved, _ = sliders(project)
    assert {"load.inertia", "damping.B", "limit.oscillation", "excitation.load_torque.mean"} <= {
        one.name for one in moved
    }
    factors = [np.ones(len(moved)), *rng.uniform(0.8, 1.2, (4, len(moved)))]
    positions = [[one.value * float(f) for one, f in zip(moved, some, strict=True)] for some in factors]
    for values, (found, _) in zip(positions, in_node(project, positions), strict=True):
        same(found, at(base, moved, values))


def at(base, moved, values):
    """The project of a page at values of its sliders."""
    return replaced(base, {one.name: _quantity(value, one.unit) for one, value in zip(moved, values, strict=True)})


def same(found, project, response=None):
    """The answer of a page is the response of a project, or another one of it, row for row."""
    if response is None:
        response, (_, g) = project.response(coexisting=False), folded(project)
        assert response.curve.coefficients.shape[1] // 2 // g == int(found["harmonics"]) // g
    rows, branch = np.array(found["rows"]), response.curve
    located = [one.omega for one in (*branch.doublings, *branch.branch_points, *branch.tori)]
    keep = ~np.isin(response.omega, located)  # the page does not seek them
    expected = np.column_stack([response.omega, response.oscillation, response.peak, response.torque])[keep]
    had, fold = rows[:, [0, 1, 2, 4]], rows[:, 5] == FOLD
    assert len(had) == len(expected)
    if response.stable.any():
        assert rows[found["top"], 1] == pytest.approx(np.max(response.oscillation[response.stable]), rel=1e-9)
    assert np.max(np.abs(had - expected) / np.max(expected, axis=0)) <= 1e-9
    assert np.array_equal(rows[~fold, 3] < DECAYS, response.stable[keep][~fold])  # at a fold a multiplier is 1
    np.testing.assert_allclose(np.sort(rows[fold, 0]), sorted(one.omega for one in response.folds), rtol=1e-9)


TRAINS = {
    "cascade": "loop: {type: cascade, bandwidth: 30 Hz, damping: 0.7}",
    "position": "loop: {type: position, bandwidth: 20 Hz, damping: 0.8}",
    "held": "mode: held",
    "gravity": "mode: held",
    "gap": "loop: {type: position, bandwidth: 20 Hz, damping: 0.8}",
}
WEIGHT = ", drag: {type: angle_torque, amplitude: 5 N*m}"
COUPLED = ", coupling: {inertia: 0.2 kg*m^2, B: 8 N*m*s/rad, law: {type: linear, K: 6e4 N*m/rad}}"


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
@pytest.mark.parametrize("motor", TRAINS)
def test_a_page_of_a_train_has_the_numbers_of_python(motor, tmp_path):
    rng = np.random.default_rng(7)
    text = HELD.replace("LAW", LAWS["hardening"]).replace("mode: held", TRAINS[motor])
    if motor == "gap":
        text += "backlash: {half_gap: 4e-5 rad}\n"
    if motor != "cascade":
        more = WEIGHT if motor == "gravity" else COUPLED
        text = text.replace("load: {inertia: 1 kg*m^2", "load: {inertia: 1 kg*m^2" + more)
    project = from_text(text, tmp_path / "project.yaml")
    base, moved, _ = sliders(project)
    names = {"load.inertia", "damping.B"} | ({"motor.loop.K_v", "motor.loop.T_n"} if motor == "cascade" else set())
    assert names <= {one.name for one in moved}
    positions = [[one.value * float(rng.uniform(0.85, 1.15)) for one in moved] for _ in range(3)]
    data, code = html.data_of(project)
    driven = motor not in ("held", "gravity")
    assert (data["held"] is not None) == driven
    asked = [[values] for values in positions]
    helds = of_page(data, code, asked, asked=HELDS) if driven else [None] * 3
    for values, (found, _), held in zip(positions, of_page(data, code, asked), helds, strict=True):
        own = at(base, moved, values)
        same(found, own)
        if driven and motor != "gap":  # whose curve has folds that rounding moves by 1e-8
            same(held, own, own.equation_response(coexisting=False))
        growth = np.max(np.abs(own.response(coexisting=False).curve.multipliers), axis=1)
        assert max(row[3] for row in found["rows"]) == pytest.approx(max(growth), rel=1e-8)


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
@pytest.mark.parametrize("gear", ["CSG-40-50", "own"])
def test_the_project_file_of_a_page_has_the_numbers_of_its_sliders(gear, tmp_path):
    text = first_text(gear) if gear != "own" else HELD.replace("LAW", LAWS["three slopes"])
    data, own = html.data_of(from_text(text, tmp_path / "project.yaml"))
    home = [one["value"] for one in data["sliders"]]
    assert any(one["name"].endswith("K1") for one in data["sliders"])
    factors = 1.0 + 0.1 * np.random.default_rng(8).uniform(-1.0, 1.0, (2, len(home)))
    factors[1] = [1.1 if one["name"].endswith("K1") else 1.0 for one in data["sliders"]]
    rows = of_page(data, own, [[home], *([list(map(float, home * row))] for row in factors)], asked=FILES)
    assert rows[0][1] == text
    for i, (found, given) in enumerate(rows[1:]):
        (tmp_path / f"{i}.yaml").write_text(given, encoding="utf-8")
        same(found, read_project(tmp_path / f"{i}.yaml"))


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_a_band_ends_where_the_oscillation_is_the_limit(tmp_path):
    project = project_of(tmp_path, "hardening")
    _, moved, _ = sliders(project)
    ((found, _),) = in_node(project, [[one.value for one in moved]])
    own, g = folded(project)
    h = int(found["harmonics"]) // g
    fine, ends = own.response(h, coexisting=False, points=4000), [g * end for end in np.ravel(found["bands"])]
    assert len(ends)
    for end in ends:
        away = np.abs(fine.omega / end - 1.0) + np.abs(fine.oscillation / project.limit - 1.0)
        i = int(np.argmin(away))
        near = slice(max(0, i - 3), i + 4)
        chord = np.polynomial.Polynomial.fit(fine.omega[near], fine.oscillation[near] / project.limit, 5)
        assert (
            chord(end) == pytest.approx(1.0, rel=1e-9)
            or np.min(np.abs(g * np.array(found["rows"])[:, 0] / end - 1.0)) < 1e-12
        )


LINEAR = HELD.replace("LAW", "{type: linear, K: 2e4 N*m/rad}").partition("excitation:")[0]


def forced(text, lines, folder, **more):
    """What the page of a drive answers to torques at its load, and the drive."""
    listed = ", ".join(f"{{order: {k}, amplitude: {size!r} N*m, phase: {phase!r} rad}}" for k, size, phase in lines)
    project = from_text(f"{text}excitation: {{load_torque: {{lines: [{listed}]}}}}\n", folder / "project.yaml")
    return of_its_page(project, **more), project.system(reduced=True)


def of_its_page(project, **more):
    """What the page of a project shows first."""
    data, own = html.data_of(project)
    ((found, _),) = of_page(data | more, own, [[[one["value"] for one in data["sliders"]]]])
    return found


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_the_speeds_above_a_limit_are_those_of_a_linear_spring(tmp_path):
    text = f"{LINEAR}limit: {{oscillation: {3.0 / 2e4!r} rad}}\n"
    found, system = forced(text, [(1, 1.0, 0.0)], tmp_path)
    own = (2e4 / system.J) ** 0.5
    zeta = 0.5 * system.B / (system.J * own)
    middle = 1.0 - 2.0 * zeta**2  # (1 - w^2)^2 + (2 zeta w)^2 = 1/limit^2
    half = np.sqrt(middle**2 - 1.0 + 1.0 / 3.0**2)
    np.testing.assert_allclose(found["bands"], [own * np.sqrt([middle - half, middle + half])], rtol=1e-9)
    top = found["rows"][int(found["top"])]
    assert top[1] * 2e4 == pytest.approx(0.5 / (zeta * np.sqrt(1.0 - zeta**2)), rel=1e-9)
    assert top[0] == pytest.approx(own * np.sqrt(middle), rel=1e-5)


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_all_crests_are_points_however_many(tmp_path):
    orders = np.arange(1, 37)
    text = LINEAR.replace("B: 15", "B: 3.4").replace("300 rpm", "37 rpm")
    found, system = forced(text, [(int(k), 1e-3, 2.0 * float(k * k)) for k in orders], tmp_path, points=10)
    speeds, sizes = np.array(found["rows"])[:, :2].T
    omega, angles = np.geomspace(found["low"], found["high"], 12_001), 2.0 * np.pi * np.arange(512) / 512
    w = omega[:, None] * orders
    waves = 1e-3 / (2e4 - system.J * w * w + 1j * system.B * w) * np.exp(2j * orders * orders)
    samples = (part @ np.exp(1j * np.outer(orders, angles)) for part in np.array_split(waves, 10))
    true = np.concatenate([np.max(np.abs(part.real), axis=1) for part in samples])
    inner = true[1:-1]
    crests = np.flatnonzero((inner > true[:-2]) & (inner > true[2:]) & (inner > 0.1 * np.max(true))) + 1
    assert len(crests) > 32
    for i in crests:
        assert np.max(sizes[np.abs(speeds / omega[i] - 1.0) < 2e-3]) >= true[i]


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_a_range_that_ends_between_folds_says_that_there_is_another_motion(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"])
    whole = from_text(text, tmp_path / "project.yaml")
    folds = [fold.omega for fold in whole.response(coexisting=False).folds]
    between = text.replace("to: 2000 rpm", f"to: {sum(folds) / 2.0 / RPM!r} rpm")
    for project, others in ((whole, False), (from_text(between, tmp_path / "project.yaml"), True)):
        assert of_its_page(project)["others"] is others


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_the_catalogue_has_the_numbers_of_the_project_file_that_it_gives(tmp_path):
    rng, path = np.random.default_rng(6), tmp_path / "project.yaml"
    data, own = html.data_of_catalogue()
    positions, compared, names = [], 0, [gear["name"] for gear in data["gears"]]
    for motor in (0, 1) * 4:
        values = [one.value * float(f) for one, f in zip(html.SLIDERS, rng.uniform(0.7, 1.3, 7), strict=True)]
        positions.append([values, int(rng.integers(len(data["gears"]))), motor])
    positions.append([[one.value for one in html.SLIDERS], names.index("CSG-25-100"), 0])
    rows = of_page(data, own, positions, "catalogue.js", asked=ROWS)
    for (_, gear, _), (found, row, text) in zip(positions, rows, strict=True):
        record = gear_of(names[gear])
        project = from_text(text, path)
        assert (project.speeds.limits[1] / RPM) <= (record.max_rpm or np.inf) * (1.0 + 1e-12)
        equation = project.system(reduced=True)
        assert row[5] == pytest.approx(0.5 * np.sqrt(record.K1 / equation.J) / RPM, rel=1e-9)
        text = re.sub("(load: {inertia: )[^}]*", rf"\g<1>{equation.J!r} kg*m^2", text).replace(
            "mode: free", "mode: held"
        )
        text = re.sub("ratio: .* %", f"B: {equation.B!r} N*m*s/rad", text)  # a free motor in folded speeds
        if not found["others"]:  # the page leaves a curve that turns outside the range to the command, and says so
            held = from_text(text, path)
            same(found, held)
            response = held.response(coexisting=False)
            assert row[6] * ARCSEC == pytest.approx(max(response.oscillation[response.stable]), rel=1e-7)
            compared += 1
    assert round(rows[-1][1][5]) == 841
    assert compared >= 5


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_a_kernel_that_ends_in_its_middle_gives_a_sentence_and_the_next_answer_is_whole(tmp_path):
    project = project_of(tmp_path, "hardening")
    data, own = html.data_of(project)
    position = [[one["value"] for one in data["sliders"]]]
    ((whole, _),) = of_page(data, own, [position])
    for lost, words, found in of_page(data, own, [position], asked=TRAPS):
        assert (lost["count"], lost["rows"], lost["bands"]) == (-1, [], [])
        assert words == ["no steady motion was found with these numbers"]
        assert found == whole


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_the_torque_of_the_load_has_a_slider_where_the_file_has_none(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("  load_torque: {mean: -4 N*m}\n", "")
    data, own = html.data_of(from_text(text, tmp_path / "project.yaml"))
    values = [2.5 if one["name"] == data["torque"] else one["value"] for one in data["sliders"]]
    ((found, given),) = of_page(data, own, [[values]], asked=FILES)
    (tmp_path / "given.yaml").write_text(given, encoding="utf-8")
    project = read_project(tmp_path / "given.yaml")
    assert project.mean_load_torque == 2.5
    same(found, project)


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_the_map_of_a_page_forbids_what_each_load_forbids(tmp_path):
    data, own = html.data_of(project_of(tmp_path, "hardening"))
    data |= {"scale": 1.0, "arcsec": 1e-5}
    calm = curve([100, 150, 200], [0.5] * 3, [1] * 3, []) | {"count": 3, "top": 1}
    above = calm | {"bands": [[120, 140]]}
    never = curve([100, 160, 170, 180, 200], [0.5, 0.5, 1.2, 0.5, 0.5], [1] * 5, []) | {"count": 5, "top": 0}
    lost = calm | {"count": -1, "rows": []}
    (told, picture), (lost_told, _) = of_page(
        data, own, [[calm, calm, above, never], [calm, calm, lost, calm]], asked=MAPS
    )
    assert told[-1].endswith("from -2 to 2 N·m: 100 to 120, 140 to 160, 180 to 200 rpm")
    assert told[0].endswith("largest oscillation 10 arcsec at 150 rpm")
    assert lost_told[-1].endswith("none")
    boxes = [
        [float(text) for text in found]
        for found in re.findall(r'"forbidden" x="(.*?)" y="(.*?)" width="(.*?)" height="(.*?)"', picture)
    ]
    left, right, top, bottom = (
        float(re.search(f'data-{name}="(.*?)"', picture)[1]) for name in ("left", "right", "top", "bottom")
    )
    place = lambda speed: left + (speed - 100) / 100 * (right - left)  # noqa: E731
    third = (bottom - top) / 3
    expected = [
        [place(120), top + third, place(140) - place(120), third], [place(160), top, place(180) - place(160), third],
    ]  # fmt: skip
    np.testing.assert_allclose(boxes, expected, atol=0.11)


def curve(speeds, growths, labels, bands):
    rows = [
        [speed, 1e-4, 1e-4, growth, 1.0, label] for speed, growth, label in zip(speeds, growths, labels, strict=True)
    ]
    return {"low": speeds[0], "high": speeds[-1], "bands": bands, "rows": rows}


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
@pytest.mark.parametrize("ends", [(200, 1600), (300, 900), (50, 3000), (1000, 1070), (20, 9999)])
def test_an_axis_of_a_narrow_picture_has_its_numbers(ends, tmp_path):
    data, own = html.data_of(project_of(tmp_path, "hardening"))
    data |= {"scale": 1.0}
    found = curve(ends, [0.5, 0.7], [1, 1], [])
    for picture in of_page(data, own, [[found, 345], [found, 480], [found, 900]], asked=PICTURE):
        numbers = [float(text) for text in re.findall(r'anchor="middle">([\d.]+)</text>', picture)]
        assert 2 <= len(numbers) <= 8
        assert all(ends[0] <= number <= ends[1] for number in numbers)


@NODE
@pytest.mark.parametrize(("mean", "said"), [("", True), ("  load_torque: {mean: -4 N*m}\n", False)])
def test_motions_within_a_gap_say_that_any_mean_is_in_balance(mean, said, tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("  load_torque: {mean: -4 N*m}\n", mean)
    project = from_text(text + "backlash: {half_gap: 60 arcsec}\n", tmp_path / "project.yaml")
    data, own = html.data_of(project)
    (words,) = of_page(data, own, [[[one["value"] for one in data["sliders"]]]], asked=TOLD)
    assert (data["facts"]["floats"] in words) == said


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_speeds_without_a_stable_motion_are_not_within_the_limit(tmp_path):
    data, own = html.data_of(project_of(tmp_path, "hardening"))
    data |= {"scale": 1.0}
    doubled = curve([100.4, 140.7, 150, 160, 170.2, 200.7], [0.5, 0.5, 1.2, 1.2, 0.5, 0.5], [1] * 6, [])
    above = doubled | {"bands": [[180.00049, 190.0006]]}
    bent = curve([100, 150, 160, 130, 120, 200], [0.5, 0.5, 1.0, 1.2, 1.0, 0.5], [1, 1, FOLD, 1, FOLD, 1], [])
    none = curve([100, 200], [1.2, 1.2], [1, 1], [])
    found, words = zip(*of_page(data, own, [doubled, above, bent, none], asked=CURVES), strict=True)
    assert found[0] == [[100.4, 140.7], [170.2, 200.7]]
    assert found[1] == [[100.4, 140.7], [170.2, 180.00049], [190.0006, 200.7]]
    assert found[2] == [[100, 200]]
    assert found[3] == []
    never = "speeds at which no motion of the curve is stable: 140.7 to 170.2 rpm"
    assert never in words[0]
    assert "speeds within it: 100.4 to 140.7, 170.2 to 180, 190.1 to 200.7 rpm" in words[1]
    assert "speeds at which the oscillation exceeds the limit: 180 to 190.1 rpm" in words[1]
    assert "the oscillation stays within the limit" in words[2]
    assert "speeds at which no motion of the curve is stable: 100 to 200 rpm" in words[3]
    assert data["digits"] == 4
    ((_, three),) = of_page(data | {"digits": 3}, own, [doubled], asked=CURVES)  # some numbers of the drive are assumed
    assert "speeds at which no motion of the curve is stable: 140 to 171 rpm" in three


@pytest.mark.slow
@pytest.mark.interpreted
def test_a_page_opens_from_a_file_with_no_request_and_answers_to_the_keyboard(browser, tmp_path):
    path = tmp_path / "drive.html"
    html.write_page(project_of(tmp_path, "three slopes"), path)
    assert path.stat().st_size <= 400_000
    context = browser.new_context(offline=True)
    context.set_default_timeout(PATIENCE)
    page, asked, errors = context.new_page(), [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: errors.append(message.text))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    page.wait_for_selector("svg polyline")
    first = page.inner_text("#said")
    assert "largest oscillation" in first
    assert page.evaluate("(url) => fetch(url).then((r) => r.text())", page.get_attribute("#file", "href")).startswith(
        "title: page"
    )
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "again"
    page.get_by_label("load inertia").focus()
    for _ in range(5):
        page.keyboard.press("PageUp")
    assert page.inner_text("#said") != first
    there = page.inner_text("#said")
    page.reload()
    assert page.inner_text("#said") == there, "its address holds its numbers"
    page.click("#again")
    assert page.inner_text("#said") == first
    page.goto(path.as_uri() + "#%")
    page.reload()
    assert page.inner_text("#said") == first, "an address that holds no numbers"
    page.locator("#later", has_text="nine load torques from -24 to 16").wait_for()
    page.hover("#map")
    assert re.match(r"-9 N·m: \d+ rpm: .* arcsec, ", page.inner_text("#how"))
    stale = "() => { document.getElementById('input4').stepUp(); document.getElementById('input4').dispatchEvent("
    assert page.evaluate(stale + "new Event('input')); return document.getElementById('map').matches('.stale'); }")
    page.wait_for_selector("#map:not(.stale)")
    page.emulate_media(media="print")
    assert page.locator("svg").first.is_visible()
    assert not page.locator("#again").is_visible()
    assert not errors
    assert all(url.startswith(("file://", "blob:")) for url in asked)
    context.close()


@pytest.fixture
def offline(browser):
    """A page without a network, whose console stays empty and which asks for nothing but files."""
    context = browser.new_context(offline=True, accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    page, asked, errors = context.new_page(), [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: errors.append(message.text))
    page.on("pageerror", lambda error: errors.append(str(error)))
    yield page
    context.close()
    assert not errors
    assert all(url.startswith(("file://", "blob:", "about:")) for url in asked)


@pytest.mark.slow
@pytest.mark.interpreted
def test_the_page_of_the_catalogue_sorts_chooses_and_gives_a_project_file(offline, tmp_path):
    path = tmp_path / "gears.html"
    done = CliRunner().invoke(cli, ["export", "catalogue", "--to", "html", "-o", str(path)])
    assert done.output == f"Gears of the catalogue: html in {path}\n"
    assert path.stat().st_size <= 1_000_000
    offline.goto(path.as_uri())
    offline.get_by_text(re.compile(r"^computing the gears: \d+ of \d+$")).wait_for()
    offline.wait_for_selector("#all:not(.stale)")
    assert offline.inner_text("#progress") == ""
    rows = offline.locator("#rows tr")
    column = lambda i: rows.evaluate_all("(rows, i) => rows.map((row) => row.cells[i].textContent)", i)  # noqa: E731
    assert rows.count() == len(html.data_of_catalogue()[0]["gears"])
    largest = [float(text) for text in column(6) if text != "–"]
    assert largest == sorted(largest)
    offline.get_by_role("button", name="rated torque").click()
    offline.get_by_role("button", name="rated torque").click()
    rated = [float(text) for text in column(2) if text != "–"]
    assert rated == sorted(rated, reverse=True)
    assert offline.locator("[aria-sort=descending]").inner_text().startswith("rated torque")
    before = offline.inner_text("#said")
    offline.get_by_role("button", name="CSG-40-50", exact=True).click()
    assert offline.inner_text("#said") != before
    assert offline.locator("[aria-current] button").inner_text() == "CSG-40-50"
    assert "dashed motions are unstable" in offline.inner_text("#said")
    assert offline.locator("[aria-current] td").first.inner_text() == "CSG-40-50 *"
    assert offline.input_value("#input0") == offline.evaluate(
        "String(DATA.gears.findIndex((g) => g.name === 'CSG-40-50'))"
    )
    with offline.expect_download() as given:
        offline.click("#file")
    given.value.save_as(tmp_path / "given.yaml")
    project = read_project(tmp_path / "given.yaml")
    found = project.response(coexisting=False)
    assert f"{np.degrees(max(found.oscillation)) * 3600:.4g} arcsec" in offline.inner_text("#said")


@pytest.mark.slow
@pytest.mark.compiled
def test_a_live_report_has_the_page_folded_away_or_says_why_not(offline, tmp_path):
    project = from_text(HELD.replace("LAW", LAWS["three slopes"]), tmp_path / "project.yaml")
    report = write(project, tmp_path / "held", sections=(), live=True)
    assert "no curve" not in report.summary
    offline.goto((tmp_path / "held" / "report.html").as_uri())
    assert not offline.locator("iframe").is_visible()
    offline.click("summary")
    inside = offline.frame_locator("iframe")
    first = inside.locator("#said").inner_text()
    inside.get_by_label("load inertia").press("PageUp")
    assert inside.locator("#said").inner_text() != first
    with offline.expect_download() as given:
        inside.get_by_text("This page as a file").click()
    given.value.save_as(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == html.page_of(project)
    several = HELD.replace("LAW", LAWS["three slopes"]).replace("mean: -4 N*m", "mean: {from: -5 N*m, to: -4 N*m}")
    report = write(from_text(several, tmp_path / "loads.yaml"), tmp_path / "loads", sections=(), live=True)
    assert "no curve that follows sliders: a page holds drives" in report.summary
    page = (tmp_path / "loads" / "report.html").read_text(encoding="utf-8")
    assert "No curve that follows sliders" in page
    assert "script" not in page


@pytest.mark.compiled
def test_a_page_that_cannot_be_made_leaves_the_report_whole(tmp_path, monkeypatch):
    project = project_of(tmp_path, "three slopes")
    view = View.of(project, project.analyze())
    for kind in (ValueError, TypeError, SolveError):

        def fail(_, kind=kind):
            raise kind("the law cannot carry 4 N*m")

        monkeypatch.setattr("strainwave.app.report.report.page_of", fail)
        write_view(view, tmp_path, (), live=True)
        page = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert "No curve that follows sliders: the law cannot carry 4 N*m" in page
        (tmp_path / "report.html").unlink()


@pytest.mark.slow
@pytest.mark.interpreted
def test_a_browser_that_is_too_old_gets_a_sentence(browser, tmp_path):
    path = tmp_path / "drive.html"
    html.write_page(project_of(tmp_path, "hardening"), path)
    older = tmp_path / "older.html"
    older.write_text(path.read_text(encoding="utf-8").replace('"use strict";', "#syntax of a later year;"), "utf-8")
    for file, missing, words in (
        (path, "WebAssembly.validate = () => false", "no WebAssembly with SIMD"),
        (path, "delete Array.prototype.reduce", "take a newer browser"),
        (older, "", "take a newer browser"),
        (path, "delete Array.prototype.toSorted", "largest oscillation"),
    ):
        context = browser.new_context()
        context.set_default_timeout(PATIENCE)
        context.add_init_script(missing)
        page = context.new_page()
        page.goto(file.as_uri())
        page.locator("#said", has_text=words).wait_for()
        context.close()
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path.as_uri())
    assert "scripts are switched off" in page.inner_text("body")
    context.close()


def test_a_slider_says_what_is_assumed_and_keeps_the_symbol_of_a_gain():
    text = first_text("CSG-32-120").replace("motor: assumed, ", "")
    labels = {one.name: one.label for one in sliders(from_text(text, Path("axis.yaml")))[1]}
    assert labels["motor.loop.T_n"] == "motor loop T_n"
    assert labels["motor.inertia"] == "motor inertia"
    assert labels["load.inertia"] == "load inertia (assumed)"
    assert labels["damping.B"] == "damping B (assumed)"


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_random_positions_leave_no_trap_and_take_no_memory(tmp_path):
    project = project_of(tmp_path, "three slopes")
    rng = np.random.default_rng(5)
    _, moved, _ = sliders(project)
    positions = [[float(rng.uniform(one.low, one.high)) for one in moved] for _ in range(300)]
    found, memory = zip(*in_node(project, positions), strict=True)
    assert memory[-1] == memory[len(memory) // 2]
    assert sum(one["count"] > 0 for one in found) > 150
    for one in found:
        assert None not in [number for row in one["rows"] for number in row]  # as JSON has NaN


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (
            "mode: held",
            "loop: {bandwidth: 30 Hz, damping: 0.7}, drag: {type: coulomb, T_c: 0.01 N*m, width: 2 rad/s}",
            "friction of the motor",
        ),
        ("load: {", "hysteresis: {type: bouc_wen, K: 3e3 N*m/rad, ratio: 0, yield_twist: 1e-4 rad}\nload: {", "memory"),
        ("mean: -4 N*m", "mean: {from: -10 N*m, to: 10 N*m}", "a range of load torques"),
        (
            "limit:",
            "postures: [{inertia: 1 kg*m^2, torque: 2 N*m}, {inertia: 3 kg*m^2, torque: 4 N*m}]\nlimit:",
            "postures",
        ),
        ("{order: 2,", "{order: {wave_generator: 2, output: 2},", "a line of the output's turn"),
    ],
)
def test_a_drive_that_no_page_holds_is_refused_by_its_part(old, new, named, tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace(old, new)
    words = f"this drive has .*{named}.*: take `strainwave app` or `strainwave analyze`, or leave it out"
    with pytest.raises(ValueError, match=words):
        html.page_of(from_text(text, tmp_path / "project.yaml"))


def test_all_parts_that_no_page_holds_are_named(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("mean: -4 N*m", "mean: {from: -10 N*m, to: 10 N*m}")
    text = text.replace("{order: 2,", "{order: {wave_generator: 2, output: 2},")
    with pytest.raises(ValueError, match=r"a range of load torques and a line of the output's turn: .* leave them out"):
        html.page_of(from_text(text, tmp_path / "project.yaml"))


def test_a_line_of_the_outputs_turn_leaves_the_turn_whole_and_its_response_beats(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("{order: 4,", "{order: {wave_generator: 2, output: 2},")
    project = from_text(text, tmp_path / "project.yaml")
    assert folded(project) == (project, 1)
    found = solved(project).found
    assert found.curve.beat == 25.0
    shown = response(project)
    np.testing.assert_array_equal(shown["beat"]["smallest_arcsec"], found.curve.envelope[:, 1] / ARCSEC)
    assert shown["beat"]["smallest_at_largest_arcsec"] < shown["largest"]["oscillation_arcsec"]
    assert shown["beat"]["period_s"] == pytest.approx(25.0 * 60.0 / shown["largest"]["speed"], rel=1e-12)


def test_sliders_do_not_depend_on_the_number_that_comes_first(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("B: 15 N*m*s/rad", "ratio: 3 %")
    head = "speed: {from: 1600 rpm, to: 2000 rpm, shaft: motor}\n"
    moved = head + re.sub("speed: .*\n", "", text)
    (base, rows, _), (other, others, _) = (
        sliders(from_text(one, tmp_path / "project.yaml")) for one in (text.replace("300 rpm", "1600 rpm"), moved)
    )
    assert sorted(one[:4] for one in rows) == sorted(one[:4] for one in others)
    assert pytest.approx(float(base.drive.B), rel=1e-12) == other.drive.B


def test_sliders_that_no_place_together_can_check_are_left_out(tmp_path, monkeypatch):
    changed = page_sliders._with

    def at_most_three(project, changes):
        if len(changes) > 3:
            raise ValueError("too many at once")
        return changed(project, changes)

    monkeypatch.setattr(page_sliders, "_with", at_most_three)
    _, rows, terms = sliders(project_of(tmp_path, "hardening"))
    assert (len(rows), terms) == (3, [])


@pytest.mark.parametrize("most", [2.0, 3.9])
def test_a_number_that_ends_within_its_slider_has_none(most, tmp_path, monkeypatch):
    changed = page_sliders._with

    def bounded(project, changes):
        bound = {row: min(value, most * row.value) for row, value in changes.items() if row.name == "damping.B"}
        return changed(project, changes | bound)

    monkeypatch.setattr(page_sliders, "_with", bounded)
    _, rows, _ = sliders(project_of(tmp_path, "hardening"))
    names = {row.name for row in rows}
    assert "load.inertia" in names
    assert "damping.B" not in names


@pytest.mark.slow
@pytest.mark.interpreted
def test_a_title_that_looks_like_a_place_of_the_page_stays_a_title(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("title: page", 'title: "@DATA@ of @CODE@"')
    page = html.page_of(from_text(text, tmp_path / "project.yaml"))
    assert "<h1>@DATA@ of @CODE@</h1>" in page
