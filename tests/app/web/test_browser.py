"""The page in a real browser: nothing leaves this machine, nothing is complained about."""

import re

import pytest
from app_page import drawn, largest, paused, pauses, save, until_drawn_again

SURE = "() => document.getElementById('answer').textContent.includes('How sure')"

RANGE: dict = {key: [500.0, 3000.0] for key in ("speed", "low_arcsec", "high_arcsec")}
RANGE |= {"together": "all", "held": None}


def drag(page, name, share):
    slider = page.locator(f'[id="value-{name}-slider"]')
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * share, box["y"] + box["height"] / 2, steps=8)
    page.mouse.up()


def test_dragged_slider_changes_the_curve_and_the_address_holds_it(page):
    page.wait_for_function(SURE)
    before = largest(page)
    drag(page, (name := "excitation.accuracy"), 0.3)
    page.wait_for_function(f"() => !({SURE})()")
    page.wait_for_function(SURE)  # which is said of the last drive
    assert f"v.{name}=" in page.url
    after, value = largest(page), page.locator(f'[id="value-{name}"]').input_value()
    assert after < 0.9 * before
    page.reload()
    page.wait_for_selector("#plot-torque[data-drawn]")
    assert largest(page) == after
    assert page.locator(f'[id="value-{name}"]').input_value() == value


EVENT = """([name, at]) => {
    const slider = document.getElementById(`value-${name}-slider`);
    slider.value = at;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
}"""
SLOW = "() => { let now = Date.now(); Date.now = () => (now += 1); }"  # of a loaded machine too


def test_a_slider_draws_while_it_is_dragged_and_its_last_value_at_the_end(page):
    name, held, lost = "load.inertia", [], []
    page.wait_for_function(SURE)
    page.evaluate(SLOW)
    page.route("**/api/response", lambda route: held.append(route))
    page.on("requestfailed", lambda request: "/api/response" in request.url and lost.append(request.url))

    def answered():
        was = drawn(page, "response")
        while not held:
            page.wait_for_timeout(5)
        (route,) = held  # one request is under way
        held.clear()
        route.continue_()
        until_drawn_again(page, was, "response")

    begin = int(drawn(page, "response"))
    for i in range(40):  # an event every 16 ms, and an answer every 48 ms
        page.evaluate(EVENT, [name, 500 + i])
        if i % 3 == 2:
            answered()
    assert int(drawn(page, "response")) - begin >= 12
    answered()
    answered()  # the newest value
    page.wait_for_function(SURE)
    assert int(drawn(page, "response")) - begin <= 17  # 15 answers, the last of them again with its band
    assert not held
    assert not lost
    value = page.locator(f'[id="value-{name}"]').input_value()
    assert f"v.{name}={value}+" in page.url
    with page.expect_response("**/api/response") as last:
        page.unroute("**/api/response")
        page.evaluate(EVENT, [name, 539])
    assert last.value.json()["largest"]["oscillation_arcsec"] == pytest.approx(largest(page), rel=5e-3)


def test_the_page_says_what_it_is_until_the_first_picture(browser, address, page):
    plain = browser.new_context(java_script_enabled=False).new_page()
    plain.goto(address)
    assert "a drive with a strain wave gear" in plain.locator("main").inner_text()
    assert "a drive with a strain wave gear" not in page.locator("main").inner_text()
    plain.context.close()


def test_a_view_chosen_before_the_drive_is_there_is_shown_with_it(blank):
    blank.route("**/api/project", lambda route: blank.wait_for_timeout(1000) or route.continue_())
    blank.goto(blank.base)
    blank.locator("#tab-motion").click()
    blank.wait_for_selector("#plot-time[data-drawn]")
    assert blank.locator("#tab-motion").get_attribute("aria-selected") == "true"


