"""What tests ask of the page."""

import base64
import re
import zlib

PATIENCE = 300_000  # ms; the first picture may have to be compiled
DONE = "() => document.getElementById('stage').textContent === 'done'"
MANY_LOADS = "; ".join(map(str, range(-80, 0, 2)))  # of a speed map that takes ten seconds
DROP = """([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}"""


def address_of(base, project):
    """The page with the text of a project."""
    packer = zlib.compressobj(wbits=-15)
    packed = packer.compress(project.encode()) + packer.flush()
    return f"{base}#project={base64.urlsafe_b64encode(packed).decode().rstrip('=')}"


def shown(page):
    """Wait for the first picture of the response, and for the pause after it."""
    page.wait_for_selector("#plot-torque[data-drawn]")
    paused(page, 0)


def said(page, text):
    """Wait for what the answer says."""
    page.wait_for_function("text => document.getElementById('answer').textContent.includes(text)", arg=text)


def pauses(page):
    return page.evaluate("() => window.pauses")


def paused(page, before):
    """Wait for a pause: the next change is one of its own for Back and Undo."""
    page.wait_for_function("was => window.pauses > was", arg=before)


def save(page, button):
    """Save something by the menu, which stays open."""
    menu = page.locator("#save")
    if menu.get_attribute("open") is None:
        menu.locator("summary").click()
    page.locator(button).click()


def drawn(page, name="torque"):
    return page.locator(f"#plot-{name}").get_attribute("data-drawn")


def until_drawn_again(page, before, name="torque"):
    page.wait_for_function(
        "([n, was]) => document.getElementById('plot-' + n).dataset.drawn !== was", arg=[name, before]
    )


def largest(page):
    return float(re.search(r"largest oscillation: ([\d.]+) arcsec", page.locator("#answer").inner_text()).group(1))
