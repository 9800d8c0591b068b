"""Friction identified from constant-speed runs, break-away torques and a presliding loop, with intervals that cover.

Stiffness of LuGre's bristles from a loop below break-away.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.special import fdtri

from ...base.arguments import typed
from ...base.quantities import checked, number, reals, shown
from ...base.results import Floats
from ...model.laws.friction import Coulomb, LoadFriction, LuGre, QuadraticDamping, Stribeck, Viscous
from ...model.laws.hysteresis import Parallel
from .friction_model import FrictionFit, FrictionSolution, Runs, Terms, lack_of_fit, predicted, solve_terms
from .intervals import Spread, derived_freedom, restricted, spread
from .law_fit import Candidate, LackOfFit, compared
from .loops.loop_model import states
from .loops.loop_path import read_loop
from .run import column

FEWEST = 6
FOLDS = 12
SHARP = 0.01  # of the lowest speed: over which the sign of dry friction is smoothed
FASTEST = 3000.0  # rad/s, 29 000 rpm
CHANCE = 1e-3  # that noise alone makes the squared errors of two right laws differ by as large a ratio
ROUNDING = 1e-12  # of the largest torque
SETTLED = 0.5  # of the highest speed: where a Stribeck speed leaves its Coulomb friction to be seen
APART = 1e-3  # of the largest: speeds or loads that differ by less are one

DAHL = 1.0  # beta - gamma
LARGEST_SHARE = 0.98  # of the break-away torque


class Presliding(NamedTuple):
    """Stiffness [N*m/rad] of the bristles, its standard deviation and the degrees of freedom of that."""

    sigma_0: float
    deviation: float
    freedom: float


def presliding_stiffness(measured: Any, breakaway: float) -> Presliding:
    """Fit sigma_0 to a slow loop, a pair of (n,) arrays [rad], [N*m], below a break-away torque [N*m].

    Raises
    ------
    ValueError
        If it is no pair of arrays, the samples are no loop, or it reaches the break-away torque.
    """
    try:
        angle, torque = measured
    except (TypeError, ValueError):
        raise ValueError(
            f"presliding is {shown(measured)}; give a pair, the angles [rad] and the torques [N*m] of a slow loop"
        ) from None
    loop = read_loop(angle, torque, check_units=False)
    reach = 0.5 * float(np.ptp(loop.torque))
    if reach > LARGEST_SHARE * breakaway:
        raise ValueError(
            f"the presliding loop reaches {reach:.4g} N*m and the shaft breaks away at {breakaway:.4g} N*m; give a "
            "loop that stays below"
        )

    def value(p: Floats) -> Floats:
        sigma = float(np.exp(p[0]))
        bristles = states(loop.path, loop.torsion, 1, breakaway / sigma, DAHL, float(np.tanh(p[1])))
        return np.asarray(breakaway * (bristles + p[2]))

    slope = float(np.polyfit(loop.torsion, loop.torque, 1)[0])
    found = least_squares(lambda p: (loop.torque - value(p)) / breakaway, [np.log(1.5 * slope), 0.0, 0.0], method="lm")
    scale = restricted(-found.jac, found.fun)
    sigma = float(np.exp(found.x[0]))
    return Presliding(sigma, sigma * float(scale.covariance[0, 0]) ** 0.5, float(np.min(scale.freedom)))


@typed
def fit_friction(
    speed: ArrayLike, torque: Any, load: ArrayLike | None = None, *, deviation: ArrayLike | None = None,
    breakaway: ArrayLike | None = None, presliding: tuple[ArrayLike, ArrayLike] | None = None,
    width: float | None = None,
) -> FrictionFit:  # fmt: skip
    """Identify friction from runs at constant speed: Coulomb, viscous, Stribeck, load-proportional, quadratic, sides.

    Every combination of terms is fitted, and compared by the error of runs that were left out; the simplest is taken
    that is within two standard errors of the best and whose error noise alone may make so much larger. Runs stand in
    the order of time: dry friction may drift. Where the law misses the means of runs that were repeated by more than
    these differ, it is said, and the intervals are wider by that. All quantities belong to one shaft.

    Parameters
    ----------
    speed : (n,) array
        Speed of each run [rad/s], negative in the other direction.
    torque : (n,) array, or sequence of n arrays
        Mean torque [N*m] that keeps the speed, of the speed's sign; or the samples of each run.
    load : (n,) array, optional
        Torque [N*m] that the gear transmits in each run, on the same shaft. Default: none.
    deviation : (n,) array, optional
        Standard errors [N*m] of the mean torques. Default: those of the samples, or all equal.
    breakaway : (m,) array, optional
        Torques [N*m] at which the shaft breaks away, negative in the other direction.
    presliding : pair of arrays, optional
        Angle [rad] and torque [N*m] of a loop below break-away, for the stiffness sigma_0 of LuGre's bristles.
    width : float, optional
        Speed [rad/s] over which the law smooths the sign of dry friction. Default: 1 % of the lowest speed.

    Returns
    -------
    FrictionFit
        `law` of the drag and its numbers by path (`values["T_c"]` [N*m], `values["B"]` [N*m*s/rad]) with
        `interval(path)`; `misses` says whether it fits.

    Raises
    ------
    ValueError
        If the runs are too few, not finite or at one speed, or the torque drives the shaft.

    References
    ----------
    Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083-1138 (terms of friction); Canudas de Wit,
    Olsson, Astrom & Lischinsky 1995, IEEE Trans. Automatic Control 40(3), 419-425, eqs. (3)-(6) (LuGre).
    """
    runs, unidentified, errors_known = _runs(speed, torque, load, deviation, breakaway)
    sliding = np.abs(runs.speed[runs.speed != 0.0])
    smooth = SHARP * float(np.min(sliding)) if width is None else number("width [rad/s]", width, positive=True)
    fits = [fit for terms in _candidates(runs, load is not None) if (fit := _fitted(terms, runs)) is not None]
    if not fits:
        raise ValueError(
            "no friction law fits these runs: the torque falls with the speed or drives the shaft; check the signs of "
            "speed and torque"
        )
    chosen, comparison, reason = _compare(runs, fits)
    scatter = restricted(chosen.jacobian, chosen.residual)
    lack = lack_of_fit(chosen, runs, errors_known)
    if lack is not None and lack.found:
        scatter = scatter._replace(covariance=scatter.covariance * max(lack.ratio, 1.0))
    stiffness = None
    if presliding is not None:
        p = chosen.terms.named(chosen.p)
        stiffness = presliding_stiffness(presliding, p["T_c"] + p.get("rise", 0.0))
    return _result(runs, chosen, scatter, unidentified, comparison, reason, smooth, stiffness, lack)


def _column(name: str, values: Any, count: int | None = None) -> Floats:
    found = column(name, values, "run")
    if found.ndim != 1 or (count is not None and len(found) != count):
        raise ValueError(f"{name} has the shape {found.shape}; give one number for each of the {count or ''} runs")
    return found


def _runs(speed: Any, torque: Any, load: Any, deviation: Any, breakaway: Any) -> tuple[Runs, dict[str, str], bool]:
    v = _column("speed [rad/s]", speed)
    if len(v) < FEWEST:
        raise ValueError(f"there are {len(v)} runs; measure at least {FEWEST}, at several speeds in both directions")
    if not np.all(v != 0.0):
        raise ValueError(
            f"run {int(np.flatnonzero(v == 0.0)[0])} stands still; give torques at which the shaft breaks away as "
            "breakaway"
        )
    if float(np.max(np.abs(v))) > FASTEST:
        raise ValueError(f"the speed reaches {np.max(np.abs(v)):.4g} rad/s, beyond any motor; is it in rpm? convert it")
    if float(np.ptp(np.abs(v))) < APART * float(np.max(np.abs(v))):
        raise ValueError(
            f"all runs are at {abs(v[0]):.4g} rad/s: Coulomb and viscous friction cannot be told apart, only T_c + "
            f"{abs(v[0]):.4g} B is identifiable; measure at several speeds"
        )
    t, own = _means(torque, len(v))
    size = np.zeros(len(v)) if load is None else np.abs(_column("load [N*m]", load, len(v)))
    spreads = own if deviation is None else _column("deviation [N*m]", deviation, len(v))
    if not np.all(spreads > 0.0):
        raise ValueError("a deviation is not positive; give the standard error of every mean torque, or none")
    if float(t @ np.sign(v)) < 0.0:
        raise ValueError(
            "the torque has the opposite sign of the speed: friction would drive the shaft; turn the sign of one"
        )
    unidentified = {}
    if load is not None and float(np.ptp(size)) <= APART * float(np.max(size)):
        unidentified["mu"] = (
            f"mu is not identifiable: the load is {size[0]:.4g} N*m in every run, so that only T_c + {size[0]:.4g} mu "
            "is; measure with several loads"
        )
    if np.all(v > 0.0) or np.all(v < 0.0):
        unidentified["offset"] = "the difference of the sides is not identifiable: all runs go in one direction"
    runs = Runs(v, np.sign(v), t, size, 1.0 / spreads, np.linspace(0.0, 1.0, len(v)))
    if breakaway is not None:
        b = _column("breakaway [N*m]", np.atleast_1d(reals(breakaway)))
        none, weight = np.zeros(len(b)), np.full(len(b), float(np.median(runs.weight)))
        more = Runs(none, np.sign(b), b, none, weight, none + 0.5)
        runs = Runs(*(np.concatenate(both) for both in zip(runs, more, strict=True)))
    return runs, unidentified, deviation is not None


def _means(torque: Any, count: int) -> tuple[Floats, Floats]:
    """Mean torques (n,) and their standard errors (all 1 where they are not known)."""
    if not (isinstance(torque, Sequence) and torque and np.ndim(torque[0]) == 1):
        return _column("torque [N*m]", torque, count), np.ones(count)
    if len(torque) != count:
        raise ValueError(f"there are {count} speeds and the torques of {len(torque)} runs; give one run a speed")
    means, errors = np.empty(count), np.empty(count)
    for i, samples in enumerate(torque):
        run = _column(f"torque of run {i} [N*m], sample", samples)
        if len(run) < FEWEST:
            raise ValueError(f"run {i} has {len(run)} samples; give at least {FEWEST}, or the mean torques")
        means[i] = np.mean(run)
        error = float(spread(np.ones((len(run), 1)), run - means[i]).covariance[0, 0])
        errors[i] = max(error, 1e-12 * max(float(means[i] ** 2), 1e-30)) ** 0.5
    return means, errors


def _candidates(runs: Runs, loaded: bool) -> Iterator[Terms]:
    sides = bool(np.any(runs.speed > 0.0) and np.any(runs.speed < 0.0))
    varied = loaded and float(np.ptp(runs.load)) > APART * float(np.max(runs.load))
    levels = len(np.unique(np.round(np.abs(runs.speed) / np.max(np.abs(runs.speed)) / APART)))
    for viscous, stribeck, load in product((False, True), (False, levels >= 4), (False, varied)):
        for offset, both in ((False, False), (sides, False), (sides, sides and viscous)):
            # loads that change with the time, as they mostly do, look like a drift
            for quadratic, drift in dict.fromkeys(product((False, viscous and levels >= 4), (False, not varied))):
                yield Terms(viscous, stribeck, load, offset, both, quadratic, drift)


def _fitted(terms: Terms, runs: Runs) -> FrictionSolution | None:
    """A candidate, None where its numbers are no friction."""
    if len(runs.speed) <= len(terms.names()) + 1:
        return None
    fit = solve_terms(terms, runs)
    p = terms.named(fit.p)
    good = p["T_c"] >= max(0.0, -p.get("drift", 0.0)) and p.get("rise", 0.0) >= 0.0 and p.get("D", 0.0) >= 0.0
    good &= p.get("B", 0.0) >= abs(p.get("B_asymmetry", 0.0))
    good &= p.get("v_s", 0.0) <= SETTLED * float(np.max(np.abs(runs.speed)))
    return fit if good and 0.0 <= p.get("mu", 0.0) < 1.0 else None


def _compare(runs: Runs, fits: list[FrictionSolution]) -> tuple[FrictionSolution, tuple[Candidate, ...], str]:
    """The simplest candidate within two standard errors of the best on runs left out, the table, and the reason.

    It must also have squared errors that noise alone may make differ so much: a ratio of chi squares (F).
    """
    fits = list({fit.terms: fit for fit in fits}.values())
    count = len(runs.speed)
    fold = np.arange(count) % min(FOLDS, count)
    errors = np.array([_left_out(runs, fit, fold) for fit in fits])
    # a few runs with large errors make the standard error large: noise alone still has no ratio as large
    rounding = (ROUNDING * float(np.max(np.abs(runs.weight * runs.torque), initial=0.0))) ** 2
    most = float(fdtri(count, count, 1.0 - CHANCE)) * (float(np.min(errors.mean(axis=1))) + rounding)
    given = [(str(fit.terms), len(fit.p)) for fit in fits]
    taken, rows, reason = compared(given, errors, 1.0 / float(np.median(runs.weight)), "on runs left out", most)
    return fits[taken], rows, reason


def _left_out(runs: Runs, fit: FrictionSolution, fold: Any) -> Floats:
    """Squared weighted error (n,) of every run under the fit to the other folds."""
    errors = np.empty(len(fold))
    for k in range(int(np.max(fold)) + 1):
        out = fold == k
        p = solve_terms(fit.terms, runs.some(~out), float(fit.p[-1])).p
        there = runs.some(out)
        errors[out] = (there.weight * (there.torque - predicted(fit.terms, p, there))) ** 2
    return errors


def _law(p: dict[str, float], width: float, lowest: float, stiffness: Presliding | None) -> Any:
    T_c, T_s, B = p["T_c"], p["T_c"] + p.get("rise", 0.0), p.get("B", 0.0)
    if stiffness is not None:
        law: Any = LuGre(stiffness.sigma_0, 0.0, B, T_c, T_s, p.get("v_s", lowest))
    else:
        law = Stribeck(T_c, T_s, p["v_s"], min(width, 0.5 * p["v_s"])) if "v_s" in p else Coulomb(T_c, width)
        law = Parallel(law, Viscous(B)) if B > 0.0 else law
    return checked(Parallel(law, QuadraticDamping(p["D"])) if p.get("D", 0.0) > 0.0 else law)


def _result(
    runs: Runs, fit: FrictionSolution, scatter: Spread, unidentified: dict[str, str],
    comparison: tuple[Candidate, ...], reason: str, width: float, stiffness: Presliding | None,
    lack: LackOfFit | None,
) -> FrictionFit:  # fmt: skip
    p = fit.terms.named(fit.p)
    rows = dict(zip(p, np.eye(len(p)), strict=True))
    combinations = {"T_c": rows["T_c"]}
    if "rise" in p:
        combinations |= {"T_s": rows["T_c"] + rows["rise"], "v_s": rows["v_s"]}
    combinations |= {name: rows[name] for name in ("B", "D", "mu", "offset", "B_asymmetry", "drift") if name in p}
    if "offset" in p:
        combinations |= {"T_c_forward": rows["T_c"] + rows["offset"], "T_c_backward": rows["T_c"] - rows["offset"]}
    R = np.array([*combinations.values()])
    freedom = derived_freedom(R, scatter.covariance, scatter.freedom)
    values, covariance = dict(zip(combinations, (R @ fit.p).tolist(), strict=True)), R @ scatter.covariance @ R.T
    remarks = []
    if "drift" in p:
        remarks.append(
            f"dry friction changes by {p['drift']:+.3g} N*m from the first run to the last; T_c is that of the first"
        )
    if stiffness is not None:
        values["sigma_0"] = stiffness.sigma_0
        covariance = np.pad(covariance, (0, 1))
        covariance[-1, -1] = stiffness.deviation**2
        freedom = np.append(freedom, stiffness.freedom)
        remarks.append("sigma_1 is 0: a slow loop does not tell the damping of the bristles")
    if "offset" in p:
        remarks.append(
            f"the law holds the mean of both directions; Coulomb friction is {values['T_c_forward']:.4g} N*m forward "
            f"and {values['T_c_backward']:.4g} N*m backward"
        )
    lowest = float(np.min(np.abs(runs.speed[runs.speed != 0.0])))
    load_law = checked(LoadFriction(p["mu"], width)) if "mu" in p else None
    fitted = predicted(fit.terms, fit.p, runs)
    return FrictionFit(
        _law(p, width, lowest, stiffness), values, covariance, freedom, unidentified, comparison, reason,
        float(np.sqrt(np.mean((runs.torque - fitted) ** 2))), runs.torque, fitted, tuple(remarks), load_law,
        runs.speed, lack_of_fit=lack,
    )  # fmt: skip
