"""What helps to decide: the answer in sight, values that meet the limit, curves side by side, gains."""

import pytest
from app_page import drawn, largest, said, until_drawn_again

THREE_DIGITS = 5e-3  # relative, of an answer
FOCUS = "() => document.activeElement.id"


@pytest.mark.parametrize(("width", "height"), [(375, 812), (1280, 800), (2560, 1440)])
def test_the_answer_stays_in_sight_at_every_slider(page, width, height):
    page.set_viewport_size({"width": width, "height": height})
    last = page.locator("#sliders .value").last
    page.locator("#part-gravity").scroll_into_view_if_needed()
    if width == 375:
        page.locator("#small").wait_for()
    inside = "height => { const box = answer.getBoundingClientRect(); return box.top >= 0 && box.bottom <= height; }"
    page.wait_for_function(inside, arg=height)
    page.wait_for_function("width => document.documentElement.scrollWidth <= width", arg=width)  # pictures are redrawn
    if width == 375:
        assert page.locator("#small").bounding_box()["y"] < 0.4 * height
    assert not last.is_visible()  # the stiffnesses of the catalogue are folded


def test_pictures_side_by_side_stay_in_their_columns_from_the_first_on(blank):
    blank.set_viewport_size({"width": 2560, "height": 1440})
    blank.goto(f"{blank.base}#gear=CSG-40-50&view=response")
    blank.wait_for_selector("#plot-response[data-drawn]")
    blank.wait_for_selector("#plot-torque[data-drawn]")
    within = "() => [...document.querySelectorAll('.plot')].every((box) => box._fullLayout.width < box.clientWidth + 1)"
    blank.wait_for_function(within)


def test_a_phone_shows_the_whole_answer_with_gravity_and_what_is_assumed(page):
    page.set_viewport_size({"width": 375, "height": 812})
    page.locator("#part-gravity").click()
    said(page, "Allowed under every load: 375 to 3000 rpm. How sure")
    assert page.evaluate("() => answer.scrollHeight <= answer.clientHeight")
    assert page.locator("#answer").get_attribute("class") == ""  # the assumed numbers may lead beyond the limit
    page.locator('[id="value-limit.oscillation"]').fill("200")
    said(page, "within the limit of 200 arcsec under this load alone. Allowed under every load: ")
    page.wait_for_selector("#answer.good")
    page.route("**/api/loads", lambda route: route.fulfill(status=422, json={"error": "it takes too long"}))
    page.locator('[id="value-limit.oscillation"]').fill("210")
    said(page, "No result for all loads: it takes too long.")


def test_a_mark_on_a_slider_is_the_value_that_meets_the_limit(held_page):
    page = held_page
    assert largest(page) > 130
    mark = page.locator('[aria-label^="Set damping ratio"]')
    mark.wait_for()
    assert "oscillation at the limit" in mark.get_attribute("aria-label")
    times = drawn(page)
    mark.click()
    until_drawn_again(page, times)
    assert page.evaluate(FOCUS) == "value-damping.ratio-slider"
    assert page.locator('[id="value-damping.ratio"]').input_value() != "3"
    assert largest(page) == pytest.approx(120, rel=2e-3)


def test_a_pinned_curve_stays_beside_that_of_another_gear(page):
    before = largest(page)
    page.locator("#pin").click()
    page.wait_for_selector("#pins")
    page.select_option("#gear", "CSG-25-100")
    page.wait_for_function("() => document.getElementById('title').textContent === 'CSG-25-100'")
    page.wait_for_function("() => document.querySelector('#pins').textContent.includes('load.inertia')")
    rows = page.locator("#pins tr").all_inner_texts()
    assert rows[2].startswith("1: CSG-40-50")
    now, pinned = (float(row.split("\t")[2]) for row in rows[1:])
    assert pinned == pytest.approx(before, rel=THREE_DIGITS)
    assert now == pytest.approx(largest(page), rel=THREE_DIGITS)
    names = page.evaluate("() => document.getElementById('plot-response').data.map((one) => one.name)")
    assert {"1: CSG-40-50", "before"} <= set(names)
    page.locator("#unpin").click()
    page.wait_for_selector("#pins", state="detached")


def test_zoom_of_one_picture_is_that_of_the_other_and_goes_back(page):
    ranges = "() => ['response', 'torque'].map((n) => document.getElementById('plot-' + n).layout.xaxis.range)"
    whole = page.evaluate(ranges)
    page.evaluate("() => window.Plotly.relayout('plot-response', {'xaxis.range[0]': 1000, 'xaxis.range[1]': 2000})")
    page.wait_for_function("() => document.getElementById('plot-torque').layout.xaxis.range[0] === 1000")
    page.locator("#whole").click()
    page.wait_for_function("() => document.getElementById('plot-torque').layout.xaxis.autorange")
    assert page.evaluate(ranges) == whole


def test_a_move_is_edited_and_its_motor_torque_is_shown(page):
    page.get_by_role("tab", name="Move").click()
    page.wait_for_selector("#plot-move-motor[data-drawn]")
    said(page, "Move of 0.6 s. Settling time: 0.01985 s, to within 59.8 arcsec of the final error.")
    said(page, "Pointing error: largest 212 arcsec")
    said(page, "The error in the move exceeds the limit of 59.8 arcsec.")
    assert page.locator("#answer").get_attribute("class") == ""
    page.locator("#edit-move").click()
    page.wait_for_selector('[id="value-move.profile.0.time"]')
    page.locator('[id="value-move.profile.0.time"]').fill("900 ms")
    said(page, "Move of 0.9 s.")
    before = page.locator("#answer").inner_text()
    page.locator("#move-type").focus()
    page.select_option("#move-type", "trapezoid")
    page.wait_for_function("was => document.getElementById('answer').textContent !== was", arg=before)
    names = page.evaluate("() => document.getElementById('plot-move-error').data.map((one) => one.name)")
    assert {"pointing error", "settling window", "limit"} <= set(names)
    assert page.evaluate(FOCUS) == "move-type"


def test_gains_are_tuned_shown_before_and_after_and_taken(blank):
    blank.goto(f"{blank.base}#gear=CSG-40-50&view=tuning&v.motor.loop.bandwidth=30+Hz&v.motor.loop.damping=0.7")
    blank.locator("#begin").click()
    blank.wait_for_selector("#plot-tuning[data-drawn]")
    names = blank.evaluate("() => document.getElementById('plot-tuning').data.map((one) => one.name)")
    assert {"before", "after"} <= set(names)
    texts = blank.locator("#tuned th:not(:first-child)").all_inner_texts()
    assert texts == ["file", "rule", "recommended"]
    assert "K_p [N·m·s/rad]" in blank.locator("#tuned td:first-child").all_inner_texts()
    blank.set_viewport_size({"width": 375, "height": 812})
    blank.wait_for_function("() => tuned.scrollWidth <= tuned.clientWidth && tuned.clientWidth < 375")
    blank.locator("#use").click()
    blank.wait_for_function("() => location.hash.startsWith('#project=')")


def test_a_tuning_without_a_loop_says_what_is_missing(held_page):
    page = held_page
    page.get_by_role("tab", name="Tuning").click()
    page.locator("#begin").click()
    page.wait_for_function("() => document.getElementById('status').textContent.includes('loop')")
