"""The fit: least squares from a motion that is drawn to the log to one that runs freely, lines and terms one by one."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ....base.results import Floats
from ..intervals import slices, whitened, whitener
from .march import spring_torque
from .model import Joint, Pair, line_names

Progress = Callable[[str, float], None]  # of a stage and a share

FIRST_LINES: tuple[Pair, ...] = ((2, 0), (4, 0), (1, 0), (2, 2))
BASIC = ("K1", "K2", "K3", "T1", "T2", "B", "coulomb", "viscous", "gravity_cos", "gravity_sin",
         "offset", "skew")  # fmt: skip
CONVERGED, LARGEST_DAMPING = 0.02, 1e12  # fall of the sum of squares that is left; damping of steps that lead nowhere
ROUNDS = 25


def normal(joint: Joint, sigma: float) -> tuple[Floats, Floats, float]:
    """Matrix and right side of the normal equations with the priors, and the sum of squares."""
    weights = joint.weights / sigma
    table, residual = joint.jacobian() * weights[:, None], np.concatenate(joint.residuals()) * weights
    far, prior = joint.away()
    return (
        table.T @ table + np.diag(prior**-2),
        table.T @ residual - far / prior,
        float(residual @ residual + far @ far),
    )


def cost(joint: Joint, sigma: float) -> float:
    """Sum of squares of residuals and priors."""
    with np.errstate(all="ignore"):
        residual = np.concatenate(joint.residuals()) * joint.weights / sigma
        total = float(residual @ residual) + float(np.sum(joint.away()[0] ** 2))
    return total if np.isfinite(total) else np.inf


def solved(joint: Joint, sigma: float, rounds: int = ROUNDS) -> Joint:
    """Least squares by Levenberg's method, damped in units of the priors, until the undamped step takes nothing."""
    damping = 1.0
    for _ in range(rounds):
        matrix, side, before = normal(joint, sigma)
        size = np.sqrt(np.diag(matrix))
        scaled, slope, prior = matrix / np.outer(size, size), side / size, joint.away()[1] * size
        if slope @ np.linalg.solve(scaled, slope) < CONVERGED:
            break
        while True:
            trial = joint.moved(np.linalg.solve(scaled + damping * np.diag(prior**-2.0), slope) / size)
            after = cost(trial, sigma)
            if after < before:
                break
            damping *= 8.0
            if damping > LARGEST_DAMPING:
                return joint
        joint, damping = trial, damping / 10.0
    return joint


def rms(joint: Joint) -> float:
    """Root mean square of the residual [rad], weighted."""
    weights = joint.weights**2
    return float(np.sqrt(np.sum(weights * np.concatenate(joint.residuals()) ** 2) / np.sum(weights)))


DRAWN = np.array([0.5, 0.25])  # of omega and its square: by which a motion is drawn to the log
BETTER, FLOOR_RATIO = 0.98, 1.05  # of another fit's residual, and of the readings' scatter
NUDGES, SAME = (0.8, 0.92, 1.08, 1.25), 1.003  # of a dry friction, and of a residual
SHAKEN, TRIES, RINGS = 0.3, 60, 80.0  # s that a start shows in; starts tried; speed for an angle [1/s]
FEW, EARLY = 8, 0.025  # readings, and s, that a start is taken from
HIGHEST, WIDEST = 8, 4  # lines looked for: so many times the motor's turn, and the load's beside it
SURE = 40.0  # of whitened residuals: the fall of the sum of squares that a line or term must bring
ADDED_LINES = 6  # more than the first ones
SMALL = 1e-3  # of its first value: the hysteresis that is looked for
WAVES, MIRRORED = {"cos": np.cos, "sin": np.sin}, 8  # rounds of the fit from a mirror
INSIDE, OUTSIDE = ("hysteresis", "load_friction", "gravity_mean"), ("gap", "asymmetry", "drag")
CLOSE, TRIED, FROM = 0.97, 0.93, 0.6  # of the largest torque: a corner that is tried, and where; of the datasheet's
HOPELESS = 10.0  # readings' scatters of a residual that is of other causes
FAR_OFF, MUCH = 2.0, 0.1  # readings' scatters of a residual with other causes, of which a line takes so much
WHITE_SHARE = 0.95  # of the error of counts: the noise from which on it is white
POWER_OF_TERM = 0.003  # of the residual's power, that a term must take


