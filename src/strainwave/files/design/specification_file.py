"""A specification in YAML with units: read as a project file is, every complaint with its line and column."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationError
from pydantic import model_validator as check_model

from ...model.excitation import KinematicError, Line
from ...model.gears import catalogue
from ...study.design.specification import DutySegment, Specification
from ..complaints import EXAMPLES as OF_PROJECTS
from ..complaints import complaints
from ..entries import Wrong, refusal, whole
from ..loop_fields import EXAMPLE_LOOP, Loop
from ..reading import ProjectError
from ..schema import (
    CATALOGUE,
    MOST_LINES,
    ErrorLine,
    Inertia,
    LimitSpec,
    Spec,
    Speed,
    Torque,
    quantity,
    read_accuracy,
    read_title,
)
from ..yaml_text import Keys, Problem, as_path, complaint, name, read, read_text

KIND = "specification"
MOST = 1000  # inertias of one kind, and segments
EXAMPLES = {
    "title": "Elbow of a robot",
    "load": "{inertias: [0.8 kg*m^2, 1.3 kg*m^2]}",
    "load.inertia": "1.3 kg*m^2",
    "load.inertias": "[0.8 kg*m^2, 1.3 kg*m^2]",
    "load.inertias[]": "1.3 kg*m^2",
    "speed": "{from: 2 rpm, to: 40 rpm}",
    "speed.from": "2 rpm",
    "speed.to": "40 rpm",
    "limit": "{oscillation: 60 arcsec}",
    "limit.oscillation": "60 arcsec",
    "motor": "{inertias: [0.5 kg*cm^2, 2 kg*cm^2]}",
    "motor.inertias": "[0.5 kg*cm^2, 2 kg*cm^2]",
    "motor.inertias[]": "2 kg*cm^2",
    "motor.loop": EXAMPLE_LOOP,
    "damping": "{ratio: 3 %}",
    "damping.ratio": "3 %",
    "duty": "[{torque: 60 N*m, speed: 20 rpm, duration: 2 s}]",
    "duty[]": "{torque: 60 N*m, speed: 20 rpm, duration: 2 s}",
    "duty[].torque": "60 N*m",
    "duty[].speed": "20 rpm",
    "duty[].duration": "2 s",
    "torque": "{mean: 40 N*m, peak: 90 N*m}",
    "torque.mean": "40 N*m",
    "torque.peak": "90 N*m",
    "torque.momentary": "200 N*m",
    "torque.preload": "5 N*m",
    "torque.average_speed": "15 rpm",
    "life": "10000 h",
    "largest": "{size: 40, mass: 3 kg}",
    "largest.size": "40",
    "largest.mass": "3 kg",
    "ratios": "[50, 80, 100]",
    "ratios[]": "50",
    "series": "[CSG]",
    "series[]": "CSG",
    "excitation": "{accuracy: catalogue}",
} | {
    field: text
    for field, text in OF_PROJECTS.items()
    if field.startswith(("excitation.accuracy", "excitation.kinematic_error"))
}


def _count(value: Any) -> int:
    found = whole(value, "write for example 50")
    if found < 1:
        raise ValueError(f"{value!r} is not positive; write a whole number from 1")
    return found


def _series(value: Any) -> str:
    known = sorted({gear.series for gear in catalogue.select()})
    if not isinstance(value, str) or value.upper() not in known:
        raise ValueError(f"{value!r} is no series of the catalogue; write one of {', '.join(known)}")
    return value.upper()


class LoadsSpec(Spec):
    """One load or several."""

    inertia: Inertia | None = None
    inertias: Annotated[list[Inertia], Field(min_length=1, max_length=MOST)] | None = None

    @check_model(mode="after")
    def _one_way(self) -> "LoadsSpec":
        if (self.inertia is None) == (self.inertias is None):
            raise ValueError("needs either one 'inertia' or a list 'inertias'; write {inertia: 1.3 kg*m^2}")
        return self


class RangeSpec(Spec):
    """Speeds of the load."""

    low: Speed = Field(alias="from")
    high: Speed = Field(alias="to")

    @check_model(mode="after")
    def _ascending(self) -> "RangeSpec":
        if self.low >= self.high:
            raise refusal(Wrong(("to",), "the range does not ascend; write the smaller speed after 'from'"))
        return self


class MotorsSpec(Spec):
    """Motors to choose from, and their loop; without one they are ideally held."""

    inertias: Annotated[list[Inertia], Field(min_length=1, max_length=MOST)]
    loop: Loop | None = None


class RatioSpec(Spec):
    """Damping of the gear as a share of the critical one on the held load."""

    ratio: Annotated[float, quantity("", "positive")]


class SegmentSpec(Spec):
    """A stretch of the duty cycle."""

    torque: Torque
    speed: Annotated[float, quantity("rad/s")]
    duration: Annotated[float, quantity("s", "positive")]


class TorquesSpec(Spec):
    """Torques of the load in place of a duty cycle, and what comes on top."""

    mean: Torque | None = None
    peak: Torque | None = None
    momentary: Torque | None = None
    preload: Torque = 0.0
    average_speed: Speed | None = None


class LargestSpec(Spec):
    """Room for the gear."""

    size: Annotated[int, BeforeValidator(_count)] | None = None
    mass: Annotated[float, quantity("kg", "positive")] | None = None


class ErrorSpec(Spec):
    """Kinematic error: an accuracy class, or lines."""

    accuracy: Annotated[Any, BeforeValidator(read_accuracy)] = None
    kinematic_error: Annotated[tuple[ErrorLine, ...], Field(max_length=MOST_LINES)] = ()

    @check_model(mode="after")
    def _one_way(self) -> "ErrorSpec":
        if self.accuracy is not None and self.kinematic_error:
            raise ValueError("gives an accuracy and the lines of a kinematic error; write one of them")
        return self


class SpecificationSpec(Spec):
    """The whole file."""

    title: Annotated[str, BeforeValidator(read_title)] = ""
    load: LoadsSpec
    speed: RangeSpec
    limit: LimitSpec
    motor: MotorsSpec
    damping: RatioSpec
    duty: Annotated[tuple[SegmentSpec, ...], Field(max_length=MOST)] = ()
    torque: TorquesSpec = TorquesSpec()
    life: Annotated[float, quantity("h", "positive")] | None = None
    largest: LargestSpec = LargestSpec()
    ratios: tuple[Annotated[int, BeforeValidator(_count)], ...] = ()
    series: tuple[Annotated[str, BeforeValidator(_series)], ...] = ()
    excitation: ErrorSpec = ErrorSpec()


def read_specification(path: str | Path) -> Specification:
    """Read a specification of a design.

    Parameters
    ----------
    path : str or Path
        YAML file of at most 256 KiB, see `examples/projects/elbow.yaml`.

    Raises
    ------
    ProjectError
        If the file cannot be read or specifies nothing; all problems found, one line each.
    """
    path = as_path(path)
    text = read_text(path, KIND)
    if isinstance(text, Problem):
        raise _error(path, [text])
    located = read(text)
    problems = list(located.problems)
    if located.content is None:
        if not problems:
            problems.append(Problem(1, 1, "file", f"is empty; begin with a line such as 'load: {EXAMPLES['load']}'"))
        raise _error(path, problems)
    try:
        spec = SpecificationSpec.model_validate(located.content)
    except ValidationError as error:
        raise _error(path, [*problems, *complaints(error, located, EXAMPLES)]) from None
    problems += [Problem(*located.place(keys), name(keys), said) for keys, said in _contradictions(spec)]
    if problems:
        raise _error(path, problems)
    return _resolved(spec, path)


def _contradictions(spec: SpecificationSpec) -> Iterator[tuple[Keys, str]]:
    torque = spec.torque
    if spec.duty and (torque.mean is not None or torque.peak is not None):
        yield ("torque",), "gives a mean or a peak, which the duty cycle gives already; remove one or the other"
    elif (torque.mean is None) != (torque.peak is None):
        yield ("torque",), "gives one of mean and peak; write both, for example {mean: 40 N*m, peak: 90 N*m}"
    elif abs(torque.mean or 0.0) > abs(torque.peak or 0.0):
        yield ("torque", "mean"), "is larger than the peak; exchange them, or check both"
    if spec.duty and not any(part.speed for part in spec.duty):
        yield ("duty",), "nothing turns in it; write the speed of at least one segment"


def _resolved(spec: SpecificationSpec, path: Path) -> Specification:
    lines = tuple(Line(line.order, line.amplitude, line.phase) for line in spec.excitation.kinematic_error)
    accuracy = spec.excitation.accuracy
    inertias = [*(spec.load.inertias or ()), *([] if spec.load.inertia is None else [spec.load.inertia])]
    return Specification(
        title=spec.title or path.stem,
        load_inertias=tuple(inertias),
        speeds=(spec.speed.low, spec.speed.high),
        limit=spec.limit.oscillation,
        motor_inertias=tuple(spec.motor.inertias),
        loop=spec.motor.loop,
        damping_ratio=spec.damping.ratio,
        duty=tuple(DutySegment(part.torque, part.speed, part.duration) for part in spec.duty),
        mean_torque=spec.torque.mean,
        peak_torque=spec.torque.peak,
        momentary_torque=spec.torque.momentary,
        preload=spec.torque.preload,
        average_speed=spec.torque.average_speed,
        life=spec.life,
        largest_size=spec.largest.size,
        largest_mass=spec.largest.mass,
        ratios=tuple(spec.ratios),
        series=tuple(spec.series),
        accuracy=None if accuracy == CATALOGUE else accuracy,
        kinematic_error=KinematicError(lines) if lines else None,
    )


def _error(path: Path, problems: list[Problem]) -> ProjectError:
    return ProjectError(complaint(path, problems))
