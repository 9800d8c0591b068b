"""Editing a drive on the page: texts with units, refusals at the field, undo, Back, another gear, damaged links."""

import re

import pytest
from app_page import DROP, address_of, drawn, largest, paused, pauses, shown, until_drawn_again
from one_joint import HELD

ACCURACY = "excitation.accuracy"
INERTIA = "() => document.getElementById('value-load.inertia').value"
ANSWER = "() => document.getElementById('answer').textContent"


def field(page, name):
    return page.locator(f'[id="value-{name}"]')


def typed(page, name, text, said=None):
    """Write a text into a field, and wait for what the answer then says, or for another picture."""
    before, rests = drawn(page), pauses(page)
    field(page, name).fill(text)
    if said is None:
        until_drawn_again(page, before)
    else:
        page.wait_for_function(f"text => ({ANSWER})().includes(text)", arg=said)
    paused(page, rests)


def verdict(page):
    """What the answer says before the range for assumed numbers, which may be computed or not yet."""
    return re.split(" The range for| How sure", page.locator("#answer").inner_text())[0]


@pytest.mark.parametrize(
    ("text", "same", "beside"),
    [("7800 kg*cm^2", "0.78", "= 0.78 kg·m²"), ("1,5", "1.5", "kg·m²"), ("1,5 kg*m^2", "1.5", "kg·m²")],
)
def test_a_field_takes_text_with_a_unit_and_keeps_what_was_typed(page, text, same, beside):
    typed(page, "load.inertia", same)
    wanted = verdict(page)
    typed(page, "load.inertia", "3")
    assert verdict(page) != wanted
    typed(page, "load.inertia", text)
    assert verdict(page) == wanted
    assert field(page, "load.inertia").input_value() == text
    assert field(page, "load.inertia").locator("xpath=../span[@class='unit']").inner_text() == beside
    at = [page.locator('[id="value-load.inertia-slider"]').input_value()]
    typed(page, "load.inertia", same)
    assert at == [page.locator('[id="value-load.inertia-slider"]').input_value()]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("-1", "'-1 kg*m^2' is not positive"),
        ("12 kg", "'12 kg' is not an inertia"),
        ("1,500", "has a comma"),
        ("", "does not begin with a finite number"),
        ("20 Nm", "is not an inertia"),
    ],
)
def test_what_is_refused_is_marked_at_its_field_and_in_the_answer(page, text, said):
    typed(page, "load.inertia", text, said)
    assert field(page, "load.inertia").get_attribute("aria-invalid") == "true"
    assert field(page, "load.inertia").input_value() == text
    wrong = page.locator('[id="value-load.inertia-wrong"]')
    assert said in wrong.inner_text()
    assert wrong.get_attribute("id") in field(page, "load.inertia").get_attribute("aria-describedby")
    assert page.locator("#answer").get_attribute("class") == "bad"
    assert "argest oscillation" not in page.locator("#answer").inner_text()
    assert page.locator("#plots").get_attribute("class") == "stale"
    assert page.locator("#answer").bounding_box()["y"] < 120
    typed(page, "load.inertia", "1")
    assert field(page, "load.inertia").get_attribute("aria-invalid") == "false"
    assert "stale" not in (page.locator("#plots").get_attribute("class") or "")
    assert wrong.inner_text() == ""


def test_arrows_change_a_field_by_one_and_ten_percent(page):
    times = drawn(page)
    field(page, "load.inertia").press("ArrowUp")
    assert field(page, "load.inertia").input_value() == "1.01"
    field(page, "load.inertia").press("Shift+ArrowDown")
    assert field(page, "load.inertia").input_value() == "0.909"
    until_drawn_again(page, times)
    field(page, "excitation.load_torque.mean").press("ArrowDown")
    assert float(field(page, "excitation.load_torque.mean").input_value()) == -1.0


def test_undo_and_redo_take_a_change_back_and_forth(page):
    first = largest(page)
    typed(page, ACCURACY, "10")
    second = largest(page)
    assert second < 0.7 * first
    typed(page, "load.inertia", "2")
    page.keyboard.press("Control+z")
    page.wait_for_function(f"n => ({ANSWER})().includes(n + ' arcsec')", arg=f"{second:g}")
    assert field(page, "load.inertia").input_value() == "1"
    page.locator("#undo").click()
    page.wait_for_function(f"n => ({ANSWER})().includes(n + ' arcsec')", arg=f"{first:g}")
    assert field(page, ACCURACY).input_value() == "59.8"
    assert page.locator("#undo").is_disabled()
    page.keyboard.press("Control+Shift+z")
    page.wait_for_function(f"n => ({ANSWER})().includes(n + ' arcsec')", arg=f"{second:g}")
    assert field(page, ACCURACY).input_value() == "10"
    assert page.locator("#redo").is_enabled()
    page.keyboard.press("Control+Y")  # as with Caps Lock
    page.wait_for_function(f"() => ({INERTIA})() === '2'")
    page.get_by_role("tab", name="Motion at a speed").click()
    speed = page.locator("#speed")
    before = speed.input_value()
    speed.fill("1200")
    speed.press("Control+z")  # undoes what is typed there
    assert speed.input_value() == before
    assert field(page, "load.inertia").input_value() == "2"


def test_a_drive_is_renamed_and_keeps_its_title_with_another_gear(page):
    page.once("dialog", lambda dialog: dialog.accept("2nd axis"))
    page.locator("#rename").click()
    page.wait_for_function("() => document.title === '2nd axis · strainwave'")
    assert "v.title=2nd+axis" in page.url
    page.select_option("#gear", "CSG-25-100")
    page.wait_for_function("() => location.hash.includes('CSG-25-100')")
    assert page.locator("#title").inner_text() == "2nd axis"


