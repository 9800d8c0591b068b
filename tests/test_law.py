"""What a law must be, as the verbs check it."""

from typing import NamedTuple

import pytest

import strainwave as sw
from strainwave.base.law import check_law
from strainwave.maths import sqrt, tanh


class Hardening(NamedTuple):
    """T = K (x + alpha x^3), whose stiffness has the factor `times` where 3 is right."""

    K: float
    alpha: float
    times: float = 3.0

    def torque(self, x):
        return self.K * (x + self.alpha * x * x * x)

    def stiffness(self, x):
        return self.K * (1.0 + self.times * self.alpha * x * x)


class Stop(NamedTuple):
    """A spring and an end stop that says where it begins, or does not; its slope there is that of one side."""

    K: float
    at: float
    more: float = 9.0
    says: int = 1

    def torque(self, x):
        return self.K * (x + self.more * 0.5 * (x - self.at + abs(x - self.at)))

    def stiffness(self, x):
        return self.K * (1.0 + self.more * (x >= self.at))

    def breakpoints(self):
        return (self.at,) if self.says else ()


class Jump(NamedTuple):
    """A constant torque against the torsion, whose slope is that of a wide step."""

    T: float
    width: float
    slope: float = 1.0

    def torque(self, x):
        return self.T * tanh(x / self.width)

    def stiffness(self, x):
        t = tanh(x / self.width)
        return self.slope * self.T / self.width * (1.0 - t * t)


class Preloaded(NamedTuple):
    """A small spring beside a large constant torque, found as the difference of large numbers."""

    T: float

    def torque(self, x):
        return self.T + sqrt(1.0 + x * x) - 1.0

    def stiffness(self, x):
        return x / sqrt(1.0 + x * x)


class Silent(NamedTuple):
    """A law that is not known beyond a torsion, or raises there."""

    end: float

    def torque(self, x):
        return [x][int(abs(x) > self.end)]

    def stiffness(self, x):
        return [1.0][int(abs(x) > self.end)]


@pytest.mark.parametrize(
    "law",
    [
        Hardening(1.0, 0.1), Hardening(7160.0, 1.5e5), Hardening(7160.0, -1.5e5), Hardening(1e-9, 1e8),
        Stop(1e5, 1e-3), Stop(1.0, 0.3), Stop(1.0, 0.0, says=0), Stop(1e5, 1.237e-3, says=0), Stop(0.0, 1.0),
        Jump(5.0, 1e-9), Jump(5.0, 10.0), Preloaded(1e4), Silent(1e-3),
    ],
    ids=repr,
)  # fmt: skip
def test_a_law_whose_stiffness_is_its_slope_passes(law):
    check_law("law", law)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (
            Hardening(1.0, 0.1, 1.0),
            "Hardening.stiffness at 1.237 rad gives 1.153 N*m/rad and its torque rises by 1.459",
        ),
        (Jump(5.0, 1e-3, 2.0), "Jump.stiffness at 1.237e-05 rad gives 9998 N*m/rad and its torque rises by 4999"),
        (Jump(5.0, 1e-3, -1.0), "Jump.stiffness at 1.237e-05 rad gives -4999 N*m/rad and its torque rises by 4999"),
    ],
)
def test_a_law_whose_stiffness_is_not_its_slope_is_refused_with_both_numbers(law, said):
    system = sw.Oscillator(1.0, 0.1, law, sw.Harmonic(1.0), 1.0)
    with pytest.raises(ValueError, match="must be the derivative of torque") as refusal:
        sw.frequency_response(system, (0.5, 1.5))
    assert said in str(refusal.value)


def test_the_slope_is_compared_between_breakpoints_too():
    class Between(Stop):
        def stiffness(self, x):
            return 2.0 * self.K if 0.0301 < x < 0.0399 else Stop.stiffness(self, x)

        def breakpoints(self):
            return 0.03, 0.04

    with pytest.raises(ValueError, match=r"at 0\.035 rad gives 2 N\*m/rad and its torque rises by 1 N\*m/rad"):
        check_law("law", Between(1.0, 0.04))


def test_the_slopes_of_the_packages_own_laws_are_not_looked_at_again(monkeypatch):
    monkeypatch.setattr("strainwave.base.law._check_slope", lambda law: pytest.fail(f"{law} was differentiated"))
    check_law("law", sw.Cubic(1e5, 1.0))
