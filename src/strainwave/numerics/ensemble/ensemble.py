"""`ensemble`: many independent trajectories of one system, and a few numbers kept of each.

Lanes march side by side in blocks (see `lanes`); threads share the blocks. A lane's numbers do not depend on its place
in the batch: each lane asks for its own number of steps, lanes that ask for the same number share blocks, and blocks
are filled up with copies.
"""

import math
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import breakpoints_of, repeating, torsion
from ...base.protocols import System, names_of, omega_of, order_of, prepared, with_parts
from ...base.quantities import parameters as parameters_of
from ...base.quantities import positive_count, replace
from ...base.results import Floats, SolveError
from ...compile.lanes import LANES, VECTOR_LANES
from ...compile.tree import leaves, mapped
from ..balance.harmonics import whole_orders
from ..integration.methods import HOPELESS, MOST_STEPS, Method
from .blocks import Batch, Block, march_all
from .measures import Peak, Rms
from .pieces import General, Smooth
from .request import LaneError, lanes_of, measures_and_method, spans
from .stepping import fastest_rates, stepping_of, steps_needed
from .variables import LANE, Variable, variables_of

if TYPE_CHECKING:
    import xarray as xr

MOST_TRIES = 12  # of finer steps, until the stiffness met asks for no more
SAMPLED_LANES = 16  # lanes; those of their numbers of steps are run again with half the step, for the error
SAMPLED_BLOCKS = 16  # of every number of steps, for laws with breakpoints: their errors differ from lane to lane
EXPLODING_STEPS = 100_000  # steps a period at most, for lanes that explode
FINEST = 10_000_000  # steps a period at first


def ensemble(
    system: System,
    parameters: dict[str, ArrayLike],
    y0: Any,
    *,
    periods: int,
    settle: int = 0,
    measures: tuple[Any, ...] = (Peak(), Rms()),
    method: Method | None = None,
    threads: int | None = None,
) -> "xr.Dataset":
    """Integrate many variants of a system over whole periods of the base angle and keep a few numbers of each.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)`
        The system that all lanes are variants of; `omega` is its base frequency (1 where it has none).
    parameters : dict of str to (lanes,) array_like
        Path of a parameter to its value in every lane (SI units), as in ``{"omega": w, "law.alpha": a}``. May be
        empty where only the states differ.
    y0 : sequence of float or of (lanes,) arrays
        State at the start: one entry per state, a number or one value per lane.
    periods : int
        Periods over which to measure.
    settle : int
        Periods before that.
    measures : tuple
        Measures to keep: `Peak()`, `Extremes()`, `Rms()`, `Mean()`, `Amplitude(k)`, `Final()`.
    method : Dop8, Rk4 or Dopri5, optional
        Default: `Dop8()` for smooth laws of an oscillator, `Dopri5()` (adaptive in every lane) for laws with
        breakpoints or memory and for other systems. `steps` of a fixed method count per shortest time scale met.
    threads : int, optional
        Default: as many as there are processors.

    Returns
    -------
    xarray.Dataset
        Over the dimension "lane": the varied parameters as coordinates; the measures (NaN in lanes that did not
        finish); `status` (0 finished, 1 diverged, 2 needed more than the method's `max_steps`), `ended` (time [s]
        until which the states stayed bounded), `period` (of the settled motion, in turns; 0 if it is not settled, or
        if its period is longer than 8), `steps` where they are fixed. Attributes: method and, of every
        measure with a fixed step, `error_estimate`, the largest difference to half the step in a sample of lanes
        (twice that for laws with breakpoints, where fixed steps are of second order; a lane whose motion would end
        up on another attractor may not be among them), in the unit of the measure.

    Raises
    ------
    ValueError
        If arrays have different lengths, a value is not finite, a path is unknown or names an order, a count is not
        positive, or the steps of the method cannot resolve the order of an `Amplitude`.
    TypeError
        If the system has no `rhs`, or a fixed step cannot be chosen for it.

    References
    ----------
    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., secs. II.4-II.5.
    """
    system = repeating("ensemble", with_parts("ensemble", system, "rhs"))
    run = run_lanes(
        system, parameters, y0, periods=periods, settle=settle, measures=measures, method=method, threads=threads
    )
    run.estimate()
    import xarray as xr  # its import takes longer than many an ensemble, and those of a speed map are arrays

    units = {p.path: p.unit for p in parameters_of(system)}
    lanes = {path: (LANE, v, {"units": units[path]}) for path, v in run.varied.items()}
    states = list(names_of(system) or [f"y{i}" for i in range(run.states)])
    of_states = any("state" in variable.dims for variable in run.variables.values())
    coordinates = {**lanes, "state": ("state", states)} if of_states else lanes
    return xr.Dataset({**coordinates, **run.variables}, attrs=run.attrs).set_coords(list(coordinates))


