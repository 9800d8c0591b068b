"""The closed forms' prediction beside that of harmonic balance: a predictor of each resonance, at every motion."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...model.oscillator import Oscillator
from ...results import Floats, SolveError
from ...theory.slow_flow.multiple_scales import slow_flow
from ...theory.slow_flow.predictor.predictor import BEYOND, OK, motion, state_of, swing
from ...theory.slow_flow.resonance import Resonance
from ...units import RPM
from ..response.resonances import active_orders, operating_point

Complexes = NDArray[np.complex128]
WIDER = 1e-3  # of the speed: a predictor's range beyond the motions that it is compared with
PER_LINE = 8  # angles on a period of the highest order


class Motions(NamedTuple):
    """Motions of a response curve in arc order.

    Speeds (n,) [rad/s] of the base angle, orders (orders,) of it, amplitudes A e^(i phi) (orders, n) [rad], and whether
    each motion is stable (n,).
    """

    omega: Floats
    orders: NDArray[np.int64]
    amplitudes: Complexes
    stable: NDArray[np.bool_]

    def others(self, i: int) -> Complexes:
        """Amplitudes (orders, m) where the curve passes the speed of motion i elsewhere, straight between motions."""
        off = self.omega - self.omega[i]
        parts = np.flatnonzero(off[:-1] * off[1:] <= 0.0)
        parts = parts[(parts != i) & (parts != i - 1)]
        share = off[parts] / (off[parts] - off[parts + 1] + 1e-300)
        return np.asarray((1.0 - share) * self.amplitudes[:, parts] + share * self.amplitudes[:, parts + 1])


class ClosedForm(NamedTuple):
    """Complex amplitudes (orders, n) [rad] of the closed forms, where they are valid (n,), and sentences."""

    amplitudes: Complexes
    valid: NDArray[np.bool_]
    remarks: tuple[str, ...]


def closed_form(system: Any, motions: Motions) -> ClosedForm:
    """Steady motions of the second-order predictors of an error equation, at the motions of a response curve.

    At every speed the predictor is that of the order whose resonance is nearest. A steady state of it with the
    stability of the motion is taken for it where no other motion of the curve at that speed is nearer; NaN where there
    is none.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is not used.
    motions : Motions
        The curve.
    """
    shape = motions.amplitudes.shape
    found = ClosedForm(np.full(shape, np.nan + 0.0j), np.zeros(shape[1], bool), ())
    if not isinstance(system, Oscillator):
        said = "There is no closed form, as the damping or the stiffness varies with the angle."
        return found._replace(remarks=(said,))
    try:
        natural, lines = operating_point(system).omega_0, np.array(active_orders(system))
    except (ValueError, SolveError) as error:
        return found._replace(remarks=(f"There is no closed form: {error}.",))
    if not len(lines) or not natural:
        return found._replace(remarks=("There is no closed form without an excitation and a stiffness at rest.",))
    nearest = lines[np.argmin(np.abs(np.log(np.outer(motions.omega, lines) / natural)), axis=1)]
    remarks = []
    for k in np.unique(nearest).tolist():
        at = np.flatnonzero(nearest == k)
        try:
            remarks += _about(system._replace(omega=natural / k), k, at, motions, found)
        except (ValueError, SolveError) as error:
            low, high = (f(motions.omega[at]) / RPM for f in (np.min, np.max))
            remarks.append(
                f"There is no closed form about order {k}'s resonance, {low:.4g} to {high:.4g} rpm: {error}."
            )
    return found._replace(remarks=tuple(remarks))


def _about(system: Any, k: int, at: Any, motions: Motions, found: ClosedForm) -> list[str]:
    """Write the motions `at` about the resonance of order k to `found`; return what is to be said."""
    omega = motions.omega[at]
    flow = slow_flow(system, Resonance(k, 1), order=2)
    predictor = flow.predictor(speeds=((1.0 - WIDER) * float(np.min(omega)), (1.0 + WIDER) * float(np.max(omega))))
    states, flags = flow.states_at(np.unique(omega)), np.full(len(omega), -1)
    for n, i in enumerate(at.tolist()):
        w, others = float(omega[n]), motions.others(i)
        for j in np.flatnonzero((states.omega == w) & (states.stable == motions.stable[i])).tolist():
            z = states.amplitude[j] * np.exp(-1j * states.phase[j])
            rows, flag = _steady(predictor, w, complex(z), motions.orders)
            off = float(np.linalg.norm(rows - motions.amplitudes[:, i]))
            if off <= np.min(np.linalg.norm(rows[:, None] - others, axis=0), initial=np.inf):
                found.amplitudes[:, i], flags[n] = rows, flag
    found.valid[at] = flags == OK
    several = f"of the {len(omega)} motions about order {k}'s resonance"
    said = [
        f"At {np.sum(flags == flag)} {several} the closed form is not valid: {predictor.meaning(flag)}."
        for flag in np.unique(flags[flags > OK]).tolist()
    ]
    if np.any(flags < OK):
        said.append(f"At {np.sum(flags < OK)} {several} the closed form has no such motion.")
    return said


def _steady(predictor: Any, omega: float, z: complex, orders: NDArray[np.int64]) -> tuple[Complexes, int]:
    """Amplitudes (orders,) [rad] of the motion that a predictor makes of a steady state z [rad], and its flag."""
    count = PER_LINE * max(int(np.max(orders)), predictor.p)
    angle = 2.0 * np.pi * np.arange(count) / count
    rate, small = predictor.force.rate(predictor.drive, omega, 1.0, z)
    states = [state_of(z, (rate, rate, rate), theta, 0.0, omega, 1.0) for theta in angle.tolist()]
    x = np.array([motion(predictor, state, small)[0] for state in states])
    flag = OK if swing(predictor, z, omega, 1.0) <= predictor.reach else BEYOND
    return 2.0 / count * np.exp(-1j * np.outer(orders, angle)) @ x, flag
