"""Methods of public results and records with arguments of wrong kinds: each answers with a result or a sentence."""

import inspect
from dataclasses import is_dataclass
from functools import cache
from operator import attrgetter

import numpy as np
import pytest
from all_results import NUMBERS, RESULTS, axis, drive, identified
from hostile_calls import WRONG, answer
from public_names import PUBLIC
from valid_calls import CALLS, SPECIFICATION

import strainwave as sw
from strainwave.base.records import Result
from strainwave.study.analysis.verdict import Answer, Verdict

CALLED_BY_VERBS = {
    "Dopri5": "simulate", "Rk4": "simulate", "Dop8": "simulate",
    "EnsembleMeasure": "sweep", "Compensator": "compensate",
}  # fmt: skip
MADE_BY_VERBS = ("refused",)  # of a class: `lyapunov` makes one
VERDICT = Verdict(Answer.BUT, ((1.0, 2.0),), (), ())
POINT = sw.results.TuningPoint((1.0,), (1.0,), sw.results.LoopFigures())
TABLE = sw.OrderTable((sw.Line(2, 1e-4), sw.Line(4, 1e-5)), ratio=50.0, delay=1e-3)
ORDERS = sw.gears.order_map(50.0)


def by_verb(name):
    """What a row of CALLS gives."""
    function, arguments = CALLS[name]()
    return function(**arguments)


def tuned():
    """A tuning that was not computed: what is asked of it by its methods is its loop."""
    loop, limits = sw.train.PositionLoop(50.0, 0.5), sw.results.TuningLimits()
    return sw.results.TunedLoop((), (), limits, (), POINT, POINT, POINT, (), (), (), loop, None, None, 1)


OTHERS = {
    "Project": axis,
    "ProjectComparison": lambda: sw.results.ProjectComparison(
        ("axis",), ("own law",), (drive(),), (VERDICT,), ((1.0, "rad/s"),), *NUMBERS[:12, None]
    ),
    "Specification": lambda: sw.Specification(**SPECIFICATION),
    "OrderTable": lambda: TABLE,
    "OrderMap": lambda: ORDERS,
    "GearOrder": lambda: ORDERS.orders[0],
    "MeasuredError": lambda: sw.gears.MEASURED_ERRORS[0],
    "Run": lambda: sw.Run(*np.arange(32.0)[None].repeat(3, 0), "rad"),
    "SlowFlow": lambda: by_verb("slow_flow"),
    "StabilityProof": lambda: by_verb("lyapunov"),
    "Basins": lambda: by_verb("basins"),
    "HysteresisLoop": lambda: by_verb("hysteresis_loop"),
    "TunedLoop": tuned,
    "TuningPoint": lambda: POINT,
    "OrderLine": lambda: RESULTS["OrderScan"]().lines[0],
    "CampbellLine": lambda: RESULTS["SpeedMap"]().lines[0],
    "IdentifiedDrive": lambda: sw.results.IdentifiedDrive(axis(), identified(), ("a", "b"), ()),
    "Pass": lambda: sw.results.Pass(0.1, 2.0, 2, 3.0, 1e-4, 1e-5),
    "Derivation": sw.theory.derive,
}


@cache
def methods():
    """Public methods with arguments of public results and records, each function once, with the class that has it."""
    rows = {}
    for path in PUBLIC:
        cls = attrgetter(path)(sw)
        if not (isinstance(cls, type) and (is_dataclass(cls) or path.startswith("results."))):
            continue
        for name in dir(cls) if cls.__name__ not in CALLED_BY_VERBS else ():
            function = getattr(cls, name)
            if name.startswith("_") or hasattr(Result, name) or hasattr(tuple, name) or name in MADE_BY_VERBS:
                continue
            python = inspect.isfunction(function) or inspect.ismethod(function)
            if python and {*inspect.signature(function).parameters} - {"self"}:
                rows.setdefault(function, f"{cls.__name__}.{name}")
    return sorted(rows.values())


@pytest.mark.interpreted
@pytest.mark.parametrize("row", methods())
def test_a_method_answers_wrong_kinds_with_a_result_or_a_sentence(row, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, _, called = row.partition(".")
    method = getattr({**RESULTS, **OTHERS}[name](), called)
    places = inspect.signature(method).parameters.values()
    needed = [p.name for p in places if p.default is p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
    _, valid = CALLS.get(row, lambda: (None, {}))()
    for place in places:
        for wrong in WRONG if place.kind is not place.VAR_KEYWORD else ():
            given = dict.fromkeys(needed, wrong) | valid | {place.name: wrong}
            assert answer(method, given, 0.2)[1] == "", (place.name, wrong)
