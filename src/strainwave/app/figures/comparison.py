"""The figure of a comparison: the oscillation of every drive over the speed, each with its own line."""

from collections.abc import Sequence

import numpy as np

from ...base.speeds import Speeds
from ...drive.drive_response import DriveResponse
from ..view import angle_unit
from .curves import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE, draw_motions
from .svg import Note, Panel, figure

WIDTH, HEIGHT = 430.0, 360.0  # narrow, so that its text is read on a telephone too
COLOURS, STYLES = (BLUE, ORANGE, BLACK, GREY), ("", DASHES, DOT_DASH, "2 3")
THIN, THICK = 0.9, 2.0  # of unstable and stable motions
LONGEST = 44  # letters of a title in the legend


def comparison_figure(
    titles: Sequence[str], responses: Sequence[DriveResponse], limits: Sequence[float | None], speeds: Speeds
) -> str:
    """Draw the responses of several drives as SVG, with their limit [rad] where they have the same one."""
    unit = angle_unit(max(float(np.max(response.oscillation)) for response in responses))
    panel = Panel("largest oscillation of the error", f"{speeds.name} ({speeds.unit})", unit.name)
    for i, (title, response) in enumerate(zip(titles, responses, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        dash = STYLES[(i + i // len(COLOURS)) % len(STYLES)]
        x, y = speeds.scale * response.omega, unit.factor * response.oscillation
        name = f"{i + 1}: {title}"
        name = name if len(name) <= LONGEST else name[: LONGEST - 3] + "..."
        draw_motions(panel, x, y, response.stable, colour, name, dash, THICK)
        draw_motions(panel, x, y, ~response.stable, colour, "", dash, THIN)
        top = int(np.argmax(y))
        panel.notes.append(Note(float(x[top]), float(y[top]), str(i + 1)))
    known = {limit for limit in limits if limit is not None}
    if len(known) == 1:
        panel.line([-np.inf, np.inf], [unit.factor * known.pop()] * 2, GREY, "limit", "8 4", 1.2)
    heights = np.concatenate([curve.y for curve in panel.curves])
    panel.log = bool(heights.min() > 0.0 and heights.max() > 30.0 * heights.min())
    panel.ylim = None if panel.log else (0.0, 1.08 * float(heights.max()))
    return figure([[panel]], HEIGHT, "oscillation of several drives over the speed", WIDTH)
