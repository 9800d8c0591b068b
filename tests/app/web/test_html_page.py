"""The page of a drive: its numbers are Python's at all positions of its sliders, in node and in Chromium."""

import inspect
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from test_extension import Dogleg

from strainwave.app.page import page as html
from strainwave.app.web.views import solved
from strainwave.compile.wasm import stamp
from strainwave.files.reading import from_text
from strainwave.files.variants.replaced import replaced
from strainwave.numerics.labels import FOLD

NODE = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
ANSWERS = """
const { readFileSync } = require("fs"), [data, kernels, own, positions] = JSON.parse(readFileSync(0));
const machine = start(bytes(kernels), data.kinds, bytes(own));
const answer = (values) => [answered(machine, data, values, data.points), machine.main.memory.buffer.byteLength];
console.log(JSON.stringify(positions.map(answer)));
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
    data, own = html.data_of(project)
    given = [data, html._packed(html.kernels()), html._packed(own), positions]
    script = html._text("machine.js") + html._text("page.js") + ANSWERS
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
    base, moved = html.sliders(project)
    assert {"load.inertia", "damping.B", "limit.oscillation", "excitation.load_torque.mean"} <= {
        one.name for one in moved
    }
    factors = [np.ones(len(moved)), *rng.uniform(0.8, 1.2, (4, len(moved)))]
    positions = [[one.value * float(f) for one, f in zip(moved, some, strict=True)] for some in factors]
    for values, (found, _) in zip(positions, in_node(project, positions), strict=True):
        changes = {one.name: html._quantity(value, one.unit) for one, value in zip(moved, values, strict=True)}
        own = html.folded(replaced(base, changes))[0]
        curve = own.response(coexisting=False, points=html.POINTS)
        rows = np.array(found["rows"])
        assert found["count"] == len(curve.omega)
        close = 1e-9 if law == "hardening" else 1e-6  # with corners, where a step ends depends on rounding
        for column, expected in ((0, curve.omega), (1, curve.oscillation), (2, curve.peak), (4, curve.torque)):
            np.testing.assert_allclose(rows[:, column], expected, rtol=close)
        assert max(rows[:, 1]) == pytest.approx(max(curve.oscillation), rel=1e-9, abs=0.0)
        assert max(rows[:, 2]) == pytest.approx(max(curve.peak), rel=1e-9, abs=0.0)
        assert np.array_equal(rows[:, 3] < 1.0 - 1e-10, curve.stable)
        np.testing.assert_allclose(rows[rows[:, 5] == FOLD, 0], [fold.omega for fold in curve.folds], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.interpreted
def test_a_page_opens_from_a_file_with_no_request_and_answers_to_the_keyboard(browser, tmp_path):
    path = tmp_path / "drive.html"
    html.write_page(project_of(tmp_path, "three slopes"), path)
    assert path.stat().st_size <= 400_000
    context = browser.new_context(offline=True)
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
    page.emulate_media(media="print")
    assert page.locator("svg").is_visible()
    assert not page.locator("#again").is_visible()
    assert not errors
    assert all(url.startswith(("file://", "blob:")) for url in asked)
    context.close()


@pytest.mark.slow
@pytest.mark.interpreted
def test_a_browser_without_vectors_gets_a_sentence(browser, tmp_path):
    path = tmp_path / "drive.html"
    html.write_page(project_of(tmp_path, "hardening"), path)
    context = browser.new_context()
    context.add_init_script("WebAssembly.validate = () => false")
    page = context.new_page()
    page.goto(path.as_uri())
    assert "no WebAssembly with SIMD" in page.inner_text("#said")
    context.close()


@NODE
@pytest.mark.slow
@pytest.mark.interpreted
def test_random_positions_leave_no_trap_and_take_no_memory(tmp_path):
    project = project_of(tmp_path, "three slopes")
    rng = np.random.default_rng(5)
    _, moved = html.sliders(project)
    positions = [[float(rng.uniform(one.low, one.high)) for one in moved] for _ in range(300)]
    found, memory = zip(*in_node(project, positions), strict=True)
    assert memory[-1] == memory[len(memory) // 2]
    assert sum(one["count"] > 0 for one in found) > 150
    for one in found:
        assert None not in [number for row in one["rows"] for number in row]  # as JSON has NaN


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("mode: held", "loop: {bandwidth: 30 Hz, damping: 0.7}", "a motor with its loop, couplings or friction"),
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
    with pytest.raises(ValueError, match=f"this drive has .*{named}.*: take `strainwave app`"):
        html.page_of(from_text(text, tmp_path / "project.yaml"))


def test_a_line_of_the_outputs_turn_leaves_the_turn_whole_and_the_response_refuses_it(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("{order: 4,", "{order: {wave_generator: 2, output: 2},")
    project = from_text(text, tmp_path / "project.yaml")
    assert html.folded(project) == (project, 1)
    with pytest.raises(ValueError, match=r"the order 2\.04 is not an integer"):
        solved(project)


def test_sliders_do_not_depend_on_the_number_that_comes_first(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("B: 15 N*m*s/rad", "ratio: 3 %")
    head = "speed: {from: 1600 rpm, to: 2000 rpm, shaft: motor}\n"
    moved = head + re.sub("speed: .*\n", "", text)
    (base, rows), (other, others) = (
        html.sliders(from_text(one, tmp_path / "project.yaml")) for one in (text.replace("300 rpm", "1600 rpm"), moved)
    )
    assert sorted(one[:4] for one in rows) == sorted(one[:4] for one in others)
    assert pytest.approx(float(base.drive.B), rel=1e-12) == other.drive.B


def test_a_title_that_looks_like_a_place_of_the_page_stays_a_title(tmp_path):
    text = HELD.replace("LAW", LAWS["hardening"]).replace("title: page", 'title: "@DATA@ of @CODE@"')
    page = html.page_of(from_text(text, tmp_path / "project.yaml"))
    assert "<h1>@DATA@ of @CODE@</h1>" in page
