"""JSON Schema of a project file, for editors."""

from ...drive.demands.payload import Payload
from ...model.oscillator import Ripple
from .entries import Loop, filter_types
from .kinds import Schema
from .python_law import NAMED
from .rows import law_types, schema_of
from .schema import PARTS, ProjectSpec

NAME = "strainwave.schema.json"  # of the file that editors read


def _definitions() -> dict[str, Schema]:
    """Entries that more than one field takes, by name."""
    laws = {name: schema_of(cls, name) for name, cls in law_types().items()}
    python = {"python": {"type": "string", "pattern": f"^{NAMED.pattern}$", "description": "Law of a Python file."}}
    forms = [
        *({"$ref": f"#/$defs/law_{name}"} for name in laws),
        {"type": "object", "properties": python, "required": ["python"]},
        {"type": "string", "pattern": f"^{NAMED.pattern}$"},
    ]
    return {
        **{f"law_{name}": law for name, law in laws.items()},
        "law": {"anyOf": forms},
        "ripple": schema_of(Ripple),
        "payload": schema_of(Payload),
        "loop": {"anyOf": Loop().schemas()},
        "filter": {"oneOf": [schema_of(cls, name) for name, cls in filter_types().items()]},
        "part": {"oneOf": [schema_of(cls, name) for name, cls in PARTS.items()]},
    }


def project_schema() -> Schema:
    """JSON Schema (draft 2020-12) of a project file, with a description, the unit and the range of every field.

    Returns
    -------
    dict
        As `json.dumps` takes it. `x-unit` has the unit of a field in SI and `x-range` the range of its number.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:strainwave:project-file",
        "title": "strainwave project file",
        "description": "A drive with a strain wave gear, its speeds and what excites it.",
        **schema_of(ProjectSpec),
        "$defs": _definitions(),
    }
