"""Notes on the input of a project, for a reader of its results.

Most of it are numbers that are legal and most likely wrong: a unit, a shaft or a factor taken for another. Thresholds
are a factor away from what gears have, so that no sound drive meets one. What gears have, over the 183 records of the
catalogue (Harmonic Drive LLC, CSF/CSG catalogue; harmonicdrive.de; Schaeffler RT1): K1 from 340 N*m/rad (CSF-8-30) to
1.45e6 N*m/rad (HFUC-90-80), a twist at the rated torque from 0.50 mrad (HFUC-90-50) to 2.4 mrad (HFUS-25-30), a
transmission accuracy of at most 2 arcmin peak-to-peak (CSF/CSG catalogue, p. 49), a ratcheting torque of 4.8 to 16
times the rated torque (p. 14), an input speed of at most 8500 rpm. A damping ratio of 0.01 to 0.05 is usual in
torsional trains (Wang, Feese & Pettinato, Turbomachinery Symposium 2012).
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from ..base.law import breakpoints_of, spring_stiffness
from ..base.units import ARCSEC, RPM, convert
from ..drive.asked import mean_of
from ..drive.project import Project
from ..drive.reductions import error_slope
from ..model.gears.gear import HEAVY, NUMBERS
from ..model.gears.limits import RATCHETING
from ..model.laws import Parallel
from ..model.laws.friction import NO_FRICTION
from ..model.orders import without_teeth
from ..model.train.controls import CascadeLoop, PositionLoop, SpeedLoop, core_of
from ..model.train.filters import NotchFilter, apart
from ..model.train.shafts import NO_DRAG

FACTOR = 10.0  # beyond what gears have
STIFFNESS = 340.0, 1.45e6  # N*m/rad
TWIST = 0.5e-3, 2.4e-3  # rad, at the rated torque
HERTZ = 1.0, 2000.0
ERROR = 10.0 * math.pi / 10800.0  # 10 arcmin, 0-to-peak: ten times the largest of the catalogue
DAMPING = 0.2  # damping ratio
WRONG_SHAFT = 3.0  # times N: halfway from a matched inertia, 0.1 to 10, to one of the other shaft, off by N^2
INPUT_RPM = 8500.0, 4000.0  # rpm of the input: of any gear, and the middle of the catalogue
FREQUENCY_FACTOR = 10.0  # times an excitation's frequency
CROSSOVER = 1.0, 1000.0  # Hz, of a speed loop
USUAL_TIME, SLOWER = 4.0, 100.0  # T_n and 1/K_v times the crossover, by the symmetric optimum; slow loops are sound


def notes(project: Project, by_bandwidth: bool) -> Iterator[str]:
    """Sentences on the input for a reader of the results; `by_bandwidth` is true for a loop given by its bandwidth."""
    yield from _arranged(project)
    yield from _balance(project)
    yield from _doubts(project)
    yield from _loop(project, by_bandwidth)
    yield from _slipping(project)
    yield from _gap(project)
    if (gear := project.gear) is None:
        return
    yield from gear.doubts_about(*(name for name in NUMBERS if name != "mass"))
    yield from of_hysteresis(project)
    if gear.input_inertia is not None and project.drive.J_m < (1.0 - 1e-6) * gear.input_inertia:
        yield (
            f"motor.inertia is {1e4 * project.drive.J_m:g} kg*cm^2, less than the {1e4 * gear.input_inertia:g} kg*cm^2 "
            f"of the wave generator of {gear.name} alone; it must include the wave generator."
        )
    if gear.input_inertia is not None and (times := project.drive.J_m / gear.input_inertia) > HEAVY:
        size = f"motor.inertia is {project.drive.J_m:.4g} kg*m^2, {times:.3g} times that of the wave generator"
        yield f"{size} of {gear.name}; check its unit."


def of_hysteresis(project: Project) -> Iterator[str]:
    """The hysteresis loss of the gear's record, where the results are without it."""
    if (gear := project.gear) is not None and gear.hysteresis_loss is not None and not project.has_memory:
        loss = gear.hysteresis_loss / ARCSEC
        yield (
            f"The record of {gear.name} gives a hysteresis loss of up to {loss:.4g} arcsec. The results "
            f"leave out its lag of up to {0.5 * loss:.4g} arcsec after a reversal, and its damping. To count them, "
            "write 'hysteresis: catalogue' at the top level of the file."
        )


