"""Numbers of a channel of torque: its constant or the load's inertia, and the motor's inertia and friction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ....base.results import Floats
from ..intervals import derived_freedom, spread
from .estimates import MECHANICAL, Estimates, Tie
from .meter import COLUMNS, FARTHEST, OF_MOTOR, Meter
from .pieces import FEWEST

SKEWS, ROUNDS, EARLY = 21, 6, 1e-4  # skews tried, then rounds; s by which one is varied
APART = 1e-3  # of a column's length, that those before must leave of it
TELL_SCALE, TELL_INERTIA = 0.07, 0.1  # largest standard deviation of a number that is told, of its own size
TELL_TORQUE, TELL_SHARE, TELL_SKEW = 0.02, 0.03, 1e-3  # of the largest torque; of load friction; s
EXPLAINED = 0.5  # of the readings' motion: what is the least that is believed
LEAST_CONSTANT, SAME_FACTOR, ALIKE = 2e-3, 0.3, 0.1  # N·m/A of the smallest motors; shares by which constants differ
LIKELY = 5.0  # times: a stiffness that is so far off the datasheet's is none of this gear
MOTOR, SCALES = COLUMNS[2:], ("torque_constant", "torque_scale")
REVERSAL = "torques of several sizes and both signs, with a reversal"
MOVES = {
    "motor_inertia": "larger accelerations of the motor", "motor_coulomb": "a reversal of the motor",
    "motor_viscous": "another speed", "motor_load_friction": REVERSAL,
}  # fmt: skip


class Linear(NamedTuple):
    """Least squares of a channel.

    Attributes
    ----------
    values : dict of str to float
        Numbers of the columns by name, and the skew.
    names : list of str
        Those that are told apart, in the order of `covariance`, `freedom` and the rows of `back`, which takes changes
        of the readings to theirs.
    keep : (windows,) array
        Which windows count.
    sign : float
        -1 where readings are of opposite sign.
    explained, left : float
        Share of the readings' motion that is explained, and what is left, root mean square.
    curves : list of (times, measured, predicted)
        In every part; not a number where windows do not count.
    """

    values: dict[str, float]
    names: list[str]
    covariance: Floats
    freedom: Floats
    back: Floats
    keep: Floats
    sign: float
    explained: float
    left: float
    curves: list[tuple[Floats, Floats, Floats]]


@dataclass(frozen=True, eq=False)
class Metered:
    """Result of a channel: its name and unit, numbers, and curves as `Linear` has them.

    `deviation` is that of the channel's scale, relative; `notes` are sentences.
    """

    name: str
    unit: str
    estimates: Estimates
    deviation: float
    curves: list[tuple[Floats, Floats, Floats]]
    notes: list[str]


def linear(meter: Meter) -> Linear | None:
    """Least squares of a channel and of its skew against the motor's angle; None where too little moves."""
    y, names = meter.readings, [*COLUMNS[: len(COLUMNS) if meter.of_motor else 2], "skew"]
    skew = min(np.linspace(-FARTHEST, FARTHEST, SKEWS).tolist(), key=lambda late: _left(meter, late, y))
    if np.count_nonzero(keep := meter.kept(skew)) < FEWEST:
        return None
    for _ in range(ROUNDS):
        table = meter.table(skew)
        late = (meter.table(skew + EARLY) - meter.table(skew - EARLY)) @ _least(table[keep], y[keep]) / (2.0 * EARLY)
        wide = np.column_stack([table, late])
        solution = _least(wide[keep], y[keep])
        skew = float(np.clip(skew + solution[-1], -FARTHEST, FARTHEST))
    sign = -1.0 if solution[0] < 0.0 else 1.0
    wide[:, :-1] *= sign
    apart = _apart(wide[keep])
    used, solution = wide[keep][:, apart], np.zeros(len(names))
    solution[apart] = _least(used, y[keep])
    predicted = wide @ solution
    residual = (y - predicted)[keep]
    edges = np.flatnonzero((np.diff(meter.records[keep]) != 0) | (np.diff(np.flatnonzero(keep)) != 1)) + 1
    scatter = spread(used, residual, np.diff([0, *edges, len(residual)]).tolist())
    parts = [(part.time[part.many :: part.many], meter.records == n) for n, part in enumerate(meter.parts)]
    return Linear(
        dict(zip(names, [*solution[:-1].tolist(), skew], strict=True)), [names[i] for i in apart], scatter.covariance,
        scatter.freedom, np.linalg.pinv(used), keep, sign, 1.0 - float(np.std(residual) / np.std(y[keep])),
        float(np.sqrt(np.mean(residual**2))),
        [(time, y[rows], np.where(keep[rows], predicted[rows], np.nan)) for time, rows in parts],
    )  # fmt: skip


