"""The largest oscillation of many drives with one gear at once by averaging of first order, its error and its slopes.

The motion of the torsion is u = u0 + a cos(k omega t + phase); the gear's law stands for its equivalent stiffness K(a),
about the torsion u0(a) that carries the mean torque (Gelb & Vander Velde 1968, Multiple-Input Describing Functions,
sec. 6.1). Everything linear is exact: with s = i k omega, motor M(s) = J_m s^2 + C(s) of loop stiffness C(s), and
1/Z = 1/(J_l s^2) + 1/(N^2 M),

    (Z + B s + K(a)) u = -Z d,    pointing error of the load = -(K(a) + B s) u/(J_l s^2),

for each line e of the kinematic error, d = e (1 - i k T_0/(N M)) with the mean torque T_0, which the changing ratio
brings to the motor. An ideally held motor is the limit Z = J_l s^2, d = e. The largest amplitude over a
range of speeds is the largest root of a = h(K(a)), h(K) being the largest |Z d/(Z + B s + K)| over the range: it is a
root at the speed of that maximum, and no other speed has a larger one, because a > h(K(a)) beyond it.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats, SolveError
from ...drive.loops.linear_control import control_parts, control_response
from ...model.excitation import Harmonic, KinematicError
from ...model.oscillator import Oscillator
from ...numerics.balance.linear_part import one_harmonic
from ...theory.resonance import Resonance
from ...theory.slow_flow.flow import slow_flow
from .result import Sensitivity

FINEST, COARSEST, MOST_SPEEDS = 1e-3, 0.01, 1000  # relative distance of speeds, and most of them
AMPLITUDES, SMALLEST_SHARE = 96, 1e-3  # of the table of K(a); its first amplitude over the lines' largest
MOST_TWIST_RAD = 1.0  # rad: more is none, where a loop feeds a vibration
SLOPE_SAMPLES = 64  # samples of the slope over a vibration
PERIOD_SAMPLES, SUM_SPEEDS = 24, 16  # samples per period of the highest line, and speeds at which all lines are added
SENSITIVITY_STEP = 0.01  # relative change of a number, up and down
UNKNOWN = math.inf  # error of averaging where no certificate tells it


class Drives(NamedTuple):
    """Drives with one gear, under one mean torque and through one range of speeds; arrays have one entry a drive.

    Attributes
    ----------
    law : law
        Torsion law of the gear.
    N : float
        Its ratio.
    torque : float
        Mean torque [N*m].
    error : KinematicError
        Its kinematic error.
    speeds : (float, float)
        Range of the motor's speed [rad/s].
    J_m, J_l, B : (n,) arrays
        Inertias [kg*m^2] of motor, on its side, and load, and damping across the spring [N*m*s/rad].
    loop : control or None
        Loop of the motor; None where it is ideally held.
    gain : (n,) array or float
        Factor on the torque of the loop.
    """

    law: Any
    N: float
    torque: float
    error: KinematicError
    speeds: tuple[float, float]
    J_m: Floats
    J_l: Floats
    B: Floats
    loop: Any = None
    gain: Any = 1.0


class Largest(NamedTuple):
    """Largest oscillation of each drive (n,): its size [rad], the motor's speed [rad/s], and the motion there.

    `low` and `high` [rad] enclose the size: see `_bounds`. `order` is the line that drives it, `amplitude` [rad] that
    of the torsion, `mass` and `damping` those of one oscillator with the same impedance at k omega [kg*m^2, N*m*s/rad].
    """

    oscillation: Floats
    low: Floats
    high: Floats
    omega: Floats
    order: Any
    amplitude: Floats
    mass: Floats
    damping: Floats


class Springs(NamedTuple):
    """Stiffnesses [N*m/rad] of the law for vibrations with amplitudes [rad] about the mean torque.

    The equivalent one, the smallest and largest slope on the way, and the slope's harmonic at the vibration's
    frequency.
    """

    amplitude: Floats
    equivalent: Floats
    softest: Floats
    stiffest: Floats
    swing: Floats


def largest(drives: Drives) -> Largest:
    """Largest oscillation of the pointing error of every drive over its range of speeds."""
    lines = [line for line in drives.error.lines if line.amplitude > 0.0]
    springs = _springs(drives, max(line.amplitude for line in lines))
    by_line = Largest(*map(np.array, zip(*(_of_line(drives, springs, line) for line in lines), strict=True)))
    worst = np.argmax(by_line.oscillation, axis=0)[None]
    largest_line = Largest(*(np.take_along_axis(table, worst, 0)[0] for table in by_line))
    return largest_line._replace(low=np.max(by_line.low, axis=0), high=np.max(by_line.high, axis=0))


def impedance(drives: Drives, s: Any) -> Any:
    """Z [N*m/rad] of motor and load as the torsion meets them, at s = i omega (n, m) [1/s]."""
    load = drives.J_l[:, None] * s * s
    if drives.loop is None:
        return load
    motor = drives.N**2 * _motor(drives, s)
    return load * motor / (load + motor)


def _motor(drives: Drives, s: Any) -> Any:
    """M [N*m/rad] of a motor in its loop, whose torque over the deviation of the motor is added."""
    by_angle, of_motor = control_response(control_parts(drives.loop), np.ravel(np.imag(s))).T
    stiffness = np.reshape(by_angle + of_motor, np.shape(s))
    return drives.J_m[:, None] * s * s + np.reshape(drives.gain, (-1, 1)) * stiffness


def _deviation(drives: Drives, line: Any, s: Any) -> Any:
    """Amplitude d [rad] of a line, complex."""
    e = line.amplitude * np.exp(1j * line.phase)
    if drives.loop is None:
        return e
    return e * (1.0 - 1j * line.order * drives.torque / (drives.N * _motor(drives, s)))


def _springs(drives: Drives, line: float) -> Springs:
    """The law over amplitudes up to more than the damping allows."""
    low, high = drives.speeds
    s = 1j * np.geomspace(low, high * max(k.order for k in drives.error.lines), 64)
    Z = impedance(drives, s[None])
    bound = float(np.max(np.abs(Z) / np.maximum(Z.imag + np.outer(drives.B, s.imag), 1e-300))) * line
    sizes = np.geomspace(SMALLEST_SHARE * line, max(2.0 * line, min(1.2 * bound, MOST_TWIST_RAD)), AMPLITUDES)
    mean, equivalent = one_harmonic(drives.law, drives.torque, sizes)
    wave = np.cos(2.0 * np.pi * np.arange(SLOPE_SAMPLES) / SLOPE_SAMPLES)
    slopes = drives.law.stiffness(mean[:, None] + sizes[:, None] * wave) + 0.0 * wave
    swing = np.abs(2.0 * (slopes @ wave) / SLOPE_SAMPLES)
    return Springs(sizes, equivalent, slopes.min(axis=1), slopes.max(axis=1), swing)


def _frequencies(drives: Drives, order: int) -> Floats:
    """Frequencies of a line over the range, as dense as its resonances are sharp."""
    low, high = drives.speeds
    step = 0.25 * float(np.min(drives.B / np.sqrt(drives.J_l * drives.law.stiffness(0.0))))
    count = math.ceil(math.log(high / low) / min(max(step, FINEST), COARSEST)) + 2
    return order * np.geomspace(low, high, min(count, MOST_SPEEDS))


def _of_line(drives: Drives, springs: Springs, line: Any) -> Largest:
    """Largest oscillation that one line drives."""
    sizes, stiffness = springs.amplitude, springs.equivalent
    w = _frequencies(drives, line.order)
    s = 1j * w[None]
    Z = impedance(drives, s)
    square = np.abs(Z * _deviation(drives, line, s)) ** 2
    # (amplitude/u)^2 = alone + K (cross + K only): its least value over the speeds
    alone, cross, only = np.abs(Z + drives.B[:, None] * s) ** 2 / square, 2.0 * Z.real / square, 1.0 / square

    def top(K: Any) -> tuple[Floats, Floats]:
        """Largest amplitude [rad] over the range at stiffnesses (n,), and its frequency."""
        inverse = alone + K[:, None] * (cross + K[:, None] * only)
        return _parabola(np.log(w), inverse, np.argmin(inverse, axis=1))

    beyond = np.array([top(np.full(len(Z), K))[0] for K in stiffness]) - sizes[:, None]  # (amplitudes, n)
    above = beyond > 0.0
    last = len(sizes) - 1 - np.argmax(above[::-1], axis=0)  # the last amplitude that is still exceeded
    last = np.where(np.any(above, axis=0), np.minimum(last, len(sizes) - 2), 0)
    at_last, after_it = beyond[last, np.arange(len(Z))], beyond[last + 1, np.arange(len(Z))]
    share = np.clip(at_last / (at_last - after_it), 0.0, 1.0)

    def at_root(table: Floats) -> Floats:
        return np.asarray(table[last] + share * (table[last + 1] - table[last]))

    def motion(K: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Largest oscillation over the range with one stiffness, its speed, torsion and frequency."""
        amplitude, frequency = top(K)
        omega = np.column_stack([frequency / line.order, *(np.full(len(Z), v) for v in extra_speeds)])
        sizes = _oscillation(drives, omega, K)
        top_index = np.argmax(sizes, axis=1)
        rows = np.arange(len(Z))
        return sizes[rows, top_index], omega[rows, top_index], amplitude, frequency

    extra_speeds = np.geomspace(*drives.speeds, SUM_SPEEDS)
    size, omega, amplitude, frequency = motion(at_root(springs.equivalent))
    Z = impedance(drives, 1j * frequency[:, None])[:, 0]
    coupling = _coupling(drives, line, at_root(springs.swing), at_root(springs.equivalent), frequency, Z)
    others = [motion(at_root(table))[0] for table in (springs.softest, springs.stiffest)]
    low, high = _bounds(np.array([size, *others]), coupling)
    mass, damping = -Z.real / frequency**2, drives.B + Z.imag / frequency
    return Largest(size, low, high, omega, np.full(len(Z), line.order), amplitude, mass, damping)


