"""The table of a project file: a row for every field, with what it holds, an example and a sentence."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from ...base.quantities import checked
from ...drive.demands.motor_limits import MotorLimits
from ...drive.demands.move_task import Feedforward, Task
from ...drive.demands.payload import Payload
from ...model.gears import catalogue
from ...model.gears.gear import Gear
from ...model.laws.friction import LoadFriction
from ...model.laws.hysteresis import Parallel
from ...model.laws.springs import Play
from ...model.orders import BY_FIXED, LARGEST_RATIO
from ...model.oscillator import GearDamping, Variation
from ...study.move.profiles import AngleProfile, Dwell, SCurve, Trapezoid
from . import groups
from .csv_files import ProfileFile, read_profile, read_torque_curve
from .drive_units import DriveUnitsSpec
from .entries import DRAG, EXAMPLE_DRAG, EXAMPLE_HYSTERESIS, EXAMPLE_LOOP, GEAR_LAW, HYSTERESIS, RIPPLES, Loop
from .groups import ASSUMED, CATALOGUE, LINE, MEASURED, MOST_SOURCES, YOURS
from .kinds import FILE_NAME, Entry, Items, Kind, NotOfKind, Quantity, Row, Schema, Text, Word, Wrong
from .postures import EXAMPLE_POSTURES, PosturesKind
from .rows import Fields, Group, Typed, field, group_text, needed, rows_of

MOST_COUPLINGS = 4  # in series: each is a class of its own to the compiler
GEAR_FIELDS = ("name", "file", "law", "ratio", "rated_torque")  # of a gear: of the first three, or of the last three
EXAMPLE_RIPPLES = "[{order: 2, depth: 5 %}]"
COUPLING = "{inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}"

INERTIA = Quantity("kg*m**2", "positive")
SPEED = Quantity("rad/s", "positive")
ANGLE = Quantity("rad", "positive")
DAMPING = Quantity("N*m*s/rad", "not negative")


def _ratio(ratio: float, text: str) -> None:
    if ratio < 1.0:
        raise ValueError(f"{text!r} is less than 1; write motor turns per output turn, for example 50")
    if 1.0 < ratio < 1.0 + 1.0 / LARGEST_RATIO:
        raise ValueError(
            f"{text!r} is too close to 1; write 1, or the ratio of the teeth, for example 1.01 with a fixed wave "
            "generator"
        )


def _title(text: str) -> str:
    if len(text) > 200 or "\n" in text.strip():
        raise ValueError("is longer than one line of 200 characters; shorten it")
    if strange := next((c for c in text.strip() if not c.isprintable()), ""):
        raise ValueError(f"has the character U+{ord(strange):04X}, which cannot be printed; remove it")
    return text.strip()


TITLE = Text(_title, lambda: {"maxLength": 200})


class ExplicitGear(Group):
    """A gear given by its ratio and law."""

    ratio: float = needed(Quantity("", "positive", check=_ratio, ends=(("minimum", 1),)), "50",
        "Motor turns per output turn.")  # fmt: skip
    law: Any = needed(GEAR_LAW, "{type: cubic, K: 7160 N*m/rad, alpha: 0.1 1/rad^2}",
        "Torsion law of the gear: its type and its fields.")  # fmt: skip
    rated_torque: float | None = field(Quantity("N*m", "positive"), "178 N*m",
        "Rated torque: full load of the hysteresis loop, for a law with memory.")  # fmt: skip
    fixed: str | None = field(Word(tuple(BY_FIXED)), "flexspline",
        "Member that is fixed to the housing: `circular_spline` (flexspline out, ratio N, against the motor), "
        "`flexspline` (circular spline out, N + 1, with the motor), `wave_generator` (circular spline out, "
        "1 + 1/N).")  # fmt: skip


class NamedGear(Group):
    """A gear of the catalogue, or of a file of the user's own beside the project file, with a law of its own or not."""

    name: str = needed(Text(), "MY-40-50", "Name of the gear in the catalogue or in the file.")
    file: str | None = field(FILE_NAME, "my_gears.yaml", "File with gears of your own beside the project file.")
    law: Any = rows_of(ExplicitGear)["law"]._replace(needed=False)
    fixed: Any = rows_of(ExplicitGear)["fixed"]

    conditions: ClassVar[Schema] = {"anyOf": [{"required": [key]} for key in ("file", "law", "fixed")]}

    def check(self) -> Iterator[Wrong]:
        """Refuse a name that the catalogue does not have."""
        if self.file is None:
            gear = catalogue.gear(self.name)
            if self.law is None:
                gear.check_law()
        yield from ()


