"""What a project file may contain: pydantic models with numbers in SI, and sentences for what is wrong.

The laws and their fields are read from the NamedTuples of `model.laws` and `model.measured`: a new law is known here
without a line of code.
"""

import re
from collections.abc import Callable
from functools import cache, partial
from typing import Annotated, Any, ClassVar, Literal, Union, get_args, get_type_hints

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, create_model
from pydantic import model_validator as check_model
from pydantic_core import PydanticCustomError

from ..model import catalogue, laws, measured
from ..quantities import checked, parse
from .yaml_text import Keys, kind_of, shown

Sign = Literal["any", "positive", "not negative"]
MOST_LINES = 64
CATALOGUE = "catalogue"  # in place of an accuracy: the one that the gear's record gives


def _at(keys: Keys, sentence: str) -> PydanticCustomError:
    """Error that belongs to a field below the one that is being validated."""
    return PydanticCustomError("at", "{sentence}", {"keys": keys, "sentence": sentence})


def _number(value: Any, unit: str, sign: Sign = "any") -> float:
    if not isinstance(value, str):
        raise ValueError(f"is {kind_of(value)}, not a number with its unit")
    number = parse(value, unit)
    if sign == "positive" and number <= 0.0:
        raise ValueError(f"{value!r} is not positive; write a value above zero")
    if sign == "not negative" and number < 0.0:
        raise ValueError(f"{value!r} is negative; write zero or more")
    if number and not 1e-30 < abs(number) < 1e30:
        raise ValueError(f"{value!r} is beyond any drive; check the number and its unit")
    return number


def _ratio(value: Any) -> float:
    number = _number(value, "", "positive")
    if number < 1.0:
        raise ValueError(f"{value!r} is less than 1; write motor turns per output turn, for example 50")
    return number


def _order(value: Any) -> int:
    if not isinstance(value, str) or not re.fullmatch(r"[+-]?[0-9]{1,9}", value.strip()):
        raise ValueError(
            f"{shown(value)} is not a whole number; write how often the line repeats per turn, for example 2"
        )
    number = int(value)
    if not 1 <= number <= 1000:
        raise ValueError(f"{value!r} is not between 1 and 1000; a constant part belongs in 'mean'")
    return number


def _title(value: Any) -> Any:
    if isinstance(value, str) and (len(value) > 200 or "\n" in value.strip()):
        raise ValueError("is longer than one line of 200 characters; shorten it")
    return value.strip() if isinstance(value, str) else value


def _file_name(value: Any) -> Any:
    if isinstance(value, str) and re.search(r"[/\\:]|^\.", value):
        raise ValueError(f"{shown(value)} is no plain file name; put the gear file beside the project file")
    return value


def _quantity(unit: str, sign: Sign = "any") -> BeforeValidator:
    return BeforeValidator(partial(_number, unit=unit, sign=sign))


Inertia = Annotated[float, _quantity("kg*m**2", "positive")]
Speed = Annotated[float, _quantity("rad/s", "positive")]
Angle = Annotated[float, _quantity("rad")]
Torque = Annotated[float, _quantity("N*m")]
Order = Annotated[int, BeforeValidator(_order)]