def _bounds(sizes: Floats, coupling: Floats) -> tuple[Floats, Floats]:
    """Bounds [rad]: linear drives with the softest and the stiffest slope on the way, and the coupling of harmonics."""
    with np.errstate(divide="ignore"):
        more = np.where(coupling < 1.0, 1.0 / np.maximum(1.0 - coupling, 1e-300), np.inf)
    return np.min(sizes, axis=0) / more, np.max(sizes, axis=0) * more


def _coupling(drives: Drives, line: Any, swing: Floats, K: Floats, frequency: Floats, Z: Any) -> Floats:
    """Torque that a line of twice the order makes at a line's own frequency, over the torque of that line.

    The swing of the slope under the vibration turns the motion of 2 k omega into a torque at k omega: at the resonance
    that is parametric amplification (Nayfeh & Mook 1979, sec. 5.7), which a single harmonic does not know.
    """
    twice = sum(other.amplitude for other in drives.error.lines if other.order == 2 * line.order)
    s = 2j * frequency
    Z_twice = impedance(drives, s[:, None])[:, 0]
    motion = twice * np.abs(Z_twice / (Z_twice + drives.B * s + K))
    return np.asarray(0.5 * swing * motion / (np.abs(Z) * line.amplitude))


def _parabola(x: Floats, inverse: Floats, index: Any) -> tuple[Floats, Floats]:
    """1/sqrt of the least value by a parabola through the least sample and its neighbours, and exp(x) there."""
    inner = np.clip(index, 1, len(x) - 2)
    rows = np.arange(len(inverse))
    before, middle, after = inverse[rows, inner - 1], inverse[rows, inner], inverse[rows, inner + 1]
    bend, slope = before - 2.0 * middle + after, 0.5 * (after - before)
    shift = np.where((bend > 0.0) & (index == inner), -slope / np.where(bend > 0.0, bend, 1.0), 0.0)
    shift = np.clip(shift, -0.5, 0.5)
    least = np.where(index == inner, middle + shift * (slope + 0.5 * bend * shift), inverse[rows, index])
    log_x = np.where(index == inner, x[inner] + shift * (x[1] - x[0]), x[index])
    # samples of a parabola that dips below what damping allows have no minimum of their own
    least = np.where(least > 0.0, least, middle)
    return 1.0 / np.sqrt(least), np.exp(log_x)


