"""Notes for a reader of results: what they count and leave out, and which numbers are most likely wrong."""

from collections.abc import Iterable, Iterator

from ..base.law import breakpoints_of, spring_stiffness
from ..base.units import ARCSEC, RPM
from ..drive.equation.reductions import error_slope
from ..drive.project import Project
from ..model.excitation import mean_torque
from ..model.gears.gear import HEAVY, NUMBERS, Gear
from ..model.laws.friction import NO_FRICTION
from ..model.laws.hysteresis import Parallel
from ..model.orders import without_teeth
from ..model.train.controls import PositionLoop, SpeedLoop, core_of
from ..model.train.shafts import NO_DRAG
from .plausibility import drive_doubts, error_doubts, loop_doubts


def notes(project: Project, by_bandwidth: bool) -> Iterator[str]:
    """Sentences on a project; `by_bandwidth` is true where the file gives the motor's loop by its bandwidth."""
    yield from _arranged(project)
    yield from _balance(project)
    yield from drive_doubts(project)
    yield from _loaded_error(project)
    yield from error_doubts(project)
    yield from loop_doubts(project, by_bandwidth)
    yield from _slipping(project)
    yield from _gap(project)
    if project.gear is not None:
        yield from project.gear.doubts_about(*(name for name in NUMBERS if name != "mass"))
        yield from hysteresis_note(project)
        yield from _wave_generator(project, project.gear)


def _wave_generator(project: Project, gear: Gear) -> Iterator[str]:
    """An inertia of the motor below that of the wave generator of its gear, or far above."""
    inertia, record = project.drive.J_m, gear.input_inertia
    if record is None:
        return
    if inertia < (1.0 - 1e-6) * record:
        yield (
            f"motor.inertia is {1e4 * inertia:g} kg*cm^2, less than the {1e4 * record:g} kg*cm^2 "
            f"of the wave generator of {gear.name} alone; motor.inertia must include the wave generator."
        )
    if inertia > HEAVY * record:
        size = f"motor.inertia is {inertia:.4g} kg*m^2, {inertia / record:.3g} times that of the wave generator"
        yield f"{size} of {gear.name}; check the unit."


def hysteresis_note(project: Project) -> Iterator[str]:
    """The hysteresis loss of the gear's record, where the results are without it."""
    if (gear := project.gear) is not None and gear.hysteresis_loss is not None and not project.has_memory:
        loss = gear.hysteresis_loss / ARCSEC
        yield (
            f"The catalogue gives {gear.name} a hysteresis loss of up to {loss:.4g} arcsec. The results neglect the "
            f"hysteresis: an error of up to {0.5 * loss:.4g} arcsec after a reversal, and damping. To include it, "
            "write 'hysteresis: catalogue' at the top level of the project file."
        )


def _arranged(project: Project) -> Iterator[str]:
    """Ratio, sense of rotation and turns of the errors that follow from the member that is fixed."""
    arrangement, R = project.arrangement, project.drive.N
    if arrangement is None:
        yield from without_teeth(R)
        return
    signed = arrangement.ratio(arrangement.teeth(R))
    sense = "with" if signed > 0 else "against"
    j, k = arrangement.lobes(arrangement.output, 2)
    oval = f"an oval {arrangement.output} gives error order {{wave_generator: {j}, output: {k if signed > 0 else -k}}}"
    if arrangement.driven == "wave generator":
        oval = f"an oval {arrangement.fixed} gives error order 2, {oval}"
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
            f"`analyze`, `speed-map`, `move --postures` and `tune` compute the {len(project.postures)} postures; all "
            "other commands compute the nominal load alone."
        )


def move_note(project: Project) -> tuple[str, ...]:
    """Note on the answers that are about the move of a project, where it has one."""
    asked = project.move is not None and bool(project.move.profile)
    return ("These results are for steady motions; `analyze` and `move` check the move of the project file.",) * asked


def curve_remark(searched: bool) -> str:
    """The motions that sizes and jumps are of; `searched` where others are looked for at the ends of the range."""
    others = "searched at the lowest and highest speed only" if searched else "not searched"
    return f"values of this response curve; other periodic motions: {others}"


