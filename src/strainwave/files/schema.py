"""What a project file may contain: pydantic models with numbers in SI, and sentences for what is wrong.

Laws, control loops and variations are objects of the model, which `entries` reads.
"""

import re
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag
from pydantic import model_validator as check_model

from ..base.quantities import checked
from ..drive.asked import MotorLimits
from ..model.gears import catalogue
from ..model.gears.gear import Gear
from ..model.laws.hysteresis import Parallel
from ..model.laws.meshing import LoadFriction
from ..model.laws.springs import Play
from ..model.varying import GearDamping
from .controller import Controller
from .entries import Wrong, about, deviation, number, phase, read_ripples, refusal, whole
from .law_fields import Drag, GearLaw, Hysteresis
from .loop_fields import Loop
from .move_fields import ReadPart, ReadPayload
from .yaml_text import shown

MOST_LINES = 64
SAME, NO_VARIANCE = 1e-9, 1e-5  # of correlations: equal, and what their rounding may do to a variance
MOST_COUPLINGS = 4  # in series: each is a class of its own to the compiler
WAYS = ("name", "file", "law", "ratio", "rated_torque")  # to give a gear: of the first three, or of the last three
CATALOGUE = "catalogue"  # in place of an accuracy: the one that the gear's record gives


def _ratio(value: Any) -> float:
    ratio = number(value, "", "positive")
    if ratio < 1.0:
        raise ValueError(f"{value!r} is less than 1; write motor turns per output turn, for example 50")
    return ratio


def _order(value: Any) -> int:
    order = whole(value, "write how often the line repeats per turn, for example 2")
    if not 1 <= order <= 1000:
        raise ValueError(f"{value!r} is not between 1 and 1000; a constant part belongs in 'mean'")
    return order


def read_title(value: Any) -> Any:
    """Read a title of one line (ValueError)."""
    if isinstance(value, str) and (len(value) > 200 or "\n" in value.strip()):
        raise ValueError("is longer than one line of 200 characters; shorten it")
    if isinstance(value, str) and (strange := next((c for c in value.strip() if not c.isprintable()), "")):
        raise ValueError(f"has the character U+{ord(strange):04X}, which cannot be printed; remove it")
    return value.strip() if isinstance(value, str) else value


def _file_name(value: Any) -> Any:
    if isinstance(value, str) and re.search(r"[/\\:]|^\.", value):
        raise ValueError(f"{shown(value)} is no plain file name; put the gear file beside the project file")
    return value


def quantity(unit: str, sign: str = "any") -> BeforeValidator:
    """Reader of a number in a unit, with a sign as `number` takes it."""
    return BeforeValidator(partial(number, unit=unit, sign=sign))


Ripples = Annotated[Any, BeforeValidator(read_ripples)]


Inertia = Annotated[float, quantity("kg*m**2", "positive")]
Speed = Annotated[float, quantity("rad/s", "positive")]
SpeedOrRest = Annotated[float, quantity("rad/s", "not negative")]
Phase = Annotated[float, BeforeValidator(phase)]
Torque = Annotated[float, quantity("N*m")]
Order = Annotated[int, BeforeValidator(_order)]


class Spec(BaseModel):
    """A mapping of the project file; unknown fields, infinities and NaN are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


class ExplicitGear(Spec):
    """A gear given by its ratio and law."""

    ratio: Annotated[float, BeforeValidator(_ratio)]
    law: GearLaw
    rated_torque: Annotated[float, quantity("N*m", "positive")] | None = None


class NamedGear(Spec):
    """A gear of the catalogue, or of a file of the user's own beside the project file, with a law of its own or not."""

    name: str
    file: Annotated[str, BeforeValidator(_file_name)] | None = None
    law: GearLaw | None = None

    @check_model(mode="after")
    def _is_known(self) -> "NamedGear":
        if self.file is None:
            catalogue.gear(self.name)
        return self


def _known_gear(value: str) -> str:
    gear = catalogue.gear(value)
    gear.check_law()
    return gear.name


def _one_gear(value: Any) -> Any:
    """Pass a gear that is given in one way."""
    given = [key for key in value if key in WAYS] if isinstance(value, dict) else []
    named = {"name", "file"} & set(given)
    if (named and set(given) & {"ratio", "rated_torque"}) or set(given) == {"name"}:
        said = " and ".join(given) if len(given) > 1 else "name alone"
        raise ValueError(
            f"gives {said}; write 'gear: CSG-40-50' for a gear of the catalogue, {{name, law}} for its record with a "
            "measured law, {file, name} for one of your own, or {ratio, law}: hysteresis and backlash of any gear are "
            "fields beside 'gear'"
        )
    return value


def _gear_kind(value: Any) -> str:
    if isinstance(value, str):
        return "name"
    return "named" if isinstance(value, dict) and ("file" in value or "name" in value) else "explicit"


class BacklashSpec(Spec):
    """Play in series with the gear's law."""

    half_gap: Annotated[float, quantity("rad", "positive")]


