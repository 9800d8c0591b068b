"""The page says what the report, the commands and its other views say of the same drive, and what it rests on."""

import re

import pytest
from app_page import DONE, DROP, address_of, said, save
from measured_axis import PROJECT, measured

SURE = "() => document.getElementById('answer').textContent.includes('How sure')"
NAMES = "(name) => document.getElementById('plot-' + name).data.map((one) => one.name)"


def opened(page, view, gear="CSG-40-50", **values):
    """A view of a gear with changed values."""
    changed = "".join(f"&v.{name.replace('__', '.')}={text}" for name, text in values.items())
    page.goto(f"{page.base}#gear={gear}&view={view}{changed.replace(' ', '+')}")


def computed(page):
    page.locator("#begin").click()
    page.wait_for_function(DONE)


@pytest.mark.parametrize(("limit", "mark", "headline"), [("900", "good", "Pass; "), ("20", "bad", "Fail")])
def test_the_page_its_speed_map_and_its_report_pass_the_same_drive(blank, tmp_path, limit, mark, headline):
    opened(blank, "response", speed__to="4000 rpm", limit__oscillation=f"{limit} arcsec")
    blank.wait_for_function(SURE)
    assert blank.locator("#answer").get_attribute("class") == mark  # 4000 rpm are above the average speed of the gear
    with blank.expect_download() as found:
        save(blank, "#save-report")
    found.value.save_as(tmp_path / "report.html")
    assert headline in (tmp_path / "report.html").read_text(encoding="utf-8")
    blank.get_by_role("tab", name="Speed map").click()
    blank.locator("#search").uncheck()
    computed(blank)
    assert (": 375 to 4000 rpm" in blank.locator("#answer").inner_text()) is (mark == "good")


def test_the_window_of_a_move_is_about_where_gravity_leaves_the_load(page):
    page.locator("#part-gravity").click()
    page.wait_for_selector('[id="value-load.drag.amplitude"]')
    page.get_by_role("tab", name="Move").click()
    page.wait_for_selector("#plot-move-speed[data-drawn]")
    error, above, below = page.evaluate("() => document.getElementById('plot-move-error').data.slice(0, 3)")
    rest = float(re.search(r"final (−?[\d.]+) arcsec", page.locator("#answer").inner_text()).group(1))
    assert rest > 100.0  # 44 N·m twist the gear and the loop
    assert rest == pytest.approx(error["y"][-1], rel=5e-3)
    assert (above["y"][-1] + below["y"][-1]) / 2 == pytest.approx(rest, rel=5e-3)
    assert above["y"][0] is None  # it begins with the end of the move


def test_a_compensation_says_what_it_assumes_and_what_other_gears_have(page):
    page.get_by_role("tab", name="Compensation").click()
    computed(page)
    page.wait_for_selector("#plot-gears[data-drawn]")
    assumed = page.locator("#assumed").inner_text()
    assert re.search(r"Assumed: samples every 250 .s, .* encoders of 16 bits \(motor\) and 24 bits \(load\)", assumed)
    said(page, "gear 20 % softer than the model: ")
    said(page, "Motor torque up to ")
    assert page.evaluate(NAMES, "compensation-time") == page.evaluate(NAMES, "gears") == ["before", "after"]


def test_a_log_that_the_model_does_not_explain_says_so_first(blank):
    blank.goto(address_of(blank.base, PROJECT))
    blank.wait_for_selector("#plot-torque[data-drawn]")
    log = measured(line=(1.37, 3e-4))  # of an order that the project does not know
    rows = "\n".join(",".join(f"{value:.12g}" for value in row) for row in zip(*log.values(), strict=True))
    blank.evaluate(DROP, ["run.csv", f"time [s],motor_angle [rad],load_angle [rad]\n{rows}\n"])
    blank.wait_for_selector("#plot-log-load_angle[data-drawn]")
    assert blank.locator(".plot").first.get_attribute("id") == "plot-log-dynamic_error"
    blank.locator("#begin").click()
    said(blank, "which the model lacks")
    answer = blank.locator("#answer").inner_text()
    assert answer.startswith("The model explains only ")
    assert "The log shows a line of order 1.37 of the motor's turn" in answer
    assert blank.locator("#answer").get_attribute("class") == "bad"
    assert blank.locator("#use").is_disabled()
    assert blank.evaluate("() => document.getElementById('plots').firstElementChild.id") == "identified-drive"


def test_the_speed_map_has_the_loads_of_the_project_or_those_that_are_written(blank):
    opened(blank, "speed-map")
    blank.locator("#search").uncheck()
    computed(blank)
    said(blank, "Allowed under every load: ")
    blank.locator("#loads").fill("-178; -44,5; 0")
    blank.locator("#begin").click()
    blank.wait_for_function("() => document.getElementById('status').textContent.includes('-44,5')")
    blank.locator("#loads").fill("-178; -44.5; 0")
    blank.locator("#begin").click()
    blank.wait_for_function("() => document.getElementById('plot-speed-map')._fullLayout.yaxis.tickvals.length === 3")
    said(blank, "Allowed under every load: ")
    axis = blank.evaluate(
        "() => { const { type, tickvals, ticktext } = document.getElementById('plot-speed-map')._fullLayout.yaxis;"
        " return [type, [...tickvals], [...ticktext]]; }"
    )
    assert axis == ["linear", [-178, -44.5, 0], ["−178", "−44.5", "0"]]


def test_a_first_start_names_the_drive_and_says_what_is_compiled(blank):
    held, answers = [], []
    blank.route("**/api/project", lambda route: held.append(route))
    blank.route("**/api/response", lambda route: answers.append(route))
    blank.route("**/api/status", lambda route: route.fulfill(json={"compiling": "compiling the response, about 20 s"}))
    with blank.expect_request("**/api/project"):
        opened(blank, "response", "CSG-25-100")
    assert blank.locator("#gear").input_value() == "CSG-25-100"
    assert "The first start on a machine" in blank.locator("#first").inner_text()
    held.pop().continue_()
    blank.wait_for_function("() => document.getElementById('status').textContent.includes('about 20 s')")
    answers.pop().continue_()
    blank.wait_for_selector("#plot-torque[data-drawn]")
    assert blank.locator("#status").inner_text() == ""


def test_the_range_for_assumed_numbers_comes_before_the_speeds_under_all_loads(page):
    held = []
    page.route("**/api/loads", lambda route: held.append(route))
    page.locator("#part-gravity").click()
    page.wait_for_function(SURE)
    said(page, "The speeds allowed under every load are being computed.")
    assert "range for assumed numbers<br>under the worst of 3 load torques" in page.evaluate(NAMES, "response")
    while not held:
        page.wait_for_timeout(50)
    held.pop().continue_()
    said(page, "Allowed under every load: 375 to 3000 rpm.")


def test_a_crosshair_goes_through_both_pictures(page):
    box = page.locator("#plot-response .nsewdrag").bounding_box()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + 0.5 * box["height"])
    for name in ("response", "torque"):
        page.wait_for_selector(f"#plot-{name} .hoverlayer .spikeline", state="attached")
    page.mouse.move(1, 1)
    page.wait_for_selector("#plot-torque .hoverlayer .spikeline", state="detached")
