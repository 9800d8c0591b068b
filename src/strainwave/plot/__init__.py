"""Drawing of results on axes of matplotlib."""

from .draw import draw_basins as draw_basins
from .draw import draw_orbit_diagram as draw_orbit_diagram
from .draw import draw_variability as draw_variability
