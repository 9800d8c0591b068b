"""Code that is written from an order table: compiled or translated, it gives what `value` gives."""

import ctypes
import dataclasses
import math
import re
import shutil
import subprocess

import numpy as np
import pytest
from order_machines import ANGLE, DEGREE, TORQUE, TWO_WAYS

import strainwave as sw
from strainwave.files.order_tables.points import Points

COMPILER = shutil.which("cc")
TABLES = {
    "angle": ANGLE,
    "torque": TORQUE,
    "two ways": dataclasses.replace(TWO_WAYS, delay=2e-4),
    "forward": dataclasses.replace(ANGLE, direction="forward", delay=1e-3, mean=1e-5),
    "backward": dataclasses.replace(ANGLE, direction="backward"),
    "nothing": sw.OrderTable((), mean=1e-6),
}
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")


def operating_points(count=2000):
    rng = np.random.default_rng(3)
    return rng.uniform(-20.0, 20.0, count), rng.uniform(-400.0, 400.0, count)


def compiled(tmp_path, source, names):
    """Functions (double, double) -> double of a C source."""
    (tmp_path / "table.c").write_text(source)
    command = [
        COMPILER,
        "-std=c99",
        "-O2",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-shared",
        "-fPIC",
        "table.c",
        "-o",
        "t.so",
        "-lm",
    ]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    library = ctypes.CDLL(str(tmp_path / "t.so"))
    found = []
    for name in names:
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * 2
        found.append(function)
    return found


def lookup_expected(table, points, angle, speed):
    """Straight lines between equidistant values of the table, read ahead by its delay."""
    at = table.zero + 2.0 * math.pi * np.arange(points) / points
    led = angle + table.delay * speed - table.zero
    ways = [Points(table.one_direction(at, backward)[None]).value(led, False) for backward in (False, True)]
    return np.where(speed < 0.0, ways[1], ways[0])


@needs_compiler
@pytest.mark.parametrize("name", TABLES)
def test_the_c_header_compiles_without_warnings_and_equals_value(tmp_path, name):
    table = TABLES[name]
    table.write(tmp_path / "order_table.h", points=96)
    source = (
        '#include "order_table.h"\n'
        "double value(double a, double s) { return order_table_value(a, s); }\n"
        "double lookup(double a, double s) { return order_table_lookup(a, s); }\n"
    )
    value, lookup = compiled(tmp_path, source, ["value", "lookup"])
    angle, speed = operating_points()
    scale = max(table.rms, 1e-12)
    got = np.array([value(a, s) for a, s in zip(angle, speed, strict=True)])
    assert np.max(np.abs(got - table.value(angle, speed))) <= 1e-12 * scale
    got = np.array([lookup(a, s) for a, s in zip(angle, speed, strict=True)])
    assert np.max(np.abs(got - lookup_expected(table, 96, angle, speed))) <= 1e-11 * scale


@needs_compiler
@pytest.mark.parametrize("name", [name for name in TABLES if name != "torque"])
def test_the_code_of_the_hal_component_compiles_and_equals_value(tmp_path, name):
    table = dataclasses.replace(TABLES[name], ratio=120.0)
    table.write(tmp_path / "order_table.comp", "hal")
    text = (tmp_path / "order_table.comp").read_text()
    head, code = text.split("\n;;\n")
    pins = re.findall(r'^pin (in|out) float (\w+) "', head, re.MULTILINE)
    assert pins == [("in", "position"), ("in", "velocity"), ("out", "correction")]
    assert re.search(r"^component order_table ", head, re.MULTILINE)
    # as halcompile does: pins are names for memory of the component, FUNCTION opens a function
    source = (
        "#include <math.h>\nstatic double position, velocity, correction;\n"
        "#define FUNCTION(name) static void run(void)\n"
        f"{code}\ndouble value(double p, double v) {{ position = p; velocity = v; run(); return correction; }}\n"
    )
    (value,) = compiled(tmp_path, source, ["value"])
    angle, speed = operating_points()
    degrees, rate = ((x - shift) / 120.0 / DEGREE for x, shift in ((angle, table.zero), (speed, 0.0)))
    got = np.array([value(p, v) for p, v in zip(degrees, rate, strict=True)]) * DEGREE
    assert np.max(np.abs(got - table.value(angle, speed))) <= 1e-11 * max(table.rms, 1e-12)


