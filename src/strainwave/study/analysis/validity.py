"""Where multiple scales hold: their error against harmonic balance, over speed and strength of the excitation.

At every speed and strength the stable steady states of largest amplitude of both orders are moved to true motions at
that speed by Newton's method (7 harmonics of the fastest component; Krack & Gross 2019, Harmonic Balance for Nonlinear
Vibration Problems, ch. 2). True motions also start from those of the neighbouring cells, so that a motion which both
orders miss is met as well. The largest stable one of them is what the orders are compared with.

Where multiple scales hold at the peak of the primary resonance of a cubic law: over alpha a^2 and damping ratio.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.arguments import typed
from ...base.protocols import with_parts
from ...base.quantities import number, numbers, shown
from ...base.records import Labelled, Result
from ...base.results import Floats
from ...base.sentences import on_screen
from ...model.excitation import Harmonic
from ...model.laws.springs import Cubic
from ...model.oscillator import Oscillator
from ...theory.slow_flow.certificate import Balance, balance_of, corrected
from ...theory.slow_flow.fixed_points import newton_step, rates_of
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.setting import PRIMARY, Complexes, Resonance, real_matrix
from ...theory.slow_flow.states import at, states

ROUNDS, NEAR, STEP = 40, 1e-12, 1e-6  # of Newton's method: steps, last relative change; step of a difference in omega

TOGETHER = 500  # cells in one step of Newton's method: a user can interrupt between
LARGER = 1.05  # times the own motion: a neighbour's motion is then tried in a cell
MOST_SPREADS = 400  # rounds of such trials
REST = 1e-6  # of the whole motion: a component near omega_0 below it is absent

ORDERS = (1, 2)
LEVELS = (1.0, 5.0, 20.0)  # percent


class Holds(Result):
    """What both maps can say: where an order holds to some percent."""

    error: Floats

    def holds(self, percent: float) -> NDArray[np.bool_]:
        """Whether each order holds to so many percent: the shape of `error`.

        Parameters
        ----------
        percent : float
            Between 0 and 100.
        """
        limit = number("percent", percent, positive=True)
        if not limit < 100.0:
            raise ValueError(f"percent is {limit:g}; it must be below 100, where no order holds")
        return self.error <= 0.01 * limit

    def _shares(self) -> list[str]:
        shares = [[f"{np.mean(part):.0%}" for part in self.holds(level)] for level in LEVELS]
        return [
            f"  order {order} holds to {', '.join(f'{level:g} %' for level in LEVELS)} in "
            f"{', '.join(share[i] for share in shares)} of the cells"
            for i, order in enumerate(ORDERS)
        ]


@dataclass(frozen=True, eq=False)
class ValidityMap(Holds):
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Attributes
    ----------
    regime : str
        The resonance treated.
    speeds : (n,) array
        Speeds of the base angle [rad/s].
    amplitudes : (m,) array
        Factors of every line of the excitation.
    error : (2, n, m) array
        Relative error of first and second order in the amplitude of the component near omega_0, of the stable state of
        largest amplitude against the stable true motion of largest amplitude at that speed; where the component is
        absent, of the whole motion. At most 1, which is also where either of the two is absent.
    motion : (n, m) array
        Amplitude [rad, 0-to-peak] of that component of the true motion; 0 where it is absent.
    """

    regime: str
    speeds: Floats
    amplitudes: Floats
    error: Floats
    motion: Floats

    def coordinates(self) -> Labelled:
        """Orders, speeds, and factors of the excitation."""
        return {
            "order": ("order", np.array(ORDERS), ""),
            "omega": ("omega", self.speeds, "rad/s"),
            "amplitude": ("amplitude", self.amplitudes, ""),
        }

    def variables(self) -> Labelled:
        """Errors of both orders, and the true amplitude."""
        return {
            "error": (("order", "omega", "amplitude"), self.error, ""),
            "motion": (("omega", "amplitude"), self.motion, "rad"),
        }

    def __str__(self) -> str:
        head = (
            f"Validity of multiple scales ({self.regime}): {len(self.speeds)} speeds, {self.speeds[0]:.6g} .. "
            f"{self.speeds[-1]:.6g} rad/s, {len(self.amplitudes)} strengths of the excitation, "
            f"{self.amplitudes[0]:.6g} .. {self.amplitudes[-1]:.6g} times the system's"
        )
        return on_screen("\n".join([head, *self._shares()]))


