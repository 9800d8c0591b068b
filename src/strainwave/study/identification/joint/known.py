"""What logs tell of a joint: intervals of its numbers, and the numbers that they cannot part, with what would."""

from typing import Any, NamedTuple

import numpy as np

from ....base.results import Floats
from ....base.sentences import listed
from ..intervals import derived_freedom, spread, without
from .model import Joint, line_names
from .solve import reached, rms
from .solve import scatter as scatter_of

DRAWS, READINGS = 30, 100  # of what the motor's encoder, and the load's, may misread
SEEN = 3.0  # of the residual: what a number may add at most, by what is known before, to be seen at all
TELL = {  # largest standard deviation of a number that is told: of the logarithm, or in units of the datasheet's T2
    "K1": 0.07, "K2": 0.07, "K3": 0.07, "T1": 0.07, "T2": 0.07, "B": 0.25, "hysteresis": 0.4, "yield_twist": 0.4,
    "coulomb": 0.01, "viscous": 0.03, "gravity": 0.03,
}  # fmt: skip
TELL_SKEW, TELL_SHARE, TELL_LINE = 1e-4, 0.01, 5e-6  # s, of load friction, rad
FAINT, CIRCLE = 3.0, 1.25  # deviations of an amplitude that may be 0; 95 % of a circle over that of a line
PARTNERS = 0.9  # correlation of numbers that are not parted
BEYOND = 1.1  # of a corner: a torque that tells it
TURNING, MOVING, ONE_SPEED = 0.02, 0.05, 0.15  # share of the time, of the largest speed, and about the usual speed
MECHANICAL = ("K1", "K2", "K3", "T1", "T2", "B", "coulomb", "viscous", "gravity", "hysteresis")

Tie = tuple[tuple[str, ...], str]


class Known(NamedTuple):
    """Values by name [SI] with covariance and degrees of freedom, sentences on what is not told, and ties.

    `of_free` (free + 3 pieces, ...) is the covariance of the joint's free numbers and starts, in units.
    """

    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    tied: list[Tie]
    of_free: Floats


def known(joint: Joint, inertia_given: bool) -> Known:
    """Numbers of a joint with their scatter, and what its logs cannot tell."""
    weights = joint.weights
    table = joint.jacobian() * weights[:, None]
    residual = np.concatenate(joint.residuals()) * weights
    priors = joint.away()[1]
    seen = np.linalg.norm(table, axis=0) * priors > SEEN * rms(joint)
    many = len(joint.free)
    covariance, freedom = np.diag(priors**2), np.ones(len(priors))
    few = int(np.count_nonzero(seen))
    held = np.concatenate([table[:, seen], np.diag(rms(joint) / priors[seen])])  # what is known before is a row each
    before = np.concatenate([np.zeros((len(table), few)), rms(joint) * np.sqrt(few) * np.eye(few)])
    scatter = spread(held, np.append(residual, np.zeros(few)), [len(p.time) for p in joint.pieces] + [1] * few)
    by_input = _of_input(joint, held) + _of_changes(held, before)
    own, other = np.diag(scatter.covariance), np.diag(by_input)
    wider = np.sqrt(np.maximum(np.diag(_of_counts(joint, held)) / own, 1.0))
    own = own * wider**2
    covariance[np.ix_(seen, seen)] = scatter.covariance * np.outer(wider, wider) + by_input
    freedom[seen] = (own + other) ** 2 / (own**2 / scatter.freedom + other**2 / DRAWS)
    values, rates = _told(joint)
    posterior = np.linalg.inv(table[:, :many].T @ table[:, :many] / rms(joint) ** 2 + np.diag(priors[:many] ** -2.0))
    full = rates @ covariance[:many, :many] @ rates.T
    lines = np.array([value if name.startswith("line") else np.inf for name, value in values.items()])
    wide = np.where(lines < FAINT * np.sqrt(np.diag(full)), CIRCLE, 1.0)
    full *= np.outer(wide, wide)
    deviation = np.sqrt(np.diag(full))
    limits = np.array([_limit(joint, name, value) for name, value in values.items()])
    lost = [name for name, sd, most in zip(values, deviation, limits, strict=True) if not sd <= most]
    tied = _ties(joint, lost, inertia_given, rates @ posterior @ rates.T, list(values))
    if "asymmetry" not in joint.free and not _sided(joint, held):
        tied.append((("asymmetry",), "torques of both signs"))
    if {"K1", "B"} <= {*lost}:  # a resonance that is not known makes any size of a line
        seen_lines = [name for name in values if name.startswith("line") and name not in lost]
        tied += (
            [(("K1", "B", *seen_lines), "a motion that makes the load ring, and other speeds")] if seen_lines else []
        )
    unidentified: dict[str, str] = {}
    for group, move in tied:
        for name in group:
            others = [other for other in group if other != name]
            apart = f" apart from {listed(others)}" if others else ""
            unidentified.setdefault(name, f"the log does not tell {name}{apart}; it takes {move}")
    told = [i for i, name in enumerate(values) if name not in unidentified]
    return Known(
        {name: value for name, value in values.items() if name not in unidentified}, full[np.ix_(told, told)],
        derived_freedom(rates[told], covariance[:many, :many], freedom[:many]), unidentified, tied,
        covariance,
    )  # fmt: skip