class Run(NamedTuple):
    """Run of all lanes: variables, varied parameters, number of states, and the settings, which xarray calls attrs.

    `estimate` adds the estimated errors to the variables, which takes as long as a few hundred lanes.
    """

    variables: dict[str, Variable]
    varied: dict[str, Floats]
    states: int
    attrs: dict[str, Any]
    estimate: Callable[[], None]


def run_lanes(
    system: System, parameters: dict[str, ArrayLike], y0: Any, *, periods: int, settle: int, measures: tuple[Any, ...],
    method: Method | None, threads: int | None, budget: float = math.inf,
) -> Run:  # fmt: skip
    """Check the request for an ensemble and run its lanes; more fixed steps of all than `budget` raise SolveError."""
    whole_orders(system)  # every turn begins at phase 0
    varied, states, lanes = lanes_of(system, parameters, y0)
    settle, periods = spans(periods, settle)
    kept, chosen = measures_and_method(system, measures, method)
    batch = _batch(system, varied, states, lanes, kept, settle, periods)
    threads = positive_count("threads", os.cpu_count() or 1 if threads is None else threads)
    members = replace(system, varied)
    block, steps = _run(batch, members, chosen, threads, budget)
    data = variables_of(system, batch, block, measures, chosen)
    if not chosen.adaptive:
        data["steps"] = Variable(LANE, steps, {"long_name": "steps per period"})

    def estimate() -> None:
        if not chosen.adaptive:
            _add_error_estimates(data, batch, chosen, steps, measures, system, threads)

    settings = {"method": str(chosen), "periods": periods, "settle": settle}
    return Run(data, varied, len(states), settings, estimate)


def _batch(
    system: System, varied: dict[str, Floats], y0: Floats, lanes: int, measures: Any, settle: int, periods: int
) -> Batch:  # fmt: skip
    members = replace(system, varied)
    numbers = prepared(members)
    table = np.array([np.broadcast_to(np.asarray(v, float), (lanes,)) for v in leaves(numbers)]).reshape(-1, lanes)
    omega = np.broadcast_to(np.asarray(omega_of(members), float), (lanes,))
    kind = Smooth() if _is_smooth(system, len(y0)) else General()
    template = mapped(lambda number: float(np.ravel(number)[0]), numbers)
    return Batch(template, table, omega, y0, kind, measures, settle, periods)


def _is_smooth(system: System, states: int) -> bool:
    """True if the second state is the rate of the first, in two states that nothing else has in common."""
    probes = [tuple(start + step * i for i in range(states)) for start, step in ((2.0, 1.0), (-0.37, 0.59))]
    return states > 1 and all(float(np.asarray(system.rhs(0.3, probe)[0])) == probe[1] for probe in probes)


def _run(batch: Batch, members: Any, method: Any, threads: int, budget: float) -> tuple[Block, Any]:
    """Run all lanes; returns their steps a period too, 0 where they are adaptive."""
    stepping = stepping_of(method)
    given = stepping.given(len(batch.omega))
    if given is not None:
        _refuse_many(batch, given, budget)
        return march_all(batch, given, method, threads), given
    order = max(1, *members.orders(), stepping.order_for(max(map(order_of, batch.measures), default=0)))
    return _run_refined(batch, members, method, order, threads, budget)


