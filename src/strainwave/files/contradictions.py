"""Contradictions in a project whose fields are right by themselves."""

from collections.abc import Iterator
from functools import reduce
from typing import Any

from ..base.law import depends, spring_stiffness
from ..base.quantities import checked
from ..base.results import SolveError
from ..model.gears.gear import Gear
from ..model.orders import BY_FIXED
from .fields.entries import EXAMPLE_HYSTERESIS
from .fields.groups import CATALOGUE, OrderPair, Radians
from .fields.rows import inside, row_at
from .fields.schema import CURVE_COLUMNS, ExplicitGear, ProjectSpec
from .variants.names import keys_of, nominal_of
from .yaml_text import Keys

NOTHING_DRIVES = "has no periodic component; write for example 'kinematic_error: [{order: 2, amplitude: 23 arcsec}]'"


def contradictions(spec: ProjectSpec, gear: Gear | None, content: dict[str, Any]) -> Iterator[tuple[Keys, str]]:
    """Fields that do not go together; groups of the spec that are None have problems of their own."""
    if spec.gear is not None and spec.motor is not None:
        yield from _inertia(spec, gear)
    if spec.gear is not None:
        yield from _arrangement(spec, gear)
        yield from _law(spec, gear)
    if spec.excitation is not None:
        yield from _excitation(spec, gear)
    yield from _drive_train(spec)
    if spec.gear is not None and spec.load_friction == CATALOGUE:
        yield from _friction(gear)
    if spec.gear is not None and spec.scatter:
        yield from _scatter(spec.scatter, gear, content)
    rows, count = len(spec.scatter_correlation or ()), len(spec.scatter or {})
    if rows and rows != count:
        yield ("scatter_correlation",), f"has {rows} rows and scatter {count} numbers; write one row for each of them"
    for name in spec.sources or ():
        try:
            keys = keys_of(content, name)
            valid = row_at(ProjectSpec, content, keys) or keys[0] == "gear" or reduce(inside, keys, content) is not None
        except ValueError as error:
            yield ("sources", name), str(error)
        else:
            if not valid:
                yield ("sources", name), "is no field of this project file; name a number or a group of the file"


def _scatter(scatter: dict[str, float], gear: Gear | None, content: dict[str, Any]) -> Iterator[tuple[Keys, str]]:
    """Names that are no numbers of the file, and angles of what is no phase."""
    for name, size in scatter.items():
        try:
            nominal_of(content, gear, name)
        except ValueError as error:
            yield ("scatter", name), str(error)
        if isinstance(size, Radians) and not name.endswith(".phase"):
            yield ("scatter", name), "is an angle, but the number is no phase; write a relative scatter, such as 5 %"