def _sided(joint: Joint, table: Floats) -> bool:
    """Whether stiffnesses that differ by 1 % to either side would be seen beside the numbers of the table (rows, p)."""
    column = np.concatenate(joint.columns(["asymmetry"]))[:, 0] * joint.weights
    column = np.append(column, np.zeros(len(table) - len(column)))
    size = np.linalg.norm(table, axis=0)
    return bool(np.linalg.norm(without(table / size, column)) > rms(joint))


def _of_input(joint: Joint, table: Floats) -> Floats:
    """Covariance (p, p) of the numbers by what the motor's encoder may misread; table (rows, p) is weighted."""
    rng, weights = np.random.default_rng(0), joint.weights
    drives = [joint.drive(i, joint.values) for i in range(len(joint.pieces))]
    before = np.concatenate([joint.predicted(i, joint.values, joint.starts[i], d) for i, d in enumerate(drives)])
    changes = []
    for _ in range(DRAWS):
        moved = []
        for i, drive in enumerate(drives):
            other = drive.copy()
            other[:2] += joint.pieces[i].misread(rng)
            moved.append(joint.predicted(i, joint.values, joint.starts[i], other))
        changes.append((np.concatenate(moved) - before) * weights)
    return _of_changes(table, np.array(changes).T)


def _of_counts(joint: Joint, table: Floats) -> Floats:
    """Covariance (p, p) of the numbers by what the counts and the noise of the load's encoder make of its angle."""
    rng, white, columns = np.random.default_rng(0), scatter_of(joint), []
    for piece, residual in zip(joint.pieces, joint.residuals(), strict=True):
        count, path = float(piece.counts[0]), (piece.value - residual)[:, None]
        noise = np.sqrt(max(white**2 - count**2 / 12.0, 0.0)) * rng.standard_normal((len(path), READINGS))
        if count:
            dithered = path + noise + count * rng.uniform(size=READINGS)
            noise = np.round(dithered / count) * count - dithered + noise
        columns.append(noise * piece.weight[:, None])
    return _of_changes(table, np.concatenate(columns))


def _of_changes(table: Floats, changes: Floats) -> Floats:
    """Covariance (p, p) of least squares by changes (rows, draws) of their data, of the first rows at least."""
    size = np.linalg.norm(table, axis=0)
    changes = np.pad(changes, ((0, len(table) - len(changes)), (0, 0)))
    found = np.linalg.lstsq(table / size, changes, rcond=None)[0] / size[:, None]
    return np.asarray(found @ found.T / changes.shape[1])


def _told(joint: Joint) -> tuple[dict[str, float], Floats]:
    """Values by their public names, and their derivatives by the free numbers, per unit."""
    free, values, rows = list(joint.free), dict[str, float](), list[Floats]()

    def add(name: str, value: float, parts: dict[str, float]) -> None:
        row = np.zeros(len(free))
        for part, rate in parts.items():
            row[free.index(part)] = rate
        values[name] = value
        rows.append(row)

    units = {name: joint.values[name] if joint.is_log(name) else joint.scales[name].unit for name in free}
    for name in free:
        if not name.startswith(("gravity", "line", "offset", "inertia")):
            add(name, joint.values[name], {name: units[name]})
    pairs = [("gravity", ("gravity_cos", "gravity_sin"))]
    for name, parts in [*pairs, *((f"line({j}, {k})", line_names((j, k))) for j, k in joint.lines)]:
        a, b = (joint.values[part] for part in parts)
        size = float(np.hypot(a, b)) or 1e-300
        add(name, size, {parts[0]: a / size * units[parts[0]], parts[1]: b / size * units[parts[1]]})
    return values, np.array(rows)


