"""Numbers of a joint from logs: their intervals, and those that the logs cannot part, with the motion that would."""

from typing import Any, NamedTuple

import numpy as np

from ....base.results import Booleans, Floats
from ....base.sentences import listed
from ..intervals import basis_of, derived_freedom, orthogonal, spread
from .model import Joint, line_names
from .solve import reached, rms
from .solve import scatter as scatter_of

DRAWS, READINGS = 30, 100  # of what the motor's encoder, and the load's, may misread
SEEN = 3.0  # of the residual: what a number may add at most, by what is known before, to be seen at all
TELL = {  # largest standard deviation of a number that is told: of the logarithm, or in units of the datasheet's T2
    "K1": 0.07, "K2": 0.07, "K3": 0.07, "T1": 0.07, "T2": 0.07, "B": 0.1, "hysteresis": 0.4, "yield_twist": 0.4,
    "coulomb": 0.01, "viscous": 0.03, "gravity": 0.03,
}  # fmt: skip
TELL_SKEW, TELL_SHARE, TELL_LINE = 1e-4, 0.01, 5e-6  # s, of load friction, rad
FAINT, CIRCLE = 3.0, 1.25  # deviations of an amplitude that may be 0; 95 % of a circle over that of a line
FAR_OUT, CHORDS, STRAIGHT = 2.0, 4, 0.1  # deviations that a number is moved by; and how near to what is expected
PARTNERS = 0.9  # correlation of numbers that are not parted
BEYOND = 1.1  # of a corner: a torque that tells it
TURNING, MOVING = 0.02, 0.05  # share of the time, and of the largest speed
MECHANICAL = ("K1", "K2", "K3", "T1", "T2", "B", "coulomb", "viscous", "gravity", "hysteresis")

Tie = tuple[tuple[str, ...], str]


class Estimates(NamedTuple):
    """Values by name [SI] with covariance and degrees of freedom, sentences on what is not told, and ties.

    `of_free` (free + 3 pieces, ...) is the covariance of the joint's free numbers and starts, in units.
    """

    values: dict[str, float]
    covariance: Floats
    freedom: Floats
    unidentified: dict[str, str]
    tied: list[Tie]
    of_free: Floats


class FreeScatter(NamedTuple):
    """Scatter of the free numbers and starts of a joint, in units.

    Attributes
    ----------
    covariance : (p, p) array
        Of all of them.
    freedom : (p,) array
        Degrees of freedom of its diagonal.
    seen : (p,) bool array
        True for those that the readings tell beyond what is known before.
    basis, back : (rows, seen), (seen, seen) arrays
        As of `basis_of`, of the readings and of what is known before.
    """

    covariance: Floats
    freedom: Floats
    seen: Booleans
    basis: Floats
    back: Floats


def _scatter_of_free(joint: Joint) -> FreeScatter:
    """Scatter by the residual, and by what the encoders of motor and load may misread."""
    weights = joint.weights
    table = joint.jacobian() * weights[:, None]
    residual = np.concatenate(joint.residuals()) * weights
    priors = joint.away()[1]
    seen = np.linalg.norm(table, axis=0) * priors > SEEN * rms(joint)
    covariance, freedom = np.diag(priors**2), np.ones(len(priors))
    few = int(np.count_nonzero(seen))
    held = np.concatenate([table[:, seen], np.diag(rms(joint) / priors[seen])])  # what is known before is a row each
    scatter = spread(held, np.append(residual, np.zeros(few)), [len(p.time) for p in joint.pieces] + [1] * few)
    basis, back = basis_of(held)
    of_readings, of_before = back @ basis[: len(table)].T, rms(joint) * back @ basis[len(table) :].T
    by_input = _covariance(of_readings @ _of_input(joint)) + of_before @ of_before.T
    variance, other = np.diag(scatter.covariance), np.diag(by_input)
    wider = np.sqrt(np.maximum(np.diag(_covariance(of_readings @ _of_counts(joint))) / variance, 1.0))
    variance = variance * wider**2
    covariance[np.ix_(seen, seen)] = scatter.covariance * np.outer(wider, wider) + by_input
    freedom[seen] = (variance + other) ** 2 / (variance**2 / scatter.freedom + other**2 / DRAWS)
    return FreeScatter(covariance, freedom, seen, basis, back)


