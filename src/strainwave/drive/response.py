"""The response through the speed range by harmonic balance: stability, folds, what a sweep does on it.

What the gear of an error equation transmits and loses, and how strongly it is damped: with any law, and varying.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.law import depends, is_spring, losses_of, torque_of
from ..base.protocols import lacking, lines_of
from ..base.quantities import checked
from ..base.records import Labelled, Result
from ..base.results import Branch, Floats
from ..base.sentences import on_screen
from ..compile.blas import one_thread
from ..numerics.balance.harmonics import grown, highest_order
from ..numerics.balance.rates import periodic
from ..numerics.balance.truncation import MATTERS
from ..numerics.continuation.passage import Coexisting
from ..numerics.continuation.trace import describe, with_crests
from ..numerics.curves.over_a_turn import traced_turn
from ..numerics.curves.response import frequencies, response_curve, with_others
from ..numerics.stability.first_order import with_special_points
from .jumps import Jumps, jumps

HARMONICS, WITH_KINKS, MOST = 7, 15, 63  # per turn for smooth laws, for laws with breakpoints, and at most
POINTS = 100  # about so many, and more where the curve bends
PER_HARMONIC, FEWEST = 32, 8  # samples of a period of the highest harmonic, or of this one, for the largest torque

SETTLE = 8.0  # in units of 1/mu: the transient falls to exp(-4) before the orbit is closed
UNDAMPED_PERIODS = 50
ANGLES = 2.0 * np.pi * np.arange(256) / 256


def damping_of(system: Any) -> float:
    """Damping [N*m*s/rad] across the gear of small motions, the mean over a turn; without friction in the law."""
    if not lacking(system, "B"):
        return float(system.B)
    return float(np.mean(np.broadcast_to(system.damping.value(ANGLES, 0.0), ANGLES.shape)))


def loses_energy(system: Any) -> bool:
    """Whether motions lose energy: by damping, or in a law with friction or memory."""
    return damping_of(system) > 0.0 or depends(system.law) > 1


def no_multiple_scales(system: Any) -> str:
    """Why multiple scales does not describe a system, as a sentence; empty where it can."""
    if depends(system.law) > 1:
        return "first-order multiple scales describes springs, and this law has friction or memory"
    if lacking(system, "B"):
        return "first-order multiple scales describes a constant stiffness and damping, and these vary"
    return ""


def gear_torque(system: Any, phase: Any, u: Any, du: Any, z: Any = ()) -> Any:
    """Torque through the gear [N*m, output side] with its damping, at torsion u [rad], rate [rad/s] and states z."""
    torque = torque_of(system.law, u, du, z)
    if not lacking(system, "B"):
        return torque + system.B * du
    return system.variation.value(phase) * torque + system.damping.value(phase, du) * du


def heat(system: Any, phase: Any, u: Any, du: Any, z: Any = ()) -> Any:
    """Power [W] that damping, friction and memory turn into heat."""
    damping = system.damping.value(phase, du) if lacking(system, "B") else system.B
    return damping * du * du + sum(losses_of(system.law, u, du, z), 0.0)


def settling_time(system: Any) -> float:
    """Time [s] to wait for the transient; without damping it never goes, so a number of periods serves."""
    mu = damping_of(system) / system.J
    return SETTLE / mu if mu > 0.0 else UNDAMPED_PERIODS * 2.0 * math.pi / float(system.omega)


@dataclass(frozen=True, eq=False)
class ExactResponse(Result):
    """Every motion that repeats with the base angle, on the curve that connects both ends of the speed range.

    Attributes
    ----------
    curve : Branch
        Points in arc order with stability and folds.
    sweep : Jumps or None
        What a slow run-up and run-down do on it; None where no motion is stable, as without damping.
    """

    curve: Branch
    sweep: Jumps | None
    method: ClassVar[str] = "harmonic balance"

    def coordinates(self) -> Labelled:
        """As of the curve."""
        return self.curve.coordinates()

    def variables(self) -> Labelled:
        """Those of the curve, and whether a slow sweep visits a point."""
        visited = np.isin(np.arange(len(self.curve)), self.visited())
        return {**self.curve.variables(), "visited": ("point", visited, "")}

    def __str__(self) -> str:
        return on_screen(f"Response by {self.method}\n{self.curve}" + ("" if self.sweep is None else f"\n{self.sweep}"))

    def largest(self) -> int | None:
        """Number of the stable point with the largest |x| that a sweep visits; None where there is no sweep."""
        visited = self.visited()
        return int(visited[np.argmax(self.curve.peak[visited])]) if len(visited) else None

    def largest_oscillation(self) -> int | None:
        """Number of the stable point with the largest |x - mean| that a sweep visits; None where there is no sweep."""
        visited = self.visited()
        return int(visited[np.argmax(self.curve.oscillation[visited])]) if len(visited) else None

    def visited(self) -> NDArray[np.int64]:
        """Numbers of the stable points that a slow run-up or run-down visits; empty where there is no sweep."""
        return self._visited

    @cached_property
    def _visited(self) -> NDArray[np.int64]:
        return np.empty(0, np.int64) if self.sweep is None else np.union1d(self.sweep.run_up, self.sweep.run_down)

    def torque(self, system: Any) -> Floats:
        """Torque through the gear with its damping [N*m, output side] at every point (rows) and place of a turn."""
        coefficients, omega = self.curve.coefficients, self.curve.omega[:, None]
        k = np.arange(1, coefficients.shape[1] // 2 + 1)[:, None]
        theta = np.linspace(0.0, 2.0 * np.pi, PER_HARMONIC * max(FEWEST, len(k)), endpoint=False)
        waves = np.stack([np.cos(k * theta), np.sin(k * theta)], axis=1).reshape(-1, len(theta))
        slopes = np.stack([-k * np.sin(k * theta), k * np.cos(k * theta)], axis=1).reshape(-1, len(theta))
        u = coefficients[:, :1] + coefficients[:, 1:] @ waves - system.error.value(theta)
        rate = omega * (coefficients[:, 1:] @ slopes - system.error.slope(theta))
        if is_spring(system):
            return np.asarray(gear_torque(system, theta, u, rate))
        # the curve holds no internal states; the torque is tau - J x''
        bends = np.repeat(k * k, 2, axis=0) * waves
        return np.asarray(system.excitation.torque(theta) + system.J * omega * omega * (coefficients[:, 1:] @ bends))

    def torsion_amplitude(self, system: Any, order: int) -> Floats:
        """0-to-peak amplitude [rad] of the torsion's component at `order` times the base speed, at every point."""
        x = self.curve.coefficients
        if 2 * order >= x.shape[1]:
            return 0.0 * self.curve.omega
        lines = [line for line in lines_of(system.error) if line.order == order]
        even = x[:, 2 * order - 1] - sum(line.amplitude * math.cos(line.phase) for line in lines)
        odd = x[:, 2 * order] + sum(line.amplitude * math.sin(line.phase) for line in lines)
        return np.asarray(np.hypot(even, odd))


