"""A law identified from a measured loop of torque over torsion: slopes, backlash, hysteresis, with their intervals."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....model.laws.hysteresis import BoucWen, Parallel
from ....model.laws.springs import Backlash, Linear, PiecewiseLinear, Play
from ....quantities import checked, number
from ....results import Floats
from .loop_errors import scatter
from .loop_lack import structure, wider
from .loop_measures import SMALL_LOOP, loop_sizes
from .loop_model import Shape
from .loop_model import torque as torque_along
from .loop_path import Loop, closed_energy, read_loop
from .loop_result import LoopCandidate, LoopFit
from .loop_solve import Solution, left_out, solve, started
from .restricted import derived_freedom

ELEMENTS = ((0, False), (1, False), (1, True), (2, False), (2, True))  # exponent of Bouc-Wen, whether beta is fitted
BEYOND = 12  # samples that a slope needs
WITHIN = 2.0  # standard errors of the difference from the best candidate
CLEAR = 2.0  # standard deviations by which two slopes must differ


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
    remarks = []
    if rated_torque is None:
        largest = float(np.max(np.abs(loop.torque - np.mean(loop.torque))))
        rated = float(f"{largest:.3g}")
        remarks.append(
            f"lost motion and hysteresis loss are those of a rated torque of {rated:g} N*m, the largest measured; give "
            "rated_torque for those of a datasheet"
        )
    else:
        rated = number("rated_torque [N*m]", rated_torque, positive=True)
    ratio = None if ratio is None else number("ratio", ratio, positive=True)
    fits, unidentified = _candidates(loop)
    chosen, comparison, reason = _compare(loop, fits)
    return _result(loop, chosen, unidentified, comparison, reason, rated, tuple(remarks), ratio)


def _candidates(loop: Loop) -> tuple[list[Solution], dict[str, str]]:
    """Every candidate fitted, with as many slopes as the samples tell apart; what they do not tell."""
    unidentified: dict[str, str] = {}
    slopes = 3
    while True:
        fits = _with_slopes(loop, slopes)
        if slopes == 1:
            offset = "torsion_offset is not identifiable: a straight line tells torque_offset - K1 torsion_offset alone"
            return fits, unidentified | {"torsion_offset": offset}
        best = min(fits, key=lambda fit: fit.cost)
        why = _untold(loop, best)
        if not why:
            return fits, unidentified
        gone = ("K3", "T2") if slopes == 3 else ("K2", "T1")
        unidentified |= {name: f"{' and '.join(gone)} are not identifiable: {why}" for name in gone}
        slopes -= 1


def _with_slopes(loop: Loop, slopes: int) -> list[Solution]:
    fits: list[Solution] = []
    plain = Shape(slopes, False, 1, False)
    first = solve(loop, plain, started(loop, plain))
    given = dict(zip(plain.names(), first.p.tolist(), strict=True))
    for n, free_beta in ELEMENTS:
        for gap in (False, True):
            shape = Shape(slopes, gap, n, free_beta)
            if shape == plain:
                fits.append(first)
                continue
            if n:
                reach = 0.5 * float(np.ptp(loop.torsion))
                more = given | {"kappa": 0.2, "half_gap": 0.01 * reach}
                start = np.array([more.get(name, 0.0) for name in shape.names()])
            else:
                start = started(loop, shape)
            fits.append(solve(loop, shape, start))
    return fits


def _untold(loop: Loop, fit: Solution) -> str:
    """Why the outermost corner of a fit is not told by the samples; empty where it is."""
    p = dict(zip(fit.shape.names(), fit.p.tolist(), strict=True))
    corner, inner, outer = ("x2", "K2", "K3") if fit.shape.slopes == 3 else ("x1", "K1", "K2")
    way = np.abs(fit.torsion - p.get("torsion_offset", 0.0)) - p.get("half_gap", 0.0)
    reached = float(np.max(np.abs(loop.torque - p["torque_offset"])))
    if np.count_nonzero(way > p[corner]) < BEYOND:
        return f"the torque reaches {reached:.4g} N*m and no corner lies below it; the law continues with {inner}"
    if np.count_nonzero(way < p["x1"]) < BEYOND:
        return f"fewer than {BEYOND} samples lie below the first corner; the law continues with {inner}"
    covariance, names = scatter(loop, fit).covariance, fit.shape.names()
    i, j, k = (names.index(name) for name in (inner, outer, corner))
    apart = covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j]
    if not abs(p[outer] - p[inner]) > CLEAR * float(np.sqrt(max(apart, 0.0))):
        return (
            f"{inner} and {outer} do not differ by more than their uncertainty up to the {reached:.4g} N*m measured; "
            f"the law continues with {inner}"
        )
    if not p[corner] > CLEAR * float(np.sqrt(covariance[k, k])):
        return f"the corner at {p[corner]:.3g} rad is as uncertain as that; the law continues with {inner}"
    return ""


def _compare(loop: Loop, fits: list[Solution]) -> tuple[Solution, tuple[LoopCandidate, ...], str]:
    """The simplest candidate within two standard errors of the best in blocks left out, the table, and the reason."""
    errors = [left_out(loop, fit) for fit in fits]
    means = [float(np.mean(error)) for error in errors]
    best = int(np.argmin(means))
    worse = []
    for error in errors:
        difference = error - errors[best]
        spread = float(np.std(difference, ddof=1) / np.sqrt(len(difference)))
        worse.append(float(np.mean(difference)) / spread if spread > 0.0 else 0.0)
    within = [i for i in range(len(fits)) if worse[i] <= WITHIN]
    taken = min(within, key=lambda i: (len(fits[i].p), means[i]))
    unit = 1.0 / float(np.median(fits[taken].weight))
    rows = tuple(
        LoopCandidate(str(fits[i].shape), len(fits[i].p), unit * float(np.sqrt(means[i])), worse[i], i == taken)
        for i in sorted(range(len(fits)), key=lambda i: means[i])
    )
    said = f"{fits[taken].shape}: error {unit * np.sqrt(means[taken]):.3g} N*m in blocks left out"
    if taken == best:
        reason = f"{said}, the smallest of {len(fits)} candidates"
    else:
        reason = (
            f"{said}, within two standard errors of the smallest, {unit * np.sqrt(means[best]):.3g} N*m, of "
            f"{fits[best].shape}, which has {len(fits[best].p) - len(fits[taken].p)} more unknowns"
        )
        if len(fits[best].p) == len(fits[taken].p):
            reason = f"{said}, the smallest of {len(fits)} candidates"
    return fits[taken], rows, reason


def _law(fit: Solution, reached: float) -> Any:
    """Law of a candidate: the spring with as many slopes as it has, its gap, its element."""
    p = dict(zip(fit.shape.names(), fit.p.tolist(), strict=True))
    gap = p.get("half_gap", 0.0)
    if fit.shape.slopes == 1:
        spring: Any = Backlash(p["K1"], gap) if gap else Linear(p["K1"])
    else:
        T1 = p["K1"] * p["x1"]
        if fit.shape.slopes == 2:
            spring = PiecewiseLinear(p["K1"], p["K2"], p["K2"], T1, max(reached, 2.0 * T1))
        else:
            spring = PiecewiseLinear(p["K1"], p["K2"], p["K3"], T1, T1 + p["K2"] * (p["x2"] - p["x1"]))
        spring = Play(gap, spring) if gap else spring
    if not fit.shape.n:
        return checked(spring)
    kappa = p.get("kappa", 0.0)
    beta, gamma = 0.5 * (1.0 + kappa), 0.5 * (1.0 - kappa)
    return checked(Parallel(spring, BoucWen(p["K"], 0.0, p["yield_twist"], 1.0, beta, gamma, fit.shape.n)))


def _numbers(fit: Solution, p: Floats, rated: float) -> dict[str, float]:
    """Numbers of a result that follow from the unknowns (p,)."""
    given = dict(zip(fit.shape.names(), p.tolist(), strict=True))
    found: dict[str, float] = {name: given[name] for name in ("K1", "K2", "K3") if name in given}
    if "x1" in given:
        found["T1"] = given["K1"] * given["x1"]
    if "x2" in given:
        found["T2"] = found["T1"] + given["K2"] * (given["x2"] - given["x1"])
    found |= {name: given[name] for name in ("half_gap", "K", "yield_twist") if name in given}
    if "kappa" in given:
        found |= {"beta": 0.5 * (1.0 + given["kappa"]), "gamma": 0.5 * (1.0 - given["kappa"])}
    found |= {name: given[name] for name in ("torsion_offset", "torque_offset") if name in given}
    found["lost_motion"] = loop_sizes(fit.shape, p, SMALL_LOOP * rated)[1]
    found["hysteresis_loss"] = loop_sizes(fit.shape, p, rated)[0]
    return found


def _result(
    loop: Loop, fit: Solution, unidentified: dict[str, str], comparison: tuple[LoopCandidate, ...], reason: str,
    rated: float, remarks: tuple[str, ...], ratio: float | None,
) -> LoopFit:  # fmt: skip
    found = structure(loop, fit)
    covariance, known, _ = wider(loop, fit, found)
    values = _numbers(fit, fit.p, rated)
    deviations = np.sqrt(np.diag(covariance))
    rates = np.zeros((len(values), len(fit.p)))
    for i, deviation in enumerate(deviations):
        if deviation > 0.0:
            h = 0.05 * deviation * (np.arange(len(deviations)) == i)
            low, high = (np.array([*_numbers(fit, p, rated).values()]) for p in (fit.p - h, fit.p + h))
            rates[:, i] = (high - low) / (0.1 * deviation)
    freedom = derived_freedom(rates, covariance, known)
    fitted = torque_along(fit.shape, fit.p, loop.path, loop.torsion).value
    reached = float(np.max(np.abs(loop.torque - fit.p[-1])))
    return LoopFit(
        _law(fit, reached), values, rates @ covariance @ rates.T, freedom, unidentified,
        comparison, reason, rated, loop.cycles, closed_energy(loop.torsion, loop.torque, loop.path),
        float(np.sqrt(np.mean((loop.torque - fitted) ** 2))), loop.torsion, loop.torque, fitted, remarks, ratio,
        None if found is None else found.lack,
    )  # fmt: skip
