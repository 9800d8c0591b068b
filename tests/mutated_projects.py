"""Project files that a hand, an editor or a disk has spoilt: the same ones for the same seed."""

import random
import re

from twelve_projects import PROJECTS

VALUES = (
    "nan", ".nan", "inf", "-.inf", "1e309", "-1e400", "1e-320", "9" * 400, "0", "-0", "-5", "''", '""', "~", "null",
    "true", "no", "0x10", "1_000", "1,5", "1e", "--3", "3..4", "½", "۳", "10 ^ 5 N*m", "5 %%", "5 kg*m^2", "5 N*m/rad",
    "5 Hz", "5 rpm", "3 parsec", "5 rad/rad", "1 N*m^99", "5 °", "5'", "[]", "{}", "[1, 2]", "{a: b}",
    "[[[[[[[[1]]]]]]]]",
    "{type: linear}", "{type: cubic, K: nan N*m/rad, alpha: 1 1/rad^2}", "{python: x.py:Y}", "{python: ../x.py:Y}",
    "x.py:Y",
    "&a [*a]", "*a", "!!python/object:os.system ls", "!!binary aGk=", "|", ">", "@", "`", "%", "\t", "? x", "- - -",
    "- x",
    "CSG-40-50", "csg 40 50", "HDC", "catalogue", "none", "1e15", "1e16 kg*m^2", "1e-16 kg*m^2", "1e15 rpm", "x" * 5000,
    "[" * 50 + "]" * 50, "{a: " * 30 + "1" + "}" * 30, "\u202e5 N*m", "5\u00a0N*m", "\ufeff5", "'5 N*m", '"5 N*m',
    "5 # N*m",
    "{from: 5 N*m, to: 1 N*m}", "{from: nan N*m, to: inf N*m}", "[0.5, [1, 2]]", "1:30:00", "2026-01-01", "=", "<<: *a",
)  # fmt: skip
UNITS = ("N*m", "rad", "rpm", "kg*m^2", "N*m/rad", "arcsec", "Hz", "%", "", "K", "s", "furlong", "1/rad^2", "N·m·s/rad")
LETTERS = "{}[]:,-#'\"|>&*!%@`?~ \t\n\r\x00\x07\x1b\x7f\x85é漢😀\u2028\ufeff"


def _spot(text, chance, pattern):
    """A match of a pattern, any of them; None where there is none."""
    found = list(re.finditer(pattern, text))
    return chance.choice(found) if found else None


def _replaced(text, spot, new):
    return text if spot is None else text[: spot.start()] + new + text[spot.end() :]


def value(text, chance):
    """Another value in place of one."""
    return _replaced(text, _spot(text, chance, r"(?<=: )[^\s,{}\[\]#][^,{}\[\]\n#]*"), chance.choice(VALUES))


def group(text, chance):
    """Another value in place of a group or a list."""
    return _replaced(text, _spot(text, chance, r"\{[^{}]*\}|\[[^\[\]]*\]"), chance.choice(VALUES))


def unit(text, chance):
    """Another unit."""
    return _replaced(text, _spot(text, chance, r"(?<=[0-9] )[A-Za-z%][A-Za-z0-9*/^%]*"), chance.choice(UNITS))


def number(text, chance):
    """Another number with the same unit."""
    numbers = (*VALUES[:14], "1e30", "-1e14", "1e-14", "3e4", "1e6", "0.001", "-40", "1e9")
    return _replaced(text, _spot(text, chance, r"(?<=[:\[ ])-?[0-9][0-9.e]*"), chance.choice(numbers))


def key(text, chance):
    """Another key, one of the file's own or a wrong one."""
    own = [m[0] for m in re.finditer(r"\w+(?=:)", text)] + [
        "",
        "K",
        "type",
        "<<",
        "1",
        "x y",
        "[a]",
        "{b}",
        "é",
        "null",
    ]
    return _replaced(text, _spot(text, chance, r"\w+(?=:)"), chance.choice(own))


def deleted(text, chance):
    """A line less."""
    lines = text.split("\n")
    del lines[chance.randrange(len(lines))]
    return "\n".join(lines)


def doubled(text, chance):
    """A line twice, the second anywhere."""
    lines = text.split("\n")
    lines.insert(chance.randrange(len(lines) + 1), chance.choice(lines))
    return "\n".join(lines)


def indented(text, chance):
    """A line further in or out."""
    lines = text.split("\n")
    at = chance.randrange(len(lines))
    lines[at] = chance.choice((" ", "  ", "\t", "      ")) + lines[at] if chance.random() < 0.6 else lines[at].lstrip()
    return "\n".join(lines)


def cut(text, chance):
    """The begin alone."""
    return text[: chance.randrange(len(text) + 1)]


def part_deleted(text, chance):
    """A part less."""
    at = chance.randrange(len(text) + 1)
    return text[:at] + text[at + chance.randrange(40) :]


def letter(text, chance):
    """A letter more."""
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice(LETTERS) + text[at:]


def nested(text, chance):
    """A group inside itself, or the whole file inside a field."""
    spot = _spot(text, chance, r"\{[^{}]*\}")
    if spot is None or chance.random() < 0.2:
        return "gear:\n" + "\n".join("  " + line for line in text.split("\n"))
    return _replaced(text, spot, f"{{{chance.choice(('first', 'law', 'type', 'mean', 'x'))}: {spot[0]}}}")


def more(text, chance):
    """A field more at the end."""
    name = chance.choice(
        ("title", "limit", "scatter", "scatter_correlation", "move", "controller", "stiffness", "hysteresis")
    )
    return f"{text}\n{name}: {chance.choice(VALUES)}\n"


CHANGES = (
    value,
    value,
    group,
    unit,
    number,
    number,
    key,
    deleted,
    doubled,
    indented,
    cut,
    part_deleted,
    letter,
    nested,
    more,
)


def mutated(seed):
    """The bytes of a spoilt project file: one to three changes of a text, or bytes in it that are no text."""
    chance = random.Random(seed)
    text = PROJECTS[chance.choice(list(PROJECTS))]
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        text = chance.choice(CHANGES)(text, chance)
    content = text.encode("utf-8", "surrogatepass")
    if chance.random() < 0.05:
        at = chance.randrange(len(content) + 1)
        content = content[:at] + chance.randbytes(chance.randrange(1, 64)) + content[at:]
    if chance.random() < 0.02:
        content = text.encode(chance.choice(("utf-16", "utf-32", "cp1252", "latin-1")), "replace")
    return content


PLACED = re.compile(r"[^:]+:[0-9]+:[0-9]+: [^:]*.*: .+[;,:] .+|[^:]+: [0-9]+ further problems; correct these first")
LONGEST = 600  # letters of a sentence


def fault(code, output):
    """What is unsound about an answer; "" for nothing."""
    if "Traceback" in output or "(unexpected error" in output:
        return f"unexpected: {output[:300]}"
    if code == 0:
        numbers = [line for line in output.splitlines() if not re.search(r": valid\b|^Project '", line)]  # titles
        return "nan" if re.search(r"\bnan\b", "\n".join(numbers)) else ""
    if code != 3:
        return f"exit code {code}"
    lines = output.splitlines()
    wrong = [line for line in lines if not PLACED.fullmatch(line) or len(line) > LONGEST]
    return f"no sentence: {wrong[0][:300]}" if wrong else "" if lines else "silent"
