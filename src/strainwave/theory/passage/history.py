"""The history of a passage put together: the whole motion's envelope, and what follows at the last speed."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...results import Floats
from ..slow_flow.fixed_points import Flow, polish
from ..slow_flow.response import PER_CYCLE
from ..slow_flow.setting import Complexes
from .destinations import destinations
from .march import March, march
from .results import DelayedJump
from .ride import Way

SETTLED = 0.02  # of the steady amplitude
TRACKED = 200  # speeds at which the last steady state is followed back
HELD = 201  # samples at the last speed
LONGER = 1.5  # than a linear drive would need


def envelope(flow: Flow, omega: Floats, z: Complexes) -> Floats:
    """Largest |x| [rad] over the base angle of slow states z [rad] at speeds omega [rad/s], both (n,)."""
    moved = flow.at(omega)
    s = moved.setting
    ratio = s.resonance.ratio
    p, q = (1, 1) if ratio is None else (ratio.numerator, ratio.denominator)
    samples = PER_CYCLE * q * max(math.ceil(p / q), *s.orders, 1)
    theta = 2.0 * np.pi * q * np.arange(samples) / samples
    parts = [(p / q, z), *((float(np.ravel(w)[0] / omega[0]), c) for w, c in moved.small(z))]
    parts += [(float(k), s.hard[:, i]) for i, k in enumerate(s.orders)]
    amplitudes = np.stack([np.broadcast_to(c, z.shape) for _, c in parts], axis=1)
    waves = np.exp(1j * np.outer([k for k, _ in parts], theta))
    x = (amplitudes @ waves).real + s.u0 + s.system.error.value(theta)
    return np.asarray(np.max(np.abs(x), axis=1))


@dataclass(frozen=True, eq=False)
class After:
    """What follows at the last speed.

    Attributes
    ----------
    t, z : (n,) arrays
        Times [s] after the end of the ramp, and slow states [rad].
    settling : float or None
        Settling time [s]; see `Passage`.
    """

    t: Floats
    z: Complexes
    settling: float | None


def settled(way: Way, rates: Floats, found: March, jumps: list[tuple[DelayedJump, ...]]) -> list[After]:
    """Hold the last speed until the motion settles, and find when it did."""
    end = found.z[:, -1]
    held = way.quick.at(way.last)
    states, label = destinations(held, end)
    steady = np.array([states[i] if i >= 0 else complex(np.nan) for i in label])
    off = np.abs(end - steady) / np.maximum(SETTLED * np.abs(steady), 1e-6 * way.size)
    time = LONGER * 2.0 * np.log(np.maximum(np.nan_to_num(off, nan=1.0), 1.0) * 2.0) / way.flow.setting.mu
    hold = march(lambda _t, z, _lanes: np.asarray(held.rates(z)), end, time, HELD, way.size)
    tracks: dict[int, tuple[Floats, Complexes]] = {}
    answers = []
    for i, place in enumerate(label.tolist()):
        t, z = found.t[i], found.z[i]
        if place < 0:
            answers.append(After(hold.t[i, 1:], hold.z[i, 1:], None))
            continue
        if place not in tracks:
            tracks[place] = _track(way, states[place])
        speeds, known = tracks[place]
        omega = way.first + way.ahead * rates[i] * t
        follow = np.interp(way.ahead * omega, way.ahead * speeds, known.real, left=np.nan)
        follow = follow + 1j * np.interp(way.ahead * omega, way.ahead * speeds, known.imag, left=np.nan)
        target = np.append(follow, np.full(HELD - 1, states[place]))
        whole_t, whole_z = np.append(t, t[-1] + hold.t[i, 1:]), np.append(z, hold.z[i, 1:])
        event = float(found.at_largest[i])
        if jumps[i]:
            event = abs(jumps[i][-1].omega - way.first) / float(rates[i])
        near = np.abs(whole_z - target) <= np.maximum(SETTLED * np.abs(target), 1e-6 * way.size)
        away = np.flatnonzero(~near)
        last = int(away[-1]) + 1 if len(away) else 0
        settling = None if last >= len(whole_t) else max(0.0, float(whole_t[last]) - event)
        answers.append(After(hold.t[i, 1:], hold.z[i, 1:], settling))
    return answers


def _track(way: Way, state: complex) -> tuple[Floats, Complexes]:
    """The last steady state [rad] followed back to the speeds where it begins: speeds in the order of the way."""
    speeds, states = [way.last], [state]
    for omega in np.linspace(way.last, way.first, TRACKED + 1)[1:]:
        flow: Any = way.quick.at(float(omega))
        z = 0j if state == 0.0 else polish(flow, states[-1])
        if z is None or abs(z - states[-1]) > 0.5 * abs(states[-1]):
            break
        speeds.append(float(omega))
        states.append(z)
    return np.array(speeds[::-1]), np.array(states[::-1])
