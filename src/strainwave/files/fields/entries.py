"""Objects of the model in a project file: laws by the place where they stand, and the loop of the motor.

In {type: linear, K: 7160 N*m/rad} `type` is the name of a class of the model; the other fields are the class's own, in
the units of their annotations. A new law is known here without a line of code. A loop is given by bandwidth and by
damping, or by gains; and either with the lag of a current loop.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from ...base.law import depends
from ...base.protocols import Law
from ...base.quantities import checked
from ...model.gears.gear import Gear
from ...model.laws.hysteresis import BoucWen
from ...model.laws.springs import PiecewiseLinear
from ...model.oscillator import Ripple, Variation
from ...model.train.controls import KINDS, USUAL, CascadeLoop, PositionLoop, SpeedLoop, Tuning, core_of, from_bandwidth
from ...model.train.filters import FILTERS, apart, around
from ...model.train.motion import AngleTorque
from ...study.gear.hysteresis_loop import fit_hysteresis
from ..yaml_text import Keys, shown
from ..yaml_text import read as read_yaml
from .groups import CATALOGUE
from .kinds import BANDWIDTH, Entry, Items, Kind, Quantity, Row, Schema, Word, Wrong, read, suggestion
from .rows import LAW, TYPE, Fields, Group, Typed, field, group_text, name_of, needed, read_group, rows_of, schema_of

EXAMPLE_HYSTERESIS = "{type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}"
EXAMPLE_DRAG = "{type: coulomb, T_c: 0.05 N*m}"
EXAMPLE_LOOP = "{type: cascade, bandwidth: 30 Hz, damping: 0.7}"


def _parts(law: Any, keys: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Laws that a law is made of, at any depth, with their places in its entry; itself where it is made of none."""
    inside = [(name, part) for name, part in zip(law._fields, law, strict=True) if hasattr(part, "torque")]
    for name, part in inside:
        yield from _parts(part, (*keys, name))
    if not inside:
        yield keys, law


def _not_of_a_shaft(law: Law) -> Iterator[Wrong]:
    for keys, part in _parts(law):
        if not getattr(part, "width", 1.0):
            yield Wrong((*keys, "width"), "is missing: friction in the gear needs a speed to smooth the sign")
        if isinstance(part, AngleTorque):
            yield Wrong(keys, "AngleTorque follows the angle of a shaft; write it as drag under motor or load")


def _drag(law: Law) -> Iterator[Wrong]:
    """Parts of a drag that do not oppose a shaft: a spring, and dry friction that creeps."""
    for keys, part in _parts(law):
        if getattr(part, "width", 0.0):
            yield Wrong((*keys, "width"), "is not a field here: dry friction of a shaft can stick; remove it")
        if depends(part) == 1 and not isinstance(part, AngleTorque):
            remedy = "write friction, or angle_torque for gravity"
            yield Wrong(keys, f"{type(part).__name__} is a spring, which ties a shaft to the ground; {remedy}")
        if isinstance(part, BoucWen) and part.ratio > 0.0:
            what = f"{part.ratio:g} of this torque is a spring, which ties a shaft to the ground"
            yield Wrong((*keys, "ratio"), f"{what}; write 'ratio: 0', or lugre")


def _gear_law(law: Law) -> Iterator[Wrong]:
    """Faults of a law that does not hold a gear together."""
    yield from (wrong := list(_not_of_a_shaft(law)))
    stiffness = float(law.stiffness(0.0))
    if not wrong and not stiffness > 0.0 and not (hasattr(law, "breakpoints") and law.breakpoints()):
        remedy = "; write {type: parallel, first: a spring, second: the friction}" if depends(law) > 1 else ""
        yield Wrong((), f"the stiffness at rest is {stiffness:g} N*m/rad; it must be positive{remedy}")


def _hysteresis(law: Law) -> Iterator[Wrong]:
    """Faults of a law that loses no energy beside a gear's law."""
    if depends(law) == 1:
        fault = f"is a spring, which loses no energy; write for example {EXAMPLE_HYSTERESIS}, and a spring as gear.law"
        return iter((Wrong((), f"{type(law).__name__} {fault}"),))
    return _not_of_a_shaft(law)


@cache
def _of_loss(law: PiecewiseLinear, loss: float, rated: float) -> Any:
    """Law beside a spring that gives the hysteresis loss [rad] of a record at the rated torque [N*m]."""
    return fit_hysteresis(law, loss, rated_torque=rated).law.second


