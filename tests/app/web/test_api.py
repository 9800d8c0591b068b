"""The API gives the numbers of the library, in the units of the page."""

import ast
import json
import math
import re
import time
from pathlib import Path

import measured_axis
import numpy as np
import pytest
from measured_axis import measured
from one_joint import HELD, JOINT
from scipy.io import savemat

import strainwave as sw
from strainwave.app.web import goals, views
from strainwave.app.web.first_project import first_text
from strainwave.app.web.parameters import about, parameters
from strainwave.app.web.requests import State
from strainwave.app.web.state import of_state, project_of
from strainwave.app.web.views import POINTS
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import from_text
from strainwave.study.speed_map.avoid import speeds_to_avoid
from strainwave.study.speed_map.error_equation import operating_point

GEAR = {"gear": "CSG-40-50"}
ARTICLE = (Path(__file__).parents[3] / "examples/projects/article.yaml").read_text(encoding="utf-8")


def posted(client, path, **body):
    answer = client.post(path, json=body)
    assert answer.status_code in (200, 201), answer.text
    return answer.json()


@pytest.fixture
def written(tmp_path):
    def project(text, **values):
        path = tmp_path / "project.yaml"
        path.write_text(text, encoding="utf-8")
        found = sw.read_project(path)
        return sw.replaced(found, values, retune=True) if values else found

    return project


