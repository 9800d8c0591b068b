"""Inertia, friction and torque constant of a motor, by its current or torque beside a joint that was fitted.

A torque at the load gives the scale of the joint's torques in the same way.
k (i - i0) = J_m a + u' T + (F_c + mu |T| / N) sign(v) + F_v v, with T the torque of the gear that the fit has, and u'
the turn of the rigid gear for one of the motor, is linear in 1/k, J_m/k, ...; a torque at the load is k (i - i0) = T.
Readings and columns are averaged over the same windows, so that none is filtered more than the other. Windows in which
the motor hardly turns are left out: at rest dry friction takes any value.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from ....base.results import Floats
from ..run import saturated
from .model import Joint
from .pieces import FEWEST, channel_of, through

OF_MOTOR, OF_GEAR = ("motor_torque", "current"), ("torque", "load_torque")
COLUMNS = ("scale", "offset", "motor_inertia", "motor_coulomb", "motor_viscous", "motor_load_friction")
WINDOW = 10  # steps of the grid, over which a channel is averaged, and once more
SLOW = 0.25  # of the largest speed: below it dry friction is not known, and larger than above
FARTHEST = 0.02  # s, of a skew


class Part(NamedTuple):
    """Readings of a channel in a piece; `many` to a window."""

    piece: int
    time: Floats
    value: Floats
    clipped: Floats
    many: int


class Meter:
    """A channel beside the pieces of a joint."""

    def __init__(self, joint: Joint, name: str, parts: list[Part]) -> None:
        self.joint, self.name, self.parts = joint, name, parts
        self.of_motor, self.unit = name in OF_MOTOR, "A" if name == "current" else "N*m"
        pieces = [joint.pieces[part.piece] for part in parts]
        self.grids = [piece.step * np.arange(len(piece) + 1) for piece in pieces]
        self.splines = [through(piece.read_time - piece.begin, piece.read) for piece in pieces]
        self.torques = [joint.torque(part.piece) for part in parts]
        self.turns = [joint.turn_of_motor(part.piece) for part in parts]
        self.fastest = max(float(np.max(np.abs(piece.motor_rate))) for piece in pieces)

    def columns(self, n: int, skew: float) -> tuple[Floats, Floats]:
        """Columns (m, p) of a part by `COLUMNS`, and the motor's speeds (m,)."""
        part = self.parts[n]
        time = part.time + skew - self.joint.pieces[part.piece].begin
        torque, speed = np.interp(time, self.grids[n], self.torques[n]), self.splines[n](time, 1)
        one = np.ones(len(time))
        if not self.of_motor:
            return np.stack([torque, one], axis=1), speed
        direction, on_motor = np.sign(speed), np.interp(time, self.grids[n], self.turns[n]) * torque
        loaded = np.abs(torque) / self.joint.ratio * direction
        return np.stack([on_motor, one, self.splines[n](time, 2), direction, speed, loaded], axis=1), speed

    def table(self, skew: float) -> Floats:
        """Columns (windows, p) of all parts."""
        return np.concatenate([averaged(self.columns(n, skew)[0], part.many) for n, part in enumerate(self.parts)])

    def kept(self, skew: float) -> Floats:
        """Windows (windows,) that count."""
        windows = []
        for n, part in enumerate(self.parts):
            wide = 2 * part.many + 1
            keep = maximum_filter1d(part.clipped, wide) == 0.0
            if self.of_motor:
                keep &= minimum_filter1d(np.abs(self.columns(n, skew)[1]), wide) > SLOW * self.fastest
            windows.append(keep[part.many :: part.many])
        return np.concatenate(windows)

    @property
    def readings(self) -> Floats:
        """Readings (windows,), averaged."""
        return np.concatenate([averaged(part.value, part.many) for part in self.parts])

    @property
    def records(self) -> Floats:
        """Part (windows,) of each window."""
        many = [len(part.value[part.many :: part.many]) for part in self.parts]
        return np.repeat(np.arange(len(many)), many)

    def by_torque(self, skew: float, values: dict[str, float]) -> Floats:
        """Derivatives (windows, free + 3 pieces) of the predicted readings by the joint's numbers and starts."""
        free, rows = len(self.joint.free), []
        for n, part in enumerate(self.parts):
            time = part.time + skew - self.joint.pieces[part.piece].begin
            rate = np.full(len(time), values["scale"])
            if self.of_motor:
                torque, direction = np.interp(time, self.grids[n], self.torques[n]), np.sign(self.splines[n](time, 1))
                rate *= np.interp(time, self.grids[n], self.turns[n])
                rate += values.get("motor_load_friction", 0.0) * np.sign(torque) * direction / self.joint.ratio
            derivatives = self.joint.derivatives(part.piece, self.joint.free, start=True, torque=True)
            places = np.clip((time / self.joint.pieces[part.piece].step).astype(int), 0, len(derivatives) - 1)
            table = averaged(rate[:, None] * derivatives[places], part.many)
            wide = np.zeros((len(table), free + 3 * len(self.joint.pieces)))
            wide[:, :free], wide[:, free + 3 * part.piece :][:, :3] = table[:, :free], table[:, free:]
            rows.append(wide)
        return np.concatenate(rows)


def averaged(rows: Floats, many: int) -> Floats:
    """Means (windows, ...) over windows of so many rows, twice."""
    return np.asarray(uniform_filter1d(uniform_filter1d(rows, many, axis=0), many, axis=0)[many::many])


def meters(joint: Joint, logs: Sequence[Any], names: Sequence[str]) -> tuple[Meter | None, list[str]]:
    """The first of the channels that is in the logs, and why it cannot be used, or in which part not."""
    notes: list[str] = []
    for name in names:
        parts: list[Part] = []
        for which, log in enumerate(logs):
            if (channel := channel_of(log, name)) is None:
                continue
            time, value = channel
            where = f"{name} in log {which + 1}"
            if len(time) < FEWEST or not np.ptp(value) > 0.0:
                how = f"stays at {value[0]:.4g}" if len(time) >= FEWEST else f"has {len(time)} samples"
                notes.append(f"{where} {how}: it contains no information and is omitted.")
                continue
            clipped = np.zeros(len(value))
            for level, extreme, share in saturated(value):
                clipped[value == level] = 1.0
                notes.append(
                    f"{where} has its {extreme} value, {level:.6g}, in {100.0 * share:.2g} % of the samples: it seems "
                    "saturated, and these are left out."
                )
            parts += _parts(joint, which, time, value, clipped)
        if parts:
            return Meter(joint, name, parts), notes
    return None, notes


def _parts(joint: Joint, which: int, time: Floats, value: Floats, clipped: Floats) -> list[Part]:
    parts = []
    for i, piece in enumerate(joint.pieces):
        end = piece.begin + piece.step * len(piece)
        inside = (time >= piece.begin + FARTHEST) & (time <= end - FARTHEST)
        if piece.log == which and np.count_nonzero(inside) >= FEWEST:
            many = max(round(WINDOW * piece.step / float(np.median(np.diff(time[inside])))), 1)
            parts.append(Part(i, time[inside], value[inside], clipped[inside], many))
    return parts