class Spec(BaseModel):
    """A mapping of the project file; unknown fields, infinities and NaN are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


class LawSpec(Spec):
    """A torsion law; one subclass for each class of `model.laws` and `model.measured`."""

    cls: ClassVar[type]

    @check_model(mode="after")
    def _physical(self) -> "LawSpec":
        law = self.model()
        if not law.breakpoints() and not law.stiffness(0.0) > 0.0:
            raise ValueError(f"the stiffness at rest is {law.stiffness(0.0):g} N*m/rad; it must be positive")
        return self

    def model(self) -> Any:
        """Return the law as the model object."""
        given = {name: getattr(self, name) for name in law_fields(self.cls)}
        inner = {name: value.model() for name, value in given.items() if isinstance(value, LawSpec)}
        make = measured.tabulated if self.cls is measured.Tabulated else self.cls
        return checked(make(**given | inner))


def _coefficients(value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or not 2 <= len(value) <= 16:
        raise ValueError(f"is {kind_of(value)}; write 2 to 16 coefficients, for example [0 N*m, 7160 N*m/rad]")
    numbers = []
    for power, text in enumerate(value):
        try:
            numbers.append(_number(text, ("N*m", "N*m/rad")[power] if power < 2 else f"N*m/rad**{power}"))
        except ValueError as error:
            raise _at((power,), str(error)) from None
    return tuple(numbers)


def _points(value: Any) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list):
        raise ValueError(f"is {kind_of(value)}; write {EXAMPLE_POINTS}")
    points = []
    for i, pair in enumerate(value):
        if not isinstance(pair, list) or len(pair) != 2:
            raise _at((i,), "is no pair of a torsion and a torque; write [0.54 mrad, 54 N*m]")
        numbers = []
        for j, unit in enumerate(("rad", "N*m")):
            try:
                numbers.append(_number(pair[j], unit))
            except ValueError as error:
                raise _at((i, j), str(error)) from None
        points.append((numbers[0], numbers[1]))
    return tuple(points)


EXAMPLE_POINTS = "points such as [[-1 mrad, -90 N*m], [0 mrad, 0 N*m], [1 mrad, 100 N*m]]"


def law_fields(cls: type) -> tuple[str, ...]:
    """Fields of a law in a project file: those of its class, but a table is given by its points."""
    return ("points",) if cls is measured.Tabulated else tuple(cls._fields)  # type: ignore[attr-defined]


def _law_fields(cls: type) -> dict[str, Any]:
    """Fields of a law's model: stiffness and torque limits positive, a gap not negative, the rest free."""
    if cls is measured.Tabulated:
        return {"points": (Annotated[tuple[tuple[float, float], ...], BeforeValidator(_points)], ...)}
    signs: dict[str, Sign] = {"N*m/rad": "positive", "N*m": "positive", "rad": "not negative"}
    fields: dict[str, Any] = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        if hint is Any:
            fields[name] = (Annotated[Any, _AnyLaw(inner=True)], ...)
        elif hint == tuple[float, ...]:
            fields[name] = (Annotated[tuple[float, ...], BeforeValidator(_coefficients)], ...)
        else:
            unit = get_args(hint)[1]
            fields[name] = (Annotated[float, _quantity(unit, signs.get(unit, "any"))], ...)
    return fields


@cache
def law_types() -> dict[str, type]:
    """Torsion laws by their name in a project file: "cubic" is `Cubic`, "piecewise_linear" `PiecewiseLinear`."""
    found = [c for m in (laws, measured) for c in vars(m).values() if isinstance(c, type) and hasattr(c, "stiffness")]
    return {re.sub(r"(?<=[a-z])(?=[A-Z])", "_", c.__name__).lower(): c for c in found}


class _AnyLaw:
    """Marker that makes pydantic choose the law's model by its `type`; a law inside another holds no third."""

    def __init__(self, inner: bool = False) -> None:
        self.inner = inner

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], Any]) -> Any:
        models = []
        for name, cls in law_types().items():
            if self.inner and "law" in law_fields(cls):
                continue
            model = create_model(
                f"{cls.__name__}Spec", __base__=LawSpec, **{"type": (Literal[name], ...)} | _law_fields(cls)
            )
            model.cls = cls
            models.append(model)
        return handler(Annotated[Union[tuple(models)], Field(discriminator="type")])  # noqa: UP007


class ExplicitGear(Spec):
    """A gear given by its ratio and law."""

    ratio: Annotated[float, BeforeValidator(_ratio)]
    law: Annotated[Any, _AnyLaw()]