def _inertia(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    if spec.motor.inertia is not None:
        return
    if gear is not None and gear.input_inertia is None:
        yield ("motor", "inertia"), f"is missing, and {gear.name} has no known value; write 'inertia: 4.5 kg*cm^2'"
    if isinstance(spec.gear, ExplicitGear):
        yield ("motor", "inertia"), "is missing for an explicit gear; write for example 'inertia: 4.5 kg*cm^2'"


def _friction(gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """Reasons why the friction of the meshing does not follow from the gear's record."""
    example = "write the friction as a share of the torque, for example 8 %"
    try:
        if gear is None:
            raise ValueError("the efficiency of an explicit gear is unknown")
        checked(gear.friction)
    except ValueError as error:
        yield ("load_friction",), f"{str(error).partition(';')[0]}; {example}"


def _arrangement(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """A member that cannot be fixed at this ratio."""
    fixed = getattr(spec.gear, "fixed", None)
    if fixed == "wave_generator" and gear is not None:
        why = f"is wave_generator, but {gear.name} has it on the motor; write ratio and law in full"
        yield ("gear", "fixed"), why
    elif fixed is not None and isinstance(spec.gear, ExplicitGear):
        try:
            BY_FIXED[fixed].teeth(spec.gear.ratio)
        except ValueError as error:
            yield ("gear", "fixed"), f"contradicts the ratio: {error}"


def _law(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """Contradictions to the law of the gear, hysteresis and backlash included."""
    if spec.hysteresis == CATALOGUE and (gear is None or None in (gear.hysteresis_loss, gear.rated_torque)):
        whose = "an explicit gear" if gear is None else gear.name
        fact = f"is catalogue, but no catalogue gives the hysteresis loss and rated torque of {whose}"
        yield ("hysteresis",), f"{fact}; write for example {EXAMPLE_HYSTERESIS}"
        return
    try:
        law = checked(spec.law(gear))
    except SolveError as error:
        yield ("hysteresis",), f"is catalogue, but {error}"
        return
    except TypeError:
        yield ("backlash",), "requires a spring, but gear.law has friction or hysteresis; write that as 'hysteresis'"
        return
    except ValueError as error:
        yield ("backlash",), f"contradicts gear.law: {error}"
        return
    if spec.damping is None:
        return
    if spec.damping.B is None and not float(spring_stiffness(law, 0.0)) > 0.0:
        field, held = "ratio" if spec.damping.ratio is not None else "quality", float(law.stiffness(0.0)) > 0.0
        what = "with friction or hysteresis but no spring" if held else "without stiffness at rest (backlash)"
        yield ("damping", field), f"has no meaning for a torsion law {what}; write B: 10 N*m*s/rad"
    if depends(law) > 1:
        for group, varies in (("stiffness", spec.stiffness is not None), ("damping", spec.damping.varies)):
            if varies:
                yield (group,), f"varies, but the torsion law is no spring (friction or hysteresis): {BOTH}"


BOTH = "leave one of them out, or write the equation in Python (strainwave.simulate takes any system)"


def _excitation(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    driven = spec.excitation
    if spec.motor is not None and spec.motor.mode == "held" and driven.motor_torque is not None:
        sentence = "has no effect on a held motor; remove motor_torque or write 'mode: free' under motor"
        if spec.motor.loop is not None:
            sentence = (
                "contradicts motor.loop, as a project file allows it for a free motor only; write cogging as motor: "
                "{drag: {type: angle_torque, amplitude: 0.02 N*m, order: 12}}, or build the drive train in Python"
            )
        yield ("excitation", "motor_torque"), sentence
    torques = [t for t in (driven.motor_torque, driven.load_torque) if t is not None]
    amplitudes = [line.amplitude for line in driven.kinematic_error]
    amplitudes += [line.amplitude for torque in torques for line in torque.lines]
    yield from _accuracy(spec, gear)
    yield from _pairs(spec, gear)
    if not any(amplitudes) and driven.accuracy is None:
        yield ("excitation",), NOTHING_DRIVES


def _forced(spec: ProjectSpec) -> bool:
    """True for speeds of the forcing."""
    return spec.speed is not None and spec.speed.shaft == "forcing"


def _pairs(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """Lines of two turns that are no line, or that another line is too."""
    ratio = None if spec.gear is None else spec.ratio(gear)
    lines, field = spec.excitation.kinematic_error, ("excitation", "kinematic_error")
    if ratio is None or not any(isinstance(line.order, OrderPair) for line in lines):
        return
    if _forced(spec):
        sentence = "has an order of the output turn, but speed is a forcing frequency; write 'shaft: motor' under speed"
        yield field, sentence
    orders = [round(ratio * line.line(ratio).order, 6) for line in lines]
    for i, order in enumerate(orders):
        if order == 0.0:
            yield (*field, i, "order"), f"has zero frequency at the ratio {ratio:g}; remove this order"
        elif order < 0.0:
            yield (*field, i, "order"), "has a negative frequency; change all signs, including the phase"
        elif order in orders[:i]:
            before = orders.index(order)
            yield (*field, i, "order"), f"has {order:g} periods per output turn, as line {before}; add the two lines"


def _accuracy(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """Contradictions to an accuracy class."""
    accuracy, field = spec.excitation.accuracy, ("excitation", "accuracy")
    if accuracy is None:
        return
    if spec.excitation.kinematic_error:
        yield field, "contradicts kinematic_error, which it would estimate; remove one of them"
    if _forced(spec):
        yield field, "refers to the motor turn, but speed is a forcing frequency; write 'shaft: motor' under speed"
    grade = accuracy if isinstance(accuracy, str) else ""
    if grade and spec.gear is not None and (gear is None or gear.accuracy_of(grade) is None):
        name = "an explicit gear" if gear is None else gear.name
        yield field, f"has no catalogue value for {name}; write an angle, for example 1 arcmin"


def train_fields(spec: ProjectSpec) -> list[Keys]:
    """Fields of the file that the drive train has and the error equation lacks."""
    fields = [("motor", "loop"), ("motor", "drag"), ("load", "drag"), ("load", "coupling"), ("load", "couplings")]
    given: list[Keys] = [(g, name) for g, name in fields if getattr(getattr(spec, g), name, None) is not None]
    return [*given, ("load_friction",)] if spec.load_friction else given


def _drive_train(spec: ProjectSpec) -> Iterator[tuple[Keys, str]]:
    """Contradictions to the drive train."""
    if spec.motor is not None and spec.motor.loop is not None and spec.motor.mode == "free":
        yield ("motor", "loop"), "contradicts 'mode: free', a motor without a loop; write 'mode: held' or no loop"
    curves = [name for name in CURVE_COLUMNS if spec.motor is not None and getattr(spec.motor, name) is not None]
    for name in curves:
        if _forced(spec):
            yield ("motor", name), "requires motor speeds, but speed is a forcing frequency; write 'shaft: motor'"
    for field in train_fields(spec):
        if _forced(spec):
            yield field, "belongs to a shaft, but speed is a forcing frequency; write 'shaft: motor' under speed"
        elif spec.stiffness is not None or (spec.damping is not None and spec.damping.varies):
            sentence = "cannot be combined with varying stiffness or damping; remove one of them, or "
            yield field, sentence + "give strainwave.DriveTrain a law of your own"