def test_without_damping_the_resonance_is_said_and_the_picture_stays_near_the_limit(blank):
    blank.goto(address_of(blank.base, HELD))
    shown(blank)
    typed(blank, "damping.ratio", "0", "The response grows without bound at")
    assert blank.locator("#answer").get_attribute("class") == "bad"
    assert "within the limit" not in blank.locator("#answer").inner_text()
    top = "(name) => document.getElementById('plot-' + name).layout.yaxis.range[1]"
    assert blank.evaluate(top, "response") < 6 * 120
    assert blank.evaluate(top, "torque") < 5000


def test_back_goes_to_the_drive_before_the_last_pause(page):
    first = largest(page)
    typed(page, ACCURACY, "10")
    rests = pauses(page)
    page.get_by_role("tab", name="Motion at a speed").click()
    page.wait_for_selector("#plot-phase[data-drawn]")
    paused(page, rests)
    page.go_back()
    page.wait_for_selector("#plot-torque[data-drawn]")
    assert field(page, ACCURACY).input_value() == "10"
    page.go_back()
    page.wait_for_function(f"n => ({ANSWER})().includes(n + ' arcsec')", arg=f"{first:g}")
    assert field(page, ACCURACY).input_value() == "59.8"


def test_what_another_gear_keeps_untouched_stays_assumed(page):
    badge = lambda name: page.locator(f'[id="value-{name}-source"]').inner_text()  # noqa: E731
    typed(page, "damping.ratio", "4")
    before = drawn(page)
    page.select_option("#gear", "CSG-25-100")
    until_drawn_again(page, before)
    assert field(page, "load.inertia").input_value() == "1"
    assert (badge("load.inertia"), badge("damping.ratio")) == ("assumed", "yours")
    typed(page, "load.inertia", "2")
    assert badge("load.inertia") == "yours"


def test_another_gear_keeps_the_axis_until_its_defaults_are_taken(page):
    typed(page, "load.inertia", "3.7")
    typed(page, "damping.ratio", "4")
    page.locator("#part-gravity").click()
    page.wait_for_selector('[id="value-load.drag.amplitude"]')
    typed(page, "motor.loop.bandwidth", "25")
    typed(page, "load.drag.amplitude", "20")
    page.select_option("#gear", "CSG-25-100")
    page.wait_for_function("() => document.getElementById('title').textContent === 'CSG-25-100'")
    kept = {"load.inertia": "3.7", "damping.ratio": "4", "motor.loop.bandwidth": "25", "limit.oscillation": "59.8"}
    kept |= {"load.drag.amplitude": "20", "motor.inertia": "0.413"}  # the wave generator is that of the other gear
    assert {name: field(page, name).input_value() for name in kept} == kept
    typed(page, "motor.inertia", "0.9")
    page.select_option("#gear", "CSG-32-120")
    page.wait_for_function("() => document.getElementById('title').textContent === 'CSG-32-120'")
    assert field(page, "motor.inertia").input_value() == "0.9"
    page.locator("#reset").click()
    page.wait_for_function("() => document.getElementById('value-load.inertia').value !== '3.7'")
    assert not page.locator('[id="value-load.drag.amplitude"]').count()


@pytest.mark.parametrize(
    ("link", "said"),
    [
        ("project=!!!", "The link is damaged"),
        ("project=VY3BCsIwEETv-Yo9eGzSWBXBm", "The link is damaged"),
        ("gear=CSG-99", "The page shows CSG-40-50 instead"),
        ("gear=CSG-40-50&v.speeed.from=1+rpm", "has no 'speeed.from'"),
    ],
)
def test_a_damaged_link_says_so_and_keeps_the_controls(blank, link, said):
    blank.goto(f"{blank.base}#{link}")
    blank.wait_for_selector("#plot-torque[data-drawn]")
    assert said in blank.locator("#status").inner_text()
    assert field(blank, "load.inertia").input_value() == "1"
    typed(blank, "load.inertia", "2")


def test_a_wrong_value_in_the_address_is_told_at_its_field(blank):
    blank.goto(f"{blank.base}#gear=CSG-25-100&v.load.inertia=-1+kg*m^2&v.damping.ratio=4+%25")
    blank.wait_for_function("() => document.getElementById('value-load.inertia')")
    blank.wait_for_function(f"() => ({ANSWER})().includes('is not positive')")
    assert blank.locator("#gear").input_value() == "CSG-25-100"
    assert field(blank, "load.inertia").get_attribute("aria-invalid") == "true"
    assert field(blank, "damping.ratio").input_value() == "4"
    field(blank, "load.inertia").fill("0.3")
    blank.wait_for_selector("#plot-torque[data-drawn]")


def test_a_project_dropped_before_the_first_answer_is_shown(blank):
    waiting = []
    blank.route("**/api/project", lambda route: route.continue_() if waiting else waiting.append(route))
    with blank.expect_request("**/api/project"):
        blank.goto(blank.base)
    blank.evaluate(DROP, ["mine.yaml", HELD.replace("title: CSG-40-50", "title: mine")])
    shown(blank)
    assert blank.locator("#title").inner_text() == "mine"
    assert blank.locator("#status").inner_text() == ""
    assert "#project=" in blank.url


def test_another_project_of_the_same_numbers_shows_its_own_sources(blank):
    blank.goto(address_of(blank.base, HELD + "sources: {load: assumed}\n"))
    shown(blank)
    badge = blank.locator('[id="value-load.inertia-source"]')
    assert badge.inner_text() == "assumed"
    blank.evaluate(DROP, ["mine.yaml", HELD.replace("title: CSG-40-50", "title: mine") + "sources: {load: measured}\n"])
    blank.wait_for_function("() => document.getElementById('title').textContent === 'mine'")
    assert badge.inner_text() == "measured"