@needs_compiler
def test_any_name_of_c_may_be_the_prefix(tmp_path):
    prefix = "MY_NAME_FORWARD_BACKWARD"
    TWO_WAYS.write(tmp_path / "a.h", prefix=prefix)
    source = (
        f'#include "a.h"\ndouble value(double a, double s) {{ return {prefix}_value(a, s) + {prefix}_lookup(a, s); }}\n'
    )
    (value,) = compiled(tmp_path, source, ["value"])
    assert value(0.3, -1.0) == pytest.approx(2.0 * TWO_WAYS.value(0.3, -1.0), rel=0.02)
    assert sw.OrderTable.read(tmp_path / "a.h") == TWO_WAYS


def translated(text, name):
    """A function of structured text as a function of Python: the few statements that the writer uses."""
    body = re.search(rf"FUNCTION {name} : LREAL\n(.*?)END_FUNCTION", text, re.DOTALL).group(1)
    constants = {}
    for variable, low, value in re.findall(r"(\w+) : (?:ARRAY\[(\d)\.\.\d+\] OF )?LREAL := ([^;]+);", body):
        numbers = [float(v) for v in value.strip("[]").split(",")]
        assert all("." in v for v in value.strip("[]").split(","))  # a literal of IEC 61131-3 has a point
        constants[variable] = [math.nan] * int(low) + numbers if low else numbers[0]
    code, depth = [f"def {name}(angle, speed):"], 1
    for line in body.rpartition("END_VAR\n")[2].strip().splitlines():
        plain = line.strip().rstrip(";")
        if not plain:
            continue
        if plain in ("END_IF", "END_FOR", "ELSE"):
            depth -= 1
        if (found := re.fullmatch(r"FOR (\w+) := (\d+) TO (\d+) DO", plain)) is not None:
            plain = "for {} in range({}, {} + 1):".format(*found.groups())
        plain = re.sub(r"^IF (.*) THEN$", r"if \1:", plain).replace("ELSE", "else:").replace(" := ", " = ")
        code.append("    " * depth + plain.replace("END_IF", "pass").replace("END_FOR", "pass"))
        if plain.endswith(":"):
            depth += 1
    code = [line for line in code if not line.endswith("pass")]
    code.append(f"    return {name}_value")
    known = {"COS": math.cos, "LREAL_TO_DINT": round, "DINT_TO_LREAL": float} | constants
    exec("\n".join(code).replace(f"{name} = ", f"{name}_value = "), known)
    return known[name]


@pytest.mark.parametrize("name", TABLES)
def test_the_structured_text_does_what_value_does(tmp_path, name):
    table = TABLES[name]
    table.write(tmp_path / "table.st", "st", points=96)
    text = (tmp_path / "table.st").read_text()
    value, lookup = translated(text, "F_OrderTable"), translated(text, "F_OrderTableLookup")
    angle, speed = operating_points(500)
    scale = max(table.rms, 1e-12)
    got = np.array([value(a, s) for a, s in zip(angle, speed, strict=True)])
    assert np.max(np.abs(got - table.value(angle, speed))) <= 1e-12 * scale
    got = np.array([lookup(a, s) for a, s in zip(angle, speed, strict=True)])
    assert np.max(np.abs(got - lookup_expected(table, 96, angle, speed))) <= 1e-11 * scale


def test_the_head_states_what_the_points_of_the_lookup_leave(tmp_path):
    one = sw.OrderTable((sw.Line(3, 1.0, 0.2),))
    one.write(tmp_path / "a.h", points=72)
    stated = float(re.search(r"72 points leave (\S+) rad", (tmp_path / "a.h").read_text()).group(1))
    angle = np.linspace(0.0, 2.0 * math.pi, 100_000)
    expected = np.sqrt(np.mean((lookup_expected(one, 72, angle, 0.0 * angle) - one.value(angle)) ** 2))
    assert stated == pytest.approx(expected, rel=0.01)
