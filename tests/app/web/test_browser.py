"""The page in a real browser: nothing leaves this machine, nothing is complained about."""

import numpy as np
from app_page import drawn, largest, paused, pauses, until_drawn_again

SURE = "() => document.getElementById('answer').textContent.includes('How sure')"


def drag(page, name, share):
    box = page.locator(f'[id="value-{name}-slider"]').bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * share, box["y"] + box["height"] / 2, steps=8)
    page.mouse.up()


def test_dragged_slider_changes_the_curve_and_the_address_holds_it(page):
    before, rests = largest(page), pauses(page)
    drag(page, (name := "excitation.kinematic_error.0.amplitude"), 0.3)
    paused(page, rests)
    page.wait_for_function(SURE)  # which is said of the last drive
    assert f"v.{name}=" in page.url
    after, value = largest(page), page.locator(f'[id="value-{name}"]').input_value()
    assert after < 0.9 * before
    page.reload()
    page.wait_for_selector("#plot-torque[data-drawn]")
    assert largest(page) == after
    assert page.locator(f'[id="value-{name}"]').input_value() == value


def test_the_page_says_what_it_is_until_the_first_picture(browser, address, page):
    plain = browser.new_context(java_script_enabled=False).new_page()
    plain.goto(address)
    assert "a drive with a strain wave gear" in plain.locator("main").inner_text()
    assert "a drive with a strain wave gear" not in page.locator("main").inner_text()
    plain.context.close()


def test_another_gear_is_another_drive(page):
    page.select_option("#gear", "CSG-25-100")
    page.wait_for_function("() => document.getElementById('title').textContent === 'CSG-25-100'")
    assert "gear=CSG-25-100" in page.url


def test_map_is_computed_and_cancelled(page):
    page.get_by_role("tab", name="Two-parameter map").click()
    page.locator("#begin").click()
    page.wait_for_selector("#plot-map[data-drawn]")
    page.select_option("#map-count", "40")
    page.locator("#begin").click()
    page.wait_for_function("() => document.getElementById('progress').value > 0")
    page.locator("#cancel").click()
    page.wait_for_function("() => document.getElementById('stage').textContent === 'cancelled'")
    assert page.locator("#begin").is_enabled()


def test_project_script_and_data_are_downloaded(page, tmp_path):
    for button, ending, holds in (
        ("#save-project", ".yaml", "gear: CSG-40-50"),
        ("#save-script", ".py", "import strainwave as sw"),
        ('[aria-label="Save response as CSV"]', ".csv", "oscillation [arcsec]"),
        ('[aria-label="Save response as SVG"]', ".svg", "<svg"),
    ):
        with page.expect_download() as found:
            page.locator(button).click()
        path = tmp_path / found.value.suggested_filename
        found.value.save_as(path)
        assert path.suffix == ending
        assert holds in path.read_text(encoding="utf-8")


def test_dropped_log_is_shown_and_a_wrong_one_said(page):
    t = np.linspace(0.0, 4.0, 4001)
    rows = "\n".join(f"{a:.6g},{31.4 * a:.8g},{1 + 0.2 * np.cos(62.8 * a):.8g}" for a in t)
    text = "time [s],motor_angle [rad],motor_torque [N*m]\n" + rows
    drop = """([name, text]) => {
        const data = new DataTransfer();
        data.items.add(new File([text], name));
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    }"""
    page.evaluate(drop, ["run.csv", text])
    page.wait_for_selector("#plot-log-motor_torque[data-drawn]")
    assert "4001 samples" in page.locator("#answer").inner_text()
    assert page.locator("#orders td").first.inner_text().startswith("2")


def test_keyboard_moves_a_slider_and_wrong_number_is_marked(page):
    times = drawn(page)
    page.locator('[id="value-load.inertia-slider"]').focus()
    page.keyboard.press("ArrowRight")
    until_drawn_again(page, times)
    assert page.locator('[id="value-load.inertia-slider"]').get_attribute("aria-valuetext").endswith("kg·m²")
    page.locator('[id="value-load.inertia"]').fill("")
    page.wait_for_selector('[id="value-load.inertia"][aria-invalid="true"]')


def test_the_band_of_assumed_numbers_comes_after_a_pause_and_a_change_ends_it(page):
    page.wait_for_function(SURE)
    names = page.evaluate("() => document.getElementById('plot-response').data.map((one) => one.name)")
    assert {"motor held", "what assumed numbers leave open"} <= set(names)
    badge = page.locator('[id="value-load.inertia-source"]')
    assert badge.inner_text() == "assumed"
    page.locator('[id="value-load.inertia"]').fill("2")
    page.wait_for_function(f"() => !({SURE})()")
    assert badge.inner_text() == "yours"
    assert "motor held" not in page.evaluate(
        "() => document.getElementById('plot-response').data.map((one) => one.name)"
    )
    page.wait_for_function(SURE)