def _oscillation(drives: Drives, omega: Floats, K: Floats) -> Floats:
    """Largest |error - mean| [rad] of the whole motion at motor speeds (n, m), the law having stiffnesses (n,)."""
    orders = [line.order for line in drives.error.lines]
    count = PERIOD_SAMPLES * max(orders)
    angle = 2.0 * np.pi * np.arange(count) / count
    total = np.zeros((*omega.shape, len(angle)))
    for line in drives.error.lines:
        s = 1j * line.order * omega
        Z, spring = impedance(drives, s), K[:, None] + drives.B[:, None] * s
        x = spring * Z * _deviation(drives, line, s) / ((Z + spring) * drives.J_l[:, None] * s * s)
        total += (x[..., None] * np.exp(1j * line.order * angle)).real
    size = np.abs(total)
    samples = np.argmax(size, axis=2)[..., None] + np.array([-1, 0, 1])  # the largest sample, and those beside it
    before, middle, after = np.moveaxis(np.take_along_axis(size, samples % len(angle), axis=2), 2, 0)
    bend = np.maximum(2.0 * middle - before - after, 1e-300)
    return np.asarray(middle + 0.125 * (after - before) ** 2 / bend)


def certified_error(drives: Drives, peaks: Largest, row: int) -> float:
    """Relative error of averaging by the certificate of the first-order slow flow, at one drive's largest oscillation.

    Near k omega the drive is one oscillator with its own mass and damping. The certificate is about the component at
    k omega and counts with its share of the oscillation, at most all. Of a motor in a loop the closed form also leaves
    out what the changing ratio does to the motor: N e' of its speed, which is added.
    """
    mass, order = float(peaks.mass[row]), int(peaks.order[row])
    slope = sum(line.order * line.amplitude for line in drives.error.lines)
    ripple = 0.0 if drives.loop is None else drives.N * slope
    if not mass > 0.0:
        return UNKNOWN
    damping, omega, torque = float(peaks.damping[row]), float(peaks.omega[row]), Harmonic(0.0, mean=drives.torque)
    oscillator = Oscillator(mass, damping, drives.law, torque, omega, drives.error)
    try:
        seen = slow_flow(oscillator, Resonance(order, 1)).certificate()
    except (SolveError, ValueError):
        return UNKNOWN
    share = min(1.0, float(peaks.amplitude[row] / peaks.oscillation[row]))
    size = max(seen.amplitude, seen.waveform) * share
    return size + ripple if math.isfinite(size) else UNKNOWN