@dataclass(frozen=True, eq=False)
class GeneralValidity(Holds):
    """Where each order holds at the peak of the primary resonance of a cubic law, whatever the drive.

    Attributes
    ----------
    bend : (n,) array
        alpha a^2 with the amplitude a of the component near omega_0 of the true motion at the peak, where it lags the
        torque by 90 degrees.
    damping_ratio : (m,) array
        zeta = B/(2 sqrt(J K)).
    amplitude_error, speed_error : (2, n, m) arrays
        Relative errors of first and second order in the amplitude and in the speed of the peak; at most 1, which is
        also where an order has no peak.
    """

    bend: Floats
    damping_ratio: Floats
    amplitude_error: Floats
    speed_error: Floats

    @property
    def error(self) -> Floats:  # type: ignore[override]
        """The larger one of both errors (2, n, m)."""
        return np.maximum(self.amplitude_error, self.speed_error)

    def coordinates(self) -> Labelled:
        """Orders, alpha a^2 and damping ratios."""
        return {
            "order": ("order", np.array(ORDERS), ""),
            "bend": ("bend", self.bend, ""),
            "damping_ratio": ("damping_ratio", self.damping_ratio, ""),
        }

    def variables(self) -> Labelled:
        """Errors of both orders."""
        dims = ("order", "bend", "damping_ratio")
        names: Any = ("amplitude_error", "speed_error", "error")
        return {name: (dims, getattr(self, name), "") for name in names}

    def __str__(self) -> str:
        head = (
            f"Validity of multiple scales at the peak of a cubic law: alpha a^2 = {self.bend[0]:.3g} .. "
            f"{self.bend[-1]:.3g}, damping ratio {self.damping_ratio[0]:.3g} .. {self.damping_ratio[-1]:.3g}"
        )
        return on_screen("\n".join([head, *self._shares()]))