@one_thread
def exact_response(
    system: Any, speeds: tuple[float, float], points: int = POINTS, given: int | None = None, coexisting: bool = True
) -> ExactResponse:  # fmt: skip
    """Follow the response of an error equation through a range of base-angle speeds [rad/s].

    The harmonics are those given, or grow until those left out do not show; `curve.tail` says how large these are.
    Without `coexisting` motions that do not join the curve are not looked for at its ends.
    """
    if not is_spring(system):
        return turn_response(system, speeds, points, given, coexisting).response
    highest = highest_order(system)
    most = max(MOST, highest + 2)
    harmonics = given or min(most, max(highest, WITH_KINKS) if system.breakpoints() else HARMONICS * highest)

    system, others = periodic("frequency_response", checked(system)), Coexisting() if coexisting else None

    def followed(h: int, _: float) -> tuple[Branch, float]:
        curve = response_curve(system, *frequencies(speeds), h, 1, points, others)
        return curve, curve.tail

    return with_sweep(grown(followed, harmonics, most if given is None else harmonics, MATTERS))


class TurnResponse(NamedTuple):
    """A response, and the balance problem and points of its curve."""

    problem: Any
    points: Floats
    response: ExactResponse


def turn_response(
    system: Any, speeds: tuple[float, float], points: int, given: int | None, coexisting: bool, locate: bool = True
) -> TurnResponse:  # fmt: skip
    """Response of any system through a range of speeds [rad/s], whose curve may be empty; see `traced_turn`.

    `locate`: the speeds where stability changes are located between points of the curve.
    """
    problem, found, tail, origin = traced_turn(system, speeds, points, given, coexisting)
    placed, labels = with_crests(problem, found.points, found.labels)
    found = replace(found, points=placed, labels=labels)
    curve = describe(problem, "omega", found, tail, origin, locate=False)
    if locate and np.any(np.diff(curve.stable)):
        placed, labels, floquet = with_special_points(problem, placed, labels, curve.multipliers)
        found = replace(found, points=placed, labels=labels)
        curve = describe(problem, "omega", found, tail, origin, locate=False, floquet=floquet)
    curve = with_others(problem, curve, found.elsewhere, [])
    return TurnResponse(problem, placed, with_sweep(curve))


def with_sweep(curve: Branch) -> ExactResponse:
    """A curve with what a slow run-up and run-down do on it."""
    try:
        return ExactResponse(curve, jumps(curve))
    except ValueError:  # nothing stable to follow
        return ExactResponse(curve, None)
