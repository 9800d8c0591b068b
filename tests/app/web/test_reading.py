"""The page without a mouse, without colours and without motion; every view from its address; what is taken along."""

import re

import pytest
from app_page import DONE, DROP, drawn, largest, save, until_drawn_again

LAST = {
    "response": "torque", "motion": "phase", "move": "move-speed", "speed-map": "speed-map",
    "compensation": "compensation",
}  # fmt: skip
JOBS = ("speed-map", "compensation")
LOW_CONTRAST = """() => {
    const parse = (text) => (text.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
    const light = ([r, g, b]) => [r, g, b]
        .map((c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
        .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
    const behind = (one) => {
        for (; one; one = one.parentElement) {
            const found = parse(getComputedStyle(one).backgroundColor);
            if (found.length === 3 || found[3] > 0) return found;
        }
        return [255, 255, 255];
    };
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), low = [];
    let seen = 0;
    while (walker.nextNode()) {
        const text = walker.currentNode.textContent.trim(), owner = walker.currentNode.parentElement;
        if (!text || owner.closest(":disabled, option, [hidden], script") || !owner.getClientRects().length) continue;
        const style = getComputedStyle(owner), front = parse(owner instanceof SVGElement ? style.fill : style.color);
        const [a, b] = [light(front), light(behind(owner))].sort((x, y) => y - x);
        seen += 1;
        if ((a + 0.05) / (b + 0.05) < 4.5) low.push(`${text}: ${((a + 0.05) / (b + 0.05)).toFixed(2)}`);
    }
    return { seen, low };
}"""
SHOWN = """() => [...document.querySelectorAll(".plot")].map((box) => [
    box.id,
    box.getAttribute("aria-label"),
    JSON.stringify(box.data.map((t) => [t.x, t.y, t.z]), (_, v) => (typeof v === "number" ? v.toPrecision(9) : v)),
])"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_can_be_read(page, scheme):
    before = drawn(page)
    page.emulate_media(color_scheme=scheme)
    if scheme == "dark":  # until the server answers the pictures have their own light paper, and dark letters on it
        until_drawn_again(page, before)
    page.wait_for_function(f"() => ({LOW_CONTRAST})().seen > 60")  # all that comes after the first picture
    found = page.evaluate(LOW_CONTRAST)
    assert found["seen"] > 60
    assert found["low"] == []


def settled(page, view):
    """Wait for the last picture of a view and for what comes after it."""
    page.wait_for_selector(f"#plot-{LAST[view]}[data-drawn]")
    if view in JOBS:
        page.wait_for_function(DONE)
    if view == "response":
        page.wait_for_function("() => document.getElementById('answer').textContent.includes('How sure')")
    page.wait_for_timeout(300)


@pytest.mark.parametrize("view", LAST)
def test_address_of_a_view_gives_its_picture_again_and_its_data(blank, view, tmp_path):
    blank.goto(f"{blank.base}#gear=CSG-40-50&view={view}&v.damping.ratio=4+%25&o.speed=1300")
    if view in JOBS:
        blank.locator("#begin").click()
        blank.wait_for_function("() => location.hash.includes('o.run=')")
    settled(blank, view)
    shown, said, where = blank.evaluate(SHOWN), blank.locator("#answer").inner_text(), blank.url
    blank.goto("about:blank")
    blank.goto(where)
    settled(blank, view)
    assert blank.evaluate(SHOWN) == shown
    assert blank.locator("#answer").inner_text() == said
    assert all(re.search(r"\d", label) for _, label, _ in shown)  # a sentence with figures stands for the picture
    for i, name in enumerate(one[0].removeprefix("plot-") for one in shown):
        if i == 3:  # Chromium holds back more than ten downloads of one page
            blank.goto("about:blank")
            blank.goto(where)
            blank.wait_for_selector(f"#plot-{LAST[view]}[data-drawn]")
        for ending, begins in (("csv", b'"'), ("svg", b"<svg"), ("png", b"\x89PNG")):
            with blank.expect_download() as found:
                save(blank, f'[aria-label="Save {name} as {ending.upper()}"]')
            found.value.save_as(tmp_path / "taken")
            content = (tmp_path / "taken").read_bytes()
            assert content.startswith(begins)
            if ending == "csv":
                head, *rows = content.decode().splitlines()
                assert rows
                assert all(row.count(",") == head.count('","') for row in rows)


@pytest.mark.parametrize("view", [*LAST, "tuning", "log"])
def test_axe_finds_nothing_in_any_view_in_light_and_dark(blank, view):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    blank.goto(f"{blank.base}#gear=CSG-40-50&view={view}&o.search=no")
    if view in (*JOBS, "tuning"):
        blank.locator("#begin").click()
        blank.wait_for_function(DONE)
    if view == "log":
        blank.wait_for_selector("#log-file")
        blank.evaluate(DROP, ["run.csv", "k1,k2\n" + "\n".join(f"{i},{2 * i}" for i in range(100))])
        blank.wait_for_selector("#columns[open]")
    elif view != "tuning":
        settled(blank, view)
    for scheme in ("light", "dark"):
        blank.emulate_media(color_scheme=scheme)
        blank.wait_for_timeout(500)
        found = axe.run(blank).response
        assert [(one["id"], [node["html"] for node in one["nodes"]]) for one in found["violations"]] == []
        assert len(found["passes"]) > 20


def test_colours_change_without_a_computed_picture_being_lost(page):
    page.get_by_role("tab", name="Compensation").click()
    page.locator("#begin").click()
    page.wait_for_selector("#plot-compensation[data-drawn]")
    before = drawn(page, "compensation")
    page.emulate_media(color_scheme="dark")
    until_drawn_again(page, before, "compensation")
    slider = page.locator('[id="value-damping.ratio-slider"]')
    slider.press("ArrowRight")
    assert slider.get_attribute("aria-valuetext").endswith(" %")
    page.wait_for_function("() => document.getElementById('stage').textContent.includes('has changed;')")
    assert "o.run" not in page.url


def tab_to(page, target):
    """Press Tab until the target has the focus; every stop on the way must be seen and have a name."""
    for _ in range(90):
        page.keyboard.press("Tab")
        stop = page.evaluate(
            "() => { const one = document.activeElement; return [one.id, getComputedStyle(one).outlineStyle,"
            " (one.getAttribute('aria-label') ?? one.labels?.[0]?.textContent ?? one.textContent ?? '').trim()"
            " || one.getAttribute('aria-labelledby'), one.tagName]; }"
        )
        if stop[0] == target:
            return
        if stop[3] != "BODY":
            assert stop[1] != "none", stop
            assert stop[2], stop
    raise AssertionError(f"Tab does not reach {target}")


def fill(page, field, text):
    """All at once: after a pause behind the "0" of "0.4" the page asks for no inertia, which is refused."""
    tab_to(page, field)
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text)


def test_whole_session_by_keyboard_from_a_gear_to_an_answer(page, tmp_path):
    tab_to(page, "gear")
    page.keyboard.type("CSG-25-100")
    page.wait_for_function("() => document.getElementById('title').textContent === 'CSG-25-100'")
    times = drawn(page)
    fill(page, "value-load.inertia", "0.4")
    until_drawn_again(page, times)
    before = largest(page)
    fill(page, "value-motor.loop.bandwidth", "20")
    page.wait_for_function(f"() => !document.getElementById('answer').textContent.includes(' {before} ')")
    tab_to(page, "part-gravity")
    page.keyboard.press("Enter")
    page.wait_for_selector('[id="value-load.drag.amplitude"]')
    page.wait_for_function("() => document.activeElement.id === 'part-gravity'")
    fill(page, "value-limit.oscillation", "300")
    page.wait_for_function("() => document.getElementById('answer').textContent.includes('300')")
    page.wait_for_function("() => document.getElementById('answer').textContent.includes('Allowed under every load')")
    tab_to(page, "tab-response")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("#plot-phase[data-drawn]")
    fill(page, "speed", "900")
    page.wait_for_function(
        "() => document.getElementById('answer').textContent.startsWith('Pointing error at 900 rpm')"
    )
    tab_to(page, "save-menu")
    page.keyboard.press("Enter")
    tab_to(page, "save-project")
    with page.expect_download() as found:
        page.keyboard.press("Enter")
    found.value.save_as(tmp_path / "drive.yaml")
    text = (tmp_path / "drive.yaml").read_text(encoding="utf-8")
    for line in ("gear: CSG-25-100", "bandwidth: 20 Hz", "type: angle_torque", "inertia: 0.4 kg*m^2", "300 arcsec"):
        assert line in text
