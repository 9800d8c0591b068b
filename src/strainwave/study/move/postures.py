"""A move in every posture of a machine: which asks most of the drive."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ...base.facts import Fact, lines
from ...drive.postures import Posture, cases_of, titled
from ...drive.project import Project
from .move import move
from .result import Move

MEASURES = {
    "pointing_error_rad": "peak_error", "settling_time_s": "settling_time", "gear_peak_torque_N_m": "peak_gear_torque",
    "motor_peak_torque_N_m": "peak_motor_torque", "motor_rms_torque_N_m": "rms_motor_torque",
}  # fmt: skip


class PostureMoves(NamedTuple):
    """Moves of a drive, one in each posture."""

    postures: tuple[Posture, ...]
    moves: tuple[Move, ...]

    def worst(self, measure: str) -> int:
        """Number of the posture, from 0 on, with the largest of a measure of `Move`; None, not settled, is largest."""
        values = [getattr(one, measure) for one in self.moves]
        return max(range(len(values)), key=lambda i: float("inf") if values[i] is None else values[i])

    def title(self, i: int) -> str:
        """Number of a posture, from 1 on, with its name."""
        return titled(i + 1, self.postures[i].name)

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of the moves, once."""
        count, worst = range(len(self.moves)), {key: self.worst(name) for key, name in MEASURES.items()}
        failures = tuple(f"{self.title(i)}: {sentence}" for i in count for sentence in self.moves[i].failures)
        largest = []
        for key, i in worst.items():
            words = key.removesuffix("_rad").removesuffix("_s").removesuffix("_N_m").replace("_", " ")
            largest += list(lines([Fact(key, self._value(key, i), f"largest {words}: {{}}, {self.title(i)}")]))
        unknown = sum(row.torque is None for row in self.postures)
        note = f"{unknown} postures have no gravity torque; the mean torque of the project file is used for them"
        return (
            Fact("failures", failures, "FAIL: {}"),
            Fact("passes", None if self.moves[0].within_limits is None else not failures),
            Fact("", tuple(largest), "{}"),
            Fact("worst", {key: i + 1 for key, i in worst.items()}),
            Fact("postures", tuple(self._row(i) for i in count)),
            Fact("remarks", (note,) if unknown else (), "note: {}"),
        )

    def _value(self, key: str, i: int) -> Any:
        value = getattr(self.moves[i], MEASURES[key])
        return "not settled" if value is None else value

    def _row(self, i: int) -> tuple[Fact, ...]:
        posture = self.postures[i]
        load = Fact("inertia_kg_m2", posture.inertia), Fact("torque_N_m", posture.torque)
        numbers = (Fact(key, getattr(self.moves[i], name)) for key, name in MEASURES.items())
        return (Fact("posture", i + 1), *load, *numbers, Fact("passes", self.moves[i].within_limits))


def move_postures(
    project: Project, profile: Any = None, *, postures: Sequence[Posture] = (),
    progress: Callable[[float], None] = lambda _: None, **options: Any,
) -> PostureMoves:  # fmt: skip
    """Move a drive in every posture, each with a constant torque of gravity and the gains of the project.

    A posture has the whole load: the payload of the project's move is left out.

    Parameters
    ----------
    project : Project
        The drive.
    profile : Trapezoid, SCurve, AngleProfile, Dwell, or a list of them
        As of `move`.
    postures : sequence of Posture
        Default: those of the project.
    progress : callable
        progress(share): called before each move.
    **options
        As of `move`.

    Returns
    -------
    PostureMoves
        `moves`, a `Move` for each of the `postures`: `pointing_error` [rad], motor and gear torque [N*m] over `time`
        [s], `settling_time` [s].

    Raises
    ------
    ValueError
        If there is no posture, or as of `move`.
    """
    rows = tuple(postures) or project.postures
    if not rows:
        raise ValueError("there are no postures; give Posture(inertia, torque), or `postures` in the project file")
    moves, asked = [], replace(project, move=project.move and project.move._replace(payload=None))
    for i, case in enumerate(cases_of(replace(asked, postures=rows), ())):
        progress(i / len(rows))
        moves.append(move(case.on(asked), profile, **options))
    return PostureMoves(rows, tuple(moves))