@dataclass(frozen=True)
class GearKind(Kind):
    """A gear by its name, or by a group that describes it in one of two ways."""

    groups = Fields(ExplicitGear), Fields(NamedGear)

    def _group(self, value: Any) -> Fields:
        return self.groups["file" in value or "name" in value]

    def read(self, value: object, entry: Entry) -> Any:
        if isinstance(value, str):
            gear = catalogue.gear(value)
            gear.check_law()
            return gear.name
        if not isinstance(value, dict):
            raise NotOfKind("a group of fields")
        given = [key for key in value if key in GEAR_FIELDS]
        named = {"name", "file"} & set(given)
        if (named and set(given) & {"ratio", "rated_torque"}) or (set(given) == {"name"} and "fixed" not in value):
            keys = " and ".join(given) if len(given) > 1 else "name alone"
            raise ValueError(
                f"gives {keys}; write 'gear: CSG-40-50' for a gear of the catalogue, {{name, law}} for its record with "
                "a measured law, {file, name} for one of your own, or {ratio, law}: hysteresis and backlash of any "
                "gear are fields beside 'gear'"
            )
        return self._group(value).read(value, entry)

    def schema(self) -> Schema:
        return {"anyOf": [{"enum": catalogue.names()}, *(group.schema() for group in self.groups)]}

    def text(self, value: object) -> str:
        return value if isinstance(value, str) else group_text(value)

    def part(self, value: object, key: str) -> Row | None:
        return self._group(value).part(value, key) if isinstance(value, dict) else None


class BacklashSpec(Group):
    """Backlash in series with the law of the gear; damping acts in the gap too."""

    half_gap: float = needed(ANGLE, "10 arcsec", "Half of the backlash, on the output side.")


SHEET = {"torque": "max_torque", "speed": "max_speed"}  # fields of the file by those of `MotorLimits`
CURVE_COLUMNS = {"peak_torque": "peak", "continuous_torque": "continuous"}
EXAMPLE_PEAK = "[[0 rpm, 3 N*m], [4000 rpm, 3 N*m], [6000 rpm, 1.5 N*m]]"
EXAMPLE_CONTINUOUS = "[[0 rpm, 1.3 N*m], [3000 rpm, 1.2 N*m], [6000 rpm, 0.6 N*m]]"


class MotorSpec(Group):
    """Motor: its inertia, its drive and its limits."""

    inertia: float | None = field(INERTIA, "4.5 kg*cm^2",
        "Inertia of motor and wave generator, on the motor side. Default: that of the catalogue's gear.")  # fmt: skip
    mode: Literal["free", "held"] = field(Word(("free", "held")), "held",
        "Motor with constant speed (held) or with given torque (free).", "held")  # fmt: skip
    loop: Any = field(Loop(), EXAMPLE_LOOP,
        "Loop of the motor, by bandwidth or by gains. Default: ideal (constant speed).")  # fmt: skip
    drag: Any = field(DRAG, EXAMPLE_DRAG, "Friction or cogging torque on the motor shaft.")
    max_torque: float | None = field(Quantity("N*m", "positive"), "3 N*m", "Largest torque of the motor.")
    max_speed: float | None = field(SPEED, "6000 rpm", "Largest speed of the motor.")
    peak_torque: Any = field(groups.TorqueCurve(), EXAMPLE_PEAK,
        "Peak torque over the speed (S3): points, or a CSV file with the columns speed and peak.")  # fmt: skip
    continuous_torque: Any = field(groups.TorqueCurve(), EXAMPLE_CONTINUOUS,
        "Continuous torque over the speed (S1): points, or a CSV file with columns speed, continuous.")  # fmt: skip
    rms_torque: float | None = field(Quantity("N*m", "positive"), "1.3 N*m",
        "Largest rms torque of the winding, at any speed.")  # fmt: skip
    rated_speed: float | None = field(SPEED, "3000 rpm", "Largest mean speed of the motor.")
    brake: float | None = field(Quantity("N*m", "positive"), "2 N*m", "Holding torque of the motor brake.")
    K_t: float | None = field(Quantity("N*m/A", "positive"), "0.12 N*m/A", "Torque constant of the motor.")
    drive_units: DriveUnitsSpec | None = field(DriveUnitsSpec, "{K_v: 0.1 1/s, K_p: 3e-4 N*m*s/rad, T_n: 0.01 ms}")

    def limits(self, folder: Path) -> MotorLimits | None:
        """Sheet of the motor, where the file gives a part of it, with curves of a folder's files (FileError)."""
        sheet = {name: getattr(self, SHEET.get(name, name)) for name in MotorLimits._fields}
        for name, column in CURVE_COLUMNS.items():
            if isinstance(sheet[name], str):
                sheet[name] = read_torque_curve(folder / sheet[name], column)
        numbers = {name: value for name, value in sheet.items() if value is not None}
        return MotorLimits(**numbers) if numbers else None

    @staticmethod
    def sheet_of(limits: MotorLimits | None) -> dict[str, Any]:
        """Fields of a sheet, None where nothing is known."""
        sheet = (limits or MotorLimits())._asdict().items()
        return {SHEET.get(name, name): None if value in (math.inf, ()) else value for name, value in sheet}

    @property
    def named(self) -> bool:
        """True where the file gives the mode or the loop of the motor."""
        return bool(self.given & {"mode", "loop"})