@pytest.mark.parametrize("values", [{}, {"damping.ratio": "1 %"}, {"excitation.load_torque.mean": "-30 N*m"}])
def test_curve_of_a_slider_is_the_finer_one(client, written, values):
    shown = posted(client, "/api/response", state={"project": HELD, "values": values})
    found = written(HELD, **values).response(coexisting=False)
    top = max(found.oscillation[found.visited()]) / ARCSEC
    assert shown["largest"]["oscillation_arcsec"] == pytest.approx(top, rel=1e-6)
    assert shown["jumps"][0]["high"] * RPM == pytest.approx(found.sweep.bands[0].high, rel=1e-6)
    finest = written(HELD, **values).response(coexisting=False, points=400)
    assert shown["largest"]["torque"] == pytest.approx(finest.usage.peak_torque, rel=2e-3)
    system = written(HELD, **values).system()
    bands = speeds_to_avoid(system, finest, operating_point(system), 120.0 * ARCSEC).bands
    np.testing.assert_allclose(np.array(shown["avoid"]) * RPM, bands, rtol=2e-3)
    # as a polyline: no point of the finer one is further off than 1 % of the picture
    width, height = np.ptp(found.omega) / RPM, np.max(found.oscillation) / ARCSEC
    line = np.column_stack([np.divide(shown["speed"], width), np.divide(shown["oscillation_arcsec"], height)])
    finer = np.column_stack([found.omega / RPM / width, found.oscillation / ARCSEC / height])
    along = np.diff(line, axis=0)
    share = np.einsum("pij,ij->pi", finer[:, None] - line[:-1], along) / np.sum(along**2, axis=1)
    nearest = line[:-1] + np.clip(share, 0.0, 1.0)[:, :, None] * along
    assert np.max(np.min(np.linalg.norm(finer[:, None] - nearest, axis=2), axis=1)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("state", [GEAR, {"project": JOINT}], ids=["gear", "joint"])
def test_motion_is_that_of_the_drive_whose_response_is_shown(client, tmp_path, monkeypatch, capsys, state):
    curve = posted(client, "/api/response", state=state)
    speed, at = curve["speed"][-10], curve["oscillation_arcsec"][-10]
    shown = posted(client, "/api/motion", state=state, speed=speed)
    assert shown["oscillation_arcsec"] == pytest.approx(at, rel=1e-3)
    assert shown["torque"] == pytest.approx(curve["torque"][-10], rel=3e-3)
    assert np.ptp(shown["poincare"]["error_arcsec"]) < 1e-3 * at
    assert shown["load_torque"] == curve["load_torques"][1]
    assert not any("leaves out" in remark for remark in shown["remarks"])
    said = printed(client, tmp_path, monkeypatch, capsys, "motion", state, speed=speed)
    error = shown["error_arcsec"]
    assert said == pytest.approx([min(error), max(error), shown["oscillation_arcsec"]], rel=1e-5)


def test_every_number_of_a_file_has_a_slider_with_unit_and_range():
    found = {one["name"]: one for one in parameters(project_of(State(project=ARTICLE)))}
    assert found["motor.inertia"]["si_unit"] == "kg*m**2"
    assert found["motor.inertia"]["unit"] == "kg*cm^2"
    assert found["excitation.motor_torque.lines.0.amplitude"]["si_unit"] == "N*m"
    assert found["gear.law.alpha"]["si_unit"] == "1/rad**2"
    assert all(one["low"] <= one["value"] <= one["high"] for one in found.values())


def test_a_line_of_both_turns_has_sliders_that_name_it_by_its_repeats():
    text = first_text("CSG-40-50").replace(
        "accuracy: catalogue",
        "kinematic_error: [{order: {wave_generator: 2, output: -2}, amplitude: 3 arcsec}, "
        "{order: {output: 1}, amplitude: {at_rest: 4 arcsec, per_torque: -0.1 arcsec/(N*m)}}]",
    )
    found = {one["label"]: one for one in parameters(project_of(State(project=text))) if "order" in one["label"]}
    assert set(found) == {
        "kinematic error order (2, -2) amplitude", "kinematic error order (0, 1) amplitude at rest",
        "kinematic error order (0, 1) amplitude per torque",
    }  # fmt: skip
    for one in found.values():
        ends = [f"{one[end]!r} {one['unit']}" for end in ("low", "high")]
        assert all(project_of(State(project=text, values={one["name"]: end})) for end in ends)
    assert found["kinematic error order (2, -2) amplitude"]["low"] > 0.0


def test_every_slider_of_a_gear_is_taken_by_the_project():
    project = project_of(State(gear="CSG-40-50"))
    for one in parameters(project):
        value = one["value"] * 1.01 if one["value"] else 1.0
        changed = project_of(State(gear="CSG-40-50", values={one["name"]: f"{value!r} {one['unit']}"}))
        assert changed != project, one["name"]


def test_a_gear_has_a_slider_for_the_motors_inertia_which_begins_with_the_wave_generator():
    for name in ("CSG-32-120", "SHG-40-80"):
        project = project_of(State(gear=name))
        (one,) = (one for one in parameters(project) if one["name"] == "motor.inertia")
        assert one["value"] == pytest.approx(1e4 * project.gear.input_inertia, rel=1e-6)
        assert (one["unit"], one["group"]) == ("kg*cm^2", "motor")
        assert not [note for note in project.notes if "wave generator" in note]


def test_numbers_that_a_file_leaves_to_the_record_of_its_gear_have_sliders():
    text = first_text("CSG-40-50").replace("inertia: 4.5 kg*cm^2, ", "")
    state = State(project=text)
    found = {one["name"]: one for one in parameters(project_of(state))}
    assert found["motor.inertia"]["value"] == pytest.approx(4.5)
    assert found["excitation.accuracy"]["value"] == 59.8
    double = project_of(State(project=text, values={"excitation.accuracy": f"{119.64!r} arcsec"}))
    amplitudes = [2.0 * line.amplitude for line in project_of(state).kinematic_error.lines]
    assert [line.amplitude for line in double.kinematic_error.lines] == pytest.approx(amplitudes, rel=1e-3)
    assert project_of(State(project=text, values={"motor.inertia": "6 kg*cm^2"})).drive.J_m == pytest.approx(6e-4)


@pytest.mark.parametrize(("typed", "shown"), [("4 %", 0.04), ("0.1", 0.1)])
def test_a_slider_shows_what_was_typed_in_the_unit_of_the_file(typed, shown):
    text = HELD.replace("title: CSG-40-50", "title: 3-axis robot\nrevision: 2026-11-26\nload_friction: 0.05")
    found = about(State(project=text, values={"load_friction": typed}))["parameters"]
    assert [one["now"] for one in found if one["name"] == "load_friction"] == pytest.approx([shown])
    assert not {"title", "revision"} & {one["name"] for one in found}


def test_every_gear_of_the_list_has_a_first_project(client):
    axes = client.get("/api/axes").json()
    assert list(axes) == ["Antenna", "Index table", "Robot joint"]
    assert {from_text(text, Path("axis.yaml")).title.partition(":")[0] for text in axes.values()} == set(axes)
    gears = client.get("/api/gears").json()
    assert len(gears) > 150
    for gear in gears:
        assert project_of(State(gear=gear["name"])).gear.name == gear["name"]


def test_exported_project_reads_back_as_the_same_drive(client, written):
    state = {**GEAR, "values": {"load.inertia": "2 kg*m^2", "gear.K1": "2e5 N*m/rad"}}
    text = client.post("/api/export/project", json={"state": state}).text
    found, meant = written(text), project_of(State(**state))
    assert (found.drive, found.speeds) == (meant.drive, meant.speeds)
    named = client.post("/api/export/project", json={"state": {**GEAR, "values": {"title": "2nd axis"}}}).text
    assert (written(named).title, "title: yours" in named) == ("2nd axis", False)
    wrong = posted(client, "/api/project", state={**GEAR, "values": {"title": "a\x07"}})
    assert (wrong["title"], "cannot be printed" in wrong["unknown"]["title"]) == ("CSG-40-50", True)


NUMBER = re.compile(r"-?[0-9]+(?:[.][0-9]+)?(?:e[-+]?[0-9]+)?")


def printed(client, tmp_path, monkeypatch, capsys, view, state=GEAR, **more):
    """Numbers that the exported script of a view prints."""
    script = client.post("/api/export/script", json={"state": state, "view": view, **more}).text
    monkeypatch.chdir(tmp_path)
    (tmp_path / "project.yaml").write_text("of the user", encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["script.py"])
    exec(compile(script, "script.py", "exec"), {"__name__": "__main__"})
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"project.yaml": "of the user"}
    return [float(number) for number in NUMBER.findall(capsys.readouterr().out)]


