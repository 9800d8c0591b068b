"""What is told about kernels that are being compiled."""

from threading import Event, Thread

import pytest

import strainwave as sw
from strainwave.compile import cache as module
from strainwave.compile import jit

pytestmark = pytest.mark.slow


def test_a_kernel_is_listed_while_it_is_compiled_and_not_afterwards():
    begun, go_on = Event(), Event()

    def slow(kinds):
        begun.set()
        go_on.wait(10.0)
        return len(kinds)

    made = []
    thread = Thread(target=lambda: made.append(module.with_progress(slow, "follow", lambda: None)((1, 2))))
    thread.start()
    assert begun.wait(10.0)
    (one,) = module.compiling()
    assert one.kernel == "follow"
    go_on.set()
    thread.join()
    assert made == [2]
    assert module.compiling() == ()


def test_a_kernel_that_cannot_be_compiled_is_not_listed_afterwards():
    def broken(_kinds):
        raise TypeError("no")

    with pytest.raises(TypeError, match="no"):
        module.with_progress(broken, "follow", lambda: None)(())
    assert module.compiling() == ()


def test_the_sentence_says_how_often():
    one = module.Compilation("follow", kept=True)
    assert str(one) == "preparing machine code, once per machine"
    assert str(one._replace(kept=False)) == (
        "preparing machine code, again at every start, as the cache cannot be written"
    )


@pytest.mark.slow
def test_what_is_compiled_is_told_once_for_kinds_of_arguments(monkeypatch):
    class Stiffening(sw.Cubic):
        """A law that no other test has compiled."""

    def torque_of(law, x):
        return law.torque(x)

    law, seen, told = Stiffening(2.0, 1.0), [], module.Compilation
    monkeypatch.setattr(module, "Compilation", lambda *fields: seen.append(fields[0]) or told(*fields))
    monkeypatch.setattr(module.CodeCache, "location", lambda *_: ([], None, ""))
    for x in (1.0, 2.0):
        assert jit.run(torque_of, law, x) == pytest.approx(law.torque(x), rel=1e-15)
    assert seen == ["torque_of"]