def fitted(joint: Joint, omega: float, progress: Progress) -> Joint:
    """The joint with its numbers, terms and lines: the best of fits that begin without and with a hysteresis."""
    fits: list[Joint] = []
    for share, hysteresis in ((0.1, False), (0.4, True)):
        progress("drawn to the log", share)
        trial = completed(running(joint, omega, FIRST_LINES, hysteresis))
        trial = without(trial, "hysteresis", "yield_twist") if hysteresis else trial  # it may but lead out of a trap
        if not fits or rms(trial) < BETTER * rms(fits[-1]):
            fits.append(trial)
        if rms(fits[-1]) < FLOOR_RATIO * scatter(fits[-1]):
            break
    return fits[-1]


def running(joint: Joint, omega: float, lines: Sequence[Pair], hysteresis: bool) -> Joint:
    """The joint with its first numbers: drawn to the log by less and less, then running freely."""
    drawn = replace(started(joint), gains=DRAWN * np.array([omega, omega * omega])).with_lines(*lines)
    drawn = _hysteretic(drawn) if hysteresis else drawn
    for gains in (1.0, 1.0, 0.2):
        drawn = solved(replace(drawn, gains=gains * drawn.gains), rms(drawn), 10).aligned()
    return settled(started(replace(drawn, gains=np.zeros(2))))


def completed(joint: Joint) -> Joint:
    """The joint with the terms, lines and corners that its residual shows."""
    if not np.isfinite(rms(joint)):
        return joint
    joint = with_terms(joint, INSIDE)
    return nudged(with_corners(hardened(with_terms(with_more_lines(shaken(joint)), INSIDE))))


def hardened(joint: Joint) -> Joint:
    """The joint whose law stiffens where it fits as well as one that softens: its mirror, about another mean torque."""
    v, (low, high) = joint.values, reached(joint)
    if "K1" not in joint.free or v["K1"] <= v["K2"]:
        return joint
    T1, side = joint.scales["T1"].first, np.sign(low + high)
    twist, torque = -side * (T1 / v["K2"] + v["T1"] / v["K1"]), -side * (T1 + v["T1"])
    load = float(np.mean(np.concatenate([piece.load for piece in joint.pieces])))
    values = v | {"K1": v["K2"], "K2": v["K1"], "T1": T1, "offset": v["offset"] + twist}
    values |= {"gravity_" + name: v["gravity_" + name] + torque * float(f(load)) for name, f in WAVES.items()}
    trial = settled(replace(joint, values=values, starts=joint.starts - np.array([twist, 0.0, 0.0])), MIRRORED)
    return trial if rms(trial) < SAME * rms(joint) else joint


def nudged(joint: Joint) -> Joint:
    """The joint from other starts and dry frictions too: where a load comes to rest depends on them by leaps."""
    if not FLOOR_RATIO < plain(joint) / scatter(joint) < HOPELESS:
        return joint
    joint = shaken(joint)
    for factor in NUDGES:
        values = joint.values | {"coulomb": factor * joint.values["coulomb"]}
        trial = settled(replace(joint, values=values), 2)
        joint = trial if plain(trial) < plain(joint) and rms(trial) < SAME * rms(joint) else joint
    return joint


def plain(joint: Joint) -> float:
    """Root mean square of the residual [rad], without weights."""
    return float(np.sqrt(np.mean(np.concatenate(joint.residuals()) ** 2)))


def scatter(joint: Joint) -> float:
    """Scatter [rad] of the readings, by the fourth differences of the residuals, and of their counts at the least."""
    return max(_noise(joint), _count_error(joint))  # at rest counts do not differ


def is_white(joint: Joint) -> bool:
    """True if the readings' scatter is that of their noise; counts that hardly change have an error that does not."""
    return _noise(joint) > WHITE_SHARE * _count_error(joint)


