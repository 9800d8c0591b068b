"""What tests ask of the page."""

import re


def drawn(page, name="torque"):
    return page.locator(f"#plot-{name}").get_attribute("data-drawn")


def until_drawn_again(page, before, name="torque"):
    page.wait_for_function(
        "([n, was]) => document.getElementById('plot-' + n).dataset.drawn !== was", arg=[name, before]
    )


def largest(page):
    return float(re.search(r"up to ([\d.]+) arcsec", page.locator("#answer").inner_text()).group(1))
