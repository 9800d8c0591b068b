"""The figure of a fitted loop: measured and fitted torque over the torsion, the residual below."""

import numpy as np

from ....base.units import ARCSEC
from ....study.identification.loops.loop_result import LoopFit
from ...console import number
from ..curves import BLUE, ORANGE
from ..svg import Panel, figure

MOST = 4000  # samples drawn
DOTS = 600  # of the residual
PALE = "#c0c0c0"
WIDTH, HEIGHT = 560.0, 300.0  # of the figure and of a panel [px]


def loop_figure(found: LoopFit) -> str:
    """Draw a fitted loop as SVG."""
    return figure([[panel] for panel in panels(found)], HEIGHT, "a measured loop and its law", WIDTH)


def panels(found: LoopFit) -> list[Panel]:
    """Two panels over the same torsion [arcmin]."""
    take = np.unique(np.linspace(0, len(found.torque) - 1, MOST).astype(int))
    x = found.torsion[take] / (60.0 * ARCSEC)
    loop = Panel("torque over torsion", "", "torque (N·m)")
    loop.line(x, found.torque[take], PALE, "measured", width=4.5)
    loop.line(x, found.fitted[take], BLUE, "fitted", width=1.0)
    rest = Panel(
        f"measured minus fitted torque, {number(found.residual_rms, 3)} N·m rms", "torsion (arcmin)", "residual (N·m)"
    )
    some = take[:: max(1, len(take) // DOTS)]
    left = (found.torque - found.fitted)[some]
    rest.points(found.torsion[some] / (60.0 * ARCSEC), left, ORANGE, "residual", "o", ORANGE)
    return [loop, rest]
