"""What an ensemble is asked for, checked once: lanes, spans, measures and method."""

from numbers import Integral
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import lacking, names_of, omega_of, order_of, orders_of
from ...base.quantities import numbers, positive_count, shown
from ...base.quantities import parameters as parameters_of
from ...base.results import Floats
from ..integration.methods import Dop8, Dopri5, Method, checked
from .lane_checks import LaneError, check_lanes
from .stepping import stepping_of, steps_known

MOST_PERIODS = 10**9  # of one run


def spans(periods: Any, settle: Any) -> tuple[int, int]:
    """Return the periods before the measures begin and those that are measured."""
    measured = positive_count("periods", periods, MOST_PERIODS)
    if isinstance(settle, bool) or not isinstance(settle, Integral) or not 0 <= int(settle) <= MOST_PERIODS:
        raise ValueError(f"settle is {shown(settle)}; it must be a whole number of periods from 0 to {MOST_PERIODS}")
    return int(settle), measured


def what_and_how(system: Any, measures: Any, method: Any) -> tuple[tuple[Any, ...], Method]:
    """Return the measures that are accumulated, and the method, whose steps resolve them."""
    kept, chosen = summed_measures(measures), method_of(system, method)
    k, orders = max(map(order_of, measures)), orders_of(system)
    most, remedy = stepping_of(chosen).resolved(k, orders)
    if k > most:  # it would be the amplitude of another order
        name = next(type(m).__name__ for m in measures if order_of(m) == k)
        raise ValueError(f"{name}({k}) is of an order that the steps of {chosen} do not resolve; take {remedy}")
    return kept, chosen


def lanes_of(system: Any, parameters: Any, y0: Any) -> tuple[dict[str, Floats], Floats, int]:
    """Return the values that vary by path, the states (states, lanes) and the number of lanes."""
    if not isinstance(parameters, dict):
        raise TypeError(f"parameters are {shown(parameters)}; they must be a dict of path to values of every lane")
    known = {p.path: p.value for p in parameters_of(system)}
    varied = {}
    for path, values in parameters.items():
        if path not in known:
            name = type(system).__name__
            raise ValueError(f"{name} has no parameter {shown(path)}; it has {', '.join(known)}")
        if not isinstance(known[path], float):
            raise ValueError(
                f"{path} is a whole number, which all lanes share; make one ensemble for each of its values"
            )
        varied[path] = numbers(path, values)
    if not isinstance(y0, list | tuple | np.ndarray) or len(y0) == 0:
        raise ValueError(f"y0 is {shown(y0)}; it must have one entry per state, a number or one value per lane")
    states = [numbers(f"y0[{i}]", entry) for i, entry in enumerate(y0)]
    lengths = {len(v) for v in [*varied.values(), *states] if len(v) > 1}
    if len(lengths) > 1:
        raise ValueError(f"the arrays have the lengths {sorted(lengths)}; every lane needs one value of each")
    lanes = lengths.pop() if lengths else 1
    varied = {path: np.full(lanes, v[0]) if len(v) == 1 else v for path, v in varied.items()}
    if len(states) != len(names := names_of(system) or states):
        said = f"{type(system).__name__} has {len(names)}: {', '.join(map(str, names))}"
        raise ValueError(f"y0 has {len(states)} states; {said}; give each one")
    check_lanes(system, varied)
    omega = varied.get("omega", np.full(lanes, float(omega_of(system))))
    if not (omega > 0.0).all():
        slow = ~(omega > 0.0)
        raise LaneError(f"omega is {omega[int(np.argmax(slow))]:g} rad/s; it must be positive", slow)
    return varied, np.stack([np.broadcast_to(v, (lanes,)) for v in states]), lanes


def summed_measures(measures: Any) -> tuple[Any, ...]:
    """Return those of the measures that are accumulated."""
    if not isinstance(measures, tuple) or not measures:
        raise TypeError(f"measures are {shown(measures)}; they must be a tuple such as (sw.Peak(), sw.Rms())")
    for measure in measures:
        if isinstance(measure, type):
            raise TypeError(f"{measure.__name__} is the class of a measure; write {measure.__name__}()")
        if len(lacking(measure, "update", "of_end", "of_turns")) == 3:
            raise TypeError(f"{shown(measure)} is no measure; take Peak(), Rms(), Amplitude(k), Final() or the like")
        if not lacking(measure, "check"):
            measure.check()
    return tuple(m for m in measures if not lacking(m, "update"))


def method_of(system: Any, method: Any) -> Method:
    """Return the method given, or the one that suits the system."""
    if method is None:
        kinks = breakpoints_of(system)
        return Dop8() if steps_known(system) and not kinks else Dopri5()
    chosen = checked(method)
    stepping_of(chosen).check(system)
    return chosen
