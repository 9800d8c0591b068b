"""Build of a predictor of a slow flow: its force, its points and steps, and the torsion up to which it is valid."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ....base.law import breakpoints_of
from ....base.quantities import States, floated, interval, number
from .. import response as response_curve
from ..averaging import AveragedFlow
from ..certificate import certify
from ..closed_forms import CubicFlow
from ..fixed_points import Flow, is_trivial
from ..second_order import Forms, SecondOrderFlow
from ..second_order_forms import FORMS
from ..setting import Setting
from .formulas import FirstOrderCubic, SecondOrderFormula
from .linear_drive import ForcedLine, LinearDrive
from .predictor import Predictor
from .samples import SLOTS, FirstOrderSamples, SecondOrderSamples

PER_PERIOD = 32  # samples per period of the fastest component, where the caller names no sample
TURN, MOST_STEPS = 0.05, 8  # of the slow state in one step [rad], and steps in a sample
SPEEDS = 9  # at which forced motions are certified
FEWEST, MOST_POINTS, KINKED = 16, {1: 64, 2: 24}, 48  # sample points along the motion, by the order; with kinks
ACCURATE, ACCEPTED = 1e-10, 0.01  # relative error of the rates by samples: where to stop, and what is refused
CERTIFIED = 24  # steady states, evenly among all by the size of their torsion
OVERSHOOT = 2.0  # the excitation at which validity is sought, over the largest of the range
Probes = list[tuple[float, complex]]


def build_predictor(flow: Flow, order: int, sample: Any, speeds: Any, amplitudes: States) -> Predictor:
    """Build the predictor of a slow flow; see `SlowFlow.predictor`."""
    s = flow.setting
    if not s.mu > 0.0:
        raise ValueError(
            f"mu = {s.mu:.6g} 1/s; a predictor needs damping, as without it every error of the start stays: give B"
        )
    low, high = interval(
        "the range of speeds [rad/s]", (0.5 * s.omega, 1.5 * s.omega) if speeds is None else speeds, positive=True
    )
    least, largest = _amplitudes(amplitudes)
    fastest = max(s.fast / s.omega * high if s.resonance.ratio else s.fast, high * max(s.orders, default=1))
    time = 2.0 * math.pi / (PER_PERIOD * fastest) if sample is None else number("sample [s]", sample, positive=True)
    at_most = scaled(flow, largest)
    drive = _linear_drive(s)
    p, q = s.resonance if s.resonance.ratio else (0, 1)
    reach = _reach(scaled(flow, OVERSHOOT * largest, OVERSHOOT), order, (low, high))
    force = _force(at_most, drive, order, _probes((low, high), min(reach, 10.0 * drive.size)), largest)
    one_step = Predictor(time, 1, (low, high), (least, largest), reach, _mean(s), p, q, drive, force)
    return Predictor(*floated(one_step._replace(steps=_steps(at_most, one_step))))


def _amplitudes(amplitudes: States) -> tuple[float, float]:
    """The range of the factor on the torque lines."""
    least, largest = interval("amplitudes", amplitudes)
    if least < 0.0:
        raise ValueError(f"amplitudes are ({least:.6g}, {largest:.6g}); they must be (lowest, highest) from 0 up")
    return least, largest


def scaled(flow: Flow, torque: float, error: float = 1.0) -> Flow:
    """The same flow with its lines of torque and of kinematic error times factors."""
    s = flow.setting
    moved = replace(s, torque_lines=s.torque_lines * torque, error_lines=s.error_lines * error).at(s.omega)
    if isinstance(flow, AveragedFlow):
        return AveragedFlow(moved, flow.means.at(moved), flow.error)
    return replace(flow, setting=moved)


def _linear_drive(s: Setting) -> LinearDrive:
    """The linear drive, with at least one line."""
    lines = tuple(
        ForcedLine(k, harmonic, float(soft), t.real / s.system.J, t.imag / s.system.J, e.real, e.imag)
        for k, harmonic, soft, t, e in zip(s.orders, s.places, s.on_fast, s.torque_lines, s.error_lines, strict=True)
    )
    ratio = 0.0 if s.resonance.ratio is None else float(s.resonance.ratio)
    return LinearDrive(s.u0, s.omega_0, s.mu, ratio, max(s.scales()), lines or (ForcedLine(1, 1, 0.0, *4 * (0.0,)),))


def _mean(s: Setting) -> float:
    """Mean of x [rad] at first order: the torsion under the mean torque, and the mean of the kinematic error."""
    n = 8 * max(s.orders, default=1) + 64
    return s.u0 + float(np.mean(s.system.error.value(2.0 * np.pi * np.arange(n) / n)))


def _force(flow: Flow, drive: LinearDrive, order: int, probes: Probes, amplitude: float) -> Any:
    """Force on the slow flow: by formula where there is one, else by samples."""
    s = flow.setting
    ratio = None if s.resonance.ratio is None or not s.orders else s.resonance.ratio / s.orders[0]
    if isinstance(flow, CubicFlow):
        return FirstOrderCubic(flow.kappa, float(flow.kind == "superharmonic"), float(flow.kind == "subharmonic"))
    if isinstance(flow, SecondOrderFlow) and isinstance(flow.force, Forms):
        share = 0.0 if ratio is None else float(s.resonance.ratio or 0) / ratio.numerator
        return SecondOrderFormula(flow.force.square, flow.force.cube, share, FORMS[ratio])
    if s.resonance.ratio is None:
        raise ValueError(
            "without resonance a predictor is there for a cubic polynomial under one line (at first order without "
            "square and mean torque); give a resonance, or integrate"
        )
    return _sampled(flow, drive, order, probes, amplitude)


def _sampled(flow: Flow, drive: LinearDrive, order: int, probes: Probes, amplitude: float) -> Any:
    """As few sample points as give the rates of the flow."""
    s = flow.setting
    best, error, points = None, math.inf, FEWEST * s.top
    most_points = s.top * (max(KINKED, MOST_POINTS[order]) if breakpoints_of(s.system.law) else MOST_POINTS[order])
    while True:
        angle, share = 2.0 * math.pi / points, s.base / s.resonance.q
        common = (floated(s.system.law), s.system.J, points, math.cos(angle), math.sin(angle), s.fast_place, share)
        force = FirstOrderSamples(*common) if order == 1 else SecondOrderSamples(*common, *_slots(flow, probes))
        off = _worst(flow, drive, force, probes, amplitude)
        if off < 0.8 * error:
            best, error = force, off
        if error <= ACCURATE or points == most_points:
            break
        points = min(2 * points, most_points)
    if best is None or not error <= ACCEPTED:
        raise ValueError(
            f"{most_points} samples of the law give the rates to {100.0 * error:.2g} % only; use the other order, or "
            "integrate"
        )
    return best


def _probes(speeds: tuple[float, float], largest: float) -> Probes:
    """Speeds and states at which the rates by samples are compared with those of the flow."""
    turns = np.exp(1j * np.array([0.3, 1.7, 4.1]))
    sizes = largest * np.array([0.1, 0.3, 1.0])
    return [(float(omega), complex(a * turn)) for omega in np.linspace(*speeds, 3) for a in sizes for turn in turns]


def _worst(flow: Flow, drive: LinearDrive, force: Any, probes: Probes, amplitude: float) -> float:
    """Largest error of the rates relative to the linear part of the slow flow."""
    worst = 0.0
    for omega, z in probes:
        local = flow.at(omega)
        if local.setting.sits_on(omega):
            continue
        s = local.setting
        rate, size = complex(local.rates(z)), (s.mu + abs(s.fast - s.omega_0)) * abs(z)
        worst = max(worst, abs(force.rate(drive, omega, amplitude, z)[0] - rate) / (size + abs(rate)))
    return worst


def _slots(flow: Flow, probes: Probes) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Numbers and weights of the small harmonics that are largest at the probes."""
    s = flow.setting
    base = s.base / s.resonance.q
    sizes: dict[int, float] = {}
    for omega, z in probes:
        for speed, small in flow.at(omega).small(z):
            number = round(float(speed) / (base * omega))
            sizes[number] = max(sizes.get(number, 0.0), abs(complex(small)) / abs(z))
    chosen = sorted(sorted(sizes, key=lambda number: -sizes[number])[:SLOTS])
    numbers = tuple(chosen + [0] * (SLOTS - len(chosen)))
    weights = tuple([0.5 if n == 0 else 1.0 for n in chosen] + [0.0] * (SLOTS - len(chosen)))
    return numbers, weights