@typed
def validity_map(system: Any, resonance: Resonance, speeds: ArrayLike, amplitudes: ArrayLike) -> ValidityMap:
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Parameters
    ----------
    system : Oscillator
        The drive; its own omega is ignored.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle.
    speeds : (n,) array_like
        Speeds of the base angle [rad/s], positive, in rising order.
    amplitudes : (m,) array_like
        Factors of every line of the system's torque and kinematic error, positive, in rising order; 1 is the system as
        it is. The mean torque stays.

    Returns
    -------
    ValidityMap
        The error of both orders in the amplitude of the component near omega_0.

    Raises
    ------
    ValueError
        If the axes are not positive and rising, or the slow flow refuses the system at a speed.
    """
    speeds, amplitudes = axis("speeds [rad/s]", speeds), axis("amplitudes", amplitudes)
    system = with_parts("validity_map", system, "law", "J", "omega")
    near = system._replace(omega=float(speeds[len(speeds) // 2]))
    flows = [slow_flow(near, resonance, order=order)._flow for order in ORDERS]
    for w in speeds.tolist():
        flows[0].setting.refuse_on_resonance(w)
    shape = len(speeds), len(amplitudes)
    omega, factor = np.repeat(speeds, shape[1]), np.tile(amplitudes, shape[0])
    everywhere = flows[0].setting.scaled(factor).at(omega)
    cells = _Cells(replace(balance_of(flows[0].setting), setting=everywhere), omega)
    motions = []
    for flow in flows:
        z = states(flow, omega, factor).largest_stable()
        motions.append(_motion(cells, replace(flow, setting=everywhere), z))
        cells.improve(np.flatnonzero(np.isfinite(z)), motions[-1])
    cells.spread(shape)
    error = np.stack([cells.error(motion).reshape(shape) for motion in motions])
    return ValidityMap(str(resonance.checked()), speeds, amplitudes, error, cells.size().reshape(shape))


def axis(name: str, values: ArrayLike) -> Floats:
    """Positive numbers in rising order, or a sentence (ValueError)."""
    found = numbers(name, values)
    if not (np.all(found > 0.0) and np.all(np.diff(found) > 0.0)):
        raise ValueError(f"{name} are {shown(values)}; they must be positive and in rising order")
    return found


def _motion(cells: "_Cells", flow: Any, z: Complexes) -> Complexes:
    """Coefficients (cells, H+1) of the motions of a flow; not finite where there is no state."""
    return np.where(np.isfinite(z)[:, None], cells.balance.motion(flow, z), np.nan)


class _Cells:
    """The true motions of all cells: the largest stable one that was met so far."""

    def __init__(self, balance: Balance, omega: Floats) -> None:
        self.balance, self.omega = balance, omega
        self.c = np.full((len(omega), balance.harmonics + 1), np.nan + 0j)

    def size(self) -> Floats:
        """Amplitude [rad] of the component near omega_0; 0 where there is none, or no true motion was met."""
        return np.asarray(np.nan_to_num(np.abs(self.c[:, self.balance.fast])))

    def improve(self, cells: Any, motion: Complexes) -> Any:
        """Start from motions (all cells) in some cells; return in which a larger stable motion was met."""
        better = [self._improve(part, motion[part]) for part in np.array_split(cells, len(cells) // TOGETHER + 1)]
        return np.concatenate(better)

    def _improve(self, cells: Any, start: Complexes) -> Any:
        if not len(cells):
            return cells
        balance, omega = self.balance.of(cells), self.omega[cells]
        solution = corrected(balance, start, omega, None)
        good = np.flatnonzero(solution.converged)
        good = good[balance.of(good).holds_still(solution.c[good], omega[good])] if len(good) else good
        where, c = cells[good], solution.c[good]
        fast = self.balance.fast
        missing = ~np.isfinite(self.c[where, fast])
        larger = missing | (np.abs(c[:, fast]) > (1.0 + REST) * np.nan_to_num(np.abs(self.c[where, fast])))
        self.c[where[larger]] = c[larger]
        return where[larger]

    def spread(self, shape: tuple[int, int]) -> None:
        """Try the motions of neighbouring cells where these are larger, until nothing changes."""
        new = np.arange(len(self.omega))
        cell = np.arange(len(self.omega)).reshape(shape)
        for _ in range(MOST_SPREADS):
            changed = np.zeros(len(self.omega), bool)
            changed[new] = True
            size, new = self.size(), np.zeros(0, int)
            for cells, neighbours in (
                (cell[1:], cell[:-1]),
                (cell[:-1], cell[1:]),
                (cell[:, 1:], cell[:, :-1]),
                (cell[:, :-1], cell[:, 1:]),
            ):
                mine, its = cells.ravel(), neighbours.ravel()
                try_it = changed[its] & (size[its] > LARGER * size[mine])
                start = np.full_like(self.c, np.nan)
                start[mine[try_it]] = self.c[its[try_it]]
                new = np.union1d(new, self.improve(mine[try_it], start))
            if not len(new):
                break

    def error(self, motion: Complexes) -> Floats:
        """Relative error of motions: of the component near omega_0, or where it is absent of the whole; at most 1."""
        fast = self.balance.fast
        mine, its = np.abs(motion[:, fast]), np.abs(self.c[:, fast])
        whole = np.linalg.norm(self.c[:, 1:], axis=1)
        off = np.linalg.norm(motion - self.c, axis=1)
        with np.errstate(all="ignore"):
            rest = (mine <= REST * whole) & (its <= REST * whole)
            error = np.where(rest, off / whole, np.abs(mine - its) / its)
        return np.where(np.isfinite(error), np.minimum(error, 1.0), 1.0)


def validity_in_general(bends: ArrayLike, damping_ratios: ArrayLike) -> GeneralValidity:
    """Where each order holds at the peak of the primary resonance of any drive with a hardening cubic law.

    Parameters
    ----------
    bends : (n,) array_like
        alpha a^2, positive, in rising order; a is the amplitude [rad, 0-to-peak] at the peak.
    damping_ratios : (m,) array_like
        zeta = B/(2 sqrt(J K)), positive, in rising order.

    Returns
    -------
    GeneralValidity
        Errors of both orders in amplitude and speed of the peak.

    Raises
    ------
    ValueError
        If the axes are not positive and rising.
    """
    bend, ratio = axis("bends", bends), axis("damping_ratios", damping_ratios)
    errors = np.ones((2, len(ORDERS), len(bend), len(ratio)))
    for j, zeta in enumerate(ratio.tolist()):
        drive = Oscillator(1.0, 2.0 * zeta, Cubic(1.0, 1.0), Harmonic(1.0), 1.0)
        flows = [slow_flow(drive, PRIMARY, order=order)._flow for order in ORDERS]
        a = np.sqrt(bend)
        omega, torque = _true_peak(balance_of(flows[0].setting), a)
        for i, flow in enumerate(flows):
            own, speed = _peak(flow, torque, a, omega)
            errors[:, i, :, j] = np.abs(own / a - 1.0), np.abs(speed / omega - 1.0)
    errors = np.where(np.isfinite(errors), np.minimum(errors, 1.0), 1.0)
    return GeneralValidity(bend, ratio, errors[0], errors[1])


def _true_peak(form: Balance, a: Floats) -> tuple[Floats, Floats]:
    """Speed and torque of motions with the first harmonic -i a; not finite where Newton's method does not converge."""
    h, s = form.harmonics, form.setting
    c = np.zeros((len(a), h + 1), complex)
    c[:, 1] = -1j * a
    omega, torque = np.sqrt(1.0 + 0.75 * a**2), 2.0 * a * s.mu
    for _ in range(ROUNDS):
        r, (matrix, _) = form.residual(c, omega), form.slopes(c, omega)
        r[:, 1] += s.torque_lines[0] - torque
        speed = np.multiply.outer(omega, np.arange(h + 1.0))
        slope = (-2.0 * speed + 1j * s.mu) * np.arange(h + 1.0) * c
        # the first harmonic is given: its columns are those of the torque and of the speed
        matrix[:, :, 1], matrix[:, 1, 1] = 0.0, -1.0
        matrix[:, :, h + 1] = np.concatenate([slope.real, slope.imag[:, 1:]], axis=1)
        right = np.concatenate([r.real, r.imag[:, 1:]], axis=1)
        step = -np.linalg.solve(matrix, right[..., None])[..., 0]
        torque, omega = torque + step[:, 1], omega + step[:, h + 1]
        step[:, 1], step[:, h + 1] = 0.0, 0.0
        c[:, 0] += step[:, 0]
        c[:, 1:] += step[:, 1 : h + 1] + 1j * step[:, h + 1 :]
        size = np.max(np.abs(step), axis=1) / a
        if np.max(size) < NEAR:
            break
    good = (size < 1e-8) & (omega > 0.0)
    return np.where(good, omega, np.nan), np.where(good, torque, np.nan)


def _peak(flow: Any, torque: Floats, a: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """Amplitude [rad] and speed of a flow's own state with a lag of 90 degrees under a torque, from the true ones."""
    a, omega = a.copy(), omega.copy()
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            z: Any = -1j * a
            rate, by_z = rates_of(at(flow, omega, torque), z)
            up = rates_of(at(flow, omega + STEP, torque), z)[0]
            down = rates_of(at(flow, omega - STEP, torque), z)[0]
            by_a = -(by_z[:, 0, 1] + 1j * by_z[:, 1, 1])
            step = newton_step(real_matrix(by_a, (up - down) / (2.0 * STEP)), rate)
            share = np.minimum(1.0, 0.3 / np.maximum(np.abs(step.real) / a, np.abs(step.imag) / omega))
            a, omega = a + share * step.real, omega + share * step.imag
            size = np.abs(step.real) / a + np.abs(step.imag) / omega
            if not np.any(size > NEAR):
                break
    good = (size < 1e-8) & (a > 0.0) & (omega > 0.0)
    return np.where(good, a, np.nan), np.where(good, omega, np.nan)