class MotorSpec(Spec):
    """What turns with the motor shaft, the wave generator included, and whether the motor keeps its speed."""

    inertia: Inertia | None = None
    mode: Literal["free", "held"] = "held"
    loop: Loop | None = None
    drag: Drag | None = None
    max_torque: Annotated[float, quantity("N*m", "positive")] | None = None
    max_speed: Annotated[float, quantity("rad/s", "positive")] | None = None

    @property
    def limits(self) -> MotorLimits | None:
        """Largest torque and speed of the motor, where the file gives one of them."""
        given = {"torque": self.max_torque, "speed": self.max_speed}
        known = {name: value for name, value in given.items() if value is not None}
        return MotorLimits(**known) if known else None

    @property
    def named(self) -> bool:
        """Whether the file says how the motor is driven."""
        return bool(self.model_fields_set & {"mode", "loop"})


class CouplingSpec(Spec):
    """What lies between the gear and the load: the inertia on the gear's side, then a law and its damping."""

    inertia: Inertia
    B: Annotated[float, quantity("N*m*s/rad", "not negative")] = 0.0
    law: GearLaw


class LoadSpec(Spec):
    """The load."""

    inertia: Inertia
    drag: Drag | None = None
    coupling: CouplingSpec | None = None
    couplings: Annotated[list[CouplingSpec], Field(min_length=1, max_length=MOST_COUPLINGS)] | None = None

    @property
    def chain(self) -> list[CouplingSpec]:
        """Couplings in series, from the gear on."""
        return self.couplings or ([] if self.coupling is None else [self.coupling])

    @check_model(mode="after")
    def _one_way(self) -> "LoadSpec":
        if self.coupling is not None and self.couplings is not None:
            raise ValueError("gives coupling and couplings; write one coupling, or all of them in 'couplings'")
        return self


class DampingSpec(Spec):
    """Damping across the spring, given in one of three ways, and how it varies: the fields of `GearDamping`."""

    B: Annotated[float, quantity("N*m*s/rad", "not negative")] | None = None
    ratio: Annotated[float, quantity("", "not negative")] | None = None
    quality: Annotated[float, quantity("", "positive")] | None = None

    ripples: Ripples | None = None
    warming: Annotated[float, quantity("K")] = 0.0
    per_kelvin: Annotated[float, quantity("1/K")] = GearDamping._field_defaults["per_kelvin"]
    fast: Annotated[float, quantity("", "not negative")] = 1.0
    v_fast: Annotated[float, quantity("rad/s", "positive")] = 1.0

    @property
    def varies(self) -> bool:
        """Whether it is more than one number."""
        return bool(self.model_fields_set - {"B", "ratio", "quality"})

    def of(self, B: float) -> GearDamping:
        """The damping as an object of the model, of the size B [N*m*s/rad]."""
        parts = {} if self.ripples is None else {"variation": self.ripples}
        numbers = {name: getattr(self, name) for name in ("warming", "per_kelvin", "fast", "v_fast")}
        return GearDamping(B, **numbers, **parts)

    @check_model(mode="after")
    def _one(self) -> "DampingSpec":
        ways = self.model_fields_set & {"B", "ratio", "quality"}
        if len(ways) != 1:
            given = " and ".join(sorted(ways)) or "nothing"
            raise ValueError(f"gives {given}; write exactly one of B, ratio, quality")
        try:
            checked(self.of(self.B or 0.0))
        except ValueError as error:
            raise refusal(about(error, GearDamping, self.model_fields_set)) from error
        return self


class StiffnessSpec(Spec):
    """How the stiffness varies with the base angle."""

    ripples: Ripples


class SpeedSpec(Spec):
    """Speeds of one shaft: a range or a list."""

    shaft: Literal["motor", "load", "forcing"]
    low: Annotated[SpeedOrRest | None, Field(alias="from")] = None
    high: Annotated[Speed | None, Field(alias="to")] = None
    at: Annotated[list[Speed], Field(min_length=1, max_length=100)] | None = None

    @check_model(mode="after")
    def _range_or_list(self) -> "SpeedSpec":
        if (self.at is None) == (self.low is None and self.high is None):
            raise ValueError("needs either a range 'from' and 'to' or a list 'at'; write {from: 100 rpm, to: 3000 rpm}")
        if self.at is None and (self.low is None or self.high is None):
            raise ValueError("has one end of the range only; write both 'from' and 'to'")
        if self.low is not None and self.high is not None and self.low >= self.high:
            raise refusal(Wrong(("to",), "the range does not ascend; write the smaller speed after 'from'"))
        return self


class ErrorLine(Spec):
    """One line of the kinematic error."""

    order: Order
    amplitude: Annotated[float, quantity("rad", "not negative")]
    phase: Phase = 0.0


class TorqueLine(Spec):
    """One line of a torque."""

    order: Order
    amplitude: Annotated[float, quantity("N*m", "not negative")]
    phase: Phase = 0.0


