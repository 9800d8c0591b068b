"""Specification of a design: a YAML file with units, read as a project file is."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..base.terminal import printable
from ..base.units import RPM
from ..model.excitation import KinematicError
from ..model.gears import catalogue
from ..study.design.specification import DutySegment, Specification
from .fields import groups, schema
from .fields.entries import EXAMPLE_LOOP, Loop
from .fields.groups import CATALOGUE, ErrorLine
from .fields.kinds import Items, Quantity, Text, Whole, Wrong
from .fields.rows import Fields, Group, field, needed, read_file, rows_of
from .plausibility import damping_doubt
from .reading import FROM_REST, REST_NOTE, ProjectError
from .yaml_text import Keys, Problem, name, read, refuse, text_of

KIND = "specification"
MOST_ITEMS = 1000  # inertias of one kind, and segments
COUNT = Whole(1, 10**9, "write for example 50", "is not positive; write a whole number from 1")
SEGMENT = "{torque: 60 N*m, speed: 20 rpm, duration: 2 s}"
INERTIAS = Items(schema.INERTIA, 1, MOST_ITEMS)


def _series(value: str) -> str:
    """A series of the catalogue, in any letters (ValueError)."""
    names = sorted({gear.series for gear in catalogue.select()})
    if value.upper() not in names:
        raise ValueError(f"{value!r} is not a series of the catalogue; write one of {', '.join(names)}")
    return value.upper()


class LoadsSpec(Group):
    """One load or several."""

    inertia: float | None = field(schema.INERTIA, "1.3 kg*m^2", "Inertia of the load.")
    inertias: tuple[float, ...] | None = field(INERTIAS, "[0.8 kg*m^2, 1.3 kg*m^2]", "Inertias of several loads.")

    def check(self) -> Iterator[Wrong]:
        """Refuse both, and neither."""
        if (self.inertia is None) == (self.inertias is None):
            yield Wrong((), "needs either one 'inertia' or a list 'inertias'; write {inertia: 1.3 kg*m^2}")


class RangeSpec(Group):
    """Speeds of the load."""

    from_: float = needed(Quantity("rad/s", "not negative"), "2 rpm", "Lower end of the range.")
    to: float = needed(schema.SPEED, "40 rpm", "Upper end of the range.")

    def check(self) -> Iterator[Wrong]:
        """Refuse a range that does not ascend."""
        return groups.ascending(self.from_, self.to, "speed")


class MotorsSpec(Group):
    """Motors to choose from, and their loop; without one they are ideally held."""

    rotor_inertias: tuple[float, ...] = needed(
        INERTIAS, "[0.5 kg*cm^2, 2 kg*cm^2]", "Inertias of the rotors, without the wave generator."
    )
    loop: Any = field(Loop(), EXAMPLE_LOOP, "Loop that controls the motor.")


class RatioSpec(Group):
    """Damping of the gear as a share of the critical one on the held load."""

    ratio: float = needed(Quantity("", "positive"), "3 %", "Damping ratio: fraction of the critical damping.")


class SegmentSpec(Group):
    """A stretch of the duty cycle."""

    torque: float = needed(groups.TORQUE, "60 N*m", "Torque of the load.")
    speed: float = needed(Quantity("rad/s"), "20 rpm", "Speed of the load.")
    duration: float = needed(Quantity("s", "positive"), "2 s", "Duration of the segment.")


SEGMENTS = Items(Fields(SegmentSpec), high=MOST_ITEMS)


class TorquesSpec(Group):
    """Torques of the load in place of a duty cycle, and what comes on top."""

    mean: float | None = field(groups.TORQUE, "40 N*m", "Mean torque of the load.")
    peak: float | None = field(groups.TORQUE, "90 N*m", "Largest torque of the load.")
    momentary: float | None = field(groups.TORQUE, "200 N*m", "Torque of a collision.")
    preload: float = field(groups.TORQUE, "5 N*m", "Additional constant torque of the load.", 0.0)
    average_speed: float | None = field(schema.SPEED, "15 rpm", "Average speed of the load.")


class LargestSpec(Group):
    """Room for the gear."""

    size: int | None = field(COUNT, "40", "Largest size of the gear.")
    mass: float | None = field(Quantity("kg", "positive"), "3 kg", "Largest mass of the gear.")


class ErrorSpec(Group):
    """Kinematic error: an accuracy class, or lines."""

    accuracy: Any = rows_of(groups.ExcitationSpec)["accuracy"]
    kinematic_error: tuple[ErrorLine, ...] = rows_of(groups.ExcitationSpec)["kinematic_error"]  # type: ignore[assignment]
    assumed: Any = field(Quantity("rad", "positive", check=groups.ACCURACY.check), "1 arcmin",
        "Accuracy assumed for gears without one in the catalogue; otherwise these gears are not judged.")  # fmt: skip

    def check(self) -> Iterator[Wrong]:
        """Refuse both."""
        if self.accuracy is not None and self.kinematic_error:
            yield Wrong((), "has both an accuracy and the lines of a kinematic error; write one of them")
        if any(isinstance(line.order, groups.OrderPair) for line in self.kinematic_error):
            yield Wrong(("kinematic_error",), "has an order of the output's turn; gears of a design differ in ratio")
        if any(line.per_torque or not line.alike for line in self.kinematic_error):
            fault = "depends on torque or direction; a design needs one amplitude"
            yield Wrong(("kinematic_error",), fault)


class SpecificationSpec(Group):
    """The whole file."""

    title: str = field(schema.TITLE, "Elbow of a robot", "Title of the answer.", "")
    load: LoadsSpec = needed(LoadsSpec, "{inertias: [0.8 kg*m^2, 1.3 kg*m^2]}")
    speed: RangeSpec = needed(RangeSpec, "{from: 2 rpm, to: 40 rpm}")
    limit: schema.LimitSpec = needed(schema.LimitSpec, "{oscillation: 60 arcsec}")
    motor: MotorsSpec = needed(MotorsSpec, "{rotor_inertias: [0.5 kg*cm^2, 2 kg*cm^2]}")
    damping: RatioSpec = needed(RatioSpec, "{ratio: 3 %}")
    duty: tuple[SegmentSpec, ...] = field(
        Items(Fields(SegmentSpec), high=MOST_ITEMS), f"[{SEGMENT}]", "Duty cycle.", ()
    )
    torque: TorquesSpec = field(TorquesSpec, "{mean: 40 N*m, peak: 90 N*m}", default=TorquesSpec())
    life: float | None = field(Quantity("h", "positive"), "10000 h", "Life of the gear.")
    largest: LargestSpec = field(LargestSpec, "{size: 40, mass: 3 kg}", default=LargestSpec())
    ratios: tuple[int, ...] = field(Items(COUNT), "[50, 80, 100]", "Ratios to choose from.", ())
    series: tuple[str, ...] = field(Items(Text(_series)), "[CSG]", "Series to choose from.", ())
    excitation: ErrorSpec = field(ErrorSpec, "{accuracy: catalogue}", default=ErrorSpec())


def read_specification(path: str | Path) -> Specification:
    """Read a specification of a design.

    Parameters
    ----------
    path : str or Path
        YAML file of at most 256 KiB, see `examples/projects/elbow.yaml`.

    Returns
    -------
    Specification
        What is asked of the axis, in SI and radians.

    Raises
    ------
    ProjectError
        If the file cannot be read or specifies nothing; all problems found, one line each.
    """
    path = Path(path)
    located = read(text_of(path, KIND, error=ProjectError))
    spec, problems = read_file(located.content, SpecificationSpec, located)
    if not problems:
        problems = [Problem(*located.position(keys), name(keys), sentence) for keys, sentence in _contradictions(spec)]
    refuse(path, problems, ProjectError)
    return _resolved(spec, path)


def _contradictions(spec: SpecificationSpec) -> Iterator[tuple[Keys, str]]:
    """Fields of torque and duty that do not go together."""
    torque = spec.torque
    if spec.duty and (torque.mean is not None or torque.peak is not None):
        yield ("torque",), "gives a mean or a peak, but the duty cycle defines both; remove one or the other"
    elif (torque.mean is None) != (torque.peak is None):
        yield ("torque",), "gives one of mean and peak; write both, for example {mean: 40 N*m, peak: 90 N*m}"
    elif abs(torque.mean or 0.0) > abs(torque.peak or 0.0):
        yield ("torque", "mean"), "is larger than the peak; exchange them, or check both"
    if spec.duty and not any(part.speed for part in spec.duty):
        yield ("duty",), "all speeds are zero; write the speed of at least one segment"


def _resolved(spec: SpecificationSpec, path: Path) -> Specification:
    """The specification that the fields of a file give."""
    lines = tuple(line.line() for line in spec.excitation.kinematic_error)
    accuracy = spec.excitation.accuracy
    low = spec.speed.from_ or FROM_REST * spec.speed.to
    begin = "" if spec.speed.from_ else REST_NOTE.format(f"{low / RPM:.4g} rpm at the load")
    return Specification(
        title=spec.title or printable(path.stem),
        load_inertias=tuple(filter(None, (spec.load.inertia, *(spec.load.inertias or ())))),
        speeds=(low, spec.speed.to),
        remarks=tuple(filter(None, (begin, damping_doubt(spec.damping.ratio)))),
        limit=spec.limit.oscillation,
        rotor_inertias=tuple(spec.motor.rotor_inertias),
        loop=spec.motor.loop,
        damping_ratio=spec.damping.ratio,
        duty=tuple(DutySegment(part.torque, part.speed, part.duration) for part in spec.duty),
        **{f"{name}_torque": getattr(spec.torque, name) for name in ("mean", "peak", "momentary")},
        preload=spec.torque.preload,
        average_speed=spec.torque.average_speed,
        life=spec.life,
        **{f"largest_{name}": getattr(spec.largest, name) for name in ("size", "mass")},
        ratios=tuple(spec.ratios),
        series=tuple(spec.series),
        accuracy=None if accuracy == CATALOGUE else accuracy,
        assumed_accuracy=spec.excitation.assumed,
        kinematic_error=KinematicError(lines) if lines else None,
    )