def _left(meter: Meter, skew: float, y: Floats) -> float:
    """Mean square of what is left at a skew."""
    keep, table = meter.kept(skew), meter.table(skew)
    if np.count_nonzero(keep) < FEWEST:
        return math.inf
    return float(np.mean((y - table @ _least(table[keep], y[keep]))[keep] ** 2))


def _least(table: Floats, y: Floats) -> Floats:
    """Least squares by columns that may depend on each other."""
    size = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(table / size, y, rcond=1e-6)[0] / size)


def _apart(table: Floats) -> list[int]:
    """Columns that those before do not give."""
    independent: list[int] = []
    for i, column in enumerate(table.T):
        left = column - table[:, independent] @ _least(table[:, independent], column) if independent else column
        if np.linalg.norm(left) > APART * np.linalg.norm(column):
            independent.append(i)
    return independent


def constant_of(channel: str, current: float | None) -> float | None:
    """Torque [N*m] that a channel's reading of 1 says; current is the torque constant [N*m/A], if known."""
    return current if channel == "current" else 1.0


def metered(meter: Meter, fit: Linear, of_free: Floats, constant: float | None, weighs: bool | None) -> Metered:
    """Numbers of a channel; of_free is the covariance of the joint's free numbers and starts.

    With the load's inertia (weighs is False) the constant is found. A channel that weighs the load has given that by
    its constant. Without both (None) nothing is known.
    """
    main = SCALES[meter.name != "current"]
    by_joint = fit.back @ meter.by_torque(fit.values["skew"], fit.values)[fit.keep]
    covariance = fit.covariance + by_joint @ of_free @ by_joint.T
    numbers = _numbers(meter, fit, constant if weighs else None, main)
    rates = np.array([[by.get(name, 0.0) for name in fit.names] for _, by in numbers.values()])
    full = rates @ covariance @ rates.T
    share = math.sqrt(covariance[0, 0]) / abs(fit.values["scale"])
    all_names = ("load inertia" if weighs else main, *(MOTOR if meter.of_motor else ()))
    tied = [(all_names, "the load's inertia, or the channel's torque constant")]
    if weighs is not None:
        wide = {name: (value, math.sqrt(full[i, i])) for i, (name, (value, _)) in enumerate(numbers.items())}
        tied = _ties(meter, fit, wide, share, all_names)
    unidentified = {
        name: f"the log does not determine {name}; required: {move}" for group, move in tied for name in group
    }
    kept = [i for i, name in enumerate(numbers) if name not in unidentified]
    estimates = Estimates(
        {name: numbers[name][0] for name in numbers if name not in unidentified}, full[np.ix_(kept, kept)],
        derived_freedom(rates[kept], covariance, fit.freedom), unidentified, tied, of_free,
    )  # fmt: skip
    return Metered(meter.name, meter.unit, estimates, share, fit.curves, _notes(meter, fit, constant, weighs))


def _numbers(meter: Meter, fit: Linear, given: float | None, main: str) -> dict[str, tuple[float, dict[str, float]]]:
    """Values by their public names, and their derivatives by the columns."""
    c, numbers = fit.values, dict[str, tuple[float, dict[str, float]]]()
    for name in (name for name in fit.names if name in MOTOR):
        by_scale = given is None or name == "motor_load_friction"
        unit = 1.0 / c["scale"] if by_scale else float(given or 0.0)
        numbers[name] = c[name] * unit, {name: unit} | ({"scale": -c[name] * unit * unit} if by_scale else {})
    if given is None:
        numbers[main] = 1.0 / c["scale"], {"scale": -1.0 / c["scale"] ** 2}
    if "skew" in fit.names:
        numbers[f"{meter.name}_skew"] = c["skew"], {"skew": 1.0}
    return numbers


def lacking(meter: Meter, fit: Linear, share: float) -> str:
    """Motion that would tell the scale of a channel, of so large a deviation, relative; "" where it is told."""
    if fit.explained < EXPLAINED:
        return f"another model, or another channel: {100.0 * max(fit.explained, 0.0):.0f} % is explained"
    if not share <= TELL_SCALE:
        return "larger torques through the gear"
    return REVERSAL if meter.of_motor and "motor_load_friction" not in fit.names else ""


