"""Oscillation of several drives over the speed, in one panel."""

from typing import TYPE_CHECKING

import numpy as np

from ..drive.speeds import Speeds
from .panels import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE, Panel, angle, of_speeds

if TYPE_CHECKING:
    from ..files.variants.comparison import ProjectComparison

COLOURS, STYLES = (BLUE, ORANGE, BLACK, GREY), ("", DASHES, DOT_DASH, "2 3")  # of several drives
THIN, THICK = 0.9, 2.0  # of unstable and stable motions
TITLE_LETTERS = 44  # letters of a title in the legend


def comparison_panels(found: "ProjectComparison", speeds: Speeds) -> list[Panel]:
    """The oscillation of every drive over the speed, each with its own line, and their limit [rad] if they share it."""
    largest = [float(np.max(response.oscillation)) for response in found.responses]
    panel = Panel("largest oscillation of the error", of_speeds(speeds), angle("", largest))
    for i, (title, response) in enumerate(zip(found.titles, found.responses, strict=True)):
        name = f"{i + 1}: {title}"
        name = name if len(name) <= TITLE_LETTERS else name[: TITLE_LETTERS - 3] + "..."
        name += " (error equation alone)" * bool(np.isnan(found.oscillation[i]))
        x, y, dash = response.omega, response.oscillation, STYLES[(i + i // len(COLOURS)) % len(STYLES)]
        colour = COLOURS[i % len(COLOURS)]
        panel.parted(x, y, response.stable, colour, name, ("", ""), (THICK, THIN), (dash, dash))
        panel.note(float(x[np.argmax(y)]), float(np.max(y)), str(i + 1))
    known = set(found.limit[~np.isnan(found.limit)].tolist())
    if len(known) == 1:
        panel.level(known.pop(), GREY, "limit", "8 4")
    panel.fit()
    return [panel]