@dataclass(frozen=True)
class HysteresisKind(Typed):
    """Hysteresis by its numbers, or that of the gear's record."""

    def read(self, value: object, entry: Entry) -> Any:
        return value if value == CATALOGUE else super().read(value, entry)

    def schema(self) -> Schema:
        return {"anyOf": [{"const": CATALOGUE}, super().schema()]}

    def text(self, value: object) -> str:
        return CATALOGUE if value == CATALOGUE else super().text(value)

    @staticmethod
    def beside(value: Any, gear: Gear | None) -> Any:
        """The law beside the spring of a gear."""
        if value != CATALOGUE or gear is None:
            return value
        return _of_loss(gear.law, gear.hysteresis_loss or 0.0, gear.rated_torque or 0.0)


GEAR_LAW, HYSTERESIS, DRAG = Typed(wrong=_gear_law), HysteresisKind(wrong=_hysteresis), Typed(wrong=_drag)


def loop_types() -> dict[str, type]:
    """Control loops of the motor by their name in a project file."""
    return {name_of(c): c for c in (SpeedLoop, PositionLoop, CascadeLoop)}


def filter_types() -> dict[str, type]:
    """Filters of a loop's torque by their name in a project file."""
    return {name_of(c).removesuffix("_filter"): c for c in FILTERS}


LOOPS = Typed(loop_types)
FILTERED = Items(Typed(filter_types, "filter"), 1, 8)
ENCODERS = ("motor", "load", "both")
AROUND = ("filters", "lag", "T_p", "encoder", "mixing_frequency")  # of a loop by its bandwidth or its gains
EXAMPLE_FILTERS = "[{type: notch, frequency: 120 Hz, width: 40 Hz}]"


@dataclass(frozen=True)
class LoopKind(Word):
    """Kind of a loop, with or without the word "loop"."""

    def read(self, value: object, entry: Entry) -> str:
        word = value.removesuffix("_loop") if isinstance(value, str) else ""
        if word not in KINDS:
            raise ValueError(f"{shown(value)} is not known{suggestion(value, list(KINDS))}")
        return word


class LoopSpec(Group):
    """A loop by its bandwidth."""

    type: Any = field(LoopKind(words=KINDS), "position", TYPE, USUAL.kind)
    bandwidth: float = needed(BANDWIDTH, "30 Hz",
        "Bandwidth of the closed loop with a rigid gear, in Hz or rad/s, instead of gains.")  # fmt: skip
    damping: float = field(Quantity("", "positive"), "0.7",
        "Damping ratio of the closed loop with a rigid gear.", USUAL.damping)  # fmt: skip
    lag: float = field(Quantity("s", "positive"), "0.5 ms", "First-order lag of the torque (current loop).")
    filters: tuple[Any, ...] = field(FILTERED, EXAMPLE_FILTERS, "Filters of the torque, in series.")
    T_p: float = field(Quantity("s", "positive"), "100 ms", "Integral time of a cascade's position loop; P without it.")
    encoder: Any = field(
        Word(ENCODERS),
        "load",
        "Encoder for the position loop of a cascade; the speed loop uses the motor encoder.",
        ENCODERS[0],
    )
    mixing_frequency: float = field(BANDWIDTH, "8 Hz",
        "With both encoders: load encoder below this frequency, motor encoder above it.")  # fmt: skip

    @property
    def tuning(self) -> Tuning:
        """The loop, whose gains follow from the inertia that it turns."""
        around_it = self.lag or 0.0, self.filters or (), self.T_p or 0.0, self.encoder, self.mixing_frequency or 0.0
        return Tuning(self.bandwidth, self.damping, self.type, *around_it)

    def check(self) -> Iterator[Wrong]:
        """Refuse a bandwidth beyond what the lag allows."""
        try:
            from_bandwidth(self.bandwidth, 1.0, lag=self.lag or 0.0)
        except ValueError as error:
            yield Wrong(("bandwidth",), f"is too large: {error}")
        if self.T_p and self.type != "cascade":
            fault = "is the integral time of a cascade's position loop; write 'type: cascade', or leave T_p out"
            yield Wrong(("T_p",), fault)
        yield from encoder_wrong(self.type == "cascade", self.encoder, self.mixing_frequency)


def encoder_wrong(is_cascade: bool, encoder: str | None, mixing: float | None) -> Iterator[Wrong]:
    """Faults of the encoder of a loop."""
    if encoder in ENCODERS[1:] and not is_cascade:
        sentence = f"{encoder!r} needs a position loop around a speed loop; write 'type: cascade', or leave encoder out"
        yield Wrong(("encoder",), sentence)
    if encoder == "both" and not mixing:
        yield Wrong(("mixing_frequency",), "is missing; with both encoders write for example 'mixing_frequency: 8 Hz'")
    if mixing and encoder != "both":
        yield Wrong(("mixing_frequency",), "mixes two encoders; write 'encoder: both', or leave mixing_frequency out")


