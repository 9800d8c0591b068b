"""Basins of the low- and the high-amplitude motion in the plane of a slow flow."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...quantities import number, positive_count
from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen
from ..slow_flow.fixed_points import Flow
from .destinations import destinations, stable_states
from .moving import tabulated

MARGIN = 1.5  # of the largest steady amplitude
MOST_POINTS = 401
ROOM, NARROW = 2.0, 1e-3  # of a table: amplitude over that of the grid, and half its range of speeds


@dataclass(frozen=True, eq=False)
class SlowBasins(Result):
    """Where the motions from a grid of slow states z = a exp(-i phase) end.

    Attributes
    ----------
    re, im : (n,) arrays
        Re z and Im z [rad] of the grid.
    label : (n, n) int array
        Place in `states` of the end, rows along im; -1 where a motion did not settle, as on the edge of two basins.
    states : tuple of complex
        Stable steady states z [rad] by descending amplitude. States that differ by whole forcing periods are one.
    """

    re: Floats
    im: Floats
    label: NDArray[np.int64]
    states: tuple[complex, ...]

    rows: ClassVar[str] = "im"

    @property
    def share(self) -> Floats:
        """Share (states,) of the grid's area in the basin of each state."""
        return np.array([float(np.mean(self.label == i)) for i in range(len(self.states))])

    def coordinates(self) -> Labelled:
        """Re z and Im z, and the states by number."""
        return {"im": ("im", self.im, "rad"), "re": ("re", self.re, "rad")}

    def variables(self) -> Labelled:
        """Labels over the plane, and amplitude and share of each state."""
        return {
            "label": (("im", "re"), self.label, ""),
            "amplitude": ("state", np.abs(np.array(self.states)), "rad"),
            "share": ("state", self.share, "1"),
        }

    def __str__(self) -> str:
        told = "; ".join(
            f"{100.0 * share:.3g} % to a = {abs(z):.6g} rad" for z, share in zip(self.states, self.share, strict=True)
        )
        return on_screen(f"Basins of the slow flow, {self.label.size} starts up to {self.re[-1]:.6g} rad: {told}")

    __repr__ = __str__


def basins(flow: Flow, size: Any, points: Any) -> SlowBasins:
    """Label a grid of starts; see `SlowFlow.basins`."""
    count = positive_count("points", points)
    if not 2 <= count <= MOST_POINTS:
        raise ValueError(f"points is {count}; it must be from 2 to {MOST_POINTS}")
    if not flow.setting.mu > 0.0:
        raise ValueError(f"B is {flow.setting.system.B:.6g} N*m*s/rad; basins need positive damping: give B")
    if size is None:
        largest = max((abs(z) for z in stable_states(flow)), default=0.0)
        size = MARGIN * largest or max(flow.setting.scales())
    axis = np.linspace(-1.0, 1.0, count) * number("size [rad]", size, positive=True)
    z = (axis[None, :] + 1j * axis[:, None]).ravel()
    omega = flow.setting.omega
    quick = tabulated(flow, (omega * (1.0 - NARROW), omega * (1.0 + NARROW)), ROOM * float(axis[-1]))
    states, label = destinations(quick, z)
    return SlowBasins(axis, axis, label.reshape(count, count), tuple(states))