def _run_refined(
    batch: Batch, members: Any, method: Any, order: int, threads: int, budget: float
) -> tuple[Block, Any]:  # fmt: skip
    """Run all lanes with fixed steps, again with finer ones where they met more stiffness than foreseen."""
    margin = _error_reach(members, len(batch.omega))
    reach = np.abs(batch.y0[0])

    def needed_steps() -> Any:
        return steps_needed(method.steps, fastest_rates(members, reach + margin), batch.omega, order)

    steps = needed_steps()
    _refuse_endless(batch, steps, order, method)
    _refuse_many(batch, steps, budget)
    block = march_all(batch, steps, method, threads)
    lost = np.zeros(len(steps), bool)  # explodes in the same period with half the step: no finer one will save it
    for _ in range(MOST_TRIES):
        reach = np.maximum(reach, 1.02 * np.where(np.isfinite(block.reach), block.reach, 0.0))
        needed = needed_steps()
        stayed = block.ended == batch.settle + batch.periods
        finer = np.where(stayed, needed, np.minimum(needed, 2 * steps))  # a lane that explodes asks for any number
        repeated = np.flatnonzero((finer > steps) & (stayed | (steps < EXPLODING_STEPS)) & ~lost)
        if not len(repeated):
            break
        _refuse_many(batch, np.where(stayed & ~lost, finer, 0), budget)
        steps[repeated] = finer[repeated]
        better = march_all(batch.part(repeated), steps[repeated], method, threads)
        lost[repeated] = ~stayed[repeated] & (better.ended == block.ended[repeated])
        block.put(repeated, better)
    return block, steps


def _refuse_endless(batch: Batch, steps: Any, order: int, method: Any) -> None:
    """Refuse lanes (LaneError) with more steps a period than `FINEST`."""
    endless = steps > FINEST
    if endless.any():
        lane = int(np.argmax(endless))
        raise LaneError(
            f"a period at omega = {batch.omega[lane]:.4g} rad/s, with orders up to {order} and {method.steps} steps "
            f"of the shortest time scale, takes more than {FINEST} steps; raise omega, leave out the highest orders, "
            "or integrate part of a period with simulate",
            endless,
        )


def _refuse_many(batch: Batch, steps: Any, budget: float) -> None:
    """Refuse lanes (LaneError) whose periods take too many steps, and more than `budget` of all lanes (SolveError)."""
    periods = batch.settle + batch.periods
    if np.any(many := periods * np.asarray(steps, float) > HOPELESS * MOST_STEPS):
        raise LaneError(
            f"{periods} periods of {int(np.max(steps))} steps are more than {HOPELESS * MOST_STEPS:,} steps; give "
            "fewer periods, or a method of fewer steps",
            many,
        )
    if (taken := periods * float(np.sum(steps))) > budget:
        raise SolveError(
            f"{periods} turns from {len(batch.omega)} starts take {taken:.3g} steps, more than {budget:.3g}; take a "
            "narrower range of speeds, or higher speeds"
        )


def _error_reach(members: object, lanes: int) -> Floats:
    """Largest distance (lanes,) of the torsion from the first state."""
    zero = np.zeros((16, lanes))
    gaps = torsion(members, np.pi / 8.0 * np.arange(16)[:, None], (zero, zero))
    return np.asarray(np.max(np.abs(np.broadcast_to(np.asarray(gaps, float), (16, lanes))), axis=0))


def _add_error_estimates(
    data: dict[str, Variable], batch: Batch, method: Any, steps: Any, measures: Any, system: System,
    threads: int,
) -> None:  # fmt: skip
    """Run a sample of lanes with half the step and say by how much every measure changes at most.

    The sample fills vectors of lanes, which take as long with one lane.
    """
    good = np.flatnonzero(data["status"].values == 0)
    if not len(good):
        return
    kinks = bool(breakpoints_of(system))
    seen, size = (good, SAMPLED_BLOCKS * LANES) if kinks else (_spread(good, SAMPLED_LANES), VECTOR_LANES)
    groups = [good[steps[good] == number] for number in np.unique(steps[seen])]
    sample = np.sort(np.concatenate([_spread(group, size) for group in groups]))
    part = batch.part(sample)
    finer = march_all(part, 2 * steps[sample], method, threads)
    factor = 2.0 if kinks else 1.0 / (1.0 - 0.5**4)  # of the error to its change
    for name, few in variables_of(system, part, finer, measures, method).items():
        if few.values.dtype.kind == "f" and name != "ended":
            change = np.abs(few.values - data[name].values[..., sample])
            largest = float(np.nanmax(change)) if np.any(np.isfinite(change)) else 0.0
            data[name].attrs["error_estimate"] = factor * largest


def _spread(places: Any, count: int) -> Any:
    """At most so many of these places, evenly spread, the first and last among them."""
    return places[np.unique(np.linspace(0, len(places) - 1, count).astype(int))]
