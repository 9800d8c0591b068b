"""A law identified from a measured loop of torque over torsion: slopes, backlash, hysteresis, with their intervals.

Lack of fit of a loop: structure along the torsion that the noise of the samples does not give. What a datasheet
measures on a law: width of its loop, lost motion, backlash, from the closed form of one motion.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import fdtrc

from ....base.quantities import checked, number
from ....base.results import Floats, SolveError
from ....model.laws import Linear
from ....model.laws.hysteresis import BoucWen, Parallel
from ....model.laws.springs import Backlash, PiecewiseLinear, Play
from ..fitted import derivatives
from ..intervals import Spread, derived_freedom, orthogonal, restricted
from ..law_fit import LackOfFit, LoopCandidate, compare_candidates
from .loop_model import FULL_STATE, Shape, state_after
from .loop_model import torque as torque_along
from .loop_path import Loop, closed_energy, read_loop
from .loop_result import LoopFit
from .loop_solve import RANK, Solution, left_out, scatter, shifts_of_begins, solve, start_values

ELEMENTS = ((0, False), (1, False), (1, True), (2, False), (2, True))  # exponent of Bouc-Wen, whether beta is fitted
SLOPE_SAMPLES, NOISE_FACTOR = 12, 3.0  # samples that a slope needs, and how many times the noise beyond its corner
SLOPE_DEVIATIONS = 4.0  # standard deviations by which two slopes must differ: their corner may be anywhere

WAVES = 8  # cosines for each direction
WAVE_ROWS = 24  # samples for each of them; below two cosines nothing is tested
LEAST_PART = 1e-3  # of a column: what the unknowns leave of it when they can stand for it
SENSOR_ERROR = 1e-4  # of the largest torque: errors along the loop that every sensor has

SMALL_LOOP = 0.04  # of the rated torque
RANGE_FACTOR = 1.25  # times the torque measured: from there on a number is told to lie beyond it
MOST_DOUBLINGS = 60


class TwistedLaw:
    """A candidate law that is twisted slowly from torque to torque, from rest; offsets and start left out."""

    def __init__(self, shape: Shape, p: Floats) -> None:
        self.shape, self.given = shape, shape.named(p)
        self.spring, self.x, self.a = _spring(shape, p, 0.0), 0.0, 0.0

    def _torque_at(self, x: float, direction: float) -> tuple[float, float]:
        """Torque [N*m] at a torsion that is reached in one direction, and the state there."""
        value = float(self.spring.torque(x))
        if not self.shape.n:
            return value, 0.0
        twist = self.given["yield_twist"]
        stroke = max(direction * (x - self.x), 0.0) / twist
        a = direction * float(state_after(direction * self.a, stroke, self.shape.n, self.given.get("kappa", 0.0)))
        return value + self.given["K"] * twist * a, a

    def to(self, target: float, direction: float, *, stay: bool = True) -> float:
        """Torsion [rad] at which the torque [N*m] is the target, in one direction; the law stays there if wanted."""

        def missing(stroke: float) -> float:
            return direction * (self._torque_at(self.x + direction * stroke, direction)[0] - target)

        if missing(0.0) >= 0.0:
            return self.x
        far = abs(target) / self.given["K1"] + abs(self.x) + 1e-12
        for _ in range(MOST_DOUBLINGS):
            if missing(far) > 0.0:
                break
            far *= 2.0
        else:
            raise SolveError(
                f"the law that fits takes no torque of {target:.4g} N*m from {self.x:.4g} rad on: a torque that is "
                "far from the others leads it astray; look at the largest torques of the loop"
            )
        x = self.x + direction * float(brentq(missing, 0.0, far, xtol=1e-15, rtol=1e-13))
        if stay:
            a = self._torque_at(x, direction)[1]
            self.x, self.a = x, math.copysign(min(abs(a), FULL_STATE), a)
        return x


def loop_sizes(shape: Shape, p: Floats, full: float) -> tuple[float, float]:
    """Width [rad] at no torque and from end to end of the loop 0 -> +full -> -full -> +full [N*m]."""
    law = TwistedLaw(shape, p)
    law.to(full, 1.0)
    first = law.to(0.0, -1.0, stay=False)
    low = law.to(-full, -1.0)
    return first - law.to(0.0, 1.0, stay=False), law.to(full, 1.0) - low


class Structure(NamedTuple):
    """Lack of fit of a loop, and its weighted residual (n,) without the structure that was found."""

    lack: LackOfFit
    noise: Floats


def structure(loop: Loop, fit: Solution) -> Structure | None:
    """Test a fit for structure along the torsion; None where samples are too few."""
    n, J = len(fit.residual), fit.jacobian[:, np.any(fit.jacobian != 0.0, axis=0)]
    basis, sizes, _ = np.linalg.svd(J / np.linalg.norm(J, axis=0), full_matrices=False)
    basis = basis[:, sizes > RANK * sizes[0]]
    # at the corrected torsion, of which the residual tells nothing: the measured one shares its noise
    columns = _waves(loop, fit.torsion) * fit.weight[:, None]
    columns /= np.linalg.norm(columns, axis=0)
    left, sizes, _ = np.linalg.svd(orthogonal(basis, columns), full_matrices=False)
    left = left[:, sizes > LEAST_PART]
    m, freedom = left.shape[1], n - basis.shape[1] - left.shape[1]
    if m == 0:
        return None
    c = left.T @ fit.residual
    noise = fit.residual - left @ c
    unit = 1.0 / float(np.median(fit.weight))
    spread = restricted(np.column_stack([basis, left]), noise)
    pulls = shifts_of_begins(loop, fit, left)
    sensor = n / m * (SENSOR_ERROR * float(np.max(np.abs(loop.torque - np.mean(loop.torque)))) / unit) ** 2
    V = spread.covariance[-m:, -m:] + pulls @ pulls.T + sensor * np.eye(m)
    ratio = float(c @ np.linalg.solve(V, c)) / m
    chance = float(fdtrc(m, float(np.min(spread.freedom)), ratio))
    pure, missed = unit * float(noise @ noise / freedom) ** 0.5, unit * float(c @ c / n) ** 0.5
    return Structure(LackOfFit(pure, missed, ratio, chance, "loop"), noise)


def widened_scatter(loop: Loop, fit: Solution, structure: Structure | None) -> Spread:
    """Scatter of the unknowns; where structure was found at least that of the noise times the ratio."""
    spread_of_noise = scatter(loop, fit)
    if structure is None or not structure.lack.found:
        return spread_of_noise
    alone = np.diag(scatter(loop, fit._replace(residual=structure.noise)).covariance) * structure.lack.ratio
    variances = np.diag(spread_of_noise.covariance)
    grown = np.sqrt(np.maximum(np.divide(alone, variances, out=np.ones(len(variances)), where=variances > 0.0), 1.0))
    return spread_of_noise._replace(covariance=spread_of_noise.covariance * np.outer(grown, grown))


def _waves(loop: Loop, x: Floats) -> Floats:
    """Cosines (n, 2 WAVES or fewer) over the torsion x (n,), on the way up and on the way down."""
    count = min(WAVES, len(x) // (2 * WAVE_ROWS))
    share = (x - np.min(x)) / np.ptp(x)
    waves = np.cos(np.pi * np.outer(share, np.arange(count if count > 1 else 0)))
    up = (loop.path.direction[loop.path.branch] > 0.0)[:, None]
    return np.hstack([waves * up, waves * ~up])


def fit_loop(
    torsion: ArrayLike, torque: ArrayLike, *, rated_torque: float | None = None, ratio: float | None = None,
    check_units: bool = True,
) -> LoopFit:  # fmt: skip
    """Identify a torsion law from a measured loop: three slopes, backlash, Bouc-Wen hysteresis, offsets of both axes.

    All unknowns are fitted jointly by least squares with noise on both axes. The candidates (with and without backlash,
    with several shapes of hysteresis) are compared by the error of blocks of samples that were left out; the simplest
    one within two standard errors of the best is taken. Intervals allow for residuals that are coloured and uneven.
    Where the law misses the torque along the loop by more than the noise gives, it is said, and they are wider by that.

    Parameters
    ----------
    torsion, torque : (n,) arrays
        Samples [rad] and [N*m, output side] in the order of time, input locked; several cycles and amplitudes allowed.
    rated_torque : float, optional
        Rated torque [N*m]: lost motion is that at +-4 % of it, hysteresis loss that after it. Default: the largest
        torque measured, and a remark says so.
    ratio : float, optional
        Ratio of the gear, which `yaml` writes.
    check_units : bool
        Whether to refuse a torsion or stiffness that no gear has.

    Returns
    -------
    LoopFit
        `law`, and its numbers in SI by path (`values["K1"]` [N*m/rad]) with `interval(path)`; `lost_motion` and
        `hysteresis_loss` [rad]; `misses` says whether the law fits.

    Raises
    ------
    ValueError
        If the samples are no loop: too few, not finite, constant, without a reversal, saturated, in wrong units, or
        running the wrong way round.

    References
    ----------
    Ismail, Ikhouane & Rodellar 2009, Arch. Comput. Methods Eng. 16(2), 161-188 (Bouc-Wen); Boggs, Byrd & Schnabel 1987,
    SIAM J. Sci. Stat. Comput. 8(6), 1052-1078 (noise on both axes); Newey & West 1987, Econometrica 55(3), 703-708,
    Andrews 1991, Econometrica 59(3), 817-858 (sandwich with autocorrelation).
    """
    loop = read_loop(torsion, torque, check_units)
    remarks, reached = [], float(np.max(np.abs(loop.torque)))
    if rated_torque is None:
        largest = float(np.max(np.abs(loop.torque - np.mean(loop.torque))))
        rated = float(f"{largest:.3g}")
        remarks.append(
            f"lost motion and hysteresis loss are those of a rated torque of {rated:g} N*m, the largest measured; give "
            "rated_torque for those of a datasheet"
        )
    else:
        rated = number("rated_torque [N*m]", rated_torque, positive=True)
        for share, what in ((1.0, "hysteresis loss"), (SMALL_LOOP, "lost motion")):
            if share * rated > RANGE_FACTOR * reached:
                remarks.append(
                    f"{what} is that of the law after {share * rated:.4g} N*m, and the loop ends at {reached:.4g} N*m: "
                    "it holds as far as the law does; measure a loop as large"
                )
    ratio = None if ratio is None else number("ratio", ratio, positive=True)
    fits, unidentified = _candidates(loop)
    chosen, comparison, reason = _compare(loop, fits)
    unidentified = {name: why for name, why in unidentified.items() if name not in chosen.shape.names()}
    return _result(loop, chosen, unidentified, comparison, reason, rated, tuple(remarks), ratio)


def _candidates(loop: Loop) -> tuple[list[Solution], dict[str, str]]:
    """Every candidate fitted, with as many slopes as the samples tell apart; what they do not tell."""
    unidentified: dict[str, str] = {}
    slopes = 3
    while True:
        fits = _with_slopes(loop, slopes)
        if slopes == 1:
            offset = "torsion_offset is not identifiable: a straight line gives torque_offset - K1 torsion_offset only"
            return fits, unidentified | {"torsion_offset": offset}
        why = _undetermined(loop, min(fits, key=lambda fit: fit.cost))
        if not why:
            return fits, unidentified
        gone = ("K3", "T2") if slopes == 3 else ("K2", "T1")
        unidentified |= {name: f"{' and '.join(gone)} are not identifiable: {why}" for name in gone}
        slopes -= 1


def _with_slopes(loop: Loop, slopes: int) -> list[Solution]:
    pieces = len(loop.path.first)
    plain = Shape(slopes, False, 1, False, pieces)
    first = solve(loop, plain, start_values(loop, plain))
    values = plain.named(first.p)
    values |= {"kappa": 0.2, "half_gap": 0.01 * (0.5 * float(np.ptp(loop.torsion)))}

    def fitted(shape: Shape) -> Solution:
        start = np.array([values.get(name, 0.0) for name in shape.names()]) if shape.n else start_values(loop, shape)
        return first if shape == plain else solve(loop, shape, start)

    return [fitted(Shape(slopes, gap, n, free_beta, pieces)) for n, free_beta in ELEMENTS for gap in (False, True)]


def _undetermined(loop: Loop, fit: Solution) -> str:
    """Reason for which the samples do not tell the outermost corner of a fit; empty where they do."""
    p = fit.shape.named(fit.p)
    corner, inner, outer = ("x2", "K2", "K3") if fit.shape.slopes == 3 else ("x1", "K1", "K2")
    twist = np.abs(fit.torsion - p.get("torsion_offset", 0.0)) - p.get("half_gap", 0.0)
    sure = NOISE_FACTOR * loop.torsion_noise
    reached = float(np.max(np.abs(loop.torque - p["torque_offset"])))
    if np.count_nonzero(twist > p[corner] + sure) < SLOPE_SAMPLES:
        return f"the torque reaches {reached:.4g} N*m and no corner lies below it; the law continues with {inner}"
    if np.count_nonzero(twist < p["x1"] - sure) < SLOPE_SAMPLES:
        return f"fewer than {SLOPE_SAMPLES} samples lie below the first corner; the law has one slope fewer"
    covariance, names = scatter(loop, fit).covariance, fit.shape.names()
    i, j, k = map(names.index, (inner, outer, corner))
    apart = covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j]
    if not abs(p[outer] - p[inner]) > SLOPE_DEVIATIONS * float(np.sqrt(max(apart, 0.0))):
        return (
            f"{inner} and {outer} do not differ by more than their uncertainty up to the {reached:.4g} N*m measured; "
            f"the law continues with {inner}"
        )
    if not p[corner] > SLOPE_DEVIATIONS * float(np.sqrt(covariance[k, k])):
        return f"the corner at {p[corner]:.3g} rad is uncertain by its own value; the law continues with {inner}"
    return ""


def _compare(loop: Loop, fits: list[Solution]) -> tuple[Solution, tuple[LoopCandidate, ...], str]:
    """The simplest candidate within two standard errors of the best in blocks left out, the table, and the reason."""
    errors, given = np.array([left_out(loop, fit) for fit in fits]), [(str(fit.shape), len(fit.p)) for fit in fits]
    units = [1.0 / float(np.median(fit.weight)) for fit in fits]
    taken, _, _ = compare_candidates(given, errors, 1.0, "")
    return fits[taken], *compare_candidates(given, errors, units[taken], "in blocks left out")[1:]


def _spring(shape: Shape, unknowns: Floats, reached: float) -> Any:
    """Spring of a candidate, with as many slopes as it has, and its gap; up to a torque [N*m] that was reached."""
    p = shape.named(unknowns)
    gap = p.get("half_gap", 0.0)
    if shape.slopes == 1:
        return Backlash(p["K1"], gap) if gap else Linear(p["K1"])
    T1 = p["K1"] * p["x1"]
    T2 = max(reached, 2.0 * T1) if shape.slopes == 2 else T1 + p["K2"] * (p["x2"] - p["x1"])
    spring = PiecewiseLinear(p["K1"], p["K2"], p.get("K3", p["K2"]), T1, T2)
    return Play(gap, spring) if gap else spring


def _law(fit: Solution, reached: float) -> Any:
    """Law of a candidate: its spring, its element."""
    p, spring = fit.shape.named(fit.p), _spring(fit.shape, fit.p, reached)
    if not fit.shape.n:
        return checked(spring)
    kappa = p.get("kappa", 0.0)
    beta, gamma = 0.5 * (1.0 + kappa), 0.5 * (1.0 - kappa)
    return checked(Parallel(spring, BoucWen(p["K"], 0.0, p["yield_twist"], 1.0, beta, gamma, fit.shape.n)))


def _numbers(fit: Solution, p: Floats, rated: float) -> dict[str, float]:
    """Numbers of a result that follow from the unknowns (p,)."""
    values = fit.shape.named(p)
    numbers: dict[str, float] = {name: values[name] for name in ("K1", "K2", "K3") if name in values}
    if "x1" in values:
        numbers["T1"] = values["K1"] * values["x1"]
    if "x2" in values:
        numbers["T2"] = numbers["T1"] + values["K2"] * (values["x2"] - values["x1"])
    numbers |= {name: values[name] for name in ("half_gap", "K", "yield_twist") if name in values}
    if "kappa" in values:
        numbers |= {"beta": 0.5 * (1.0 + values["kappa"]), "gamma": 0.5 * (1.0 - values["kappa"])}
    numbers |= {name: values[name] for name in ("torsion_offset", "torque_offset") if name in values}
    numbers["lost_motion"] = loop_sizes(fit.shape, p, SMALL_LOOP * rated)[1]
    numbers["hysteresis_loss"] = loop_sizes(fit.shape, p, rated)[0]
    return numbers


def _result(
    loop: Loop, fit: Solution, unidentified: dict[str, str], comparison: tuple[LoopCandidate, ...], reason: str,
    rated: float, remarks: tuple[str, ...], ratio: float | None,
) -> LoopFit:  # fmt: skip
    pattern = structure(loop, fit)
    covariance, freedoms, _ = widened_scatter(loop, fit, pattern)
    values = _numbers(fit, fit.p, rated)
    steps = 0.05 * np.sqrt(np.diag(covariance))
    rates = derivatives(lambda p: np.array([*_numbers(fit, p, rated).values()]), fit.p, steps)
    freedom = derived_freedom(rates, covariance, freedoms)
    fitted = torque_along(fit.shape, fit.p, loop.path, loop.torsion).value
    reached = float(np.max(np.abs(loop.torque - fit.p[-1])))
    return LoopFit(
        law=_law(fit, reached), values=values, covariance=rates @ covariance @ rates.T, freedom=freedom,
        unidentified=unidentified, comparison=comparison, reason=reason,
        residual_rms=float(np.sqrt(np.mean((loop.torque - fitted) ** 2))), torque=loop.torque, fitted=fitted,
        remarks=remarks, rated_torque=rated, cycles=loop.cycles,
        energy=closed_energy(loop.torsion, loop.torque, loop.path), torsion=loop.torsion, ratio=ratio,
        lack_of_fit=None if pattern is None else pattern.lack,
    )  # fmt: skip