def _limit(joint: Joint, name: str, value: float) -> float:
    """Largest standard deviation [SI] with which a number is told."""
    if name == "skew":
        return TELL_SKEW
    if name.startswith("line"):
        return max(TELL_LINE, 0.3 * value)
    if name not in TELL:
        return TELL_SHARE
    return TELL[name] * (value if joint.is_log(name) else joint.scales["T2"].first)


def one_way(joint: Joint) -> bool:
    """Whether the load turns in one direction only."""
    v = np.concatenate([piece.motor_rate for piece in joint.pieces])
    least = MOVING * float(np.max(np.abs(v)))
    return bool(min(np.mean(v > least), np.mean(v < -least)) < TURNING)


def one_speed(joint: Joint) -> bool:
    """Whether it turns at one speed nearly all the time that it turns."""
    v = np.concatenate([piece.motor_rate for piece in joint.pieces])
    v = v[np.abs(v) > MOVING * np.max(np.abs(v))]
    usual = float(np.median(v))
    return bool(np.mean(np.abs(v - usual) < ONE_SPEED * abs(usual)) > 0.8)


def _ties(
    joint: Joint, lost: list[str], inertia_given: bool, covariance: Floats, told: list[str]
) -> list[Tie]:  # fmt: skip
    """Groups of names that are not parted, and the move that would part them."""
    found: list[Tie] = []
    if not inertia_given:
        found.append(
            (
                ("load inertia", *(name for name in MECHANICAL if name in told or name == "K1")),
                "the load's inertia, a torque measured at the load, or a motor's current with its torque constant",
            )
        )
    if one_way(joint):
        found.append((("coulomb", "gravity mean"), "a reversal of the load: move it to and fro"))
        many = "another speed and a reversal" if one_speed(joint) else "a reversal, and a jerk after which it rings"
        found.append((("skew", "offset", "viscous"), many))
    low, high = reached(joint)
    reach = max(-low, high)
    if one_way(joint) and min(-low, high) < BEYOND * joint.values["T1"]:  # all corners move with the torque's zero
        found.append((("T1", "T2", "gravity mean"), "torques beyond T1 to both sides"))
    elif "gravity_mean" in joint.free and "T1" in lost:
        found.append((("T1", "gravity mean"), "torques beyond T1 to both sides"))
    for corner, slope in (("T1", "K2"), ("T2", "K3")):
        group = tuple(name for name in (slope, corner) if name in lost)
        if group:
            limit = joint.values[corner]
            beyond = "well beyond" if reach < 1.2 * limit else "to both sides of"
            move = f"torques {beyond} {corner} of {limit:.3g} N·m, with a reversal (this log reaches {reach:.3g} N·m)"
            found.append((group, move))
    done = {name for group, _ in found for name in group}
    correlation = covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    for name in (name for name in lost if name not in done):
        at = told.index(name)
        group = tuple(other for i, other in enumerate(told) if i == at or abs(correlation[at, i]) > PARTNERS)
        found.append((tuple(dict.fromkeys((name, *group))), _move(name, reach)))
    return found


def _move(name: str, reach: float) -> str:
    """What a motion that tells a number would be."""
    moves: dict[str, Any] = {
        "K1": "torques of both signs: accelerate harder", "B": "a motion that makes the load ring: a jerk, or a pass",
        "skew": "a jerk after which the load rings, or torques beyond T1",
        "viscous": "a jerk after which the load rings, or torques beyond T1",
        "coulomb": "slow reversals of the load", "gravity": "a longer travel of the load",
    }  # fmt: skip
    if name.startswith("line"):
        return "more turns of the motor in one go"
    return str(moves.get(name, f"larger torques than {reach:.3g} N·m"))
