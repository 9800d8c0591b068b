"""Compiled code of a balance: its type is that of how a law is taken, its numbers are the whole problem's."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.address import ByAddress, kind_of
from strainwave.compile.jit import load
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.second_order import second_order
from strainwave.numerics.continuation.trace import trace

ONE = sw.Oscillator(1.3, 20.0, sw.Cubic(1e5, 6.9e4), sw.Harmonic(3.0, mean=20.0), 140.0)
TWO = ONE._replace(
    law=sw.Polynomial((0.0, 1e5, 0.0, 6.9e9)),
    excitation=sw.Harmonics((sw.Harmonic(3.0), sw.Harmonic(2.0, 3, 0.2, 5.0))),
    error=sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(4, 2e-5))),
)
KINKED = ONE._replace(law=sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0))


def problem(system, path="omega"):
    return second_order(system, leaf_of(system, path), leaf_of(system, "omega"), 5)


@pytest.mark.slow
@pytest.mark.parametrize("path", ["omega", "law.K", "excitation.amplitude", "J"])
def test_machine_code_knows_no_law_torque_or_error(path):
    other = TWO._replace(law=ONE.law, excitation=sw.Harmonic(2.0, 3)) if path != "omega" else TWO
    problems = [problem(system, path) for system in (ONE, other)]
    one, two = (ByAddress(each, each.addressed).native() for each in problems)
    assert one[1:5] == two[1:5]
    assert kind_of(one) == kind_of(two)


@pytest.mark.slow
@pytest.mark.parametrize("system", [ONE, TWO, KINKED])
@pytest.mark.parametrize("path", ["omega", "J", "B", "excitation", "law", "error"])
def test_machine_code_follows_the_curve_of_python(system, path, monkeypatch):
    if path == "error" and system is not TWO:
        system = system._replace(error=TWO.error)
    number = {"law": "law.K1" if system is KINKED else "law.K", "error": "error.lines.0.amplitude"}.get(path, path)
    if path == "law" and system is TWO:
        number = "law.coefficients.1"
    if path == "excitation":
        number = "excitation.terms.0.amplitude" if system is TWO else "excitation.amplitude"
    own = problem(system, number)
    value = _value(system, number)
    start = own.linear_response(value)
    load()
    found = trace(own, start, 1.0, 0.5 * value, 1.5 * value, 0.2, max_points=40)
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    expected = trace(own, start, 1.0, 0.5 * value, 1.5 * value, 0.2, max_points=40)
    assert found.outcome == expected.outcome
    assert len(found.points) == len(expected.points)
    # where the next point lies depends on differences by the parameter, whose rounding is 1e-8
    sizes = np.max(np.abs(expected.points), axis=0, initial=np.max(np.abs(expected.points[:, :-1])))
    np.testing.assert_allclose(found.points / sizes, expected.points / sizes, rtol=0.0, atol=1e-6)


def _value(system, path):
    for name in path.split("."):
        system = system[int(name)] if name.isdigit() else getattr(system, name)
    return system
