"""Sentences for what pydantic finds wrong with a project: fact, value, remedy, at the right line and column."""

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from .controller import EXAMPLE as EXAMPLE_CONTROLLER
from .entries import RIPPLES, Wrong, near
from .law_fields import EXAMPLE_DRAG, EXAMPLE_HYSTERESIS
from .loop_fields import EXAMPLE_LOOP
from .yaml_text import Keys, Located, Problem, name, shown

# Every field by its name without list positions, with the example that a complaint shows.
EXAMPLES = {
    "title": "Azimuth axis",
    "gear": "CSG-40-50",
    "gear.file": "my_gears.yaml",
    "gear.name": "MY-40-50",
    "gear.ratio": "50",
    "gear.law": "{type: cubic, K: 7160 N*m/rad, alpha: 0.1 1/rad^2}",
    "gear.rated_torque": "178 N*m",
    "hysteresis": EXAMPLE_HYSTERESIS,
    "backlash": "{half_gap: 10 arcsec}",
    "backlash.half_gap": "10 arcsec",
    "motor": "{inertia: 4.5 kg*cm^2, mode: held}",
    "motor.inertia": "4.5 kg*cm^2",
    "motor.mode": "held",
    "motor.loop": EXAMPLE_LOOP,
    "motor.loop.type": "position",
    "motor.loop.bandwidth": "30 Hz",
    "motor.loop.damping": "0.7",
    "motor.loop.lag": "0.5 ms",
    "motor.drag": EXAMPLE_DRAG,
    "controller": EXAMPLE_CONTROLLER,
    "controller.period": "250 us",
    "controller.delay": "250 us",
    "controller.motor_encoder": "16 bit",
    "controller.load_encoder": "24 bit",
    "controller.loss": "0.1 %",
    "load": "{inertia: 1.3 kg*m^2}",
    "load.inertia": "1.3 kg*m^2",
    "load.drag": "{type: angle_torque, amplitude: 40 N*m}",
    "load.coupling": "{inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}",
    "load.coupling.inertia": "0.1 kg*m^2",
    "load.coupling.B": "5 N*m*s/rad",
    "load.coupling.law": "{type: linear, K: 2e5 N*m/rad}",
    "load.couplings": "[{inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}]",
    "load.couplings[]": "{inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}",
    "load.couplings[].inertia": "0.1 kg*m^2",
    "load.couplings[].B": "5 N*m*s/rad",
    "load.couplings[].law": "{type: linear, K: 2e5 N*m/rad}",
    "damping": "{ratio: 0.02}",
    "damping.B": "10 N*m*s/rad",
    "damping.ratio": "0.02",
    "damping.quality": "25",
    "damping.ripples": RIPPLES,
    "damping.warming": "20 K",
    "damping.per_kelvin": "0.035 1/K",
    "damping.fast": "0.5",
    "damping.v_fast": "1 rad/s",
    "stiffness": f"{{ripples: {RIPPLES}}}",
    "stiffness.ripples": RIPPLES,
    "speed": "{from: 100 rpm, to: 3000 rpm, shaft: motor}",
    "speed.from": "100 rpm",
    "speed.to": "3000 rpm",
    "speed.at": "[1000 rpm, 2000 rpm]",
    "speed.shaft": "motor",
    "excitation": "{kinematic_error: [{order: 2, amplitude: 23 arcsec}]}",
    "excitation.accuracy": "1 arcmin",
    "excitation.kinematic_error": "[{order: 2, amplitude: 23 arcsec}]",
    "excitation.kinematic_error[]": "{order: 2, amplitude: 23 arcsec}",
    "excitation.kinematic_error[].order": "2",
    "excitation.kinematic_error[].amplitude": "23 arcsec",
    "excitation.kinematic_error[].phase": "90 deg",
    "limit": "{oscillation: 60 arcsec}",
    "limit.oscillation": "60 arcsec",
    "scatter": "{load.inertia: 5 %}",
    "scatter_correlation": "[[1, -0.5], [-0.5, 1]]",
} | {
    f"excitation.{torque}{field}": text
    for torque in ("motor_torque", "load_torque")
    for field, text in {
        "": "{mean: 5 N*m, lines: [{order: 1, amplitude: 0.1 N*m}]}",
        ".mean": "5 N*m" if torque == "motor_torque" else "{from: -60 N*m, to: 60 N*m}",
        ".mean.from": "-60 N*m",
        ".mean.to": "60 N*m",
        ".lines": "[{order: 1, amplitude: 0.1 N*m}]",
        ".lines[]": "{order: 1, amplitude: 0.1 N*m}",
        ".lines[].order": "1",
        ".lines[].amplitude": "0.1 N*m",
        ".lines[].phase": "90 deg",
    }.items()
}