def _noise(joint: Joint) -> float:
    differences = np.concatenate([np.diff(residual, 4) for residual in joint.residuals()])
    return float(np.sqrt(np.mean(differences**2) / 70.0))


def _count_error(joint: Joint) -> float:
    return max(float(piece.counts[0]) for piece in joint.pieces) / float(np.sqrt(12.0))


def shaken(joint: Joint) -> Joint:
    """The joint with starts among many near its own that fit better: where a load sticks, its motion has kinks."""
    rng, starts, measured = np.random.default_rng(0), joint.starts.copy(), started(joint).starts
    for i, piece in enumerate(joint.pieces):
        left = _off(joint, i, starts[i])
        least, size = float(left @ left), np.std(left[piece.time < piece.time[0] + SHAKEN])
        for k in range(TRIES):
            trial = joint.starts[i] + rng.standard_normal(3) * size * np.array([1.0, RINGS, 1.0])
            trial = trial if k else measured[i] * np.array([1.0, 0.0, 1.0])  # at rest
            left = _off(joint, i, trial)
            if (now := float(left @ left)) < least:
                starts[i], least = trial, now
    return settled(replace(joint, starts=starts)) if np.any(starts != joint.starts) else joint


def _off(joint: Joint, i: int, start: Floats) -> Floats:
    """Residual (m,) of a piece from another start, without weights: at rest these hardly tell a start."""
    return joint.pieces[i].value - joint.predicted(i, joint.values, start)


def started(joint: Joint) -> Joint:
    """The joint whose starts are the measured ones: a cubic through the first readings of each piece."""
    starts = []
    for i, piece in enumerate(joint.pieces):
        many = max(FEW, int(np.searchsorted(piece.time, piece.time[0] + EARLY)))
        time = piece.time[:many] + joint.values["skew"] - piece.begin
        rate, angle = np.polyfit(time, piece.value[:many] - joint.offset(i), 3)[2:]
        starts.append((angle, rate, 0.0))
    return replace(joint, starts=np.array(starts))


def settled(joint: Joint, rounds: int = 3) -> Joint:
    """Least squares, priors and readings weighed by the residual that is left."""
    for _ in range(rounds):
        white = scatter(joint)
        joint = replace(joint, pieces=tuple(piece.weighed(white) for piece in joint.pieces))
        before = rms(joint)
        joint = solved(joint.aligned(), before)
        if rms(joint) > 0.99 * before:
            break
    return joint


class Score:
    """Whitened residual of a joint, and what columns that it lacks would take of it."""

    def __init__(self, joint: Joint) -> None:
        residuals = joint.residuals()
        self.parts = slices([len(one) for one in residuals], len(joint.weights))
        weights = joint.weights
        self.weights, residual = weights[:, None], weights * np.concatenate(residuals)
        self.filter = whitener(residual, self.parts)
        self.residual = whitened(residual, self.filter, self.parts)
        table = whitened(joint.jacobian() * self.weights, self.filter, self.parts)
        sizes = np.linalg.norm(table, axis=0)
        self.basis = np.linalg.qr(table[:, sizes > 0.0] / sizes[sizes > 0.0])[0]
        self.residual = self.residual - self.basis @ (self.basis.T @ self.residual)
        self.power = float(self.residual @ self.residual)

    def gains(self, columns: Floats, each: int) -> Floats:
        """Fall of the whitened sum of squares over its mean, for each group of so many columns (rows, groups each)."""
        white = whitened(columns * self.weights, self.filter, self.parts)
        white = white - self.basis @ (self.basis.T @ white)
        falls = []
        for i in range(0, white.shape[1], each):
            some = white[:, i : i + each]
            side, matrix = some.T @ self.residual, some.T @ some
            moves = np.all(np.diag(matrix) > 0.0)
            falls.append(float(side @ np.linalg.lstsq(matrix, side, rcond=1e-9)[0]) if moves else 0.0)
        return np.array(falls) * len(self.residual) / max(self.power, 1e-300)


