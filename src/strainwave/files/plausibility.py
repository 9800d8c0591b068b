"""Numbers of a project that are legal and most likely wrong: a unit, a shaft or a factor taken for another.

Thresholds are a factor away from what gears have, so that no sound drive meets one. What gears have, over the 183
records of the catalogue (Harmonic Drive LLC, CSF/CSG catalogue; harmonicdrive.de; Schaeffler RT1): K1 from 340 N*m/rad
(CSF-8-30) to 1.45e6 N*m/rad (HFUC-90-80), a twist at the rated torque from 0.50 mrad (HFUC-90-50) to 2.4 mrad
(HFUS-25-30), a transmission accuracy of at most 2 arcmin peak-to-peak (CSF/CSG catalogue, p. 49), a ratcheting torque
of 4.8 to 16 times the rated torque (p. 14), an input speed of at most 8500 rpm. A damping ratio of 0.01 to 0.05 is
usual in torsional trains (Wang, Feese & Pettinato, Turbomachinery Symposium 2012).
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..base.law import spring_stiffness
from ..base.units import RPM, convert
from ..drive.project import Project
from ..model.gears.limits import RATCHETING
from ..model.train.controls import CascadeLoop, SpeedLoop, core_of
from ..model.train.filters import NotchFilter, apart

FACTOR = 10.0  # times beyond what gears have
STIFFNESS = 340.0, 1.45e6  # N*m/rad, at rest
TWIST = 0.5e-3, 2.4e-3  # rad, at the rated torque
NATURAL_HZ = 1.0, 2000.0  # of drives
ERROR_RAD = 10.0 * math.pi / 10800.0  # 10 arcmin, 0-to-peak: ten times the largest of the catalogue
DAMPING_RATIO = 0.2
WRONG_SHAFT = 3.0  # times N: halfway from a matched inertia, 0.1 to 10, to one of the other shaft, off by N^2
INPUT_RPM = 8500.0, 4000.0  # rpm of the input: of any gear, and the middle of the catalogue
FREQUENCY_FACTOR = 10.0  # times an excitation's frequency
CROSSOVER_HZ = 1.0, 1000.0  # of a speed loop
USUAL_TIME = 4.0  # T_n and 1/K_v times the crossover, by the symmetric optimum
SLOWEST_TIME = 100.0  # times that: slow loops are sound


def drive_doubts(project: Project) -> Iterator[str]:
    """Stiffness, inertias, torque, natural frequency and speeds that no drive has."""
    if project.speeds.by_motor:
        yield from _stiffness(project)
        yield from _inertia(project)
        yield from _torque(project)
    yield from _natural_frequency(project)


def error_doubts(project: Project) -> Iterator[str]:
    """A kinematic error of degrees, and a damping ratio that no gear has."""
    lines = () if project.kinematic_error is None else project.kinematic_error.lines
    size = sum(abs(line.amplitude) for line in lines)
    if size > ERROR_RAD:
        yield (
            f"The amplitudes of the kinematic error sum to {convert(size, 'rad', 'arcmin'):.4g} arcmin; gears have at "
            "most 1 arcmin. Check the unit; amplitudes are angles of the output."
        )
    yield from filter(None, [damping_doubt(project.damping_ratio or 0.0)])


def damping_doubt(ratio: float) -> str:
    """Sentence on a damping ratio that no gear has; empty for a usual one."""
    usual = "0.01 to 0.05 is usual. Write 4 % as '4 %' or 0.04."
    return (
        f"The damping ratio is {ratio:.3g} ({100.0 * ratio:.3g} % of critical); {usual}"
        if ratio > DAMPING_RATIO
        else ""
    )


def loop_doubts(project: Project, by_bandwidth: bool) -> Iterator[str]:
    """Gains of a speed loop in another unit: by the frequency at which it crosses over, and by times beside it."""
    core: Any = None if project.whole is None else core_of(project.whole.motor.control)
    if not isinstance(core, CascadeLoop | SpeedLoop) or not core.K_p > 0.0:
        return
    crossover = core.K_p / project.loop_inertia
    yield from _notches(project, crossover)
    hertz = crossover / (2.0 * math.pi)
    if not CROSSOVER_HZ[0] / FACTOR <= hertz <= CROSSOVER_HZ[1] * FACTOR:
        gain = "of motor.loop.bandwidth" if by_bandwidth else f"and the shaft of motor.loop.K_p, {core.K_p:g} N*m*s/rad"
        yield (
            f"The gain crossover of the speed loop is at {hertz:.3g} Hz; {CROSSOVER_HZ[0]:g} to {CROSSOVER_HZ[1]:g} Hz "
            f"is usual. Check the unit {gain}."
        )
    elif isinstance(core, CascadeLoop) and not by_bandwidth:
        yield from _beside("T_n", f"{1e3 * core.T_n:g} ms", core.T_n * crossover)
        yield from _beside("K_v", f"{core.K_v:g} 1/s", crossover / core.K_v)
    elif isinstance(core, SpeedLoop) and core.K_i > 0.0 and not by_bandwidth:
        yield from _beside("K_i", f"{core.K_i:g} N*m/rad", core.K_p / core.K_i * crossover)


def _notches(project: Project, crossover: float) -> Iterator[str]:
    """Notches whose band holds the crossover [rad/s] of the speed loop, by |K_p F(j w)/(J w)| = 1 on a rigid gear."""
    train: Any = project.whole
    for filter_ in apart(train.motor.control)[1].get("filters", ()):
        if not isinstance(filter_, NotchFilter) or abs(filter_.frequency - crossover) > 0.5 * filter_.width:
            continue
        w, a, b, _ = filter_.shape()
        s, c = w * w, crossover**2
        cubic = [1.0, a * a - 2.0 * s - c, s * s + c * (2.0 * s - b * b), -c * s * s]
        after = math.sqrt(min(root.real for root in np.roots(cubic) if abs(root.imag) <= 1e-9 * abs(root)))
        lost = math.degrees(math.atan2(a * after, w * w - after**2) - math.atan2(b * after, w * w - after**2))
        before, now, hertz = [x / (2.0 * math.pi) for x in (crossover, after, filter_.frequency)]
        yield (
            f"The gain crossover of the speed loop lies in the band of the {hertz:.3g} Hz notch: the crossover falls "
            f"from {before:.3g} to {now:.3g} Hz, with a phase loss of {lost:.3g} degrees. Make the notch narrower, or "
            "place it on a resonance at a higher frequency."
        )


def _beside(name: str, text: str, turns: float) -> Iterator[str]:
    """A gain whose time, in units of that of the speed loop, is far from the usual one."""
    share = turns / USUAL_TIME
    if not 1.0 / FACTOR <= share <= SLOWEST_TIME:
        slower = f"{share:.3g} times slower" if share > 1.0 else f"{1.0 / share:.3g} times faster"
        yield f"motor.loop.{name} is {text}, {slower} than usual for this K_p; check the unit."


def _stiffness(project: Project) -> Iterator[str]:
    """A stiffness that no gear has: by the twist at the rated torque, or else by its size."""
    stiffness, rated = float(spring_stiffness(project.drive.law, 0.0)), project.rated_torque
    if not stiffness > 0.0:
        return
    if rated is not None and not TWIST[0] / FACTOR <= rated / stiffness <= TWIST[1] * FACTOR:
        twist = convert(rated / stiffness, "rad", "arcmin")
        yield (
            f"The gear twists by {twist:.3g} arcmin under its rated torque of {rated:g} N*m; catalogue gears twist by "
            f"1.7 to 8.3 arcmin. Check the units of the stiffness at zero torque, {stiffness:.4g} N*m/rad, and of the "
            "torque."
        )
    elif rated is None and not STIFFNESS[0] / FACTOR <= stiffness <= STIFFNESS[1] * FACTOR:
        yield (
            f"The stiffness of the gear at zero torque is {stiffness:.4g} N*m/rad; catalogue gears have "
            f"{STIFFNESS[0]:g} to {STIFFNESS[1]:.3g} N*m/rad. Check the unit."
        )


def _inertia(project: Project) -> Iterator[str]:
    """Inertias that fit better when one belongs to the other shaft."""
    drive = project.drive
    ratio, bound = drive.J_l / (drive.N * drive.N * drive.J_m), WRONG_SHAFT * drive.N
    if ratio > bound or ratio < 1.0 / bound:
        large, small = ("load", "motor") if ratio > bound else ("motor", "load")
        yield (
            f"The load inertia is {ratio:.3g} times the motor inertia at the output, {drive.N:g}^2 J_m; 0.1 to 10 is "
            "usual. Write load.inertia for the output shaft and motor.inertia for the motor shaft: "
            f"{large}.inertia may be too large by {drive.N:g}^2, or {small}.inertia too small."
        )


def _torque(project: Project) -> Iterator[str]:
    """A torque of the load at which the teeth skip, where nothing computed is a result."""
    largest = max(map(abs, project.load_torques))
    gear, rated = project.gear, project.rated_torque
    limit = None if gear is None else gear.ratcheting_torque
    skip = "the teeth skip, and no computed value is valid; check the torque and its unit"
    reaches = f"The load torque reaches {largest:g} N*m"
    if limit is not None and largest > limit:
        yield f"{reaches}, above the ratcheting torque of {limit:g} N*m: {skip}."
    elif limit is None and rated is not None and largest > RATCHETING * rated:
        times = f"{largest / rated:.3g} times the rated torque; gears ratchet at 5 to 16 times"
        yield f"{reaches}, {times}: {skip}."


def _natural_frequency(project: Project) -> Iterator[str]:
    """A natural frequency that no drive has, or that nothing in the speed range comes near."""
    omega_0 = project.omega_0
    if not omega_0:
        return
    hertz = omega_0 / (2.0 * math.pi)
    if NATURAL_HZ[0] <= hertz <= NATURAL_HZ[1]:
        yield from _speeds(project, omega_0)
    else:
        usual = f"{NATURAL_HZ[0]:g} Hz to 2 kHz is usual. Check the units of stiffness and inertia."
        yield f"The natural frequency is {hertz:.3g} Hz; {usual}"


def _speeds(project: Project, omega_0: float) -> Iterator[str]:
    """Speeds of the wrong shaft, or else far from every resonance."""
    lines: Sequence[Any] = () if project.kinematic_error is None else project.kinematic_error.lines
    terms = [term for torque in (project.motor_torque, project.load_torque) if torque for term in torque.terms]
    speeds, orders = project.speeds, sorted({one.order for one in (*lines, *terms) if one.amplitude})
    if not orders:
        return
    (low, high), N = (speeds.given[0], speeds.given[-1]), project.drive.N
    gear = project.gear
    largest = INPUT_RPM[1] if gear is None or gear.max_rpm is None else gear.max_rpm
    below = orders[-1] * high < omega_0
    if speeds.by_motor and speeds.ratio == 1.0 and below and high / RPM <= largest / N:
        yield (
            f"The motor speed is at most {high / RPM:.4g} rpm, low enough for an output speed, and no order reaches "
            "the natural frequency; if these are output speeds, write 'shaft: load'."
        )
    elif speeds.by_motor and high / RPM > FACTOR * INPUT_RPM[0]:
        remedy = "write 'shaft: motor'" if speeds.ratio != 1.0 else "check the unit"
        yield (
            f"The motor speed is {high / RPM:.4g} rpm; gears allow at most {INPUT_RPM[0]:g} rpm at the input. If these "
            f"are motor speeds, {remedy}."
        )
    elif FREQUENCY_FACTOR * orders[-1] * high < omega_0 or orders[0] * low > FREQUENCY_FACTOR * omega_0:
        yield (
            f"The natural frequency, {omega_0 / (2.0 * math.pi):.3g} Hz, is far from all excitation frequencies in the "
            f"speed range, {orders[0] * low / (2.0 * math.pi):.3g} to {orders[-1] * high / (2.0 * math.pi):.3g} Hz; "
            "check stiffness, inertia and speeds."
        )