def load_remark(project: Project) -> tuple[str, ...]:
    """Note on the torque of the load that one curve is for, where the load has a range of them."""
    low, high = project.other_loads
    if low == high:
        return ()
    return (
        f"The curve is for a load torque of {project.mean_load_torque:.4g} N*m; gravity or the project file gives "
        f"{low:.4g} to {high:.4g} N*m. `analyze` covers this range.",
    )


def _gap(project: Project) -> Iterator[str]:
    """Note on the damping of a drive with backlash, which acts in the gap too."""
    law = project.drive.law
    law = law.first if isinstance(law, Parallel) else law
    if breakpoints_of(law) and spring_stiffness(law, 0.0) == 0.0 and project.drive.B > 0.0:
        yield (
            "The damping acts within the backlash gap too; for damping in contact only, write "
            "'hysteresis: {type: contact_damping, ...}' with 'damping: {B: 0 N*m*s/rad}'"
        )


def _slipping(project: Project) -> Iterator[str]:
    """Note on a loop without stiffness, which gives way under a mean torque."""
    loop = core_of(None if project.train is None else project.train.motor.control)
    if (isinstance(loop, SpeedLoop) and loop.K_i == 0.0) or (isinstance(loop, PositionLoop) and loop.K_p == 0.0):
        gain = "K_i" if isinstance(loop, SpeedLoop) else "K_p"
        yield (
            f"motor.loop has {gain} = 0: a mean torque slows the motor, and the motor angle drifts off the reference. "
            "The results are for the reduced mean speeds, the pointing error is without the drift, and other periodic "
            "motions are not searched."
        )


def _balance(project: Project) -> Iterator[str]:
    """Note on mean torques that a free motor cannot balance, of a range of them those farthest from it."""
    drive, given = project.drive, mean_torque(project.motor_torque)
    means = project.mean_range or (project.mean_load_torque,)
    at_load = max(means, key=lambda mean: abs(drive.N * given + mean))
    total = drive.N * given + at_load
    if project.motor == "free" and abs(total) > 1e-9 * (abs(drive.N * given) + abs(at_load)):
        rate = drive.N * total / (drive.N * drive.N * drive.J_m + drive.J_l)
        under = f" under a load torque of {at_load:g} N*m" if len(means) > 1 else ""
        remedy = "" if len(means) > 1 else f"give the free motor a mean torque of {-at_load / drive.N:.4g} N*m, or "
        yield (
            f"The mean torques do not balance{under}: the motor accelerates by {rate / RPM:.4g} rpm/s and cannot run "
            f"steadily; {remedy}write 'mode: held'."
        )


def _loaded_error(project: Project) -> Iterator[str]:
    """Notes on a kinematic error that depends on torque or direction."""
    loaded = project.loaded_error
    if loaded is not None and any(loaded.per_torque):
        yield (
            f"The kinematic error grows with the torque. It is computed for the mean load torque of "
            f"{project.mean_load_torque:.4g} N*m, without torques that depend on an angle."
        )
        torques = project.mean_load_torque, *project.load_torques, *(row.torque or 0.0 for row in project.postures)
        if turned := [T for T in torques if any(line.amplitude < 0.0 for line in loaded.under(-T).lines)]:
            yield (
                f"Under a load torque of {turned[0]:.4g} N*m, per_torque makes an amplitude of the kinematic error "
                "negative, a phase shift of 180 deg; check the sign of per_torque."
            )
    if loaded is not None and loaded.backward is not None:
        yield (
            "The kinematic error differs in backward motion. Only a compensation at a negative speed uses the backward "
            "error; all other results use the forward error."
        )


def remarks(project: Project) -> tuple[str, ...]:
    """Notes of the file, and sentences about effects that the error equation neglects."""
    train, sentences = project.train, list(project.notes)
    if train is None:
        return tuple(sentences)
    present = {"motor.drag": train.motor.drag != NO_DRAG, "load_friction": train.friction != NO_FRICTION}
    for field in filter(present.__getitem__, present if train.motor.held else ()):
        sentences.append(f"{field} has no effect: an ideally held motor keeps its speed under any torque.")
    if train.motor.free and project.kinematic_error is not None:
        sentences.append(
            "With a free motor the error equation neglects the ripple of the motor speed and the motor's reaction to "
            f"the varying ratio, N e' up to {error_slope(train):.2g}; `strainwave analyze` compares the equation with "
            "the whole drive train."
        )
    return tuple(sentences)