def with_more_lines(joint: Joint, highest: int = HIGHEST) -> Joint:
    """The joint with the lines that its residual shows, the strongest first."""
    tried = [(j, k) for j in range(1, highest + 1) for k in range(-WIDEST, WIDEST + 1) if (j, k) not in joint.lines]
    names = [name for pair in tried for name in line_names(pair)]
    columns = joint.with_lines(*tried).columns(names)  # which a line more hardly changes
    for _ in range(ADDED_LINES):
        score = Score(joint)
        gains = score.gains(columns, 2)
        best, least = int(np.argmax(gains)), POWER_OF_TERM if rms(joint) < FAR_OFF * scatter(joint) else MUCH
        if gains[best] < max(SURE, least * len(score.residual)):
            return joint
        columns = np.delete(columns, [2 * best, 2 * best + 1], axis=1)
        joint = settled(joint.with_lines(tried.pop(best)), 2)
    return joint


def shown(joint: Joint, names: Sequence[str]) -> dict[str, float]:
    """Terms that the joint lacks and its residual shows, with how far the whitened sum of squares falls by them."""
    lacking = [name for name in names if name not in joint.free]
    if not lacking:
        return {}
    gains = Score(joint).gains(np.stack([_term_column(joint, name) for name in lacking], axis=1), 1)
    return {name: gain for name, gain in zip(lacking, gains.tolist(), strict=True) if gain >= SURE}


def with_terms(joint: Joint, names: Sequence[str]) -> Joint:
    """The joint with those of the terms that its residual shows."""
    while gains := shown(joint, names):
        best = max(gains, key=lambda name: gains[name])
        more = _hysteretic(joint) if best == "hysteresis" else replace(joint, free=(*joint.free, best))
        trial = settled(more)
        joint = trial if fell(joint, trial) else joint
        names = [name for name in names if name != best]
    return joint


def fell(joint: Joint, trial: Joint) -> bool:
    """True if another fit leaves so much less that it is no chance."""
    return bool((rms(joint) / rms(trial)) ** 2 - 1.0 > max(POWER_OF_TERM, SURE / len(joint.weights)))


def without(joint: Joint, *names: str) -> Joint:
    """The joint without a term, the first of its names, where what it takes may be chance."""
    kept = tuple(name for name in joint.free if name not in names)
    less = settled(replace(joint, values=joint.values | {names[0]: 0.0}, free=kept))
    return joint if (rms(less) / rms(joint)) ** 2 - 1.0 > SURE / len(joint.weights) else less


def with_corners(joint: Joint) -> Joint:
    """The joint whose corners are tried below the largest torque: from above it they are not seen."""
    for corner in ("T1", "T2"):
        reach = float(np.max(np.abs(reached(joint))))
        if joint.values[corner] > CLOSE * reach and reach > FROM * joint.scales[corner].first:
            trial = settled(replace(joint, values=joint.values | {corner: TRIED * reach}))
            joint = trial if fell(joint, trial) else joint
    return joint


def reached(joint: Joint) -> tuple[float, float]:
    """Least and largest torque [N*m] of the spring in the logs."""
    p, twists = joint.kernel_numbers(joint.values), np.concatenate([[0.0], *joint.twists()])
    return float(spring_torque(float(np.min(twists)), p)), float(spring_torque(float(np.max(twists)), p))


def _term_column(joint: Joint, name: str) -> Floats:
    """Derivative (rows,) of the predicted angles by a term that the joint lacks, in any unit."""
    if name != "hysteresis":
        return joint.columns([name])[:, 0]
    little = replace(joint, values=joint.values | {name: SMALL * joint.scales[name].first})
    return np.concatenate([a - b for a, b in zip(joint.residuals(), little.residuals(), strict=True)]) / SMALL


def _hysteretic(joint: Joint) -> Joint:
    values = joint.values | {"hysteresis": joint.scales["hysteresis"].first}
    return replace(joint, values=values, free=(*joint.free, "hysteresis", "yield_twist"))
