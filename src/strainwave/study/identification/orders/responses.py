"""Change of lines with the speed: a channel that is held or averaged over a time, a delay and a growth of each line.

At the speed w a line of order k is (a + b |w|/w_0) sinc(k w T/2 pi) exp(-i k w d): T is the time over which the channel
is held or averaged, whose mean delay of T/2 is part of d, and w_0 the largest speed.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....base.results import Complexes, Floats
from ..run import angle_before
from .order_fit import DELAY_S, SAME_SPEED, RunFit

HOLDS = np.linspace(0.0, 8e-3, 81)  # s, of a channel
MODEL_ERROR = 0.02  # of a line, that no such form is better than
NUMBER_PRICE = 6.0  # in squared deviations, of a number more
MISFIT_SHARE = 0.5  # of the misfit of one amplitude and delay, which a form must not leave
FEWEST_SPEEDS = 3  # speeds that tell a form
WINDOW_S = 0.05  # s, over which a speed counts


class Response(NamedTuple):
    """One line over the speed: complex amplitude at rest, what it gains up to w_0, delay [s]."""

    order: float
    constant: complex
    gain: complex
    delay: float


class Responses(NamedTuple):
    """Lines over the speed, w_0 [rad/s], and the time [s] over which the channel is held or averaged, 0 for none."""

    lines: tuple[Response, ...]
    fastest: float
    hold: float

    def value(self, time: Floats, angle: Floats) -> Floats:
        """Sum of the lines (n,) over times and angles."""
        speed = (angle_before(time, angle, -WINDOW_S) - angle_before(time, angle, WINDOW_S)) / (2.0 * WINDOW_S)
        total = np.zeros(len(time))
        for order, constant, gain, delay in self.lines:
            size = (constant + gain * np.abs(speed) / self.fastest) * sinc(order, speed, self.hold)
            total += (size * np.exp(1j * order * angle_before(time, angle, delay))).real
        return total


def sinc(order: float | Floats, speed: Floats, hold: float) -> Floats:
    """Transfer of a hold or a mean over a time."""
    return np.asarray(np.sinc(order * speed * hold / (2.0 * np.pi)))


def responses(orders: Floats, speeds: Floats, fits: Sequence[RunFit], delay: float) -> Responses | None:
    """The forms that the runs show; None where one amplitude and delay of all serve, or too few speeds tell."""
    fastest = float(np.max(np.abs(speeds)))
    distinct = np.sort(np.abs(speeds))
    if not len(orders) or 1 + np.sum(distinct[1:] > (1.0 + SAME_SPEED) * distinct[:-1]) < FEWEST_SPEEDS:
        return None
    forms = []
    for hold in HOLDS:
        total, plain, lines = (NUMBER_PRICE if hold else 0.0), 0.0, []
        for i, order in enumerate(orders):
            values = np.array([fit.values[i] for fit in fits]) * np.exp(-1j * order * speeds * delay)
            spread = np.array([0.5 * np.trace(fit.spreads[i]) for fit in fits])
            usual, score, line = _line(float(order), speeds, values, spread, delay, float(hold), fastest)
            total, plain = total + score, plain + usual
            lines.append(line)
        forms.append((total, plain, Responses(tuple(lines), fastest, float(hold))))
    total, _, best = min(forms, key=lambda one: one[0])
    return best if total < MISFIT_SHARE * forms[0][1] else None


def _line(
    order: float, speeds: Floats, values: Complexes, spread: Floats, delay: float, hold: float, fastest: float
) -> tuple[float, float, Response]:
    """Misfit of one line with one amplitude and the delay of all, the score of its best form, and that form."""
    weights = 1.0 / (spread + (MODEL_ERROR * np.median(np.abs(values))) ** 2)
    shapes = sinc(order, speeds, hold) * np.array([np.ones_like(speeds), np.abs(speeds) / fastest])
    step = 0.05 / (order * fastest)
    tried = np.append(delay, np.arange(-DELAY_S, DELAY_S, max(step, 1e-5)))
    turned = values * np.exp(1j * order * speeds * tried[:, None])  # (delays, runs)
    power, forms = float(np.sum(weights * np.abs(values) ** 2)), []
    for columns, price in (((0,), 0.0), ((1,), 0.0), ((0, 1), 2.0 * NUMBER_PRICE)):
        some = shapes[list(columns)]
        gram = (some * weights) @ some.T
        shares = np.linalg.solve(gram, (some * weights) @ turned.T)  # (columns, delays)
        left = power - np.sum(np.conj(shares) * (gram @ shares), axis=0).real
        for index, more in ((0, 0.0), (int(np.argmin(left)), NUMBER_PRICE)):
            parts = np.zeros(2, complex)
            parts[list(columns)] = shares[:, index]
            line = Response(order, complex(parts[0]), complex(parts[1]), float(tried[index]))
            forms.append((float(left[index]) + price + more, line))
    usual = forms[0]
    best = min(forms, key=lambda form: form[0])
    return usual[0], *(best if best[0] < MISFIT_SHARE * usual[0] else usual)