class CouplingSpec(Group):
    """Coupling or structure between gear and load: the inertia on the gear's side, then a law and its damping."""

    inertia: float = needed(INERTIA, "0.1 kg*m^2", "Inertia on the gear's side of the coupling.")
    B: float = field(DAMPING, "5 N*m*s/rad", "Damping of the coupling.", 0.0)
    law: Any = needed(GEAR_LAW, "{type: linear, K: 2e5 N*m/rad}", "Torsion law of the coupling.")


class LoadSpec(Group):
    """The load."""

    inertia: float = needed(INERTIA, "1.3 kg*m^2", "Inertia of the load, on the output side.")
    drag: Any = field(DRAG, "{type: angle_torque, amplitude: 40 N*m}",
        "Friction, gravity or imbalance torque on the load.")  # fmt: skip
    coupling: CouplingSpec | None = field(CouplingSpec, COUPLING, "Coupling or structure between gear and load.")
    couplings: tuple[CouplingSpec, ...] | None = field(Items(Fields(CouplingSpec), 1, MOST_COUPLINGS),
        f"[{COUPLING}]", "Couplings in series, starting at the gear.")  # fmt: skip

    conditions: ClassVar[Schema] = {"not": {"required": ["coupling", "couplings"]}}

    @property
    def chain(self) -> tuple[CouplingSpec, ...]:
        """Couplings in series, starting at the gear."""
        return self.couplings or (() if self.coupling is None else (self.coupling,))

    def check(self) -> Iterator[Wrong]:
        """Refuse both."""
        if self.coupling is not None and self.couplings is not None:
            yield Wrong((), "gives coupling and couplings; write one coupling, or all of them in 'couplings'")


def one_of(*choices: tuple[str, ...]) -> Schema:
    """Condition of a JSON Schema that the fields of exactly one choice are given."""
    return {"oneOf": [{"required": list(fields)} for fields in choices]}


class DampingSpec(Group):
    """Damping across the spring: exactly one of B, ratio, quality."""

    B: float | None = field(DAMPING, "10 N*m*s/rad", "Damping coefficient.")
    ratio: float | None = field(Quantity("", "not negative"), "0.02",
        "Damping ratio (fraction of critical damping), with the stiffness at zero torque.")  # fmt: skip
    quality: float | None = field(Quantity("", "positive"), "25", "Quality factor, 1/(2 ratio).")
    ripples: Variation | None = field(RIPPLES, EXAMPLE_RIPPLES, "Lines of the damping over the base angle.")
    warming: float = field(Quantity("K"), "20 K", "Temperature rise above the temperature of the given damping.", 0.0)
    per_kelvin: float = field(Quantity("1/K"), "0.035 1/K",
        "Relative decrease of the damping per kelvin.", GearDamping._field_defaults["per_kelvin"])  # fmt: skip
    fast: float = field(Quantity("", "not negative"), "0.5",
        "Damping factor far above the torsion speed v_fast.", 1.0)  # fmt: skip
    v_fast: float = field(SPEED, "1 rad/s", "Speed of the torsion about which the damping changes.", 1.0)

    conditions: ClassVar[Schema] = one_of(("B",), ("ratio",), ("quality",))

    @property
    def varies(self) -> bool:
        """True for a damping of more than one number."""
        return bool(self.given - {"B", "ratio", "quality"})

    def of(self, B: float) -> GearDamping:
        """The damping as an object of the model, of the size B [N*m*s/rad]."""
        parts: Any = {} if self.ripples is None else {"variation": self.ripples}
        heat = {"warming": self.warming, "per_kelvin": self.per_kelvin}
        return GearDamping(B, **heat, fast=self.fast, v_fast=self.v_fast, **parts)

    def check(self) -> Iterator[Wrong]:
        """Refuse several sizes, or none, and a variation that is none."""
        sizes = self.given & {"B", "ratio", "quality"}
        if len(sizes) != 1:
            given = " and ".join(sorted(sizes)) or "nothing"
            yield Wrong((), f"gives {given}; write exactly one of B, ratio, quality")
        checked(self.of(self.B or 0.0))


