"""One verb that draws whatever is drawn: what `result.plot()` calls."""

from typing import Any

from ..numerics.attractors.basins import Basins
from ..numerics.attractors.poincare import OrbitDiagram
from ..numerics.sampled.linear import LoopResponse
from ..numerics.sampled.result import LoopEnsemble, LoopRun
from ..quantities import shown
from ..results import Branch, Orbit, Trajectory
from ..study.analysis.drive_response import DriveResponse
from ..study.compensation.monitoring import Monitored
from ..study.compensation.moves import CompensatedMove
from ..study.compensation.prediction import PredictionTable
from ..study.compensation.result import Compensation, CompensationBench, Units
from ..study.compensation.runup import CompensatedRunup
from ..study.design.result import Design
from ..study.identification.free_decay.decay import DecayFit
from ..study.identification.friction.friction_result import FrictionFit
from ..study.identification.identified import Identified
from ..study.identification.logs.log import Log
from ..study.identification.loops.loop_result import LoopFit
from ..study.identification.orders.order_result import OrderScan
from ..study.identification.response_curve.response_fit import ResponseFit
from ..study.move.result import Move
from ..study.response.response import ExactResponse
from ..study.response.validity_results import GeneralValidity, ValidityMap
from ..study.speed_map.result import SpeedMap
from ..study.train.bode import Bode
from ..study.train.run import DriveRun
from ..study.variability.result import Variability
from ..theory.slow_flow.results import SlowResponse
from .compensation import (
    draw_compensation,
    draw_compensation_bench,
    draw_loop,
    draw_loop_response,
    draw_loops,
    draw_units,
)
from .curves import (
    draw_bode,
    draw_branch,
    draw_drive,
    draw_move,
    draw_orbit,
    draw_response,
    draw_run,
    draw_slow_response,
    draw_trajectory,
)
from .designs import draw_design
from .ensembles import draw_basins, draw_orbit_diagram, draw_variability
from .fits import draw_decay, draw_identified, draw_order_scan, draw_response_fit
from .logs import draw_log
from .loops import draw_friction_fit, draw_loop_fit
from .maps import draw_general_validity, draw_validity
from .speed_maps import draw_speed_map
from .ways import draw_compensated_move, draw_compensated_runup, draw_monitored, draw_predictions

DRAWN: dict[type, Any] = {
    Branch: draw_branch, Orbit: draw_orbit, Trajectory: draw_trajectory, ExactResponse: draw_response,
    DriveResponse: draw_drive, DriveRun: draw_run, Move: draw_move, SlowResponse: draw_slow_response, Bode: draw_bode,
    Basins: draw_basins, OrbitDiagram: draw_orbit_diagram, Variability: draw_variability,
    ValidityMap: draw_validity, GeneralValidity: draw_general_validity,
    SpeedMap: draw_speed_map, Design: draw_design, DecayFit: draw_decay, ResponseFit: draw_response_fit,
    Identified: draw_identified, OrderScan: draw_order_scan,
    Compensation: draw_compensation, CompensationBench: draw_compensation_bench, Units: draw_units,
    CompensatedMove: draw_compensated_move, CompensatedRunup: draw_compensated_runup,
    Monitored: draw_monitored, PredictionTable: draw_predictions,
    Log: draw_log, LoopFit: draw_loop_fit, FrictionFit: draw_friction_fit,
    LoopRun: draw_loop, LoopEnsemble: draw_loops, LoopResponse: draw_loop_response,
}  # fmt: skip


def draw(result: Any, axes: Any = None) -> Any:
    """Draw a result on axes of matplotlib.

    Parameters
    ----------
    result : Branch, Orbit, Trajectory, DriveRun, ...
        What to draw.
    axes : matplotlib Axes, optional
        Where. Default: those of a new figure.

    Returns
    -------
    matplotlib Axes
        The axes, for titles and for `axes.figure.savefig(...)`.

    Raises
    ------
    TypeError
        If nothing is drawn of such a thing.
    ModuleNotFoundError
        If axes are to be made and matplotlib is missing.
    """
    if type(result) not in DRAWN:
        known = ", ".join(cls.__name__ for cls in DRAWN)
        raise TypeError(f"there is no figure of {shown(result)}; there is one of each of {known}")
    if axes is None:
        try:
            from matplotlib import pyplot
        except ModuleNotFoundError:
            raise ModuleNotFoundError("figures need the extra `plot`: pip install 'strainwave[plot]'") from None
        axes = pyplot.subplots(layout="constrained")[1]
    DRAWN[type(result)](axes, result)
    return axes