def test_exported_script_prints_what_the_page_says(client, tmp_path, monkeypatch, capsys):
    shown = posted(client, "/api/response", state=GEAR)["largest"]
    said = printed(client, tmp_path, monkeypatch, capsys, "response")
    assert said == pytest.approx([shown["oscillation_arcsec"], shown["speed"]], rel=1e-4)
    script = client.post("/api/export/script", json={"state": GEAR, "view": "response"}).text
    monkeypatch.setattr("sys.argv", ["script.py", "picture.svg"])
    exec(compile(script, "script.py", "exec"), {"__name__": "__main__"})
    assert "oscillation" in (tmp_path / "picture.svg").read_text(encoding="utf-8")


LOADS = [-89.5, 0.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "more"), [("speed-map", {}), ("speed-map", {"loads": LOADS, "search": False}), ("compensation", {})]
)
def test_script_of_a_job_prints_its_result(client, tmp_path, monkeypatch, capsys, kind, more):
    result = waited(client, posted(client, "/api/jobs", state=GEAR, kind=kind, **more)["id"])["result"]
    said = printed(client, tmp_path, monkeypatch, capsys, kind, **more)
    if kind == "speed-map":
        assert result["load"] == (more.get("loads") or [0.0])  # those of the project where none are chosen
        assert said == pytest.approx([speed for window in result["allowed"] for speed in window], rel=1e-5)
    else:
        assert said[:2] == pytest.approx([result[when]["rms_arcsec"] for when in ("before", "after")], rel=1e-4)