def test_project_script_and_data_are_downloaded(page, tmp_path):
    times = drawn(page)
    page.emulate_media(color_scheme="dark")
    until_drawn_again(page, times)
    for button, ending, holds in (
        ("#save-project", ".yaml", "gear: CSG-40-50"),
        ("#save-script", ".py", "import strainwave as sw"),
        ('[aria-label="Save response as CSV"]', "-response.csv", "oscillation [arcsec]"),
        ('[aria-label="Save response as SVG"]', "-response.svg", "<svg"),
    ):
        with page.expect_download() as found:
            save(page, button)
        path = tmp_path / found.value.suggested_filename
        found.value.save_as(path)
        assert path.name == f"CSG-40-50{ending}"
        assert holds in (text := path.read_text(encoding="utf-8"))
    assert ">CSG-40-50</text>" in text
    assert "rgb(255, 255, 255)" in text  # a light page, as it is printed
    assert "rgb(20, 23, 27)" not in text


def test_the_band_of_assumed_numbers_comes_after_a_pause_and_a_change_ends_it(page):
    page.wait_for_function(SURE)
    names = page.evaluate("() => document.getElementById('plot-response').data.map((one) => one.name)")
    assert {"motor held", "range for assumed numbers"} <= set(names)
    badge = page.locator('[id="value-load.inertia-source"]')
    assert badge.inner_text() == "assumed"
    page.locator('[id="value-load.inertia"]').fill("2")
    page.wait_for_function(f"() => !({SURE})()")
    assert badge.inner_text() == "yours"
    assert "motor held" not in page.evaluate(
        "() => document.getElementById('plot-response').data.map((one) => one.name)"
    )
    axis = "() => document.getElementById('plot-response')._fullLayout.yaxis.range"
    assert page.evaluate(axis)[0] == 0.0
    assert page.evaluate(axis)[1] > largest(page)
    page.wait_for_function(SURE)


@pytest.mark.parametrize("met", [True, False])
def test_a_drive_with_assumed_numbers_passes_where_their_range_does(page, met):
    content = RANGE | {"how_sure": ["one", "all"], "met": met}
    held = []
    page.route("**/api/sureness", lambda route: held.append(route))
    page.locator('[id="value-limit.oscillation"]').fill("600")
    says = "text => document.getElementById('answer').textContent.includes(text)"
    page.wait_for_function(says, arg="limit of 600 arcsec. The effect of the assumed values is being computed.")
    assert page.locator("#answer").get_attribute("class") == ""
    page.route("**/api/sureness", lambda route: route.fulfill(json=content))
    for route in held:  # that of the page as it opened may be here, and that of 600 arcsec still to come
        route.fulfill(json=content)
    page.wait_for_function(says, arg="limit of 600 arcsec. How sure: all.")
    assert page.locator("#answer").get_attribute("class") == ("good" if met else "")


def test_the_torque_of_one_curve_says_that_the_load_is_left_out(page):
    before = drawn(page)
    page.locator("#part-gravity").click()
    until_drawn_again(page, before)
    names = page.evaluate("() => document.getElementById('plot-torque').data.map((one) => one.name)")
    assert "largest without the load's torque, stable" in names
    (need,) = (
        text for text in page.locator("#remarks li").all_inner_texts() if text.startswith("Largest torque: gear")
    )
    assert re.match(r"Largest torque: gear [\d.]+ N·m, motor [\d.]+ N·m or more: vibration is known", need)
    assert "alone. The speeds allowed under every load are being computed." in page.inner_text("#answer")


def test_a_slow_picture_does_not_erase_what_is_said_of_assumed_numbers(blank):
    content = RANGE | {"how_sure": ["one", "all", "lost"], "met": False}
    blank.route("**/api/sureness", lambda route: route.fulfill(json=content))
    blank.goto(blank.base)
    blank.wait_for_function(SURE)
    blank.evaluate(
        """() => {
            const react = window.Plotly.react;
            window.Plotly.react = async (box, ...more) => {
                if (box.id === "plot-torque") await new Promise((resolve) => setTimeout(resolve, 1000));
                return react(box, ...more);
            };
        }"""
    )
    blank.locator('[id="value-limit.oscillation"]').fill("50")
    ends = "text.includes('limit of 50 arcsec') && text.endsWith('How sure: all.')"
    blank.wait_for_function(f"() => {{ const text = document.getElementById('answer').textContent; return {ends}; }}")
    assert blank.locator("#remarks li").all_inner_texts()[-3:] == content["how_sure"]