def of_damping(ratio: float) -> str:
    """Sentence on a damping ratio that no gear has; empty for a usual one."""
    usual = "0.01 to 0.05 is usual, and 4 % is written '4 %' or 0.04."
    return f"The damping ratio is {ratio:.3g} ({100.0 * ratio:.3g} % of critical); {usual}" if ratio > DAMPING else ""


def _arranged(project: Project) -> Iterator[str]:
    """Ratio, sense of rotation and turns of the errors that follow from the member that is fixed."""
    arrangement, R = project.arrangement, project.drive.N
    if arrangement is None:
        yield from without_teeth(R)
        return
    signed = arrangement.ratio(arrangement.teeth(R))
    sense = "with" if signed > 0 else "against"
    j, k = arrangement.lobes(arrangement.output, 2)
    oval = f"an oval {arrangement.output} gives the order {{wave_generator: {j}, output: {k if signed > 0 else -k}}}"
    if arrangement.driven == "wave generator":
        oval = f"an oval {arrangement.fixed} gives order 2, {oval}"
    yield (
        f"gear.fixed: the {arrangement.fixed} is fixed and the {arrangement.output} turns {sense} the motor, once in "
        f"{R:g} turns; {oval}."
    )


def unsaid(notes: Iterable[str], sentences: Iterable[str]) -> list[str]:
    """Notes but those in the sentences: a doubt about a limit of the gear stands with the limit."""
    text = " ".join(sentences).replace("N·m", "N*m")
    return [note for note in notes if note not in text]


def posture_note(project: Project) -> Iterator[str]:
    """Note on the answers that are about the postures of a project, where it has any."""
    if project.postures:
        yield (
            f"`analyze`, `speed-map`, `move --postures` and `tune` compute the {len(project.postures)} postures; every "
            "other answer is for the load of the file alone."
        )


def move_note(project: Project) -> tuple[str, ...]:
    """Note on the answers that are about the move of a project, where it has one."""
    asked = project.move is not None and bool(project.move.profile)
    return ("The move of the file is judged by `analyze` and `move`; this is about steady motions.",) * asked


def of_curve(searched: bool) -> str:
    """The motions that sizes and jumps are of; `searched` where others are looked for at the ends of the range."""
    others = "looked for at the ends of the range alone" if searched else "not looked for"
    return f"of this curve alone: motions apart from it are {others}"


def load_remark(project: Project) -> tuple[str, ...]:
    """Note on the torque of the load that one curve is for, where the load has a range of them."""
    low, high = project.other_loads
    if low == high:
        return ()
    return (
        f"The curve is for a load torque of {project.mean_load_torque:.4g} N*m, of the range from {low:.4g} to "
        f"{high:.4g} N*m that gravity or the file gives; an analysis follows the range.",
    )


def _gap(project: Project) -> Iterator[str]:
    """Note on the damping of a drive with backlash, which acts in the gap too."""
    law = project.drive.law
    law = law.first if isinstance(law, Parallel) else law
    if breakpoints_of(law) and spring_stiffness(law, 0.0) == 0.0 and project.drive.B > 0.0:
        yield (
            "The damping acts across the gear, in its gap too; 'hysteresis: {type: contact_damping, ...}' with "
            "'damping: {B: 0 N*m*s/rad}' acts in contact alone"
        )


def _slipping(project: Project) -> Iterator[str]:
    """Note on a loop without stiffness, which gives way under a mean torque."""
    loop = core_of(None if project.train is None else project.train.motor.control)
    if (isinstance(loop, SpeedLoop) and loop.K_i == 0.0) or (isinstance(loop, PositionLoop) and loop.K_p == 0.0):
        gain = "K_i" if isinstance(loop, SpeedLoop) else "K_p"
        yield (
            f"motor.loop has {gain} 0: a mean torque slows the motor and its angle drifts off the reference; the "
            "results are for the mean speeds that it has, and the pointing error is without that drift. "
            "Motions apart from the curve are not looked for."
        )


def _balance(project: Project) -> Iterator[str]:
    """Note on mean torques that a free motor cannot balance, of a range of them those farthest from it."""
    drive, given = project.drive, mean_of(project.motor_torque)
    means = project.mean_range or (project.mean_load_torque,)
    at_load = max(means, key=lambda mean: abs(drive.N * given + mean))
    total = drive.N * given + at_load
    if project.motor == "free" and abs(total) > 1e-9 * (abs(drive.N * given) + abs(at_load)):
        rate = drive.N * total / (drive.N * drive.N * drive.J_m + drive.J_l)
        under = f" with {at_load:g} N*m on the load" if len(means) > 1 else ""
        remedy = "" if len(means) > 1 else f"give the free motor a mean torque of {-at_load / drive.N:.4g} N*m, or "
        yield (
            f"The mean torques do not balance{under}: the motor speeds up by {rate / RPM:.4g} rpm/s and does not keep "
            f"the speeds analysed; {remedy}write 'mode: held'."
        )


