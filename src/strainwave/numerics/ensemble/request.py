"""Checks of a request for an ensemble: lanes, spans of time, measures and method.

Lanes with parameters that no single system may have are found without a look at every lane.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import System, lacking, names_of, omega_of, order_of, orders_of
from ...base.quantities import checked, numbers, positive_count, replace, shown, whole
from ...base.quantities import parameters as parameters_of
from ...base.results import Booleans, Floats
from ..integration.methods import Dop8, Dopri5, Method
from ..integration.methods import checked as checked_method
from .stepping import stepping_of, steps_known


class LaneError(ValueError):
    """Some lanes of an ensemble cannot be computed: `lanes` (n,) says which, `reason` why the first of them cannot."""

    def __init__(self, reason: str, lanes: Booleans) -> None:
        super().__init__(f"lane {int(np.argmax(lanes))}: {reason}")
        self.reason, self.lanes = reason, lanes

    def __reduce__(self) -> Any:
        return LaneError, (self.reason, self.lanes)  # between processes


def check_lanes(system: System, varied: Mapping[str, Floats]) -> None:
    """Raise a LaneError if `checked` refuses the variant of a lane, with the sentence for the first of them.

    Given the others, the values of a parameter that a model allows are an interval, or all but 0. Where the corners of
    the box of all values are allowed (with 0, where that lies inside), all lanes are; else the box is halved.
    """
    if not varied:
        return
    table = np.array(list(varied.values()))
    refused = np.zeros(table.shape[1], bool)
    width = None
    waiting = [np.arange(table.shape[1])]
    while waiting:
        lanes = waiting.pop()
        part = table if width is None else table[:, lanes]
        low, high = part.min(axis=1), part.max(axis=1)
        width = np.maximum(high - low, 1e-300) if width is None else width
        sides = [
            sorted({a, b, 0.0} if a < 0.0 < b else {a, b}) for a, b in zip(low.tolist(), high.tolist(), strict=True)
        ]
        corners = int(np.prod([len(side) for side in sides], dtype=float))
        if corners == 1:
            refused[lanes] = bool(_refusal(system, varied, part[:, 0]))
        elif len(lanes) <= corners:
            refused[lanes] = [bool(_refusal(system, varied, values)) for values in part.T]
        elif any(_refusal(system, varied, corner) for corner in product(*sides)):
            widest = int(np.argmax((high - low) / width))
            below = part[widest] <= 0.5 * (low[widest] + high[widest])
            waiting += [lanes[~below], lanes[below]]
    if refused.any():
        raise LaneError(_refusal(system, varied, table[:, int(np.argmax(refused))]), refused)


def _refusal(system: Any, varied: Mapping[str, Floats], values: Any) -> str:
    """Return what `checked` says against the variant with these values, "" if nothing."""
    try:
        checked(replace(system, {path: float(value) for path, value in zip(varied, values, strict=True)}))
    except (TypeError, ValueError) as error:
        return str(error)
    return ""


MOST_PERIODS = 10**9  # of one run


def spans(periods: Any, settle: Any) -> tuple[int, int]:
    """Return the periods before the measures begin and those that are measured."""
    measured = positive_count("periods", periods, MOST_PERIODS)
    if whole("settle", settle) > MOST_PERIODS:
        raise ValueError(f"settle is {shown(settle)}; it must be a whole number of periods from 0 to {MOST_PERIODS}")
    return int(settle), measured


def measures_and_method(system: System, measures: Any, method: Any) -> tuple[tuple[Any, ...], Method]:
    """Return the measures that are accumulated, and the method, whose steps resolve them."""
    accumulated, chosen = summed_measures(measures), method_of(system, method)
    k, orders = max(map(order_of, measures)), orders_of(system)
    highest, remedy = stepping_of(chosen).resolved(k, orders)
    if k > highest:  # it would be the amplitude of another order
        name = next(type(m).__name__ for m in measures if order_of(m) == k)
        raise ValueError(f"{name}({k}) is of an order that the steps of {chosen} do not resolve; take {remedy}")
    return accumulated, chosen


def lanes_of(system: System, parameters: Any, y0: Any) -> tuple[dict[str, Floats], Floats, int]:
    """Return the values that vary by path, the states (states, lanes) and the number of lanes."""
    values_of = {p.path: p.value for p in parameters_of(system)}
    varied = {}
    for path, values in parameters.items():
        if path not in values_of:
            name = type(system).__name__
            raise ValueError(f"{name} has no parameter {shown(path)}; it has {', '.join(values_of)}")
        if not isinstance(values_of[path], float):
            raise ValueError(
                f"{path} is a whole number, which all lanes share; make one ensemble for each of its values"
            )
        varied[path] = numbers(path, values)
    if len(y0) == 0:
        raise ValueError(f"y0 is {shown(y0)}; it must have one entry per state, a number or one value per lane")
    states = [numbers(f"y0[{i}]", entry) for i, entry in enumerate(y0)]
    lengths = {len(v) for v in [*varied.values(), *states] if len(v) > 1}
    if len(lengths) > 1:
        raise ValueError(f"the arrays have the lengths {sorted(lengths)}; every lane needs one value of each")
    lanes = lengths.pop() if lengths else 1
    varied = {path: np.full(lanes, v[0]) if len(v) == 1 else v for path, v in varied.items()}
    if len(states) != len(names := names_of(system) or states):
        text = f"{type(system).__name__} has {len(names)}: {', '.join(map(str, names))}"
        raise ValueError(f"y0 has {len(states)} states; {text}; give each one")
    check_lanes(system, varied)
    omega = varied.get("omega", np.full(lanes, float(omega_of(system))))
    if not (omega > 0.0).all():
        slow = ~(omega > 0.0)
        raise LaneError(f"omega is {omega[int(np.argmax(slow))]:g} rad/s; it must be positive", slow)
    return varied, np.stack([np.broadcast_to(v, (lanes,)) for v in states]), lanes


def summed_measures(measures: Any) -> tuple[Any, ...]:
    """Return those of the measures that are accumulated."""
    if not measures:
        raise ValueError("measures are empty; give a tuple such as (sw.Peak(), sw.Rms())")
    for measure in measures:
        if lacking(measure, "start", "update", "results") and lacking(measure, "of_end"):
            raise TypeError(f"{shown(measure)} is no measure; take Peak(), Rms(), Amplitude(k), Final() or the like")
        if not lacking(measure, "check"):
            measure.check()
    return tuple(m for m in measures if not lacking(m, "update"))


def method_of(system: System, method: Any) -> Method:
    """Return the method given, or the one that suits the system."""
    if method is None:
        kinks = breakpoints_of(system)
        return Dop8() if steps_known(system) and not kinks else Dopri5()
    chosen = checked_method(method)
    stepping_of(chosen).check(system)
    return chosen
