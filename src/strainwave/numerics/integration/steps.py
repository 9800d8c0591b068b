"""One step of each integration method, on tuple states; used by `integrate` and by the ensembles.

They take the phase at the start and its growth, which all lanes of an ensemble share in steps of fixed size, the state,
and the step in time.

Butcher tableaus: Dormand & Prince 5(4) with its dense output, and the 8th-order method of DOP853.
"""

import math
from typing import Any, NamedTuple

from ...base.protocols import System
from ...base.quantities import Reals, States
from ...base.results import Floats
from ...compile.jit import chosen, kernel, routine
from ...compile.tree import axpy, times

ORDER = 5  # power of h that the estimate of the error of Dormand & Prince 5(4) grows with

SAFETY, PAST_POWER, ERROR_POWER = 0.9, 0.2, 0.85  # of `growth`
LEAST_FACTOR, LARGEST_FACTOR, LOST_FACTOR = 0.2, 10.0, 0.1  # of a step by the next; and where the error is no number
LEAST_SQUARE = 1e-20  # of an error, whose logarithm is taken

DOP8_C = (
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
)

DOP8_A = (  # without the zeros between the first and the others of a row
    (),
    (0.05260015195876773,),
    (0.0197250569845379, 0.0591751709536137),
    (0.02958758547680685, 0.08876275643042054),
    (0.2413651341592667, -0.8845494793282861, 0.924834003261792),
    (0.037037037037037035, 0.17082860872947386, 0.12546768756682242),
    (0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125),
    (0.03709200011850479, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023),
    (
        0.6241109587160757,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ),
    (
        0.47766253643826434,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ),
    (
        -0.9371424300859873,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ),
    (
        2.273310147516538,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ),
)

DOP8_B = (
    0.054293734116568765,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
)