@pytest.mark.slow
def test_compensation_of_a_joint_is_that_of_the_library(client, written):
    shown = waited(client, posted(client, "/api/jobs", state={"project": JOINT}, kind="compensation")["id"])["result"]
    found = sw.compensate(written(JOINT))
    assert shown["speed"] * RPM == pytest.approx(found.speed, rel=1e-9)
    assert shown["speed_unit"] == "rpm"
    assert shown["before"]["rms_arcsec"] * ARCSEC == pytest.approx(found.before.rms, rel=1e-9)
    assert shown["after"]["rms_arcsec"] * ARCSEC == pytest.approx(found.after.rms, rel=1e-9)
    assert shown["torque"] == pytest.approx(found.torque.peak, rel=1e-9)
    for when, own in (("before", found.before), ("after", found.after)):
        run = np.array(shown[f"{when}_arcsec"]) * ARCSEC
        assert np.mean(run) == pytest.approx(own.mean, rel=1e-3)
        assert np.max(np.abs(run)) == pytest.approx(own.peak, rel=0.01)
    assert {*found.remarks} <= {*shown["assumed"]}
    assert any("Assumed: samples every 250 us" in text for text in shown["assumed"])
    assert [one["stiffness"] for one in shown["other_gears"]] == [-0.2, 0.2]
    for one, own in zip(shown["other_gears"], found.robustness, strict=True):
        assert one["after_rms_arcsec"] * ARCSEC == pytest.approx(own.after, rel=1e-9)


def test_words_of_a_project_stay_words_in_a_script(client):
    title = "SPEED {body} __import__('os') \\"
    state = {**GEAR, "values": {"title": title}}
    script = client.post("/api/export/script", json={"state": state, "view": "motion", "speed": 900.0}).text
    words = {node.value for node in ast.walk(ast.parse(script)) if isinstance(node, ast.Constant)}
    assert title in words
    state = {"project": JOINT.replace("title: joint", f"title: {title}")}
    script = client.post("/api/export/script", json={"state": state, "view": "motion", "speed": 900.0}).text
    words = {node.value for node in ast.walk(ast.parse(script)) if isinstance(node, ast.Constant)}
    assert any(isinstance(text, str) and title in text for text in words)


def test_a_script_repeats_the_session_with_one_line_an_action(client, tmp_path, monkeypatch, capsys):
    first, last = {"load.inertia": "2 kg*m^2"}, {"load.inertia": "2 kg*m^2", "motor.loop.bandwidth": "20 Hz"}
    before = [{"values": {}, "view": "response"}, {"values": first, "view": "motion", "speed": 900.0},
              {"values": first, "view": "move"}, {"values": {}, "view": ""}]  # fmt: skip
    state = {**GEAR, "values": last}
    shown = posted(client, "/api/response", state=state)["largest"]
    said = printed(client, tmp_path, monkeypatch, capsys, "response", state, before=before)
    assert said == pytest.approx([shown["oscillation_arcsec"], shown["speed"]], rel=1e-4)
    script = client.post("/api/export/script", json={"state": state, "view": "response", "before": before}).text
    lines = script.partition("no file is written\n")[2].splitlines()
    calls = ("project.response(", "sw.replaced(drive, {'load.inertia'", "sw.drive_motion(project, 900.0", "sw.move(",
             "project = drive", "sw.replaced(drive, {'load.inertia'", "project.response(")  # fmt: skip
    assert [call in line for call, line in zip(calls, lines, strict=False)] == [True] * len(calls)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"view": "motion"}, "needs its speed"),
        ({"view": "log"}, "view: "),
    ],
)
def test_a_script_that_lacks_something_is_refused(client, body, said):
    answer = client.post("/api/export/script", json={"state": GEAR, **body})
    assert answer.status_code == 422
    assert said in answer.json()["error"]