def test_a_view_that_is_left_while_it_is_drawn_adds_nothing_to_the_next(page):
    page.route("**/api/sureness", lambda route: route.fulfill(json=RANGE | {"how_sure": ["all"], "met": False}))
    page.evaluate(
        """() => {
            const react = window.Plotly.react;
            window.Plotly.react = (box, ...more) => {
                if (box.id === "plot-move-error") document.getElementById("tab-response").click();
                return react(box, ...more);
            };
        }"""
    )
    rests = pauses(page)
    page.get_by_role("tab", name="Move").click()
    page.wait_for_function("() => document.body.dataset.view === 'move'")
    page.wait_for_selector("#plot-torque[data-drawn]")
    paused(page, rests)
    page.wait_for_function(SURE)
    names = page.evaluate("() => [...document.querySelectorAll('.plot')].map((box) => box.id)")
    assert names == ["plot-response", "plot-torque"]


def test_a_picture_is_dimmed_while_a_newer_answer_is_under_way(page):
    held = []
    page.route("**/api/response", lambda route: held.append(route))
    page.locator('[id="value-load.inertia"]').fill("2")
    page.wait_for_selector("#plots.waiting")
    assert page.evaluate("() => Number(getComputedStyle(document.getElementById('plot-response')).opacity)") < 1.0
    held[0].continue_()
    page.wait_for_selector("#plots:not(.waiting)")
    assert page.evaluate("() => Number(getComputedStyle(document.getElementById('plot-response')).opacity)") == 1.0


def test_the_pictures_of_a_move_show_the_same_times(page):
    page.get_by_role("tab", name="Move").click()
    page.wait_for_selector("#plot-move-speed[data-drawn]")
    page.evaluate("() => window.Plotly.relayout('plot-move-motor', {'xaxis.range[0]': 0.1, 'xaxis.range[1]': 0.3})")
    for name in ("error", "torque", "speed"):
        axis = f"() => document.getElementById('plot-move-{name}').layout.xaxis.range"
        assert page.evaluate(axis) == [0.1, 0.3]


def test_a_job_names_the_pictures_that_it_will_show(page):
    page.get_by_role("tab", name="Tuning").click()
    promised = page.locator(".awaited").all_inner_texts()
    assert [text.partition(":")[0] for text in promised] == ["Pointing", "Tracking", "Disturbance"]
    page.get_by_role("tab", name="Speed map").click()
    assert page.locator(".awaited").count() == 1
    page.locator("#search").uncheck()
    page.locator("#begin").click()
    page.wait_for_selector("#plot-speed-map[data-drawn]")
    assert page.locator(".awaited").count() == 0


def test_the_script_of_the_page_repeats_its_session(page, tmp_path):
    rests = pauses(page)
    page.locator('[id="value-load.inertia"]').fill("2")
    paused(page, rests)
    page.get_by_role("tab", name="Speed map").click()  # is looked at, and not computed
    page.get_by_role("tab", name="Motion at a speed").click()
    page.locator("#speed").fill("900")
    page.wait_for_function("() => document.getElementById('answer').textContent.includes('900 rpm')")
    with page.expect_download() as found:
        save(page, "#save-script")
    found.value.save_as(tmp_path / "session.py")
    lines = (tmp_path / "session.py").read_text(encoding="utf-8").partition("no file is written\n")[2].splitlines()
    response, changed = "found = project.response(", "project = sw.replaced(drive, {'load.inertia': '2 kg*m^2'}"
    begins = (response, changed, response, "found = sw.drive_motion(project, 900")
    assert [line.strip().startswith(begin) for line, begin in zip(lines, begins, strict=False)] == [True] * len(begins)