class TorqueRange(Spec):
    """A mean torque that lies anywhere between two, as that of gravity on an arm does."""

    low: Torque = Field(alias="from")
    high: Torque = Field(alias="to")

    @check_model(mode="after")
    def _ascending(self) -> "TorqueRange":
        if self.low >= self.high:
            raise refusal(Wrong(("to",), "the range does not ascend; write the smaller torque after 'from'"))
        return self


class TorqueSpec(Spec):
    """A torque: its mean and its lines."""

    mean: Torque = 0.0
    lines: Annotated[list[TorqueLine], Field(max_length=MOST_LINES)] = []


class LoadTorqueSpec(Spec):
    """A torque on the load: its mean, or the range in which that lies, and its lines."""

    mean: Annotated[
        Annotated[Torque, Tag("one")] | Annotated[TorqueRange, Tag("range")],
        Discriminator(lambda value: "range" if isinstance(value, dict | TorqueRange) else "one"),
    ] = 0.0
    lines: Annotated[list[TorqueLine], Field(max_length=MOST_LINES)] = []


def _load_friction(value: Any) -> Any:
    """Read a share of the transmitted torque, or the word for that of the catalogue's efficiency."""
    if value == CATALOGUE:
        return value
    mu = number(value, "", "not negative")
    return checked(LoadFriction(mu)).mu


def read_accuracy(value: Any) -> Any:
    """Read an accuracy [rad], or the word for that of the catalogue (ValueError)."""
    return value if value == CATALOGUE else number(value, "rad", "positive")


class ExcitationSpec(Spec):
    """What drives the error; `accuracy` in place of lines is the gear's accuracy class, peak-to-peak."""

    accuracy: Annotated[float | Literal["catalogue"] | None, BeforeValidator(read_accuracy)] = None
    kinematic_error: Annotated[list[ErrorLine], Field(max_length=MOST_LINES)] = []
    motor_torque: TorqueSpec | None = None
    load_torque: LoadTorqueSpec | None = None


class LimitSpec(Spec):
    """What the drive may have at most."""

    oscillation: Annotated[float, quantity("rad", "positive")]


class MoveSpec(Spec):
    """A move of the load: its profile part by part."""

    profile: Annotated[list[ReadPart], Field(min_length=1, max_length=1000)]
    start: Annotated[float, quantity("rad")] | None = None
    payload: ReadPayload | None = None
    window: Annotated[float, quantity("rad", "positive")] | None = None


Deviation = Annotated[Any, BeforeValidator(deviation)]  # a float, or `Radians`, which pydantic would make one


def _correlation(rows: Any) -> tuple[tuple[float, ...], ...]:
    """Read a correlation matrix: equal on both sides of its diagonal of ones, and no variance below zero."""
    if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
        raise ValueError("is no list of rows; write for example [[1, -0.5], [-0.5, 1]]")
    given = tuple(tuple(number(value, "") for value in row) for row in rows)
    if any(len(row) != len(given) for row in given):
        raise ValueError(f"has {len(given)} rows, not all with {len(given)} numbers; write one for each of 'scatter'")
    matrix = np.array(given)
    if np.any(np.abs(matrix - matrix.T) > SAME) or np.any(np.abs(np.diag(matrix) - 1.0) > SAME):
        raise ValueError(
            "is not the same on both sides of a diagonal of ones; write for example [[1, -0.5], [-0.5, 1]]"
        )
    if len(given) and (least := float(np.linalg.eigvalsh(matrix)[0])) < -NO_VARIANCE:
        raise ValueError(
            f"gives a sum of the numbers a variance of {least:.2g}, below zero; write smaller correlations"
        )
    return given


class ProjectSpec(Spec):
    """The whole project file."""

    title: Annotated[str, BeforeValidator(read_title)] = ""
    gear: Annotated[
        Annotated[str, BeforeValidator(_known_gear), Tag("name")]
        | Annotated[ExplicitGear, Tag("explicit")]
        | Annotated[NamedGear, Tag("named")],
        Discriminator(_gear_kind),
        BeforeValidator(_one_gear),
    ]
    hysteresis: Hysteresis | None = None
    backlash: BacklashSpec | None = None
    load_friction: Annotated[float | Literal["catalogue"] | None, BeforeValidator(_load_friction)] = None
    motor: MotorSpec = MotorSpec()
    controller: Controller | None = None
    load: LoadSpec
    damping: DampingSpec
    stiffness: StiffnessSpec | None = None
    speed: SpeedSpec
    excitation: ExcitationSpec
    limit: LimitSpec | None = None
    move: MoveSpec | None = None
    scatter: Annotated[dict[str, Deviation], Field(min_length=1, max_length=32)] | None = None
    scatter_correlation: Annotated[tuple[tuple[float, ...], ...], BeforeValidator(_correlation)] | None = None

    def law(self, gear: Gear | None) -> Any:
        """Torsion law: that of the gear or its record, with the backlash in series and the hysteresis in parallel."""
        own = None if isinstance(self.gear, str) else self.gear.law
        law = (gear and gear.law) if own is None else own
        if self.backlash is not None:
            law = Play(self.backlash.half_gap, law)
        return law if self.hysteresis is None else Parallel(law, self.hysteresis)
