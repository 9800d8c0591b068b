"""What is told about kernels that are being compiled."""

import time
from threading import Event, Thread

import pytest

import strainwave as sw
from strainwave.compile import compiling as module
from strainwave.compile import jit


def test_a_kernel_is_listed_while_it_is_compiled_and_not_afterwards():
    begun, go_on = Event(), Event()

    def slow(kinds):
        begun.set()
        go_on.wait(10.0)
        return len(kinds)

    made = []
    thread = Thread(target=lambda: made.append(module.watched(slow, "follow")((1, 2))))
    before = time.monotonic()
    thread.start()
    assert begun.wait(10.0)
    (one,) = module.compiling()
    assert (one.kernel, one.law, one.expected) == ("follow", "", module.SECONDS["follow"])
    assert before <= one.since <= time.monotonic()
    go_on.set()
    thread.join()
    assert made == [2]
    assert module.compiling() == ()


def test_a_kernel_that_cannot_be_compiled_is_not_listed_afterwards():
    def broken(_kinds):
        raise TypeError("no")

    with pytest.raises(TypeError, match="no"):
        module.watched(broken, "follow")(())
    assert module.compiling() == ()


def test_the_sentence_says_how_long_and_how_often():
    one = module.Compilation("follow", "PiecewiseLinear", 0.0, 20.0, kept=True)
    assert str(one) == (
        "compiling the equations of this drive with the torsion law PiecewiseLinear, about 20 s, once per machine"
    )
    assert "again at every start, as the cache cannot be written" in str(one._replace(kept=False, law=""))


def test_what_is_compiled_is_told_once_with_its_law(monkeypatch):
    class Stiffening(sw.Cubic):
        """A law that no other test has compiled."""

    def torque_of(law, x):
        return law.torque(x)

    law, seen, law_of = Stiffening(2.0, 1.0), [], module.law_of
    monkeypatch.setattr(module, "law_of", lambda kinds: seen.append(law_of(kinds)) or seen[-1])
    monkeypatch.setattr(jit, "cache_writable", lambda: False)
    for x in (1.0, 2.0):
        assert jit.run(torque_of, law, x) == pytest.approx(law.torque(x), rel=1e-15)
    assert seen == ["Stiffening"]
