"""Jobs go on while another view is shown, the report waits beside a map; a log whose names are not known."""

import numpy as np
from app_page import DROP, MANY_LOADS, save


def begun(page):
    page.get_by_role("tab", name="Speed map").click()
    page.wait_for_selector("#begin")
    page.fill("#loads", MANY_LOADS)
    page.locator("#begin").click()
    page.wait_for_function("() => document.getElementById('progress').value > 0")


def test_a_map_goes_on_while_another_view_is_shown_and_its_picture_stays(held_page):
    page = held_page
    begun(page)
    page.get_by_role("tab", name="Response").click()
    assert "busy" in page.locator("#tab-speed-map").get_attribute("class")
    page.wait_for_selector("#plot-torque[data-drawn]")
    page.wait_for_selector("#tab-speed-map:not(.busy)")
    page.get_by_role("tab", name="Speed map").click()
    page.wait_for_selector("#plot-speed-map[data-drawn]")
    assert page.locator("#stage").inner_text() == "done"
    assert "Allowed under every load: " in page.locator("#answer").inner_text()


def test_a_report_waits_for_a_map_and_says_so(held_page):
    page = held_page
    begun(page)
    save(page, "#save-report")
    stage = page.locator("#report-stage")
    page.wait_for_function("() => document.getElementById('report-stage').textContent.includes('waiting for')")
    assert stage.inner_text() == "waiting for a speed map of this page or of another"
    assert page.locator("#save-report").inner_text() == "Cancel report"
    assert page.locator("#save-report").bounding_box()["y"] < 250
    share = page.evaluate("() => document.getElementById('progress').value")
    page.wait_for_function("was => document.getElementById('progress').value > was", arg=share)
    save(page, "#save-report")
    page.wait_for_function("() => document.getElementById('save-report').textContent === 'Report'")
    page.locator("#cancel").click()
    page.wait_for_function("() => document.getElementById('stage').textContent === 'cancelled'")


def test_columns_of_a_log_without_known_names_are_named_in_a_table(page):
    t = np.linspace(0.0, 4.0, 4001)
    rows = "\n".join(f"{1e3 * a:.8g},{31.4 * a:.8g},{1 + 0.2 * np.cos(62.8 * a):.8g}" for a in t)
    page.evaluate(DROP, ["run.csv", "k1,k2,k3\n" + rows])
    page.wait_for_selector("#columns[open]")
    assert page.locator("#answer").get_attribute("class") == "bad"
    assert "columns=" not in page.locator("#answer").inner_text()
    for place, channel in ((1, "time"), (2, "motor_angle"), (3, "motor_torque")):
        page.get_by_label(f"channel of column {place}").select_option(channel)
    page.get_by_label("unit of column 1").fill("ms")
    page.locator("#read-so").click()
    page.wait_for_selector("#plot-log-motor_torque[data-drawn]")
    assert "4001 samples, 0 to 4 s" in page.locator("#answer").inner_text()
    assert page.locator("#orders td").first.inner_text().startswith("2")
    page.get_by_role("tab", name="Response").click()
    page.wait_for_selector("#plot-torque[data-drawn]")
    page.get_by_role("tab", name="Log").click()
    page.wait_for_selector("#plot-log-motor_torque[data-drawn]")


def test_a_log_that_does_not_fit_says_so_and_the_page_goes_on(page):
    page.evaluate(DROP, ["run.csv", "\x00\x01\x02"])
    page.wait_for_function("() => document.getElementById('answer').textContent.startsWith('run.csv: ')")
    assert page.locator("#answer").get_attribute("class") == "bad"
    page.wait_for_selector("#log-file")
    page.get_by_role("tab", name="Response").click()
    page.wait_for_selector("#plot-torque[data-drawn]")
