"""The JSON Schema of the project file agrees with what reads the file, and the page with the schema."""

import json
import re
from pathlib import Path

import pytest
from field_examples import examples
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML
from twelve_projects import PROJECTS

from strainwave.base.quantities import parse
from strainwave.files.fields.entries import LoopSpec, loop_types
from strainwave.files.fields.kinds import Quantity
from strainwave.files.fields.rows import law_types, rows_of
from strainwave.files.fields.schema import ProjectSpec
from strainwave.files.reading import ProjectError, from_text
from strainwave.files.reference import project_schema, reference, template

ROOT = Path(__file__).resolve().parents[3]
FILES = [*(ROOT / "examples/projects").glob("*.yaml"), *(ROOT / "src/strainwave/app/projects").glob("*.yaml")]
TEXTS = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in FILES if path.stem != "elbow"}
TEXTS |= PROJECTS  # elbow.yaml is a specification of an axis
TEXTS |= {
    f"page {i}": text
    for i, text in enumerate(
        re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/project-file.md").read_text(encoding="utf-8"), re.DOTALL)
    )
    if "51" not in text  # the file that is refused there
}
EXAMPLES = dict(examples(ProjectSpec)) | dict(examples(LoopSpec, "motor.loop."))
SCHEMA = Draft202012Validator(project_schema())