def _covariance_of_values(joint: Joint, free: FreeScatter, values: dict[str, float], rates: Floats) -> Floats:
    """Covariance (values, values) [SI], wider for faint lines and where the sum of squares is no parabola."""
    many = len(joint.free)
    covariance = np.asarray(rates @ free.covariance[:many, :many] @ rates.T)
    deviation = np.sqrt(np.diag(covariance))
    lines = np.array([value if name.startswith("line") else np.inf for name, value in values.items()])
    wider = np.where(lines < FAINT * deviation, CIRCLE, 1.0) * _farther(joint, free, rates, list(values), deviation)
    return covariance * np.outer(wider, wider)


def estimates_of(joint: Joint, inertia_given: bool) -> Estimates:
    """Numbers of a joint with their scatter, and what its logs cannot tell."""
    free, (values, rates) = _scatter_of_free(joint), _named_values(joint)
    full = _covariance_of_values(joint, free, values, rates)
    deviation = np.sqrt(np.diag(full))
    lost = [n for (n, value), sd in zip(values.items(), deviation, strict=True) if not sd <= _limit(joint, n, value)]
    tied = _ties(joint, lost, inertia_given, full, list(values))
    if "asymmetry" not in joint.free and not _sided(joint, free.basis):
        tied.append((("asymmetry",), "torques of both signs"))
    seen_lines = [name for name in values if name.startswith("line") and name not in lost]
    if seen_lines and {"K1", "B"} <= {*lost}:  # a resonance that is not known makes any size of a line
        tied.append((("K1", "B", *seen_lines), "a motion that excites load vibration, and other speeds"))
    unidentified: dict[str, str] = {}
    for group, move in tied:
        for name in group:
            others = [other for other in group if other != name]
            apart = f" apart from {listed(others)}" if others else ""
            unidentified.setdefault(name, f"the log does not determine {name}{apart}; required: {move}")
    many, kept = len(joint.free), [i for i, name in enumerate(values) if name not in unidentified]
    return Estimates(
        values={name: value for name, value in values.items() if name not in unidentified},
        covariance=full[np.ix_(kept, kept)],
        freedom=derived_freedom(rates[kept], free.covariance[:many, :many], free.freedom[:many]),
        unidentified=unidentified, tied=tied, of_free=free.covariance,
    )  # fmt: skip


def _sided(joint: Joint, basis: Floats) -> bool:
    """True if stiffnesses that differ by 1 % to either side would be seen beside the numbers of the basis (rows, p)."""
    column = joint.columns(["asymmetry"])[:, 0] * joint.weights
    return bool(np.linalg.norm(orthogonal(basis, np.pad(column, (0, len(basis) - len(column))))) > rms(joint))


def _farther(joint: Joint, free: FreeScatter, rates: Floats, names: list[str], deviation: Floats) -> Floats:
    """Factor (m,) of each number's deviation by the sum of squares: from 1 on.

    A number is moved off by so much, the others to their least squares by chords, and the sum of squares rises less
    than the derivatives say: a profile, as Bates & Watts 1988, ch. 6, have it. Lines are linear.
    """
    full_back, factors = np.zeros((len(free.seen), len(free.back))), np.ones(len(names))
    full_back[free.seen] = free.back

    def left(by: Floats) -> Floats:
        trial = joint.moved(full_back @ by)
        residual = np.concatenate(trial.residuals()) * joint.weights
        return np.append(residual, -rms(joint) * trial.away()[0][free.seen])

    before = left(np.zeros(len(free.back)))
    for n in (n for n, name in enumerate(names) if not name.startswith("line")):
        row = rates[n] @ full_back[: rates.shape[1]]
        if not (square := row @ row):
            continue
        expected = (FAR_OUT * deviation[n]) ** 2 / square
        for shift in (-FAR_OUT, FAR_OUT):
            by, least = shift * deviation[n] / square * row, np.inf
            for _ in range(CHORDS):
                after = left(by)
                least = min(least, float(after @ after - before @ before) / expected)
                if not abs(least - 1.0) > STRAIGHT:
                    break
                step = free.basis.T @ after
                by = by + step - row * (row @ step) / square
            factors[n] = max(factors[n], max(least, 1e-4) ** -0.5)
    return factors


def _of_input(joint: Joint) -> Floats:
    """Changes (rows, draws) of the weighted angles by what the motor's encoder may misread."""
    rng, changes = np.random.default_rng(0), []
    for i, piece in enumerate(joint.pieces):
        drive, start = joint.drive(i, joint.values), joint.starts[i]
        drives = (drive + np.pad(errors, ((0, 2), (0, 0))) for errors in np.moveaxis(piece.misread(rng, DRAWS), -1, 0))
        moved = [joint.predicted(i, joint.values, start, other) for other in drives]
        before = joint.predicted(i, joint.values, start, drive)
        changes.append((np.stack(moved, axis=1) - before[:, None]) * piece.weight[:, None])
    return np.concatenate(changes)


