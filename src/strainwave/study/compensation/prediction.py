"""Prediction: the pointing error over speed by harmonic balance of the whole drive, branch by branch."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...model.controllers.speed_table import SpeedTable
from ...model.train.motion import MOST
from ...protocols import lacking
from ...quantities import interval, number, shown
from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen
from ...units import ARCSEC, RPM
from .bench import Bench, bench_of

Complexes = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class PredictionTable(Result):
    """Complex amplitudes of the pointing error along the response curve.

    Attributes
    ----------
    omega : (n,) array
        Speed of the motor [rad/s], in the order of the arc, from the low end.
    orders : (orders,) int array
        Orders of the motor's angle.
    amplitudes : (orders, n) complex array
        A e^(i phi) [rad] of A cos(order angle + phi).
    stable : (n,) bool array
        Whether the motion is stable.
    """

    rows: ClassVar[str] = "point"

    omega: Floats
    orders: Any
    amplitudes: Complexes
    stable: NDArray[np.bool_]

    def runs(self) -> list[tuple[int, int]]:
        """First and last point of each stretch of stable motions whose speed grows or falls throughout."""
        forward = np.diff(self.omega) > 0.0
        edges = [0]
        for i in range(1, len(self.omega)):
            turns = i > 1 and forward[i - 1] != forward[i - 2]
            if self.stable[i] != self.stable[i - 1] or turns:
                edges.append(i)
        spans = [(a, b) for a, b in zip(edges, [*edges[1:], len(self.omega)], strict=True) if b - a > 1]
        return [(a, b) for a, b in spans if self.stable[a]]

    def at(self, speed: float, direction: int = 1) -> tuple[Complexes, str]:
        """Amplitudes (orders,) at a speed [rad/s] that is reached from below (1) or from above (-1), and a flag.

        Where several motions are stable a run-up stays on the one that it is on until that ends. The flag is empty
        where the prediction holds, else a sentence; the amplitudes are then NaN.
        """
        speed = number("speed [rad/s]", speed)
        if direction not in (1, -1):
            raise ValueError(f"direction is {shown(direction)}; it must be 1, from below, or -1, from above")
        low, high = float(np.min(self.omega)), float(np.max(self.omega))
        nothing = np.full(len(self.orders), np.nan + 0.0j)
        if not low <= speed <= high:
            return nothing, f"the speed is outside of the table, {low / RPM:.4g} to {high / RPM:.4g} rpm"
        runs = self.runs()
        for a, b in runs if direction > 0 else reversed(runs):
            x, y = self.omega[a:b], self.amplitudes[:, a:b]
            if min(x[0], x[-1]) <= speed <= max(x[0], x[-1]):
                way = slice(None, None, 1 if x[-1] > x[0] else -1)
                return np.array([np.interp(speed, x[way], row[way]) for row in y]), ""
        return nothing, "no stable motion that repeats with every turn is known at this speed"

    def coordinates(self) -> Labelled:
        """Speeds and orders."""
        return {"omega": ("point", self.omega, "rad/s"), "order": ("order", self.orders, "")}

    def variables(self) -> Labelled:
        """Amplitudes, phases and stability."""
        dims = ("order", "point")
        return {
            "amplitude": (dims, np.abs(self.amplitudes), "rad"),
            "phase": (dims, np.angle(self.amplitudes), "rad"),
            "stable": ("point", self.stable, ""),
        }

    def __str__(self) -> str:
        lines = [
            f"PredictionTable: {len(self.omega)} motions from {np.min(self.omega) / RPM:.4g} to "
            f"{np.max(self.omega) / RPM:.4g} rpm, {len(self.runs())} stretches of stable ones"
        ]
        for k, row in zip(self.orders, np.abs(self.amplitudes), strict=True):
            top = int(np.argmax(row))
            lines.append(f"  order {k}: up to {row[top] / ARCSEC:.4g} arcsec, at {self.omega[top] / RPM:.4g} rpm")
        return on_screen("\n".join(lines))

    __repr__ = __str__


def prediction_table(project: Any, orders: tuple[int, ...] | None = None) -> PredictionTable:
    """Predict the pointing error of a drive over its range of speeds, order by order.

    Parameters
    ----------
    project : Project
        From `read_project`.
    orders : tuple of int, optional
        Orders of the motor's angle. Default: those of the kinematic error.

    Returns
    -------
    PredictionTable

    Raises
    ------
    TypeError
        If it is no project.
    ValueError
        If an order is none of the response's harmonics.
    SolveError
        If no periodic motion is found.
    """
    if lacking(project, "response", "motors"):
        raise TypeError(f"project is {shown(project)}; give what read_project returns")
    own = bench_of(project).orders if orders is None else tuple(orders)
    curve = project.response().curve
    x = curve.coefficients
    way = slice(None, None, 1 if curve.omega[0] <= curve.omega[-1] else -1)
    most = x.shape[1] // 2
    if not own or any(not isinstance(k, int) or isinstance(k, bool) or not 1 <= k <= most for k in own):
        raise ValueError(f"orders is {shown(orders)}; give integers from 1 to {most}, the harmonics of this response")
    rows = [x[:, 2 * k - 1] - 1j * x[:, 2 * k] for k in own]
    return PredictionTable(curve.omega[way], np.array(own), np.array(rows, complex)[:, way], curve.stable[way])


def speed_table(
    project: Any, speeds: tuple[float, float], *, table: PredictionTable | None = None, direction: int = 1, **bench: Any
) -> Any:
    """Return the plain loop with the torque that cancels the predicted error over a range of speeds: `SpeedTable`.

    At 16 speeds the torque is the predicted amplitude over the response of the sampled loop; between them it is
    straight. Where the error is large enough to bend the gear's stiffness, or the model is wrong, a rest is left.

    Parameters
    ----------
    project : Project
        The drive.
    speeds : (low, high)
        Speeds of the motor [rad/s].
    table : PredictionTable, optional
        Default: that of the project.
    direction : int
        1 for run-ups, -1 for run-downs.
    **bench
        `sampling` and `loop` as of `compensate`.

    Raises
    ------
    ValueError
        If the table has no prediction at one of the speeds: the sentence says why.
    """
    low, high = interval("speeds [rad/s]", speeds, positive=True)
    own: Bench = bench_of(project, bench.get("sampling"), bench.get("loop"))
    predicted = prediction_table(project) if table is None else table
    grid = np.linspace(low, high, MOST)
    torque = np.empty((len(predicted.orders), MOST), complex)
    for i, speed in enumerate(grid.tolist()):
        amplitudes, flag = predicted.at(speed, direction)
        if flag:
            raise ValueError(f"there is no prediction at {speed / RPM:.4g} rpm: {flag}")
        torque[:, i] = -amplitudes / own.response(speed, predicted.orders).error_of_torque
    loop: Any = own.loop
    for k, row in zip(predicted.orders.tolist(), torque, strict=True):
        loop = SpeedTable(loop, tuple(grid.tolist()), tuple(row.real.tolist()), tuple((-row.imag).tolist()), order=k)
    return loop