class StiffnessSpec(Group):
    """Variation of the stiffness with the base angle."""

    ripples: Variation = needed(RIPPLES, EXAMPLE_RIPPLES, "Lines of the stiffness over the base angle.")


class SpeedSpec(Group):
    """Speeds of one shaft: a range from and to, or a list at."""

    from_: float | None = field(Quantity("rad/s", "not negative"), "100 rpm",
        "Lower end of the range; for 0, 1 % of the upper end is used.")  # fmt: skip
    to: float | None = field(SPEED, "3000 rpm", "Upper end of the range.")
    at: tuple[float, ...] | None = field(Items(SPEED, 1, 100), "[1000 rpm, 2000 rpm]",
        "Single speeds instead of a range.")  # fmt: skip
    shaft: Literal["motor", "load", "forcing"] = needed(Word(("motor", "load", "forcing")), "motor",
        "Shaft of these speeds; forcing means the frequency of the excitation itself.")  # fmt: skip

    conditions: ClassVar[Schema] = one_of(("from", "to", "shaft"), ("at", "shaft"))

    def check(self) -> Iterator[Wrong]:
        """Refuse both a range and a list, neither, and half a range."""
        if (self.at is None) == (self.from_ is None and self.to is None):
            yield Wrong((), "needs either a range 'from' and 'to' or a list 'at'; write {from: 100 rpm, to: 3000 rpm}")
        elif self.at is None and (self.from_ is None or self.to is None):
            yield Wrong((), "has one end of the range only; write both 'from' and 'to'")
        elif self.from_ is not None and self.to is not None:
            yield from groups.ascending(self.from_, self.to, "speed")


class LimitSpec(Group):
    """Limits of the error of the drive."""

    oscillation: float = needed(ANGLE, "60 arcsec", "Limit of the error about its mean, in a steady motion.")


PARTS = {"trapezoid": Trapezoid, "s_curve": SCurve, "dwell": Dwell, "angle_profile": ProfileFile}
PART = Typed(lambda: PARTS, "part")
PAYLOAD = Fields(Payload, "payload")


class MoveSpec(Group):
    """A move of the load."""

    profile: tuple[Any, ...] = needed(Items(PART, 1, 1000), "[{type: trapezoid, angle: 90 deg, time: 0.6 s}]",
        "Parts of the profile, one after the other.")  # fmt: skip
    start: float | None = field(Quantity("rad"), "-45 deg", "Angle of the load at the start.")
    payload: Payload | None = field(PAYLOAD, "{mass: 2 kg, radius: 0.4 m}", "Payload of the load.")
    window: float | None = field(ANGLE, "30 arcsec", "Settling window about the final angle of the load.")
    feedforward: Feedforward | None = field(
        Feedforward, "{acceleration: 100 %, gravity: 90 %}",
        "Feedforward of the motor torque, as fractions of the torque that the model requires.")  # fmt: skip

    def task(self, folder: Path) -> Task:
        """Task of the move, its files read from a folder (FileError)."""
        parts = (read_profile(folder / part.file) if isinstance(part, ProfileFile) else part for part in self.profile)
        files = tuple(part.file if isinstance(part, ProfileFile) else "" for part in self.profile)
        return Task(tuple(parts), self.start, self.payload, self.window, files, self.feedforward)

    @staticmethod
    def of(task: Task) -> "MoveSpec":
        """The group of a task; ValueError if a part is an `AngleProfile` of no file, which a project file lacks."""
        parts = [ProfileFile(file) if file else part for part, file in zip(task.profile, task.files, strict=True)]
        if any(isinstance(part, AngleProfile) for part in parts):
            fault = "a project file holds an AngleProfile as a CSV file beside it; write one and name it there"
            raise ValueError(fault)
        more = task._asdict() | {"profile": parts}
        return MoveSpec(**{key: item for key, item in more.items() if key != "files"})