def waited(client, name):
    for _ in range(6000):
        job = client.get(f"/api/jobs/{name}").json()
        if job["state"] not in ("waiting", "running"):
            return job
        time.sleep(0.05)
    raise AssertionError("the job does not end")


def test_log_is_read(client):
    t = np.linspace(0.0, 4.0, 8001)
    motor = 2 * np.pi * 5.0 * t
    torque = 1.0 + 0.2 * np.cos(2 * motor)
    rows = "\n".join(f"{a:.9g},{b:.9g},{c:.9g}" for a, b, c in zip(t, motor, torque, strict=True))
    text = "time [s],motor_angle [rad],motor_torque [N*m]\n" + rows
    shown = client.post("/api/log?name=run.csv", content=text.encode()).json()
    assert (shown["samples"], shown["said"]) == (8001, "8001 samples, 0 to 4 s, 2000 Hz")
    assert [c["name"] for c in shown["channels"]] == ["motor_angle", "motor_torque"]
    assert shown["orders"]["lines"][0]["order"] == pytest.approx(2.0, abs=0.01)
    assert shown["orders"]["lines"][0]["amplitude"] == pytest.approx(0.2, rel=0.01)


@pytest.mark.parametrize("way", [1, -1])
def test_a_log_of_both_angles_has_the_error_between_them(client, way):
    t = np.linspace(0.0, 4.0, 4001)
    motor = 2 * np.pi * 5.0 * t
    load = way * (motor / 50 - 20 * ARCSEC * np.cos(2 * motor))
    rows = [f"{a:.9g},{b:.12g},{c:.12g}" for a, b, c in zip(t, motor, load, strict=True)]
    text = "\n".join(["time,motor_angle [rad],load_angle [rad]", *rows])
    shown = client.post("/api/log?name=run.csv", content=text.encode())
    pointing = shown.json()["pointing"]
    assert pointing["unit"] == "arcsec"
    np.testing.assert_allclose(pointing["values"], 20 * np.cos(2 * motor)[::2], atol=0.01)


