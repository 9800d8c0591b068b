"""Poincaré sections of one long motion, and orbit diagrams: stroboscopic points over a parameter, swept both ways."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ...base.arguments import typed
from ...base.law import repeating, torsion
from ...base.protocols import System, lacking, omega_of, with_parts
from ...base.quantities import number, numbers, parameters, positive_count, replace, shown
from ...base.results import Floats, SolveError, Status
from ..integration.methods import Dopri5, Method
from ..integration.simulate import simulate

METHOD = Dopri5()
PER_TURN = 256  # samples between which crossings are looked for
BISECTIONS = 40
MOST_TURNS = 100_000
STEPS = 8_000  # of a turn of an orbit diagram on average: with an order of 320 it takes about 6,000
FOR_PEAKS = 64  # samples of a turn between which its peak is found
LONGEST, SETTLED = 8, 1e-5  # periods looked for, and by how much of its size a state may miss itself


@dataclass(frozen=True, eq=False)
class PoincareSection:
    """Points of a motion on a section.

    Attributes
    ----------
    t : (n,) array
        Times [s] after the start.
    phase : (n,) array
        Base phase [rad], between 0 and 2 pi.
    y : (states, n) array
        States there.
    section : str
        What the section is.
    """

    t: Floats
    phase: Floats
    y: Floats
    section: str

    def __str__(self) -> str:
        if not len(self.t):
            return f"Poincare section at {self.section}: no crossings"
        low, high = np.min(self.y, axis=1), np.max(self.y, axis=1)
        spans = ", ".join(f"{a:.5g} .. {b:.5g}" for a, b in zip(low, high, strict=True))
        return f"Poincare section at {self.section}: {len(self.t)} points, states {spans}"

    __repr__ = __str__


@typed
def poincare_section(
    system: System,
    y0: ArrayLike,
    *,
    turns: int = 1000,
    settle: int = 200,
    phase: float | None = None,
    torsion_level: float | None = None,
    method: Method = METHOD,
) -> PoincareSection:
    """Look at one motion once per turn, or each time that the torsion rises through a level.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)`
        The system.
    y0 : (states,) array_like
        State at base phase 0.
    turns, settle : int
        Turns of the base angle to look at, and before that.
    phase : float, optional
        Base phase [rad] of a stroboscopic section. Default: 0.
    torsion_level : float, optional
        In its place: the torsion [rad] (the first state, where the system has no torsion) whose rising crossings are
        kept, located between samples by cubic interpolation.
    method : Dopri5, Rk4 or Dop8
        Integration method.

    Returns
    -------
    PoincareSection
        States `y` (states, n), x [rad] and x' [rad/s] of an oscillator, with the base `phase` (n,) [rad] and the time
        `t` (n,) [s] of each cut. May be empty where no crossing occurs.

    Raises
    ------
    ValueError
        If a count or a number is out of range, or both sections are asked for.
    SolveError
        If the motion leaves every bound.
    """
    system = repeating("poincare_section", with_parts("poincare_section", system, "rhs"))
    start = numbers("y0", y0)
    turns = positive_count("turns", turns, MOST_TURNS)
    settle = positive_count("settle", settle, MOST_TURNS)
    if phase is not None and torsion_level is not None:
        raise ValueError(f"phase is {shown(phase)} and torsion_level {shown(torsion_level)}; a section has one of them")
    omega = number("omega", omega_of(system), positive=True)
    turn = 2.0 * np.pi / omega
    if torsion_level is None:
        angle = number("phase", 0.0 if phase is None else phase) % (2.0 * np.pi)
        t = np.asarray(turn * (settle + np.arange(turns)) + angle / omega, float)
        run = _whole(simulate(system, start, np.concatenate([[0.0], t]), method=method))
        return PoincareSection(t, np.full(turns, angle), run.y[:, 1:], f"base phase {angle:.6g} rad")
    level = number("torsion_level", torsion_level)
    t = turn * (settle + np.arange(turns * PER_TURN + 1) / PER_TURN)
    run = _whole(simulate(system, start, np.concatenate([[0.0], t]), method=method))
    return _crossings(system, t, run.y[:, 1:], run.rate[:, 1:], omega, level)


def _whole(run: Any) -> Any:
    if not run.status:
        raise SolveError(f"the motion ended: {run.message}")
    return run


def _crossings(system: System, t: Floats, y: Floats, rate: Floats, omega: float, level: float) -> PoincareSection:
    def is_above(times: Floats, states: Floats) -> NDArray[np.bool_]:
        return np.asarray(torsion(system, omega * times, tuple(states)) > level)

    up = is_above(t, y)
    i = np.flatnonzero(~up[:-1] & up[1:])
    h = t[1] - t[0]

    def between(s: Floats) -> Floats:
        """States by cubic Hermite interpolation."""
        y0, y1, r0, r1 = y[:, i], y[:, i + 1], h * rate[:, i], h * rate[:, i + 1]
        return np.asarray(y0 + s * (r0 + s * (3 * (y1 - y0) - 2 * r0 - r1 + s * (2 * (y0 - y1) + r0 + r1))))

    low, high = np.zeros(len(i)), np.ones(len(i))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        risen = is_above(t[i] + middle * h, between(middle))
        low, high = np.where(risen, low, middle), np.where(risen, middle, high)
    times = np.asarray(t[i] + high * h, float)
    return PoincareSection(times, omega * times % (2.0 * np.pi), between(high), f"torsion rising through {level:g} rad")


@dataclass(frozen=True, eq=False)
class OrbitDiagram:
    """Stroboscopic points of the motions that a slow sweep of a parameter follows, up and down.

    Attributes
    ----------
    parameter : str
        Path of the parameter.
    values : (n,) array
        Its values, rising.
    up, down : (n, points, starts) arrays
        First state [rad] at base phase 0 in the last turns at each value; nan after the motion left every bound.
    period_up, period_down : (n, starts) int arrays
        Turns after which it repeats; 0 where it does not settle (chaos, a slow transient, a period above 8).
    peak_up, peak_down : (n, starts) arrays
        Largest absolute value of the first state in those turns [rad].
    unit : str
        Unit of the parameter, "" where it has none.
    """

    parameter: str
    values: Floats
    up: Floats
    down: Floats
    period_up: NDArray[np.int64]
    period_down: NDArray[np.int64]
    peak_up: Floats
    peak_down: Floats
    unit: str = ""

    def dataset(self) -> xr.Dataset:
        """All of it over the parameter, "direction" (up, down), "point" and "start"."""
        data = xr.Dataset(coords={self.parameter: self.values, "direction": ["up", "down"]})
        dims = ("direction", self.parameter)
        data[self.parameter].attrs["units"] = self.unit
        data["x"] = ((*dims, "point", "start"), np.stack([self.up, self.down]), {"units": "rad"})
        data["period"] = ((*dims, "start"), np.stack([self.period_up, self.period_down]), {"units": "turn"})
        data["peak"] = ((*dims, "start"), np.stack([self.peak_up, self.peak_down]), {"units": "rad"})
        return data

    def __str__(self) -> str:
        lines = [f"Orbit diagram over {self.parameter} = {self.values[0]:g} .. {self.values[-1]:g}: {len(self.values)}"]
        for name, period in (("up", self.period_up), ("down", self.period_down)):
            counts = ", ".join(
                f"{np.mean(period == n):.1%} {'not settled' if n == 0 else f'period {n}'}" for n in np.unique(period)
            )
            lines.append(f"  {name}: {counts}")
        return "\n".join(lines)

    __repr__ = __str__


@typed
def orbit_diagram(
    system: System,
    path: str,
    values: ArrayLike,
    y0: Any = (0.0, 0.0),
    *,
    settle: int = 200,
    points: int = 64,
    method: Method | None = None,
    threads: int = 2,
) -> OrbitDiagram:
    """Sweep a parameter slowly up and down and keep the stroboscopic points of the motion at every value.

    At each value the motion goes on from where it was at the value before. Several starts find branches that one sweep
    does not visit.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)`
        The system.
    path : str
        The parameter, for instance "omega" or "excitation.amplitude".
    values : (n,) array_like
        Its values, rising.
    y0 : sequence of float or of (starts,) arrays
        State with which each sweep begins.
    settle, points : int
        Turns at each value before the points are kept, and how many are kept.
    method : Dopri5, Rk4 or Dop8, optional
        Integration method. Default: `Dopri5()` with at most 8,000 steps a turn on average.
    threads : int
        How many sweeps to follow at a time.

    Returns
    -------
    OrbitDiagram
        First state [rad] once per turn, `up` and `down` (n, points, starts), at each of the `values` of the
        parameter.

    Raises
    ------
    ValueError
        If the values do not rise, there is no such parameter, y0 is no state or a count is out of range.
    SolveError
        If a motion takes more steps than the method may.
    """
    system = repeating("orbit_diagram", with_parts("orbit_diagram", system, "rhs"))
    grid = numbers("values", values)
    if len(grid) < 2 or not np.all(np.diff(grid) > 0.0):
        raise ValueError(f"values are {shown(values)}; they must be two or more rising numbers")
    values_of = {p.path: p.value for p in parameters(system)}
    unit = next((p.unit for p in parameters(system) if p.path == str(path)), "")
    if not (isinstance(path, str) and isinstance(values_of.get(path), float)):
        able = ", ".join(p for p, v in values_of.items() if isinstance(v, float))
        raise ValueError(f"{type(system).__name__} has no parameter {shown(path)} that can be swept; it has {able}")
    points = positive_count("points", points, MOST_TURNS)
    settle = positive_count("settle", settle, MOST_TURNS)
    positive_count("threads", threads)
    if not isinstance(y0, list | tuple | np.ndarray) or getattr(y0, "ndim", 1) == 0 or len(y0) == 0:
        raise ValueError(f"y0 is {shown(y0)}; it must have one entry per state, a number or one value per start")
    first = np.array(np.broadcast_arrays(*(numbers(f"y0[{i}]", entry) for i, entry in enumerate(y0)))).T
    members = [with_parts("orbit_diagram", replace(system, {path: float(value)}), "rhs") for value in grid]
    for member in members:
        number("omega", omega_of(member), positive=True)
    chosen = method or Dopri5(max_steps=min(METHOD.max_steps, STEPS * (settle + points)))

    def sweep(job: tuple[list[Any], Floats]) -> tuple[Floats, Any, Floats]:
        return _swept(*job, settle, points, chosen)

    jobs = [(order, start) for order in (members, members[::-1]) for start in first]
    with ThreadPoolExecutor(threads) as pool:
        sweeps = [sweep(jobs[0]), *pool.map(sweep, jobs[1:])]  # the first compiles, where that is still to do
    x, period, peak = [np.stack(parts, axis=-1) for parts in zip(*sweeps, strict=True)]
    up, down = slice(None, len(first)), slice(len(first), None)
    return OrbitDiagram(
        path, grid, x[..., up], x[::-1, ..., down], period[:, up], period[::-1, down], peak[:, up], peak[::-1, down],
        unit,
    )  # fmt: skip


def _swept(members: list[Any], y: Floats, settle: int, points: int, method: Any) -> tuple[Floats, Any, Floats]:
    """First states (n, points), periods (n,) and peaks (n,) of one sweep over the members in their order."""
    x, period = np.full((len(members), points), np.nan), np.zeros(len(members), np.int64)
    peak = np.full(len(members), np.nan)
    turns = settle + np.arange(points * FOR_PEAKS + 1) / FOR_PEAKS
    for i, member in enumerate(members):
        t = 2.0 * np.pi / float(omega_of(member)) * np.concatenate([[0.0], turns])
        run = simulate(member, y, t, method=method)
        if run.status is Status.TOO_MANY_STEPS and lacking(method, "max_steps"):
            raise SolveError(f"the motion at omega = {float(omega_of(member)):.6g} rad/s ended: {run.message}")
        if run.status is Status.TOO_MANY_STEPS:
            raise SolveError(
                f"{settle + points} turns at omega = {float(omega_of(member)):.6g} rad/s from a largest state of "
                f"{np.max(np.abs(y)):.3g} take more than {method.max_steps} steps; start from a smaller y0, take fewer "
                f"turns, or give method=Dopri5(max_steps={10 * method.max_steps})"
            )
        if not run.status:
            break
        once = run.y[:, 1 + FOR_PEAKS :: FOR_PEAKS]
        x[i], period[i], peak[i], y = once[0], _period(once), run.peak(after=t[1]), run.y[:, -1]
    return x, period, peak


def _period(once: Floats) -> int:
    """Turns after which the last of the states (states, points) comes back; 0 where it does not within 8."""
    size = np.max(np.abs(once), axis=1)
    for n in range(1, min(LONGEST, once.shape[1] - 1) + 1):
        if np.all(np.abs(once[:, -1] - once[:, -1 - n]) <= SETTLED * size):
            return n
    return 0
