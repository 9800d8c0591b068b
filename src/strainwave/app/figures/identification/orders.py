"""The figure of an order scan: the amplitude of each line over its order, with its interval."""

import numpy as np

from ....base.units import ARCSEC
from ....study.identification.orders.order_result import OrderScan
from ..curves import BLUE, ORANGE
from ..svg import Panel, figure

GREY = "#707070"
COLOURS = {"order": (BLUE, "stays with the angle"), "frequency": (ORANGE, "stays with the time")}
HEIGHT = 320.0  # [px]


def orders_figure(found: OrderScan, channel: str) -> str:
    """Draw the lines as SVG: stems from zero, and a bar over the interval of 95 %."""
    size, unit = (ARCSEC, "arcsec") if found.unit == "rad" else (1.0, found.unit.replace("*", "·") or "–")
    panel = Panel(f"lines of {channel.replace('_', ' ')}", "order per turn", f"amplitude ({unit})")
    highest = max((line.order for line in found.lines), default=1.0)
    half, said = 0.006 * highest, set[str]()
    for line in found.lines:
        colour, label = COLOURS.get(line.kind, (GREY, "undecided"))
        low, high = (max(end, 0.0) / size for end in line.interval())
        at = np.full(2, line.order)
        panel.line(at, np.array([0.0, line.amplitude / size]), colour, "" if label in said else label, width=3.0)
        panel.line(at, np.array([low, high]), colour, width=1.0)
        for end in (low, high):
            panel.line(line.order + np.array([-half, half]), np.full(2, end), colour, width=1.0)
        said.add(label)
    panel.xlim = (0.0, 1.05 * highest)
    return figure([[panel]], HEIGHT, "lines of an order scan")