def _of_counts(joint: Joint) -> Floats:
    """Changes (rows, draws) of the weighted angles by the counts and the noise of the load's encoder."""
    rng, white, columns = np.random.default_rng(0), scatter_of(joint), []
    for piece, residual in zip(joint.pieces, joint.residuals(), strict=True):
        count, path = float(piece.counts[0]), (piece.value - residual)[:, None]
        noise = np.sqrt(max(white**2 - count**2 / 12.0, 0.0)) * rng.standard_normal((len(path), READINGS))
        if count:
            dithered = path + noise + count * rng.uniform(size=READINGS)
            noise = np.round(dithered / count) * count - dithered + noise
        columns.append(noise * piece.weight[:, None])
    return np.concatenate(columns)


def _covariance(changes: Floats) -> Floats:
    """Covariance (p, p) of numbers by draws (p, draws) of their changes."""
    return np.asarray(changes @ changes.T / changes.shape[1])


def _named_values(joint: Joint) -> tuple[dict[str, float], Floats]:
    """Values by their public names, and their derivatives by the free numbers, per unit."""
    free, values, rows = list(joint.free), dict[str, float](), list[Floats]()

    def add(name: str, value: float, parts: dict[str, float]) -> None:
        values[name] = value
        rows.append(np.array([parts.get(part, 0.0) for part in free]))

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
    unit = value if joint.is_log(name) else joint.scales["T2"].first
    return TELL[name] * unit if name in TELL else TELL_SHARE


def one_way(joint: Joint) -> bool:
    """True if the load turns in one direction only."""
    v = np.concatenate([piece.motor_rate for piece in joint.pieces])
    least = MOVING * float(np.max(np.abs(v)))
    return bool(min(np.mean(v > least), np.mean(v < -least)) < TURNING)


def _ties(
    joint: Joint, lost: list[str], inertia_given: bool, covariance: Floats, names: list[str]
) -> list[Tie]:  # fmt: skip
    """Groups of names that are not parted, and the move that would part them."""
    ties: list[Tie] = []
    if not inertia_given:
        group = ("load inertia", *(name for name in MECHANICAL if name in names or name == "K1"))
        move = "the load's inertia, a torque measured at the load, or a motor's current with its torque constant"
        ties.append((group, move))
    if one_way(joint):
        ties.append((("coulomb", "gravity mean"), "a reversal of the load: move it to and fro"))
        ties.append((("skew", "offset", "viscous"), "a reversal, another speed, and a jerk that excites vibration"))
    low, high = reached(joint)
    reach = max(-low, high)
    if one_way(joint) and min(-low, high) < BEYOND * joint.values["T1"]:  # all corners move with the torque's zero
        ties.append((("T1", "T2", "gravity mean"), "torques beyond T1 to both sides"))
    elif "gravity_mean" in joint.free and "T1" in lost:
        ties.append((("T1", "gravity mean"), "torques beyond T1 to both sides"))
    for corner, slope in (("T1", "K2"), ("T2", "K3")):
        group = tuple(name for name in (slope, corner) if name in lost)
        if group:
            limit = joint.values[corner]
            beyond = "well beyond" if reach < 1.2 * limit else "to both sides of"
            move = f"torques {beyond} {corner} of {limit:.3g} N·m, with a reversal (this log reaches {reach:.3g} N·m)"
            ties.append((group, move))
    done = {name for group, _ in ties for name in group}
    correlation = covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    for name in (name for name in lost if name not in done):
        index = names.index(name)
        group = tuple(other for i, other in enumerate(names) if i == index or abs(correlation[index, i]) > PARTNERS)
        ties.append((tuple(dict.fromkeys((name, *group))), _move(name, reach)))
    return ties


def _move(name: str, reach: float) -> str:
    """Motion that would tell a number."""
    moves: dict[str, Any] = {
        "K1": "torques of both signs: larger accelerations", "B": "a motion that excites vibration: a jerk, or a pass",
        "skew": "a jerk after which the load rings, or torques beyond T1",
        "viscous": "a jerk after which the load rings, or torques beyond T1",
        "coulomb": "slow reversals of the load", "gravity": "a longer travel of the load",
        "line": "more motor turns in one run",
    }  # fmt: skip
    return str(moves.get(name.split("(")[0], f"larger torques than {reach:.3g} N·m"))