def complaints(
    error: ValidationError, located: Located, examples: Mapping[str, str] = EXAMPLES
) -> Iterator[Problem]:  # fmt: skip
    """Turn every error of a validation into a `Problem`; fields that are empty were reported when they were read.

    `examples` has every field of the file by its name without list positions.
    """
    for item in error.errors(include_url=False):
        keys, value = _follow(item["loc"], located.content)
        context = item.get("ctx", {})
        if item["type"] == "missing":
            field = (*keys, str(item["loc"][-1]))
            yield Problem(*located.place(keys), name(field), f"is missing; {_write(field, examples)}")
        elif item["type"] == "extra_forbidden":
            yield Problem(*located.keys[keys], name(keys), _unknown(keys, examples))
        elif item["type"] == "at":
            yield from _below(keys, context["problems"], located)
        elif value is not None or not keys:
            yield _about_value(item, keys, value, located, examples)


def _below(keys: Keys, problems: tuple[Wrong, ...], located: Located) -> Iterator[Problem]:
    """Everything that is wrong below a field."""
    for wrong in problems:
        below = (*keys, *wrong.keys)
        if wrong.sentence:
            place = located.keys[below] if wrong.on_key else located.place(below)
            yield Problem(*place, name(below), wrong.sentence)


def _about_value(item: Any, keys: Keys, value: Any, located: Located, examples: Mapping[str, str]) -> Problem:
    kind, context = item["type"], item.get("ctx", {})
    if kind == "value_error":
        sentence = str(context["error"])
    elif kind == "literal_error":
        sentence = f"{shown(value)} is not known{near(value, _literals(context['expected']))}"
    elif kind in ("too_short", "too_long"):
        limit = context.get("min_length", context.get("max_length"))
        sentence = f"has {len(value)} items; write at {'least' if kind == 'too_short' else 'most'} {limit}"
    elif not keys:
        first = next(field for field in examples if field != "title")
        sentence = f"holds {shown(value)}, not fields; begin with a line such as '{first}: {examples[first]}'"
    else:
        wanted = {"list_type": "a list", "tuple_type": "a list", "string_type": "a text"}.get(kind, "a group of fields")
        sentence = f"{shown(value)} is not {wanted}; {_write(keys, examples)}"
    return Problem(*located.place(keys), name(keys), sentence)


def _follow(loc: tuple[str | int, ...], content: Any) -> tuple[Keys, Any]:
    """Follow pydantic's location through the content, leaving out the tags of unions that it contains."""
    keys: list[str | int] = []
    for key in loc:
        items: Any = dict(enumerate(content)) if isinstance(content, list) else content
        if isinstance(items, dict) and key in items:
            content = items[key]
            keys.append(key)
    return tuple(keys), content


def _literals(expected: str) -> list[str]:
    return [word.strip("' ") for word in expected.replace(" or ", ",").split(",")]


def _pattern(keys: Keys) -> str:
    return "".join("[]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def _write(keys: Keys, examples: Mapping[str, str]) -> str:
    text = examples.get(_pattern(keys))
    return f"write for example '{keys[-1]}: {text}'" if isinstance(keys[-1], str) else f"write for example {text}"


def _siblings(keys: Keys, examples: Mapping[str, str]) -> list[str]:
    """Return the fields that may stand beside the last of `keys`."""
    group = _pattern(keys[:-1])
    start = f"{group}." if group else ""
    rest = (field.removeprefix(start) for field in examples if field.startswith(start))
    return [field for field in rest if "." not in field and "[" not in field]


def _unknown(keys: Keys, examples: Mapping[str, str]) -> str:
    """Sentence for a field that nobody knows: the nearest field here, else the nearest at the top, else all of them."""
    here, top = _siblings(keys, examples), _siblings(("",), examples)
    word = str(keys[-1]).lower()
    spelt = {field.lower(): field for field in (*top, *here)}
    near = difflib.get_close_matches(word, list(spelt), n=1)
    if near and spelt[near[0]] in here:
        return f"unknown field; did you mean {spelt[near[0]]!r}?"
    if near:
        return f"unknown field; did you mean {near[0]!r}? It stands at the top level, not in {name(keys[:-1])!r}"
    return f"unknown field; known here: {', '.join(here)}"