class ProjectSpec(Group):
    """The whole project file."""

    title: str = field(TITLE, "Azimuth axis", "Title of the report, one line. Default: the name of the file.", "")
    revision: str = field(TITLE, "B, 2026-11-26, A. Meier", "Revision, date and author, one line, for reports.", "")
    gear: str | ExplicitGear | NamedGear = needed(GearKind(), "CSG-40-50",
        "Name of a gear of the catalogue, or a group that describes a gear.")  # fmt: skip
    hysteresis: Any = field(HYSTERESIS, EXAMPLE_HYSTERESIS,
        "Hysteresis or friction of the gear, parallel to its law; catalogue uses its hysteresis loss.")  # fmt: skip
    backlash: BacklashSpec | None = field(BacklashSpec, "{half_gap: 10 arcsec}")
    load_friction: float | str | None = field(
        Quantity("", "not negative", CATALOGUE, lambda mu, _: checked(LoadFriction(mu))),
        "5 %",
        "Friction of the meshing as a fraction of the torque, or catalogue (from the catalogue's efficiency).",
    )
    motor: MotorSpec = field(MotorSpec, f"{{inertia: 4.5 kg*cm^2, loop: {EXAMPLE_LOOP}}}", default=MotorSpec())
    controller: groups.ControllerSpec | None = field(groups.ControllerSpec,
        "{period: 250 us, delay: 250 us, motor_encoder: 16 bit, load_encoder: 24 bit}")  # fmt: skip
    load: LoadSpec = needed(LoadSpec, "{inertia: 1.3 kg*m^2}")
    damping: DampingSpec = needed(DampingSpec, "{ratio: 0.02}")
    stiffness: StiffnessSpec | None = field(StiffnessSpec, f"{{ripples: {EXAMPLE_RIPPLES}}}")
    speed: SpeedSpec = needed(SpeedSpec, "{from: 100 rpm, to: 3000 rpm, shaft: motor}")
    excitation: groups.ExcitationSpec = needed(groups.ExcitationSpec, f"{{kinematic_error: [{LINE}]}}")
    limit: LimitSpec | None = field(LimitSpec, "{oscillation: 60 arcsec}")
    move: MoveSpec | None = field(MoveSpec, "{profile: [{type: trapezoid, angle: 90 deg, time: 0.6 s}]}")
    postures: Any = field(PosturesKind(), EXAMPLE_POSTURES,
        "Loads of the drive in postures of the machine: rows, a CSV file, or links and angles of an arm.")  # fmt: skip
    scatter: dict[str, float] | None = field(
        groups.Named(groups.Deviation()),
        "{load.inertia: 5 %}",
        "Standard deviations by field name of this file: relative values; for phases, angles.",
    )
    scatter_correlation: tuple[tuple[float, ...], ...] | None = field(groups.Correlation(), "[[1, -0.5], [-0.5, 1]]",
        "Correlation matrix of the numbers of scatter, in their order.")  # fmt: skip
    sources: dict[str, str] | None = field(
        groups.Named(Word((YOURS, ASSUMED, MEASURED, CATALOGUE)), MOST_SOURCES), "{damping: assumed}",
        "Sources of numbers or groups of this file; a number without a source is yours.")  # fmt: skip

    def ratio(self, gear: Gear | None) -> float:
        """Motor turns per output turn: of an explicit gear, or of a record with the member that is fixed."""
        fixed = getattr(self.gear, "fixed", None)
        record = self.gear if isinstance(self.gear, ExplicitGear) else gear
        if record is None:
            raise ValueError(f"the catalogue has no gear {self.gear!r}")
        if record is self.gear or not fixed:
            return float(record.ratio)
        return abs(float(BY_FIXED[fixed].ratio(record.ratio)))

    def law(self, gear: Gear | None) -> Any:
        """Torsion law: that of the gear or its record, with the backlash in series and the hysteresis in parallel."""
        given = None if isinstance(self.gear, str) else self.gear.law
        law = (gear and gear.law) if given is None else given
        if self.backlash is not None:
            law = Play(self.backlash.half_gap, law)
        beside = HYSTERESIS.beside(self.hysteresis, gear)
        return law if beside is None else Parallel(law, beside)