def _reach(flow: Flow, order: int, speeds: tuple[float, float]) -> float:
    """Torsion [rad] about its mean up to which the certificate holds the steady states under an excitation valid."""
    curves = response_curve.response(flow, *speeds)
    states = []
    for branch in curves.branches:
        z = branch.amplitude * np.exp(-1j * branch.phase)
        states += list(zip(branch.omega.tolist(), z.tolist(), strict=True))
    for omega in np.linspace(*speeds, SPEEDS).tolist():
        local = flow.at(omega)
        if not local.setting.sits_on(omega) and (local.setting.resonance.ratio is None or is_trivial(local)):
            states.append((omega, 0j))
    ranked = sorted((abs(z) + float(np.sum(np.abs(flow.at(omega).setting.hard))), omega, z) for omega, z in states)
    if not ranked or ranked[-1][0] == 0.0:
        return math.inf

    certified = [ranked[i] for i in sorted(set(np.linspace(0, len(ranked) - 1, CERTIFIED).astype(int).tolist()))]
    verdicts = [certify(flow.at(omega), z, order, curve=True) for _, omega, z in certified]
    valid = [size for (size, _, _), verdict in zip(certified, verdicts, strict=True) if verdict.valid]
    if not valid:
        raise ValueError(f"no steady state of this range is valid: {verdicts[0].sentence}")
    return float(max(valid))


def _steps(flow: Flow, predictor: Predictor) -> int:
    """Steps in which the slow state turns little."""
    fastest = 0.0
    for omega in np.linspace(*predictor.speeds, 3):
        local = flow.at(float(omega))
        largest = min(predictor.reach, 10.0 * max(local.setting.scales()))
        for a in (1e-6 * largest, largest):
            fastest = max(fastest, float(np.linalg.norm(local.jacobian(complex(a)), 2)))
    steps = math.ceil(fastest * predictor.sample / TURN)
    if steps > MOST_STEPS:
        raise ValueError(
            f"a sample of {predictor.sample:.6g} s is too long: the slow state turns by "
            f"{fastest * predictor.sample:.3g} rad in it; give at most {MOST_STEPS * TURN / fastest:.3g} s, or a "
            "narrower range of speeds"
        )
    return max(1, steps)