@dataclass(frozen=True)
class Loop(Kind):
    """The loop of a motor: a `Tuning`, or a control with gains, with the lag of a current loop."""

    def read(self, value: object, entry: Entry) -> Any:
        if isinstance(value, dict) and {"bandwidth", "damping"} & set(value):
            names = {key for cls in loop_types().values() for key in rows_of(cls)}
            gains = {key: item for key, item in value.items() if key in names}
            for gain in gains:
                sentence = "is a gain, and bandwidth and damping give the gains already; remove one or the other"
                entry.inside(gain).wrong(sentence, on_key=True)
            spec = read_group({key: item for key, item in value.items() if key not in gains}, LoopSpec, entry)
            return spec and spec.tuning
        parts: dict[str, Any] = {}
        if isinstance(value, dict):
            rows = {key: rows_of(LoopSpec)[key] for key in AROUND if key in value}
            parts = {key: read(row.kind, value[key], entry.inside(key, row.example)) for key, row in rows.items()}
            value = {key: item for key, item in _full_name(value).items() if key not in AROUND}
        loop = LOOPS.read(value, entry)
        if loop is None or None in parts.values():
            return None
        wrong = encoder_wrong(isinstance(loop, CascadeLoop), parts.get("encoder"), parts.get("mixing_frequency"))
        for one in wrong:
            return entry.inside(one.keys[0]).wrong(one.sentence)
        return around(loop, **parts)

    def schema(self) -> Schema:
        return {"$ref": "#/$defs/loop"}

    def schemas(self) -> list[Schema]:
        """JSON Schemas of a loop by its bandwidth, and by its gains."""
        more = {key: rows_of(LoopSpec)[key].schema() for key in AROUND}
        schemas = [schema_of(LoopSpec), *(schema_of(cls, name, more) for name, cls in loop_types().items())]
        schemas[0]["description"] = LoopSpec.__doc__
        for schema, name in zip(schemas[1:], loop_types(), strict=True):
            schema["properties"]["type"] = {"enum": [name, name.removesuffix("_loop")], "description": TYPE}
        return schemas

    def text(self, value: object) -> str:
        if isinstance(value, Tuning):
            given = {key: getattr(value, key) for key in AROUND if getattr(value, key) not in (0.0, (), ENCODERS[0])}
            return group_text(LoopSpec(type=value.kind, bandwidth=value.bandwidth, damping=value.damping, **given))
        core, fields = apart(value)
        if around(core, **fields) != value:
            raise ValueError("a project file supports one torque lag, after its filters; use this loop in Python")
        more = group_text(LoopSpec(**fields))
        return ", ".join(filter(None, [LOOPS.text(core)[:-1], more[1:-1]])) + "}"

    def part(self, value: object, key: str) -> Row | None:
        gains = LOOPS.part(_full_name(value), key) if isinstance(value, dict) else None
        return gains or rows_of(LoopSpec).get(key)


def _full_name(value: dict[str, Any]) -> dict[str, Any]:
    """The entry of a loop by its gains with the whole name of its type."""
    return {**value, "type": f"{value['type']}_loop"} if value.get("type") in KINDS else value


@dataclass(frozen=True)
class Ripples(Items):
    """Lines of what varies with the base angle."""

    def read(self, value: object, entry: Entry) -> Any:
        before, ripples = len(entry.faults), Items.read(self, value, entry)
        return None if len(entry.faults) > before else checked(Variation(ripples))

    def schema(self) -> Schema:
        return Items.schema(self) | {"minItems": 1}

    def text(self, value: Variation) -> str:
        if not isinstance(value, Variation):
            raise ValueError(f"no project file says what {type(value).__name__} holds; it has ripples of a Variation")
        return Items.text(self, value.ripples)


RIPPLES = Ripples(Fields(Ripple, "ripple"))


def project_entry(model: Any) -> str:
    """Write a law as the entry of a project file that reads back as the same law.

    Parameters
    ----------
    model : NamedTuple
        A law of this package, of any kind, for `gear: {ratio: 50, law: ...}`; laws inside it too. Fields that have
        their default are left out.

    Returns
    -------
    str
        One line of YAML, for example "{type: cubic, K: 7160.0 N*m/rad, alpha: 0.1 1/rad^2}".

    Raises
    ------
    ValueError
        If it is no such law, a table whose slopes are not those that `tabulated` finds, or one with numbers that a
        project file refuses.
    TypeError
        If it is not a model object.
    """
    kind = Loop() if isinstance(core_of(model), tuple(loop_types().values())) else LAW
    text, faults = kind.text(checked(model)), list[Wrong]()
    read(kind, read_yaml(f"law: {text}").content["law"], Entry((), faults))
    if faults:
        path = " ".join([type(model).__name__, *map(str, faults[0].keys)])
        raise ValueError(f"a project file does not take this law: {path} {faults[0].sentence}")
    return text