@pytest.mark.slow
def test_a_dropped_log_identifies_its_drive(client):
    log = measured()
    columns = (log["time"], np.degrees(log["motor_angle"]), np.degrees(log["load_angle"]))
    rows = "\n".join(",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True))
    text = f"time [s],motor_angle [deg],load_angle [deg]\n{rows}\n"
    state = {"project": measured_axis.PROJECT}
    body = json.dumps({"state": state}).encode() + b"\n" + text.encode()
    job = waited(client, client.post("/api/identify?name=run.csv", content=body).json()["id"])
    assert job["state"] == "done", job["error"]
    found = {number["name"]: number for number in job["result"]["numbers"]}
    for name, true in (("K1", measured_axis.K1), ("K2", measured_axis.K2), ("B", measured_axis.B)):
        assert found[name]["low"] < true < found[name]["high"]
    assert job["result"]["usable"]
    assert job["result"]["headline"].startswith("The model explains 99.")
    assert job["result"]["rms_arcsec"] == pytest.approx(measured_axis.NOISE / ARCSEC, rel=0.1)
    again = posted(client, "/api/project", state={"project": job["result"]["project"]})
    assert again["title"] == "axis"


@pytest.mark.parametrize(
    ("body", "status", "said"),
    [
        (b"no json\ntime,motor_angle\n", 422, "no JSON"),
        (b"", 422, "no JSON"),
        (b'{"state": {"gear": "CSG-40-50"}}\n', 201, "the log is empty"),
        (b'{"state": {"gear": "CSG-40-50"}}\ntime [s],motor_angle [rad]\n0,1\n1,2\n2,3\n', 201, "log"),
    ],
)
def test_a_log_that_identifies_nothing_is_refused_in_a_sentence(client, body, status, said):
    answer = client.post("/api/identify?name=run.csv", content=body)
    assert answer.status_code == status
    error = answer.json()["error"] if status == 422 else waited(client, answer.json()["id"])["error"]
    assert said in error
    assert "Traceback" not in error


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_a_small_file_that_unpacks_to_a_large_one_is_refused(client, tmp_path, suffix):
    zeros, path = np.zeros(40_000_000), tmp_path / f"bomb{suffix}"
    if suffix == ".npz":
        np.savez_compressed(path, time=zeros)
    else:
        savemat(path, {"time": zeros}, do_compression=True)
    assert path.stat().st_size < 1_000_000
    answer = client.post(f"/api/log?name=bomb{suffix}", content=path.read_bytes())
    assert answer.status_code == 422
    assert "unpacks to more than 256 MiB" in answer.json()["error"]


def test_schema_describes_every_body(client):
    posts = client.get("/api/schema").json()["post"]
    assert all(schema["additionalProperties"] is False for schema in posts.values())
    assert set(posts["/api/response"]["properties"]) == {"state", "whole"}


def test_parts_that_a_gear_has_not_are_added_and_have_numbers(client, written):
    plain = posted(client, "/api/project", state={"project": HELD})
    loop, gravity = (part for part in plain["parts"] if part["name"] in ("motor loop", "gravity"))
    assert not loop["present"]
    assert "limit" not in [part["name"] for part in plain["parts"]]  # it has one
    state = {"project": HELD, "values": {**loop["values"], **gravity["values"], "motor.loop.bandwidth": "20 Hz"}}
    with_both = posted(client, "/api/project", state=state)
    assert [part["name"] for part in with_both["parts"] if part["present"]] == ["motor loop", "gravity"]
    added = {one["name"]: one["value"] for one in with_both["parameters"] if one["added"]}
    assert added == {"motor.loop.bandwidth": 30.0, "motor.loop.damping": 0.7, "load.drag.amplitude": 44.0}
    shown = posted(client, "/api/response", state=state)
    project = written(
        HELD.replace("mode: held", "loop: {type: cascade, bandwidth: 20 Hz, damping: 0.7}").replace(
            "load: {", "load: {drag: {type: angle_torque, amplitude: 44 N*m, order: 1}, "
        )
    )
    found = project.response(coexisting=False, points=POINTS)
    np.testing.assert_allclose(np.array(shown["speed"]) * RPM, found.omega, rtol=1e-9)
    np.testing.assert_allclose(np.array(shown["oscillation_arcsec"]) * ARCSEC, found.oscillation, rtol=1e-6)
    np.testing.assert_allclose(shown["torque"], found.torque, rtol=1e-6)
    assert shown["stable"] == found.stable.tolist()


def test_every_part_can_be_added_to_a_first_project():
    parts = about(State(gear="CSG-40-50"))["parts"]
    assert {"gravity", "move"} <= {part["name"] for part in parts}
    for part in parts:
        found = about(State(gear="CSG-40-50", values=part["values"]))
        assert not found["unknown"], part["name"]
        assert {one["name"]: one["present"] for one in found["parts"]}[part["name"]]


LOOP = {"motor.loop.bandwidth": "30 Hz", "motor.loop.damping": "0.7"}
GRAVITY = {"load.drag.type": "angle_torque", "load.drag.amplitude": "400 N*m", "load.drag.order": "1"}


def test_one_curve_of_a_load_that_varies_does_not_pass():
    free = of_state(views.response, State(gear="CSG-40-50", values=LOOP))
    heavy = of_state(views.response, State(gear="CSG-40-50", values=LOOP | GRAVITY))
    low = of_state(views.response, State(gear="CSG-40-50", values=LOOP | GRAVITY | {"limit.oscillation": "50 arcsec"}))
    assert (free["passes"], heavy["passes"], low["passes"]) == (True, None, False)
    assert heavy["load_torques"] == pytest.approx([-400.0, 0.0, 400.0])
    heaviest = LOOP | GRAVITY | {"load.drag.amplitude": "1000 N*m"}
    held = of_state(views.response, State(gear="CSG-40-50", values=heaviest))
    assert held["passes"] is False
    assert held["said"].startswith("Pointing error, largest oscillation: ")
    assert held["torque_said"].startswith("Largest torque: gear 1000 N·m")


@pytest.mark.slow
def test_the_verdict_under_all_loads_is_that_of_the_speed_map():
    light = LOOP | GRAVITY | {"load.drag.amplitude": "44 N*m"}
    for values in (light, light | {"limit.oscillation": "50 arcsec"}):
        project = project_of(State(gear="CSG-40-50", values=values))
        under, found = views.allowed_under_every_load(project), sw.speed_map(project)
        np.testing.assert_allclose(under["allowed"], found.windows / RPM, rtol=1e-9)
        assert under["passes"] is under["whole"] is ("limit.oscillation" not in values)
    assert views.allowed_under_every_load(project_of(State(gear="CSG-40-50", values=LOOP))) is None


def test_both_ends_of_every_slider_of_a_loop_are_accepted():
    found = about(State(gear="CSG-40-50", values=LOOP))
    numbers = [one for one in found["parameters"] if one["name"].startswith("motor.loop.")]
    assert len(numbers) == 2
    for one in numbers:
        for end in (one["low"], one["high"]):
            project_of(State(gear="CSG-40-50", values=LOOP | {one["name"]: f"{end:g} {one['unit']}"}))


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        (HELD.replace("held", "free"), {"gravity", "move"}),
        (HELD, {"gravity", "motor loop", "move"}),
        (ARTICLE, {"limit"}),  # of a forcing
    ],
)
def test_only_parts_that_the_drive_may_have_are_offered(text, offered):
    assert {part["name"] for part in about(State(project=text))["parts"]} == offered


