"""Static sources of the kinematic error: what a gear's design, manufacture, assembly and deformation contribute.

The source article names design, assembly and the deformation of the flexspline; the manufacturing deviations of the
parts are a kind of their own here. The orders follow from the two lobes of the wave generator (see `orders`).
"""

from typing import Literal, NamedTuple

from .orders import order_map

Turn = Literal["motor", "output"]
KINDS = ("design", "manufacture", "assembly", "deformation")


class Source(NamedTuple):
    """One contributor to the kinematic error.

    `kind` is one of design, manufacture, assembly, deformation; `order` counts repeats per `turn` of the motor (the
    wave generator) or of the output; `amplitude` is 0-to-peak [rad, output side]; `phase` [rad] is None where unknown.
    """

    name: str
    kind: str
    order: int
    amplitude: float
    phase: float | None = None
    turn: Turn = "motor"


def static_sources(N: float) -> dict[str, Source]:
    """List the usual static sources of a gear of ratio N with their kinds and orders, all with the amplitude 0.

    The orders follow from the geometry (`order_map`), to first order in the deviations; sizes and what else a design
    has are the designer's to give: `static_sources(50)["flexspline run-out"]._replace(amplitude=1e-5)`.

    Parameters
    ----------
    N : float
        Ratio, a whole number.

    Returns
    -------
    dict of str to Source
        By name.

    Raises
    ------
    ValueError
        If N is not an integer of 2 to 10 000.
    """
    engagement = order_map(N).order("flexspline tooth engagement").per_output_turn
    rows: list[tuple[str, str, int, Turn]] = [
        ("approximate tooth profile", "design", 2, "motor"),
        ("wave generator eccentricity", "manufacture", 1, "motor"),
        ("wave generator ellipticity", "manufacture", 2, "motor"),
        ("circular spline ovality", "manufacture", 2, "motor"),
        ("circular spline four-lobed", "manufacture", 4, "motor"),
        ("flexspline ovality", "manufacture", engagement, "output"),
        ("flexspline run-out", "manufacture", 1, "output"),
        ("coupling offset", "assembly", 1, "motor"),
        ("circular spline misalignment", "assembly", 2, "motor"),
        ("output bearing run-out", "assembly", 1, "output"),
        ("flexspline deformation under load", "deformation", 2, "motor"),
        ("circular spline deformation by its screws", "deformation", 4, "motor"),
    ]
    return {name: Source(name, kind, order, 0.0, turn=turn) for name, kind, order, turn in rows}