def _doubts(project: Project) -> Iterator[str]:
    """Sentences on numbers that are most likely meant otherwise; none for a sound drive."""
    if project.speeds.by_motor:
        yield from _stiffness(project)
        yield from _inertia(project)
        yield from _torque(project)
    yield from _natural_frequency(project)
    yield from _error(project)
    yield from filter(None, [of_damping(project.damping_ratio or 0.0)])


def _stiffness(project: Project) -> Iterator[str]:
    """A stiffness that no gear has: by the twist at the rated torque, or else by its size."""
    stiffness, rated = float(spring_stiffness(project.drive.law, 0.0)), project.rated_torque
    if not stiffness > 0.0:
        return
    if rated is not None and not TWIST[0] / FACTOR <= rated / stiffness <= TWIST[1] * FACTOR:
        twist = convert(rated / stiffness, "rad", "arcmin")
        yield (
            f"The gear twists by {twist:.3g} arcmin under its rated torque of {rated:g} N*m, those of the catalogue "
            f"by 1.7 to 8.3 arcmin; check the unit of the stiffness at rest, {stiffness:.4g} N*m/rad, and the torque."
        )
    elif rated is None and not STIFFNESS[0] / FACTOR <= stiffness <= STIFFNESS[1] * FACTOR:
        yield (
            f"The stiffness of the gear at rest is {stiffness:.4g} N*m/rad, and gears of the catalogue have "
            f"{STIFFNESS[0]:g} to {STIFFNESS[1]:.3g} N*m/rad; check its unit."
        )


def _loop(project: Project, by_bandwidth: bool) -> Iterator[str]:
    """Gains of a speed loop in another unit: by the frequency at which it crosses over, and by times beside it."""
    core: Any = None if project.whole is None else core_of(project.whole.motor.control)
    if not isinstance(core, CascadeLoop | SpeedLoop) or not core.K_p > 0.0:
        return
    crossover = core.K_p / project.loop_inertia
    yield from _notches(project, crossover)
    hertz = crossover / (2.0 * math.pi)
    if not CROSSOVER[0] / FACTOR <= hertz <= CROSSOVER[1] * FACTOR:
        gain = "of motor.loop.bandwidth" if by_bandwidth else f"and the shaft of motor.loop.K_p, {core.K_p:g} N*m*s/rad"
        yield (
            f"The speed loop crosses over at {hertz:.3g} Hz, and those of drives do at {CROSSOVER[0]:g} to "
            f"{CROSSOVER[1]:g} Hz; check the unit {gain}."
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
            f"The notch of {hertz:.3g} Hz holds the crossover of the speed loop in its band: the crossover falls from "
            f"{before:.3g} to {now:.3g} Hz, where the notch takes {lost:.3g} degrees of phase; make it narrower, or "
            "put it on a resonance above."
        )


def _beside(name: str, text: str, turns: float) -> Iterator[str]:
    """A gain whose time, in units of that of the speed loop, is far from the usual one."""
    share = turns / USUAL_TIME
    if not 1.0 / FACTOR <= share <= SLOWER:
        slower = f"{share:.3g} times slower" if share > 1.0 else f"{1.0 / share:.3g} times faster"
        yield f"motor.loop.{name} is {text}, {slower} than is usual beside K_p; check its unit."


def _inertia(project: Project) -> Iterator[str]:
    """Inertias that fit better when one belongs to the other shaft."""
    drive = project.drive
    ratio, bound = drive.J_l / (drive.N * drive.N * drive.J_m), WRONG_SHAFT * drive.N
    if ratio > bound or ratio < 1.0 / bound:
        large, small = ("load", "motor") if ratio > bound else ("motor", "load")
        yield (
            f"The inertia of the load is {ratio:.3g} times that of the motor at the output, {drive.N:g}^2 J_m, and 0.1 "
            f"to 10 is usual; write load.inertia at the output and motor.inertia at the motor: the {large}'s may be "
            f"too large by {drive.N:g}^2, or the {small}'s too small."
        )