def test_numbers_of_an_added_part_are_assumed_until_they_are_changed():
    loop = {
        f"motor.loop.{key}": text for key, text in (("type", "cascade"), ("bandwidth", "30 Hz"), ("damping", "0.7"))
    }
    first = {one.name: one.word for one in project_of(State(project=HELD, values=loop)).sources}
    assert (first["motor.loop.bandwidth"], first["motor.loop.damping"]) == ("assumed", "assumed")
    changed = project_of(State(project=HELD, values=loop | {"motor.loop.bandwidth": "20 Hz"}))
    assert {one.name: one.word for one in changed.sources}["motor.loop.bandwidth"] == "yours"


@pytest.mark.parametrize(
    ("excess", "least", "most"),
    [
        (lambda x: x - math.log(2.00049), 1.99, 2.00049),
        (lambda x: math.log(2.00049) - x, 2.00049, 2.01),
        (lambda x: 0.3 if x > math.log(2.00049) else -0.2, 1.99, 2.00049),  # a jump
    ],
)
def test_a_value_that_meets_the_limit_is_on_its_side_of_the_crossing(excess, least, most):
    value = goals._crossing(
        excess, math.log(3.0 if excess(2.0) > 0.0 else 1.0), math.log(1.0 if excess(2.0) > 0.0 else 9.0)
    )
    assert least <= value <= most
    assert excess(math.log(value)) <= 0.0
    assert goals._crossing(lambda x: 0.1 + x * x, 0.0, 1.0) is None


def test_a_goal_is_that_of_the_changed_gear():
    text = HELD.replace("oscillation: 120 arcsec", "oscillation: 40 arcsec")
    project = project_of(State(project=text, values={"gear.K1": "2e4 N*m/rad"}))
    name = "excitation.kinematic_error.0.amplitude"
    found = goals.goal(project, name)
    met = project_of(State(project=text, values={"gear.K1": "2e4 N*m/rad", name: f"{found['value']} arcsec"}))
    curve = views.solved(met)
    assert 0.99 * 40.0 <= curve.oscillation[curve.top] / ARCSEC <= 40.0