def _ties(
    meter: Meter, fit: Linear, values: dict[str, tuple[float, float]], share: float, all_names: tuple[str, ...]
) -> list[Tie]:  # fmt: skip
    """Groups of names that are not parted, and the move that would part them; values are with their deviations."""
    if move := lacking(meter, fit, share):
        return [(all_names, move)]
    size = float(np.max(np.abs(meter.readings[fit.keep] - fit.values["offset"]))) / fit.values["scale"]
    inertia = values.get("motor_inertia", (0.0, 0.0))[0]
    limits = {
        "motor_inertia": TELL_INERTIA * abs(inertia), "motor_coulomb": TELL_TORQUE * size,
        "motor_viscous": TELL_TORQUE * size / meter.fastest, "motor_load_friction": TELL_SHARE,
    }  # fmt: skip
    limits = (limits if meter.of_motor else {}) | {f"{meter.name}_skew": TELL_SKEW}
    lost = [name for name, limit in limits.items() if not values.get(name, (0.0, math.inf))[1] <= limit]
    return [((name,), MOVES.get(name, "a jerk")) for name in lost]


def _notes(meter: Meter, fit: Linear, constant: float | None, weighs: bool | None) -> list[str]:
    """Sentences on a channel."""
    share, unit = 100.0 * max(fit.explained, 0.0), meter.unit
    notes = [f"The model explains {share:.1f} % of {meter.name}; {fit.left:.3g} {unit} rms remain unexplained."]
    if fit.explained < EXPLAINED:
        return notes
    if fit.sign < 0.0:
        notes.append(f"{meter.name} has the opposite sign of the torque on the shaft; its sign was changed.")
    if weighs is False:
        fitted = 1.0 / fit.values["scale"]
        if constant is None and fitted < LEAST_CONSTANT:
            notes.append(
                f"A torque constant of {fitted:.3g} N·m/A is impossible for a motor: {meter.name} seems to be in mA "
                "but was read in A; give its unit."
            )
        elif constant is not None:
            notes += doubt(meter, fitted / constant, 1.0 + ALIKE)
        if meter.of_motor:
            notes.append("The motor's numbers and the scale are proportional to the load inertia, with its error.")
    return notes


def doubt(meter: Meter, ratio: float, limit: float) -> list[str]:
    """Sentence on a channel's torque that is many times its readings; none within a factor of `limit`."""
    if 1.0 / limit < ratio < limit:
        return []
    N, why = meter.joint.ratio, "check its unit and the load's inertia"
    if abs(abs(math.log(ratio)) - math.log(1e3)) < SAME_FACTOR:
        why = "the unit seems wrong by a factor of 1000; give its unit"
    elif abs(math.log(ratio * N if meter.of_motor else ratio / N)) < SAME_FACTOR:
        why = f"it seems to be of the other shaft; name it {'torque' if meter.of_motor else 'motor_torque'}"
    return [f"{meter.name} reads {1.0 / ratio:.4g} times the torque from other data: {why}."]


def joined(of_joint: Estimates, channels: Sequence[Metered], weighs: Metered | None, inertia: float) -> Estimates:
    """All numbers; those that hang on an inertia that a channel has weighed have its scatter too."""
    every = [of_joint, *(one.estimates for one in channels)]
    values = {name: value for one in every for name, value in one.values.items()}
    unidentified = {name: why for one in every for name, why in one.unidentified.items()}
    tied = [tie for one in every for tie in one.tied]
    if not any(one.name in OF_MOTOR for one in channels):
        move = "a current or a torque of the motor"
        tied.append((MOTOR[:3], move))
        unidentified |= {name: f"the log does not determine {name}; required: {move}" for name in MOTOR}
    covariance = block_diag(*(one.covariance for one in every))
    dof = np.concatenate([one.freedom for one in every])
    if weighs is not None and "load inertia" not in weighs.estimates.unidentified:
        alike = {*MECHANICAL, *(name for one in channels if one is not weighs for name in (*MOTOR[:3], *SCALES))}
        by = np.array([value if name in alike else 0.0 for name, value in values.items()] + [inertia])
        covariance = block_diag(covariance, 0.0) + weighs.deviation**2 * np.outer(by, by)
        values, dof = values | {"load_inertia": inertia}, np.append(dof, max(np.min(weighs.estimates.freedom), 1.0))
    return of_joint._replace(values=values, covariance=covariance, freedom=dof, unidentified=unidentified, tied=tied)
