"""Sentences for what pydantic finds wrong with a project: fact, value, remedy, at the right line and column."""

import difflib
from collections.abc import Iterator
from typing import Any, get_args, get_type_hints

from pydantic import ValidationError

from ..model import friction, hysteresis
from ..quantities import example
from .schema import EXAMPLE_POINTS, law_fields, law_types
from .yaml_text import Keys, Located, Problem, name, shown

# Every field by its name without list positions, with the example that a complaint shows.
EXAMPLES = {
    "title": "Azimuth axis",
    "gear": "CSG-40-50",
    "gear.file": "my_gears.yaml",
    "gear.name": "MY-40-50",
    "gear.ratio": "50",
    "gear.law": "{type: cubic, K: 7160 N*m/rad, alpha: 0.1 1/rad^2}",
    "gear.law.type": "cubic",
    "motor": "{inertia: 4.5 kg*cm^2, mode: held}",
    "motor.inertia": "4.5 kg*cm^2",
    "motor.mode": "held",
    "load": "{inertia: 1.3 kg*m^2}",
    "load.inertia": "1.3 kg*m^2",
    "damping": "{ratio: 0.02}",
    "damping.B": "10 N*m*s/rad",
    "damping.ratio": "0.02",
    "damping.quality": "25",
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
} | {
    f"excitation.{torque}{field}": text
    for torque in ("motor_torque", "load_torque")
    for field, text in {
        "": "{mean: 5 N*m, lines: [{order: 1, amplitude: 0.1 N*m}]}",
        ".mean": "5 N*m",
        ".lines": "[{order: 1, amplitude: 0.1 N*m}]",
        ".lines[]": "{order: 1, amplitude: 0.1 N*m}",
        ".lines[].order": "1",
        ".lines[].amplitude": "0.1 N*m",
        ".lines[].phase": "90 deg",
    }.items()
}


def complaints(error: ValidationError, located: Located) -> Iterator[Problem]:
    """Turn every error of a validation into a `Problem`; fields that are empty were reported when they were read."""
    for item in error.errors(include_url=False):
        keys, value = _follow(item["loc"], located.content)
        context = item.get("ctx", {})
        if item["type"] == "missing":
            field = (*keys, str(item["loc"][-1]))
            yield Problem(*located.place(keys), name(field), f"is missing; {_write(field)}")
        elif item["type"] == "extra_forbidden":
            yield Problem(*located.keys[keys], name(keys), _unknown(keys, located.content))
        elif item["type"] == "at":
            below = (*keys, *context["keys"])
            yield Problem(*located.place(below), name(below), context["sentence"])
        elif value is not None or not keys:
            yield _about_value(item, keys, value, located)


def _about_value(item: Any, keys: Keys, value: Any, located: Located) -> Problem:
    kind, context = item["type"], item.get("ctx", {})
    if kind == "value_error":
        sentence = str(context["error"])
    elif kind == "literal_error":
        sentence = f"{shown(value)} is not known{_near(value, _literals(context['expected']))}"
    elif kind == "union_tag_not_found":
        return Problem(
            *located.place(keys), name((*keys, "type")), f"is missing; write one of {', '.join(law_types())}"
        )
    elif kind == "union_tag_invalid":
        keys = (*keys, "type")
        known = list(law_types())
        if value["type"] in known:  # known, but not here
            known.remove(value["type"])
            sentence = f"{shown(value['type'])} cannot stand inside another law; write one of {', '.join(known)}"
        elif _python_only(value["type"]):
            sentence = (
                f"{shown(value['type'])} has friction or memory, which a project file cannot describe; write a spring, "
                f"or take strainwave.{_python_only(value['type'])} in Python, with frequency_response and simulate"
            )
        else:
            sentence = f"{shown(value['type'])} is not known{_near(value['type'], known)}"
    elif kind in ("too_short", "too_long"):
        limit = context.get("min_length", context.get("max_length"))
        sentence = f"has {len(value)} items; write at {'least' if kind == 'too_short' else 'most'} {limit}"
    elif not keys:
        sentence = f"holds {shown(value)}, not fields; begin with a line such as 'gear: CSG-40-50'"
    else:
        wanted = {"list_type": "a list", "string_type": "a text"}.get(kind, "a group of fields")
        sentence = f"{shown(value)} is not {wanted}; {_write(keys)}"
    return Problem(*located.place(keys), name(keys), sentence)


def _python_only(kind: Any) -> str:
    """Class of the law with friction or memory that a text means, "bouc_wen" or "BoucWen"; empty if none."""
    plain = kind.replace("_", "").lower() if isinstance(kind, str) else ""
    classes = [c for m in (friction, hysteresis) for c in vars(m).values() if hasattr(c, "stiffness")]
    return next((c.__name__ for c in classes if c.__name__.lower() == plain), "")


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


def _near(value: Any, known: list[str]) -> str:
    near = difflib.get_close_matches(str(value).lower().replace("-", "_").replace(" ", "_"), known, n=1)
    return f"; did you mean {near[0]!r}?" if near else f"; write one of {', '.join(known)}"


def _pattern(keys: Keys) -> str:
    return "".join("[]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def _write(keys: Keys) -> str:
    pattern = _pattern(keys)
    text = EXAMPLES.get(pattern)
    if text is None and pattern.startswith("gear.law."):
        return f"write it, {_law_examples().get(str(keys[-1]), 'see the documentation of the law')}"
    return f"write for example '{keys[-1]}: {text}'" if isinstance(keys[-1], str) else f"write for example {text}"


def _law_examples() -> dict[str, str]:
    """Example of every field of every law, from the unit in its annotation."""
    texts = {
        "coefficients": "for example [0 N*m, 7160 N*m/rad]",
        "points": EXAMPLE_POINTS,
        "law": "for example {type: linear, K: 7160 N*m/rad}",
    }
    for cls in law_types().values():
        for field, hint in get_type_hints(cls, include_extras=True).items():
            if field not in texts and field in law_fields(cls):
                texts[field] = example(get_args(hint)[1])
    return texts


def _siblings(keys: Keys, content: Any) -> list[str]:
    """Return the fields that may stand beside the last of `keys`."""
    if keys[:2] == ("gear", "law") and set(keys[2:-1]) <= {"law"}:
        group = content
        for key in keys[:-1]:
            group = group[key]
        cls = law_types().get(group.get("type"))
        return ["type", *law_fields(cls)] if cls else ["type"]
    group = _pattern(keys[:-1])
    start = f"{group}." if group else ""
    rest = (field.removeprefix(start) for field in EXAMPLES if field.startswith(start))
    return [field for field in rest if "." not in field and "[" not in field]


def _unknown(keys: Keys, content: Any) -> str:
    """Sentence for a field that nobody knows: the nearest field here, else the nearest at the top, else all of them."""
    here = _siblings(keys, content)
    word = str(keys[-1]).lower()
    spelt = {field.lower(): field for field in here}
    near = difflib.get_close_matches(word, list(spelt), n=1)
    if near:
        return f"unknown field; did you mean {spelt[near[0]]!r}?"
    top = difflib.get_close_matches(word, _siblings(("",), content), n=1)
    if top:
        return f"unknown field; did you mean {top[0]!r}? It stands at the top level, not in {name(keys[:-1])!r}"
    return f"unknown field; known here: {', '.join(here)}"