GOOD = """\
title: Axis
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 4.5 kg*cm^2, mode: held}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 100 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""
MUTATIONS = (
    ("ratio: 50", "ratio: 0.5"), ("ratio: 50, ", ""), ("type: linear", "type: lineal"), ("K: 1e5 N*m/rad", "K: 1e5"),
    ("K: 1e5 N*m/rad", "k: 1e5 N*m/rad"), ("K: 1e5 N*m/rad", "K: -1e5 N*m/rad"),
    ("inertia: 4.5 kg*cm^2", "inertia: 4.5"),
    ("mode: held", "mode: hold"), ("load: {inertia: 1.3 kg*m^2}", "load: {}"), ("1.3 kg*m^2", "-1.3 kg*m^2"),
    ("load: {inertia: 1.3 kg*m^2}", "load: 1.3 kg*m^2"), ("ratio: 3 %", "ratio: 3 %, B: 1 N*m*s/rad"),
    ("ratio: 3 %", "ratio: -3 %"), ("damping: {ratio: 3 %}", "damping: {}"), ("shaft: motor", "shaft: motr"),
    ("from: 100 rpm, ", ""), ("order: 2", "order: 2.5"), ("order: 2", "order: 0"), ("23 arcsec", "23"),
    ("23 arcsec", "-23 arcsec"), ("excitation", "exitation"), ("title: Axis", "titel: Axis"),
    ("[{order: 2, amplitude: 23 arcsec}]", "{order: 2, amplitude: 23 arcsec}"), ("1.3 kg*m^2", "0 kg*m^2"),
)  # fmt: skip


def errors(text):
    return list(SCHEMA.iter_errors(YAML(typ="safe").load(text)))


def fields_of_schema(schema):
    """Every field of a schema, at any depth."""
    if isinstance(schema, dict):
        yield from schema.get("properties", {}).items()
        for value in schema.values():
            yield from fields_of_schema(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from fields_of_schema(value)


def test_it_is_a_schema_of_draft_2020_12_that_refers_to_nothing_outside():
    schema = project_schema()
    Draft202012Validator.check_schema(schema)
    text = json.dumps(schema)
    assert "://" not in text.replace("https://json-schema.org/draft/2020-12/schema", "")
    assert "://" not in schema["$id"]


@pytest.mark.parametrize("name", TEXTS)
def test_every_project_is_valid(name):
    assert errors(TEXTS[name]) == []


@pytest.mark.parametrize(("before", "after"), MUTATIONS)
def test_a_wrong_project_is_refused_by_the_schema_as_by_the_reader(before, after):
    assert errors(GOOD) == []
    wrong = GOOD.replace(before, after, 1)
    assert wrong != GOOD
    assert errors(wrong)
    with pytest.raises(ProjectError):
        from_text(wrong, Path("axis.yaml"))


def test_every_field_has_a_description_which_names_its_unit():
    found = list(fields_of_schema(project_schema()))
    assert len(found) > 150
    for name, item in found:
        assert item.get("description"), name
        if item.get("x-unit", "1") != "1":
            assert f"[{item['x-unit']}]" in item["description"], name


def test_every_field_that_a_complaint_knows_is_in_the_schema():
    fields = {re.sub(r"\[\]", "", field) for field in EXAMPLES}
    known = set(re.findall(r"^\| `([\w.]+)`", reference(), re.MULTILINE))
    fields_of_loops = "type", "bandwidth", "damping", "lag", "filters", "T_p", "encoder", "mixing_frequency"
    loops = {f"motor.loop.{field}" for field in fields_of_loops}  # in a table of their own
    assert fields - known == loops


def test_every_field_of_a_law_and_of_a_loop_has_its_unit_and_its_default():
    defs = project_schema()["$defs"]
    schemas = [(cls, defs[f"law_{name}"]) for name, cls in law_types().items()]
    schemas += list(zip(loop_types().values(), defs["loop"]["anyOf"][1:], strict=True))
    for cls, schema in schemas:
        assert set(rows_of(cls)) <= set(schema["properties"])
        for field, value in cls._field_defaults.items():
            item = schema["properties"][field]
            unit = item["x-unit"]
            written = item["default"]
            assert (written if unit == "1" else parse(written, unit)) == value


@pytest.mark.parametrize(
    ("unit", "sign", "text", "good"),
    [
        ("rad", "positive", "23 arcsec", True), ("rad", "positive", "0 arcsec", False), ("rad", "any", "−5'", True),
        ("rad", "positive", "23 rad/s", False), ("rad/s", "positive", "600 rpm", True), 
        ("rad/s", "any", "5 N*m", False),
        ("kg*m**2", "positive", "3.1×10⁴ kg·cm²", True), ("", "positive", "2 %", True), ("", "any", "2 kg", False),
        ("N*m", "any", "-40 ft-lb", True), ("N*m", "not negative", "-1 N*m", False), ("s", "positive", "250 us", True),
    ],
)  # fmt: skip
def test_quantities_of_the_schema(unit, sign, text, good):
    assert Draft202012Validator(Quantity(unit, sign).schema()).is_valid(text) is good
    if good:
        assert isinstance(parse(text, unit), float)


def test_the_page_is_what_the_command_gives():
    page = (ROOT / "docs/api/project-file-reference.md").read_text(encoding="utf-8")
    assert page == reference()


def test_a_template_holds_its_values_and_comments_that_may_be_taken():
    values = {"gear": "CSG-40-50", "motor.inertia": "", "load.inertia": "2 kg*m^2", "damping.ratio": "2 %"}
    values |= {"speed.from": "1 rpm", "speed.to": "9 rpm", "speed.shaft": "motor", "excitation.accuracy": "1 arcmin"}
    values |= {"limit.oscillation": ""}
    text = template(values, "own.json")
    assert text.startswith("# yaml-language-server: $schema=own.json\n")
    project = from_text(text, Path("axis.yaml"))
    assert (project.drive.J_l, project.limit) == (2.0, None)
    taken = re.sub(r"^#( +inertia:)", r"\1", text, flags=re.MULTILINE)
    taken = re.sub(r"^# ?(limit:)", r"\1", taken, flags=re.MULTILINE)
    taken = re.sub(r"^#( +oscillation:)", r"\1", taken, flags=re.MULTILINE)
    more = from_text(taken.replace("motor:", "motor:", 1).replace("# motor:", "motor:"), Path("axis.yaml"))
    assert more.limit == pytest.approx(parse(EXAMPLES["limit.oscillation"], "rad"), rel=1e-12)
    assert more.drive.J_m == pytest.approx(parse(EXAMPLES["motor.inertia"], "kg*m**2"), rel=1e-12)
