"""The numbers of a drive that the kernel `answer` gets, and its answer by machine code of this process."""

from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import linear_part_of
from ...base.results import Floats
from ...compile.address import ByAddress
from ...compile.jit import run
from ...compile.tree import leaf_of
from ..addressed import law_at
from ..balance.condensed.build import lines_of_error, repeats
from ..balance.condensed.pencil import to_real
from ..balance.condensed.problem import Condensed, assembled
from ..balance.harmonics import highest_order
from ..balance.piecewise import is_piecewise_linear
from ..balance.rates import is_second_order
from .answer import MOST_POINTS, answer
from .inner_balance import Drive, Functions
from .over_a_turn import of_drive, of_spring


class EquationPart:
    """The linear part of an oscillator, as that of a train."""

    follows, loose, gear_damping = False, -1, 0.0

    def __init__(self, system: Any) -> None:
        none, one = np.zeros((1, 1)), np.ones(1)
        self.inertia, self.damping, self.stiffness = np.array([[float(system.J)]]), none, none
        self.per_speed = self.zero_mean = self.integral = np.zeros(1)
        self.laws, self.error, self.disturbed = (system.law,), system.error, system
        self.values, self.rates = np.array([one, 0.0 * one]), np.array([0.0 * one, one])
        self.excitation, self.gear_damping = system.excitation, float(system.B)

    def forces(self, angles: Floats) -> Floats:
        """Torques (1, samples) at base angles [rad]."""
        return np.asarray(self.excitation.torque(angles) + 0.0 * angles)[None]


class Begin(NamedTuple):
    """Harmonics to begin with and at most, and how many of them are one of a `Drive`."""

    harmonics: int
    most: int
    per: int


def problem_for(system: Any, speeds: tuple[float, float]) -> Condensed:
    """The balance of an oscillator or a train with the harmonics of what drives it, at the middle of a range [rad/s].

    Raises
    ------
    ValueError
        If it is not linear around laws of twists, or its kinematic error has no end of lines.
    """
    leaf = leaf_of(system, "omega")
    middle = system._replace(omega=(speeds[0] * speeds[1]) ** 0.5)
    top = highest_order(middle)
    part: Any = EquationPart(middle) if is_second_order(middle) else linear_part_of(middle)
    lines = None if part is None else lines_of_error(part.error)
    if lines is None:
        raise ValueError("it is not linear around its laws, or its kinematic error has too many lines")
    every = repeats(part, top)
    return assembled(middle, part, lines, leaf, leaf, max(1, top // every), 1, every)


def drive_numbers(problem: Condensed) -> Drive:
    """The numbers of a drive, its laws without addresses."""
    part, pencil = problem.part, problem.pencil
    calm = part if part.loose < 0 else linear_part_of(part.disturbed)
    disturbed = np.array([calm.inertia, calm.damping, calm.stiffness])
    return Drive(
        pencil.matrices, disturbed, to_real(pencil.forces), pencil.per_speed, np.array(part.zero_mean, float),
        part.values[0].copy(), problem.gear.lines, float(problem.gear_damping),
        np.zeros((len(part.laws), 10), np.int64), int(part.follows), pencil.loose, pencil.controls, problem.every,
        int(isinstance(part, EquationPart)),
    )  # fmt: skip


def beginning(problem: Condensed) -> Begin:
    """The harmonics that the response begins with."""
    top, g = problem.highest(), problem.every
    kinked = any(len(breakpoints_of(law)) for law in problem.part.laws)
    alone = isinstance(problem.part, EquationPart)
    return Begin(*(of_spring(top, kinked) if alone else of_drive(top, g, kinked)), g)


def answered(system: Any, speeds: tuple[float, float], limit: float, points: int) -> tuple[Floats, Floats, Floats, int]:
    """Rows of the curve, bands above a limit [rad] and what is `about` them, and what the kernel `answer` returns."""
    problem = problem_for(system, speeds)
    curve, pairs, about = np.zeros((MOST_POINTS, 6)), np.zeros((MOST_POINTS, 2)), np.zeros(5)
    drive, begin = drive_numbers(problem), beginning(problem)

    def functions(words: Any) -> Functions:
        known = problem.addressed(words)
        return Functions(known.equations_at, known.stiffness_at, known.slope_at)

    def addressed(words: Any) -> Drive:
        springs = problem.springs.addressed(words).places
        rows = [
            (*law_at(law, words(law)), *spring[1:], int(is_piecewise_linear(law)))
            for law, spring in zip(problem.part.laws, springs.tolist(), strict=True)
        ]
        return drive._replace(laws=np.array(rows, np.int64))

    count = run(
        answer, ByAddress(drive, addressed), ByAddress(drive, functions), *map(float, (*speeds, limit)), points, *begin,
        curve, pairs, about,
    )  # fmt: skip
    return curve[: max(0, count)], pairs[: int(about[2])], about, int(count)
