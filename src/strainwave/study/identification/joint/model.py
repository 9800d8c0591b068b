"""Numbers of a joint, and the load's angles that they give in pieces of a log."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ....base.results import Floats
from ....compile.jit import run
from . import march as places
from .march import march
from .pieces import Piece

NUMBERS = (  # numbers besides lines and starts, in the order of the kernel, then those of the loads and encoders
    "inertia", "K1", "K2", "K3", "T1", "T2", "B", "hysteresis", "yield_twist", "coulomb", "viscous", "load_friction",
    "gap", "asymmetry", "drag", "gravity_cos", "gravity_sin", "gravity_mean", "offset", "skew",
)  # fmt: skip
TORQUES = ("inertia", "K1", "K2", "K3", "T1", "T2", "B", "hysteresis", "coulomb", "viscous", "drag")
OF_KERNEL = 15
POSITIVE = 9  # the first of them, whose logarithms are free
APART = 1.02  # of T1: the least T2
DIFFERENCE = 1e-5  # of a number's scale: a larger one tells apart by a bend of the law what no log parts

Pair = tuple[int, int]


class Scale(NamedTuple):
    """First value (of a logarithm: factor), unit of the free number, and how far it may be from the first, in units."""

    first: float
    unit: float
    prior: float


def scales(inertia: float, law: Sequence[float], omega: float) -> dict[str, Scale]:
    """First value, unit and width of the prior of each free number; law is K1, K2, K3, T1, T2 of the datasheet.

    `omega` is the natural frequency of the load [rad/s]. Numbers without a datasheet begin at what such gears have.
    """
    T2 = law[4]
    slopes = {name: Scale(value, 1.0, 0.2) for name, value in zip(NUMBERS[1:6], law, strict=True)}
    return {"inertia": Scale(inertia, 1.0, 1.0), **slopes} | {
        "B": Scale(inertia * omega / 20.0, 1.0, 2.0),
        "hysteresis": Scale(0.02 * T2 / 8e-5, 1.0, 1.5),
        "yield_twist": Scale(8e-5, 1.0, 0.7),
        "coulomb": Scale(0.0, 0.01 * T2, 30.0),
        "viscous": Scale(0.0, 0.01 * T2, 100.0),
        "load_friction": Scale(0.0, 0.01, 30.0),
        "gap": Scale(0.0, 1e-5, 30.0),
        "asymmetry": Scale(0.0, 0.01, 30.0),
        "drag": Scale(0.0, 0.01 * T2, 100.0),
        "gravity_cos": Scale(0.0, 0.01 * T2, 300.0),
        "gravity_sin": Scale(0.0, 0.01 * T2, 300.0),
        "gravity_mean": Scale(0.0, 0.01 * T2, 300.0),
        "offset": Scale(0.0, 1e-5, 1e6),
        "skew": Scale(0.0, 1e-5, 1e3),
    }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Joint:
    """Numbers of a joint in pieces of its logs, and how the load would move.

    Attributes
    ----------
    pieces : tuple of Piece
        The measured motion.
    ratio : float
        Of the gear.
    scales : dict of str to Scale
        Of every number.
    values : dict of str to float
        Numbers in SI by name; lines are "line(j, k) cos" and "line(j, k) sin".
    lines : tuple of (int, int)
        Lines of the kinematic error: so many times the motor's turn, and the load's.
    starts : (pieces, 3) array
        Angle and speed of the load, and the twist of the hysteresis, at the begin of every piece.
    free : tuple of str
        Names of the free numbers, without the starts.
    gains : (2,) array
        By which the motion is drawn to the measured angle; 0: it runs freely, and starts are free too.
    lead : float
        Skew [s] with which gravity and lines are taken from the load's readings.
    """

    pieces: tuple[Piece, ...]
    ratio: float
    scales: dict[str, Scale]
    values: dict[str, float]
    lines: tuple[Pair, ...]
    starts: Floats
    free: tuple[str, ...]
    gains: Floats
    lead: float = 0.0
    kept: dict[Pair, list[Floats]] = field(default_factory=dict)

    @cached_property
    def waves(self) -> list[dict[str, Floats]]:
        """Drive [u, u', pull] (3, 2 n + 1) of each piece per unit of a number, for those that are linear in it."""
        rows = []
        for i, piece in enumerate(self.pieces):
            zero = np.zeros(len(piece.motor))
            load = self.turned(piece)
            c, s = np.cos(load), np.sin(load)
            made = {
                "gravity_cos": np.array([zero, zero, c]), "gravity_sin": np.array([zero, zero, s]),
                "gravity_mean": np.array([zero, zero, zero + 1.0]),
            }  # fmt: skip
            for pair in self.lines:
                made |= dict(zip(line_names(pair), self.line_waves(pair)[i], strict=True))
            rows.append(made)
        return rows

    def turned(self, piece: Piece) -> Floats:
        """Angle of the load at the motor's stamps (2 n + 1,)."""
        return np.asarray(np.interp(piece.grid - self.lead, piece.grid, piece.load))

    def aligned(self) -> "Joint":
        """The joint whose gravity and lines are taken with the skew that was found."""
        return replace(self, lead=self.values["skew"], kept={})

    def line_waves(self, pair: Pair) -> list[Floats]:
        """Drives (2, 3, 2 n + 1) of a line's cosine and sine in each piece."""
        if pair not in self.kept:
            self.kept[pair] = []
            for piece in self.pieces:
                angle, rate = pair[0] * piece.motor + pair[1] * self.turned(piece), pair[0] * piece.motor_rate
                rate = rate + pair[1] * piece.load_rate
                c, s, zero = np.cos(angle), np.sin(angle), np.zeros(len(angle))
                self.kept[pair].append(-np.array([[c, -s * rate, zero], [s, c * rate, zero]]))
        return self.kept[pair]

    def with_lines(self, *pairs: Pair) -> "Joint":
        """The joint with more lines, of amplitude 0 and free."""
        names = [name for pair in pairs for name in line_names(pair)]
        return replace(
            self, lines=(*self.lines, *pairs), values=self.values | dict.fromkeys(names, 0.0),
            scales=self.scales | {name: Scale(0.0, 1e-6, 1e3) for name in names}, free=(*self.free, *names),
        )  # fmt: skip

    def kernel_numbers(self, values: dict[str, float]) -> Floats:
        """Numbers in the order of the kernel."""
        p = np.array([values[name] for name in NUMBERS[:OF_KERNEL]])
        p[places.T2] = max(p[places.T2], APART * p[places.T1])
        return p

    def drive(self, i: int, values: dict[str, float]) -> Floats:
        """Angle of the rigid gear, its rate, the load's pull and its measured angle (4, 2 n + 1) in a piece."""
        piece, made = self.pieces[i], self.waves[i]
        drive = np.zeros((4, len(piece.motor)))
        np.divide(piece.motor, self.ratio, out=drive[0])
        np.divide(piece.motor_rate, self.ratio, out=drive[1])
        for name, wave in made.items():
            if values[name]:
                drive[:3] += values[name] * wave
        if self.gains[0]:
            drive[3] = piece.load - values["skew"] * piece.load_rate - self.offset(i, values)
        return drive

    def predicted(self, i: int, values: dict[str, float], start: Floats, drive: Floats | None = None) -> Floats:
        """Angles of the load at its own stamps in a piece (m,)."""
        drive = self.drive(i, values) if drive is None else drive
        return self.marched(i, values, start, drive)[1] + self.offset(i, values)

    def marched(self, i: int, values: dict[str, float], start: Floats, drive: Floats) -> tuple[Floats, Floats]:
        """Angle, speed and the gear's torque (n + 1, 3) on the grid of a piece; angles (m,) at the load's stamps."""
        piece = self.pieces[i]
        stamps = (piece.time + values["skew"] - piece.begin) / piece.step
        states, read = np.empty((len(piece) + 1, 3)), np.empty(len(stamps))
        run(march, self.kernel_numbers(values), drive, piece.step, start, self.gains, stamps, states, read)
        return states, read

    def torque(self, i: int) -> Floats:
        """Torque [N*m] of the gear on the grid of a piece (n + 1,)."""
        return self.marched(i, self.values, self.starts[i], self.drive(i, self.values))[0][:, 2]

    def turn_of_motor(self, i: int) -> Floats:
        """Turn of the rigid gear for one of the motor on the grid of a piece (n + 1,): 1/ratio, and what lines add."""
        turn = np.full(len(self.pieces[i]) + 1, 1.0 / self.ratio)
        for pair in self.lines:
            (c, _, _), (s, _, _) = self.line_waves(pair)[i]
            a, b = (self.values[name] for name in line_names(pair))
            turn += pair[0] * (b * c - a * s)[::2]
        return turn

    def offset(self, i: int, values: dict[str, float] | None = None) -> float:
        """Reading of the load where motor and load are at 0, in a piece: each log after the first has its own."""
        values = self.values if values is None else values
        return values["offset"] + values.get(f"offset {self.pieces[i].log + 1}", 0.0)

    def residuals(self) -> list[Floats]:
        """Measured less predicted angles [rad] in every piece."""
        return [p.value - self.predicted(i, self.values, self.starts[i]) for i, p in enumerate(self.pieces)]

    def twists(self) -> list[Floats]:
        """Predicted torsion [rad] of the spring at the load's stamps in every piece."""
        torsions = []
        for i, piece in enumerate(self.pieces):
            drive = self.drive(i, self.values)
            load = self.predicted(i, self.values, self.starts[i], drive) - self.offset(i)
            torsions.append(np.interp(piece.time + self.values["skew"], piece.grid, drive[0]) - load)
        return torsions

    @property
    def weights(self) -> Floats:
        """Weights (rows,) of all angles."""
        return np.concatenate([piece.weight for piece in self.pieces])

    def changed(self, name: str, by: float) -> dict[str, float]:
        """Values with one number changed by so many of its units."""
        value = self.values[name]
        new = value * float(np.exp(by)) if self.is_log(name) else value + by * self.scales[name].unit
        return {**self.values, name: new}

    @staticmethod
    def is_log(name: str) -> bool:
        """True if the logarithm of a number is what is free."""
        return name in NUMBERS[:POSITIVE]

    def moved(self, change: Floats) -> "Joint":
        """The joint after a change (free + 3 pieces,) of its free numbers and starts, in units.

        A change of a logarithm is clipped to 1 either way. Starts stay where gains draw the motion to the readings.
        """
        values = dict(self.values)
        for name, by in zip(self.free, change[: len(self.free)].tolist(), strict=True):
            values[name] = self.changed(name, float(np.clip(by, -1.0, 1.0)) if self.is_log(name) else by)[name]
        starts = self.starts
        if not self.gains[0]:
            starts = starts + change[len(self.free) :].reshape(-1, 3) * START_UNITS
        return replace(self, values=values, starts=starts)

    def scaled(self, factor: float) -> "Joint":
        """The joint with all inertias, stiffnesses and torques so many times as large: it moves alike."""
        values = {n: factor * v if n in TORQUES or n.startswith("gravity") else v for n, v in self.values.items()}
        return replace(self, values=values)

    def columns(self, names: Sequence[str]) -> Floats:
        """Derivatives (rows, names) of all predicted angles by numbers, per unit."""
        return np.concatenate([self.derivatives(i, names) for i in range(len(self.pieces))])

    def varied(self, i: int, name: str, drive: Floats) -> tuple[dict[str, float], Floats]:
        """Values with one number a little off, and the drive of a piece with them."""
        values = self.changed(name, DIFFERENCE)
        if name in self.waves[i]:
            other = drive.copy()
            other[:3] += (values[name] - self.values[name]) * self.waves[i][name]
            return values, other
        return values, self.drive(i, values) if self.gains[0] and name.startswith(("offset", "skew")) else drive

    def derivatives(self, i: int, names: Sequence[str], start: bool = False, torque: bool = False) -> Floats:
        """Derivatives (m, names) of a piece's angles, or of the gear's torque on its grid, by numbers, perhaps starts.

        Per unit; of the start there are three columns.
        """
        drive, begun, predictions = self.drive(i, self.values), self.starts[i], list[Floats]()
        cases = [(self.values, drive, begun), *((*self.varied(i, name, drive), begun) for name in names)]
        if start:
            cases += [(self.values, drive, begun + DIFFERENCE * unit) for unit in np.diag(START_UNITS)]
        for values, other, initial in cases:
            states, read = self.marched(i, values, initial, other)
            predictions.append(states[:, 2] if torque else read + self.offset(i, values))
        return (np.stack(predictions, axis=1)[:, 1:] - predictions[0][:, None]) / DIFFERENCE

    def jacobian(self) -> Floats:
        """Derivatives (rows, free + 3 pieces) of all predicted angles [rad] by the free numbers and the starts."""
        if self.gains[0]:
            return self.columns(self.free)
        many, parts = len(self.free), [self.derivatives(i, self.free, start=True) for i in range(len(self.pieces))]
        starts = block_diag(*(part[:, many:] for part in parts))
        return np.concatenate([np.concatenate([part[:, :many] for part in parts]), starts], axis=1)

    def away(self) -> tuple[Floats, Floats]:
        """Distance of free numbers and starts from the first ones, in priors, and one prior in units."""
        far, priors = [], []
        for name in self.free:
            scale, value = self.scales[name], self.values[name]
            off = np.log(value / scale.first) if self.is_log(name) else (value - scale.first) / scale.unit
            far.append(off / scale.prior)
            priors.append(scale.prior)
        if self.gains[0]:
            return np.array(far), np.array(priors)
        starts, of = self.starts / START_UNITS / START_PRIORS, np.tile(START_PRIORS, len(self.starts))
        starts[:, :2] = 0.0
        return np.append(far, starts), np.append(priors, of)


START_UNITS = np.array([1e-5, 1e-4, 1e-5])  # rad, rad/s, rad
START_PRIORS = np.array([1e4, 1e4, 10.0])  # units


def line_names(pair: Pair) -> tuple[str, str]:
    """Names of a line's two numbers."""
    return f"line({pair[0]}, {pair[1]}) cos", f"line({pair[0]}, {pair[1]}) sin"
