"""Steps of a method in an ensemble: their number, what they resolve, and the kernel that marches.

Fixed steps a period of each lane are enough for the fastest time scale that it meets.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.law import is_spring
from ...base.protocols import System, has_jacobian, lacking
from ...base.results import Floats
from ..integration.methods import Dopri5, FixedStep
from .adaptive_step import march_adaptive
from .fixed_step import march_pairs, march_steps

PER_ORDER = 4  # pieces of a fixed step per turn of the highest order that an amplitude is taken of
HIGHEST_ADAPTIVE = 20  # order, in those of the system, that steps of a relative tolerance of 1e-9 resolve to 1e-4
SETTLED_CHANGE = 1e-6  # largest change of a settled state from one period (or up to eight) to the next, of fixed steps
LOOSE = 1e4  # of adaptive ones, in units of their tolerance


@dataclass(frozen=True)
class AdaptiveLanes:
    """Adaptive steps, in every lane."""

    blocks: ClassVar = 1  # that are worth a chunk of a sweep
    kernel: ClassVar = staticmethod(march_adaptive)  # of a block

    method: Dopri5

    def arguments(self, omega: Floats, _: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the times (lanes,) that it counts in."""
        method = self.method
        return (float(method.rtol), float(method.atol), method.max_steps), 1.0 / omega

    def check(self, _: Any) -> None:
        """Refuse what lanes cannot do (ValueError)."""
        if self.method.largest_step is not None:
            raise ValueError(
                f"Dopri5.largest_step is {self.method.largest_step:g} s; steps of an ensemble are at most 1/16 of a "
                "turn: leave it out, or give Rk4(steps_per_period=...)"
            )

    def resolved(self, k: int, orders: tuple[int, ...]) -> tuple[float, str]:
        """Highest order of an amplitude that the steps resolve, and what does with order k.

        The steps follow the motion, whose orders are those of the system, not the cosine that it is multiplied by.
        """
        highest = max(1, int(HIGHEST_ADAPTIVE * (1e-9 / self.method.rtol) ** 0.2 * max((1, *orders))))
        return highest, f"a smaller rtol, or Dop8(steps_per_period={8 * PER_ORDER * -(-k // 8)})"

    def given(self, lanes: int) -> Any:
        """Steps a period (lanes,), all 0: every lane finds its own."""
        return np.zeros(lanes, int)

    def tolerances(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return max(SETTLED_CHANGE, LOOSE * self.method.rtol), 10.0 * self.method.atol


@dataclass(frozen=True)
class FixedLanes:
    """Equal steps of a method, on a phase grid that lanes share."""

    blocks: ClassVar = 32  # some run again to estimate the error, and lanes share those of one number of steps only

    method: FixedStep

    @property
    def kernel(self) -> Any:
        """March of a block."""
        return march_pairs if self.method.piece == 2 else march_steps

    def arguments(self, omega: Floats, steps: int) -> tuple[Any, Floats]:
        """Arguments of the march, and the steps (lanes,) [s]."""
        return (self.method.scheme, steps), 2.0 * np.pi / steps / omega

    def check(self, system: System) -> None:
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

    def tolerances(self) -> tuple[float, float]:
        """Relative and absolute distance below which a state has come back."""
        return SETTLED_CHANGE, 0.0

    def _rounded(self) -> int:
        return -(-(self.method.steps_per_period or 0) // 4) * 4


def stepping_of(method: Any) -> Any:
    """Steps of a method in an ensemble: `AdaptiveLanes` or `FixedLanes`."""
    return (AdaptiveLanes if method.adaptive else FixedLanes)(method)


def steps_known(system: System) -> bool:
    """True for a system that states its fastest rates: fixed steps can be chosen for it."""
    return has_jacobian(system) and not lacking(system, "orders")


LADDER = np.unique(4 * np.ceil(16.0 * 2.0 ** (np.arange(60) / 3.0) / 4.0).astype(int))  # 16, 24, 28, 32, 44, ...
PLACES = np.linspace(-1.0, 1.0, 33)  # of the torsion, in units of its largest value


def fastest_rates(system: Any, reach: Floats) -> Floats:
    """Largest modulus (lanes,) [1/s] of the eigenvalues of the Jacobian for torsions up to `reach` (lanes,)."""
    with np.errstate(all="ignore"):
        x = PLACES[:, None] * reach[None, :]
        rows = system.jacobian(0.0, (x, np.zeros_like(x)))
        stiffness, damping = [-np.broadcast_to(np.asarray(entry, float), x.shape) for entry in rows[1]]
        half = 0.5 * np.abs(damping)
        fast = np.where(half * half > stiffness, half + np.sqrt(np.abs(half * half - stiffness)), np.sqrt(stiffness))
    return np.asarray(np.max(np.where(np.isfinite(fast), fast, 0.0), axis=0))


def steps_needed(per_scale: int, fastest: Floats, omega: Floats, order: int) -> Any:
    """Steps a period (lanes,) for `per_scale` steps per shortest time scale, from a ladder of few numbers."""
    wanted = per_scale * np.maximum(fastest / omega, order)
    return LADDER[np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)]
