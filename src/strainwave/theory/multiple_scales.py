"""First-order multiple scales for any law (API; bodies follow)."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from ..results import Floats
from .resonance import Resonance
from .slow_results import Certificate, Evolution, SlowResponse, SteadyState


@dataclass(frozen=True)
class SlowFlow:
    """The slow flow of a system at a resonance."""

    system: Any
    resonance: Resonance

    def steady_states(self) -> list[SteadyState]:
        """All fixed points, by descending amplitude."""
        raise NotImplementedError

    def exists(self) -> bool:
        """Whether a steady state with a > 0 exists."""
        raise NotImplementedError

    @property
    def existence(self) -> str:
        """The existence condition of nontrivial states, with numbers."""
        raise NotImplementedError

    def evolve(self, y0: ArrayLike, t: ArrayLike) -> Evolution:
        """Transient from the physical state y0 = (x, x') at t[0]."""
        raise NotImplementedError

    def x(self, t: ArrayLike, y0: ArrayLike = (0.0, 0.0)) -> Floats:
        """Dynamic error x(t) of the transient from y0 at time 0."""
        raise NotImplementedError

    def rates(self, z: complex) -> complex:
        """Rate of z = a exp(-i phase)."""
        raise NotImplementedError

    def response(self, band: tuple[float, float]) -> SlowResponse:
        """Steady amplitude against omega in the band (lo, hi)."""
        raise NotImplementedError

    def backbone(self, amplitudes: ArrayLike) -> Floats:
        """Frequencies Omega(a) without damping and forcing."""
        raise NotImplementedError

    def certificate(self) -> Certificate:
        """How far the result can be trusted."""
        raise NotImplementedError


def slow_flow(system: Any, resonance: Resonance, *, order: int = 1) -> SlowFlow:
    """Reduce a system to the slow flow of a resonance."""
    raise NotImplementedError