class OwnGear(Spec):
    """A gear from a file of the user's own that lies beside the project file."""

    file: Annotated[str, BeforeValidator(_file_name)]
    name: str


def _known_gear(value: str) -> str:
    gear = catalogue.gear(value)
    gear.check_law()
    return gear.name


def _gear_kind(value: Any) -> str:
    if isinstance(value, str):
        return "name"
    return "own" if isinstance(value, dict) and ("file" in value or "name" in value) else "explicit"


class MotorSpec(Spec):
    """What turns with the motor shaft, the wave generator included, and whether the motor keeps its speed."""

    inertia: Inertia | None = None
    mode: Literal["free", "held"] = "held"


class LoadSpec(Spec):
    """The load."""

    inertia: Inertia


class DampingSpec(Spec):
    """Damping across the spring, given in one of three ways."""

    B: Annotated[float, _quantity("N*m*s/rad", "not negative")] | None = None
    ratio: Annotated[float, _quantity("", "not negative")] | None = None
    quality: Annotated[float, _quantity("", "positive")] | None = None

    @check_model(mode="after")
    def _one(self) -> "DampingSpec":
        if len(self.model_fields_set) != 1:
            given = " and ".join(sorted(self.model_fields_set)) or "nothing"
            raise ValueError(f"gives {given}; write exactly one of B, ratio, quality")
        return self


class SpeedSpec(Spec):
    """Speeds of one shaft: a range or a list."""

    shaft: Literal["motor", "load", "forcing"]
    low: Annotated[Speed | None, Field(alias="from")] = None
    high: Annotated[Speed | None, Field(alias="to")] = None
    at: Annotated[list[Speed], Field(min_length=1, max_length=100)] | None = None

    @check_model(mode="after")
    def _range_or_list(self) -> "SpeedSpec":
        if (self.at is None) == (self.low is None and self.high is None):
            raise ValueError("needs either a range 'from' and 'to' or a list 'at'; write {from: 100 rpm, to: 3000 rpm}")
        if self.at is None and (self.low is None or self.high is None):
            raise ValueError("has one end of the range only; write both 'from' and 'to'")
        if self.low is not None and self.high is not None and self.low >= self.high:
            raise _at(("to",), "the range does not ascend; write the smaller speed after 'from'")
        return self


class ErrorLine(Spec):
    """One line of the kinematic error."""

    order: Order
    amplitude: Annotated[float, _quantity("rad", "not negative")]
    phase: Angle = 0.0


class TorqueLine(Spec):
    """One line of a torque."""

    order: Order
    amplitude: Annotated[float, _quantity("N*m", "not negative")]
    phase: Angle = 0.0


class TorqueSpec(Spec):
    """A torque: its mean and its lines."""

    mean: Torque = 0.0
    lines: Annotated[list[TorqueLine], Field(max_length=MOST_LINES)] = []


def _accuracy(value: Any) -> Any:
    return value if value == CATALOGUE else _number(value, "rad", "positive")


class ExcitationSpec(Spec):
    """What drives the error; `accuracy` in place of lines is the gear's accuracy class, peak-to-peak."""

    accuracy: Annotated[float | Literal["catalogue"] | None, BeforeValidator(_accuracy)] = None
    kinematic_error: Annotated[list[ErrorLine], Field(max_length=MOST_LINES)] = []
    motor_torque: TorqueSpec | None = None
    load_torque: TorqueSpec | None = None


class ProjectSpec(Spec):
    """The whole project file."""

    title: Annotated[str, BeforeValidator(_title)] = ""
    gear: Annotated[
        Annotated[str, BeforeValidator(_known_gear), Tag("name")]
        | Annotated[ExplicitGear, Tag("explicit")]
        | Annotated[OwnGear, Tag("own")],
        Discriminator(_gear_kind),
    ]
    motor: MotorSpec = MotorSpec()
    load: LoadSpec
    damping: DampingSpec
    speed: SpeedSpec
    excitation: ExcitationSpec
