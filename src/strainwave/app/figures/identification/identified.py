"""The figure of an identified drive: measured and computed torsion over the time, the residual below."""

from typing import Any

import numpy as np

from ....base.results import Floats
from ....base.units import ARCSEC
from ....study.identification.identified import Identified
from ...console import number
from ..curves import BLUE, ORANGE, thin
from ..svg import Panel, figure

PALE = "#c0c0c0"
HEIGHT = 230.0  # of a panel [px]


def identified_figure(found: Identified, measured: list[Floats]) -> str:
    """Draw every record of the torsion [rad] as SVG, one beside the other over their own times."""
    begin, columns = 0, []
    for values in measured:
        left = found.residual[0][begin : begin + len(values)]
        columns.append(_panels(found, values, left))
        begin += len(values)
    return figure([list(row) for row in zip(*columns, strict=True)], HEIGHT, "measured and computed torsion")


def _panels(found: Identified, measured: Any, left: Floats) -> tuple[Panel, Panel]:
    time: Floats = found.step * np.arange(len(left), dtype=float)
    torsion = Panel("torsion", "", "torsion (arcmin)")
    torsion.line(*thin(time, measured / (60.0 * ARCSEC)), PALE, "measured", width=3.0)
    torsion.line(*thin(time, (measured - left) / (60.0 * ARCSEC)), BLUE, "computed", width=1.0)
    rms = number(float(np.sqrt(np.nanmean(left * left))) / ARCSEC, 3)
    rest = Panel(f"measured less computed, {rms} arcsec rms", "time (s)", "residual (arcsec)")
    rest.line(*thin(time, left / ARCSEC), ORANGE, width=0.7)
    return torsion, rest