def _torque(project: Project) -> Iterator[str]:
    """A torque of the load at which the teeth skip, where nothing computed is a result."""
    largest = max(map(abs, project.load_torques))
    gear, rated = project.gear, project.rated_torque
    limit = None if gear is None else gear.ratcheting_torque
    skip = "the teeth skip, and no number computed here is a result; check the torque and its unit"
    reaches = f"The torque of the load reaches {largest:g} N*m"
    if limit is not None and largest > limit:
        yield f"{reaches}, beyond the ratcheting torque of {limit:g} N*m: {skip}."
    elif limit is None and rated is not None and largest > RATCHETING * rated:
        times = f"{largest / rated:.3g} times the rated torque, and gears ratchet from 5 to 16 times on"
        yield f"{reaches}, {times}: {skip}."


def _natural_frequency(project: Project) -> Iterator[str]:
    """A natural frequency that no drive has, or that nothing in the speed range comes near."""
    omega_0 = project.omega_0
    if not omega_0:
        return
    hertz = omega_0 / (2.0 * math.pi)
    if HERTZ[0] <= hertz <= HERTZ[1]:
        yield from _speeds(project, omega_0)
    else:
        usual = f"drives have {HERTZ[0]:g} Hz to 2 kHz; check the units of stiffness and inertia."
        yield f"The natural frequency is {hertz:.3g} Hz, and {usual}"


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
            f"The motor turns at up to {high / RPM:.4g} rpm, which the output reaches too, and no order meets the "
            "natural frequency; if these are speeds of the output, write 'shaft: load'."
        )
    elif speeds.by_motor and high / RPM > FACTOR * INPUT_RPM[0]:
        remedy = "write 'shaft: motor'" if speeds.ratio != 1.0 else "check the unit"
        yield (
            f"The motor turns at {high / RPM:.4g} rpm, and gears take at most {INPUT_RPM[0]:g} rpm at the input; if "
            f"these are speeds of the motor, {remedy}."
        )
    elif FREQUENCY_FACTOR * orders[-1] * high < omega_0 or orders[0] * low > FREQUENCY_FACTOR * omega_0:
        yield (
            f"The natural frequency, {omega_0 / (2.0 * math.pi):.3g} Hz, is far from every order in the speed range, "
            f"{orders[0] * low / (2.0 * math.pi):.3g} to {orders[-1] * high / (2.0 * math.pi):.3g} Hz; check "
            "stiffness, inertia and speeds."
        )


def _error(project: Project) -> Iterator[str]:
    """A kinematic error of degrees, and one that depends on torque or direction."""
    loaded = project.loaded_error
    if loaded is not None and any(loaded.per_torque):
        yield (
            f"The kinematic error grows with the torque; it is that under the mean torque of the load, "
            f"{project.mean_load_torque:.4g} N*m, without torques that follow an angle."
        )
        torques = project.mean_load_torque, *project.load_torques, *(row.torque or 0.0 for row in project.postures)
        if turned := [T for T in torques if any(line.amplitude < 0.0 for line in loaded.under(-T).lines)]:
            yield (
                f"Under {turned[0]:.4g} N*m on the load per_torque makes the amplitude of a line negative, which turns "
                "its phase by 180 deg; check the sign of per_torque."
            )
    if loaded is not None and loaded.backward is not None:
        yield (
            "The kinematic error is another one in backward motion; a compensation at a negative speed has that, and "
            "all else that of forward motion."
        )
    lines = () if project.kinematic_error is None else project.kinematic_error.lines
    size = sum(abs(line.amplitude) for line in lines)
    if size > ERROR:
        yield (
            f"The kinematic error has amplitudes of {convert(size, 'rad', 'arcmin'):.4g} arcmin in all, and gears have "
            "at most 1 arcmin; check the unit, and that they are angles of the output."
        )


def remarks(project: Project) -> tuple[str, ...]:
    """Notes of the file, and sentences about effects that the error equation neglects."""
    train, sentences = project.train, list(project.notes)
    if train is None:
        return tuple(sentences)
    present = {"motor.drag": train.motor.drag != NO_DRAG, "load_friction": train.friction != NO_FRICTION}
    for field in filter(present.__getitem__, present if train.motor.held else ()):
        sentences.append(f"{field} does not enter: an ideally held motor keeps its speed whatever opposes it.")
    if train.motor.free and project.kinematic_error is not None:
        sentences.append(
            "With the motor free the error equation leaves out the motor's answer to the changing ratio, N e' up to "
            f"{error_slope(train):.2g}, and the ripple of the motor's speed; `strainwave analyze` compares it with the "
            "whole drive train."
        )
    return tuple(sentences)