def _with_stiffness(drives: Drives, by: float) -> Drives:
    law = drives.law
    return drives._replace(law=law._replace(**{k: by * getattr(law, k) for k in ("K1", "K2", "K3", "T1", "T2")}))


def _with_error(drives: Drives, by: float) -> Drives:
    lines = tuple(line._replace(amplitude=by * line.amplitude) for line in drives.error.lines)
    return drives._replace(error=drives.error._replace(lines=lines))


CHANGES: dict[str, Callable[[Drives, float], Drives]] = {
    "stiffness of the gear": _with_stiffness,
    "damping of the gear": lambda d, by: d._replace(B=by * d.B),
    "inertia of the load": lambda d, by: d._replace(J_l=by * d.J_l),
    "inertia of the motor": lambda d, by: d._replace(J_m=by * d.J_m),
    "kinematic error": _with_error,
    "mean torque": lambda d, by: d._replace(torque=by * d.torque),
}


def sensitivities(designs: list[tuple[str, float, Drives]]) -> Iterator[Sensitivity]:
    """Slopes of designs: name of the gear, inertia of the motor, and the drive; damping and loop stay as they are."""
    for gear, motor, drives in designs:
        base = float(largest(drives).oscillation[0])
        for name, changed in CHANGES.items():
            up = float(largest(changed(drives, 1.0 + SENSITIVITY_STEP)).oscillation[0])
            down = float(largest(changed(drives, 1.0 - SENSITIVITY_STEP)).oscillation[0])
            yield Sensitivity(gear, motor, name, (up - down) / (2.0 * SENSITIVITY_STEP * base))
