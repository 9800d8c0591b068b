"""How an ensemble takes the steps of a method: what they resolve, how many there are, and the kernel that marches."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...law import is_spring
from ...protocols import has_jacobian, lacking
from ...results import Floats
from ..integration.methods import AdaptiveStep, FixedStep
from .adaptive_step import march_adaptive
from .fixed_step import march_pairs, march_steps

PER_ORDER = 4  # pieces of a fixed step per turn of the highest order that an amplitude is taken of
HIGHEST_ADAPTIVE = 20  # order, in those of the system, that steps of a relative tolerance of 1e-9 resolve to 1e-4
SETTLED = 1e-6  # largest change of a settled state from one period (or up to eight) to the next, of fixed steps
LOOSE = 1e4  # of adaptive ones, in units of their tolerance


@dataclass(frozen=True)
class AdaptiveLanes:
    """Steps of a method that adapts them, in every lane."""

    blocks: ClassVar = 1  # that are worth a chunk of a sweep
    of_thread: ClassVar = 1  # lanes of a thread of a graphics processor

    method: AdaptiveStep

    @property
    def kernel(self) -> Any:
        """March of a block."""
        return march_adaptive

    def arguments(self, omega: Floats, _: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the times (lanes,) that it counts in."""
        method = self.method
        return (method.scheme, float(method.rtol), float(method.atol), method.max_steps), 1.0 / omega

    def check(self, _: Any) -> None:
        """Refuse what lanes cannot do (ValueError)."""
        if self.method.largest_step is not None:
            name = type(self.method).__name__
            raise ValueError(
                f"{name}.largest_step is {self.method.largest_step:g} s; steps of an ensemble are at most 1/16 of a "
                "turn: leave it out, or give Rk4(steps_per_period=...)"
            )

    def resolved(self, k: int, orders: tuple[int, ...]) -> tuple[float, str]:
        """Highest order of an amplitude that the steps resolve, and what does with order k.

        The steps follow the motion, whose orders are those of the system, not the cosine that it is multiplied by.
        """
        most = max(1, int(HIGHEST_ADAPTIVE * (1e-9 / self.method.rtol) ** 0.2 * max((1, *orders))))
        return most, f"a smaller rtol, or Dop8(steps_per_period={8 * PER_ORDER * -(-k // 8)})"

    def given(self, lanes: int) -> Any:
        """Steps a period (lanes,), all 0: every lane finds its own."""
        return np.zeros(lanes, int)

    def near(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return max(SETTLED, LOOSE * self.method.rtol), 10.0 * self.method.atol


@dataclass(frozen=True)
class FixedLanes:
    """Equal steps of a method, on a phase grid that lanes share."""

    blocks: ClassVar = 32  # some run again to estimate the error, and lanes share those of one number of steps only

    method: FixedStep

    @property
    def of_thread(self) -> int:
        """Lanes of a thread of a graphics processor, which share cosines: long steps leave no registers for two."""
        return 4 if self.method.piece == 2 else 1

    @property
    def kernel(self) -> Any:
        """March of a block."""
        return march_pairs if self.method.piece == 2 else march_steps

    def arguments(self, omega: Floats, steps: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the steps (lanes,) [s]."""
        return (self.method.scheme, steps), 2.0 * np.pi / steps / omega

    def check(self, system: Any) -> None:
        """Refuse a system for which a step cannot be chosen (TypeError)."""
        if self.method.steps_per_period is None and not steps_known(system):
            name = type(system).__name__
            spring = is_spring(system)
            lacks = f"{name} has no jacobian and orders" if spring else "a law with friction or memory has no rate"
            raise TypeError(f"{lacks} to choose a step from; give steps_per_period or use Dopri5")

    def resolved(self, k: int, _: tuple[int, ...]) -> tuple[float, str]:
        """Highest order of an amplitude that the steps resolve, and what does with order k."""
        if self.method.steps_per_period is None:
            return np.inf, ""
        pieces = self._rounded() // self.method.piece
        return pieces // PER_ORDER, f"steps_per_period={PER_ORDER * self.method.piece * k}"

    def order_for(self, k: int) -> int:
        """Order that the system is to be taken to have, so that the method's own steps resolve an amplitude."""
        return -(-k * PER_ORDER * self.method.piece // self.method.steps)

    def given(self, lanes: int) -> Any:
        """Steps a period (lanes,), fours, where they are given."""
        return None if self.method.steps_per_period is None else np.full(lanes, self._rounded())

    def near(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return SETTLED, 0.0

    def _rounded(self) -> int:
        return -(-(self.method.steps_per_period or 0) // 4) * 4


def stepping_of(method: Any) -> Any:
    """How an ensemble takes the steps of a method: `AdaptiveLanes` or `FixedLanes`."""
    return (AdaptiveLanes if method.adaptive else FixedLanes)(method)


def steps_known(system: Any) -> bool:
    """Whether a system says how fast it is: fixed steps can be chosen for it."""
    return has_jacobian(system) and not lacking(system, "orders")
