"""Drawing of results on axes of matplotlib."""

from .any_result import draw as draw
from .any_result import draw_general_validity as draw_general_validity
from .any_result import draw_log as draw_log
from .any_result import draw_speed_map as draw_speed_map
from .any_result import draw_validity as draw_validity
from .curves import draw_basins as draw_basins
from .curves import draw_bode as draw_bode
from .curves import draw_branch as draw_branch
from .curves import draw_drive as draw_drive
from .curves import draw_orbit as draw_orbit
from .curves import draw_orbit_diagram as draw_orbit_diagram
from .curves import draw_response as draw_response
from .curves import draw_run as draw_run
from .curves import draw_slow_response as draw_slow_response
from .curves import draw_trajectory as draw_trajectory
from .curves import draw_variability as draw_variability
from .fits import draw_decay as draw_decay
from .fits import draw_design as draw_design
from .fits import draw_identified as draw_identified
from .fits import draw_order_scan as draw_order_scan
from .fits import draw_response_fit as draw_response_fit
