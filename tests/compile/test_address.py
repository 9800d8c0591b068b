"""Things by their address: what a kernel gets of them, and what an error in them becomes."""

from typing import NamedTuple

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.address import ByAddress, words_of
from strainwave.compile.calls import VECTOR, at, call, value
from strainwave.compile.jit import entry, kernel, run
from strainwave.numerics.addressed import law_by_address, torques

pytestmark = pytest.mark.slow


class Inner(NamedTuple):
    order: int
    size: float


class Thing(NamedTuple):
    even: bool
    parts: tuple[Inner, ...]
    table: np.ndarray
    nothing: None
    last: float

    def written(self, out):
        thing = at(self)
        total = 0.0
        for i in range(thing.table.shape[0]):
            for j in range(thing.table.shape[1]):
                total += thing.table[i, j] * (1 + j)
        for part in thing.parts:
            total += part.order * part.size
        out[0], out[1] = total, thing.last if thing.even else 0.0

    def summed(self):
        thing = at(self)
        return thing.last + len(thing.parts)


class ThingAt(NamedTuple):
    words: int
    written_at: int
    summed_at: int


@kernel
def both(thing, out):
    call(thing.written_at, thing.words, (out,))
    return value(thing.summed_at, thing.words, ())


def by_address(thing):
    return ByAddress(
        thing,
        lambda words: ThingAt(words(thing), entry(Thing.written, thing, VECTOR), entry(Thing.summed, thing)),
    )


def thing(even, orders, rows):
    parts = tuple(Inner(order, 0.5 + order) for order in orders)
    return Thing(even, parts, np.arange(2.0 * rows).reshape(rows, 2), None, 7.25)


def test_a_function_gets_all_numbers_of_a_thing_and_another_of_its_kind_takes_the_same_code():
    one, two, longer = thing(True, (2, 5), 3), thing(False, (-1, 4), 6), thing(True, (1, 2, 3), 1)
    for each in (one, two, longer):
        out, expected = np.zeros(2), np.zeros(2)
        Thing.written(each, expected)
        assert run(both, by_address(each), out) == each.summed()
        np.testing.assert_array_equal(out, expected)
    assert entry(Thing.written, one, VECTOR) == entry(Thing.written, two, VECTOR)
    assert entry(Thing.written, one, VECTOR) != entry(Thing.written, longer, VECTOR)


def test_an_array_with_gaps_and_what_is_no_number_are_refused():
    with pytest.raises(TypeError, match="do not follow each other"):
        words_of((np.zeros((4, 4))[:, ::2],))


class Careful(NamedTuple):
    """A law that refuses large torsions."""

    K: float

    def torque(self, x):
        if abs(x) > 0.5:
            raise ValueError("beyond the table of this law")
        return self.K * x

    def stiffness(self, x):
        return self.K


class Whole(NamedTuple):
    """A law whose stiffness is a whole number."""

    K: float

    def torque(self, x):
        return self.K * x

    def stiffness(self, x):
        return 1


class Lost(NamedTuple):
    """A law that gives no number beyond a torsion."""

    K: float

    def torque(self, x):
        return self.K * x + 0.0 * sw.maths.log(0.5 - abs(x))

    def stiffness(self, x):
        return self.K + 0.0 * sw.maths.log(0.5 - abs(x))


def oscillator(law):
    return sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.18), 0.7)


def test_an_exception_of_a_law_is_one_of_the_verb():
    assert sw.simulate(oscillator(Careful(1.0)), (0.1, 0.0), 1.0).status
    with pytest.raises(ValueError, match="beyond the table of this law"):
        sw.simulate(oscillator(Careful(1.0)), (0.4, 1.0), 10.0)


def test_a_law_may_return_whole_numbers():
    found = sw.frequency_response(oscillator(sw.Linear(1.0)), (0.5, 0.8), harmonics=3)
    other = sw.frequency_response(oscillator(Whole(1.0)), (0.5, 0.8), harmonics=3)
    np.testing.assert_allclose(other.peak, found.peak, rtol=1e-12)


def test_a_law_without_a_value_ends_the_curve_with_its_status():
    with np.errstate(invalid="ignore"):  # NumPy warns where it looks at the law beside the curve
        found = sw.frequency_response(oscillator(Lost(1.0)), (0.5, 1.6), harmonics=5)
    assert not found.status
    assert np.all(np.isfinite(found.peak))


@pytest.mark.parametrize("orders", [(2, 4), (6, 1)])
def test_other_orders_and_amplitudes_are_numbers_of_the_same_code(orders):
    from strainwave.compile import jit

    error = sw.KinematicError(tuple(sw.Line(order, 1e-3 / order) for order in orders))
    sw.frequency_response(oscillator(sw.Cubic(1.0, 0.1))._replace(error=error), (0.5, 0.9), harmonics=13)
    known = sum(map(len, jit._entries.values()))
    error = sw.KinematicError(tuple(sw.Line(order + 1, 2e-3 / order) for order in orders))
    sw.frequency_response(oscillator(sw.Cubic(2.0, 0.3))._replace(error=error), (0.5, 0.9), harmonics=13)
    assert sum(map(len, jit._entries.values())) == known


class Held(NamedTuple):
    """A law with a number of any kind."""

    k: object

    def torque(self, x):
        return self.k * x

    def stiffness(self, x):
        return self.k + 0.0 * x


class First(NamedTuple):
    """A law whose stiffness is the first of an array."""

    a: object

    def torque(self, x):
        return self.a[0] * x

    def stiffness(self, x):
        return self.a[0] + 0.0 * x


def of_law(law):
    values = np.empty(3)
    run(torques, law_by_address(law), np.array([0.0, 1.0, 2.0]), values)
    return values.tolist()


@pytest.mark.parametrize("number", [1.5, np.float32(1.5), 2, True, np.bool_(1), np.int16(-2)])
def test_numbers_of_every_kind_are_taken_as_they_are(number):
    assert of_law(Held(number)) == [0.0, float(number), 2.0 * float(number)]


def test_arrays_of_another_byte_order_are_not_read_as_they_stand():
    assert of_law(First(np.array([1.5, 2.0]))) == [0.0, 1.5, 3.0]
    with pytest.raises(TypeError, match="First cannot be compiled"):
        of_law(First(np.array([1.5, 2.0], ">f8")))


@pytest.mark.parametrize("wrong", ["hi", [1.0], 10**25, 1j, np.arange(4.0)[::2]])
def test_what_machine_code_does_not_take_is_told_in_a_sentence(wrong):
    with pytest.raises(TypeError, match=r"a model holds .*STRAINWAVE_JIT=0"):
        of_law(Held(wrong))