@kernel
def rk4_step(system: Any, phase: Any, turn: Any, y: Any, h: Any) -> Any:
    """Classical fourth-order Runge-Kutta step of h in time, `turn` in phase."""
    middle = phase + 0.5 * turn
    k1 = system.rhs(phase, y)
    k2 = system.rhs(middle, axpy(y, 0.5 * h, k1))
    k3 = system.rhs(middle, axpy(y, 0.5 * h, k2))
    k4 = system.rhs(phase + turn, axpy(y, h, k3))
    return axpy(axpy(axpy(axpy(y, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4)


@chosen
def combined(y: States, weights: States, k: Any) -> Any:
    """Return y plus the weighted sum of the first of the tuples k."""
    return _with_first if len(weights) else _alone


def _with_first(y: States, weights: States, k: Any) -> Any:
    return combined(axpy(y, weights[0], k[0]), weights[1:], k[1:])


def _alone(y: States, weights: Any, k: Any) -> Any:
    return y


@kernel
def dop8_step(system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
    """Eighth-order step with the twelve stages of DOP853 (zero weights left out); rates are multiplied by h once."""
    a, c = DOP8_A, DOP8_C
    k0 = times(h, system.rhs(phase, y))
    k1 = times(h, system.rhs(phase + turn * c[1], combined(y, a[1], (k0,))))
    k2 = times(h, system.rhs(phase + turn * c[2], combined(y, a[2], (k0, k1))))
    k3 = times(h, system.rhs(phase + turn * c[3], combined(y, a[3], (k0, k2))))
    k4 = times(h, system.rhs(phase + turn * c[4], combined(y, a[4], (k0, k2, k3))))
    k5 = times(h, system.rhs(phase + turn * c[5], combined(y, a[5], (k0, k3, k4))))
    k6 = times(h, system.rhs(phase + turn * c[6], combined(y, a[6], (k0, k3, k4, k5))))
    k7 = times(h, system.rhs(phase + turn * c[7], combined(y, a[7], (k0, k3, k4, k5, k6))))
    k8 = times(h, system.rhs(phase + turn * c[8], combined(y, a[8], (k0, k3, k4, k5, k6, k7))))
    k9 = times(h, system.rhs(phase + turn * c[9], combined(y, a[9], (k0, k3, k4, k5, k6, k7, k8))))
    k10 = times(h, system.rhs(phase + turn * c[10], combined(y, a[10], (k0, k3, k4, k5, k6, k7, k8, k9))))
    k11 = times(h, system.rhs(phase + turn, combined(y, a[11], (k0, k3, k4, k5, k6, k7, k8, k9, k10))))
    return combined(y, DOP8_B, (k0, k5, k6, k7, k8, k9, k10, k11))


class Classical(NamedTuple):
    """The classical Runge-Kutta step of fourth order."""

    def step(self, system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
        """State after a step of h in time, `turn` in phase."""
        return rk4_step(system, phase, turn, y, h)


class EighthOrder(NamedTuple):
    """The step of DOP853."""

    def step(self, system: System, phase: Reals, turn: Reals, y: States, h: Reals) -> Any:
        """State after a step of h in time, `turn` in phase."""
        return dop8_step(system, phase, turn, y, h)


@kernel
def dopri5_step(system: System, phase: Reals, turn: Reals, y: States, h: Reals, rate: Any) -> Any:
    """Dormand-Prince step from y with rate = rhs(y): the new state, its rate, the error, and the dense-output vector.

    Hairer, Norsett & Wanner I, table II.5.2 and eq. (II.6.17), with the rates multiplied by h once.
    """
    k1 = times(h, rate)
    k2 = times(h, system.rhs(phase + turn * (1 / 5), axpy(y, 1 / 5, k1)))
    k3 = times(h, system.rhs(phase + turn * (3 / 10), combined(y, (3 / 40, 9 / 40), (k1, k2))))
    k4 = times(h, system.rhs(phase + turn * (4 / 5), combined(y, (44 / 45, -56 / 15, 32 / 9), (k1, k2, k3))))
    y5 = combined(y, (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729), (k1, k2, k3, k4))
    k5 = times(h, system.rhs(phase + turn * (8 / 9), y5))
    y6 = combined(y, (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656), (k1, k2, k3, k4, k5))
    k6 = times(h, system.rhs(phase + turn, y6))
    y7 = combined(y, (35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84), (k1, k3, k4, k5, k6))
    new_rate = system.rhs(phase + turn, y7)
    k7 = times(h, new_rate)
    later, error = (k3, k4, k5, k6, k7), (-71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
    dense = (
        87487479700 / 32700410799, -10690763975 / 1880347072, 701980252875 / 199316789632, -1453857185 / 822651844,
        69997945 / 29380423,
    )  # fmt: skip
    return (
        y7, new_rate, combined(times(71 / 57600, k1), error, later),
        combined(times(-12715105075 / 11282082432, k1), dense, later),
    )  # fmt: skip


@kernel
def dense_weights(s: Reals, h: Reals) -> Any:
    """Weights for `weighted` that give the state at the fraction s of a step of h.

    It is of fourth order for the step of Dormand & Prince (Hairer, Norsett & Wanner I, eq. II.6.17).
    """
    r = 1.0 - s
    return r * r * (1.0 + 2.0 * s), h * s * r * r, s * s * (1.0 + 2.0 * r), -h * s * s * r, s * s * r * r


@kernel
def slope_weights(s: float, h: float) -> Any:
    """Derivatives of `dense_weights` by s."""
    r = 1.0 - s
    return -6.0 * s * r, h * r * (1.0 - 3.0 * s), 6.0 * s * r, h * s * (3.0 * s - 2.0), 2.0 * s * r * (r - s)


@kernel
def weighted(a: States, y: Any, k: Any, y_end: Any, k_end: Any, dense: Any) -> Any:
    """Weighted sum of state and rate at the begin of a step, those at its end, and the vector of the dense output."""
    return a[0] * y + a[1] * k + a[2] * y_end + a[3] * k_end + a[4] * dense


@routine
def error_square(n: int, error: Floats, y: Any, y_end: Floats, rtol: float, atol: float) -> float:
    """Mean square of n errors in units of the tolerance (Hairer, Norsett & Wanner I, eq. II.4.11).

    Where a step waits for it, the root costs 4 % of the step.
    """
    total = 0.0
    for i in range(n):
        scaled = error[i] / (atol + rtol * max(abs(y[i]), abs(y_end[i])))
        total += scaled * scaled
    return total / n


@kernel
def bounded(y: Any, bound: float) -> bool:
    """True if every state is below the bound (False for NaN)."""
    good = True
    for i in range(len(y)):
        good = good and abs(y[i]) < bound
    return good


@kernel
def growth(order: int, error: float, past: float) -> float:
    """Factor of the next step, from the logarithms of the error of this step and of the last, in tolerances.

    SAFETY (e_past^PAST_POWER/e^ERROR_POWER)^(1/order): PI control (Hairer & Wanner II, sec. IV.2).
    """
    factor = SAFETY * math.exp(PAST_POWER / order * past - ERROR_POWER * (1.0 / order) * error)
    return min(LARGEST_FACTOR, max(LEAST_FACTOR, factor))
