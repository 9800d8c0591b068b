"""YAML 1.2 text to mappings, lists and strings, with the line and column of every key and value.

Scalars stay the text that the person wrote: "1e-3", "no" or "0x10" cannot turn into something else on the way. What
a project file never needs (aliases, tags, several documents, deep nesting) is refused: a hostile file costs little.
"""

import codecs
import gzip
import json
import re
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from io import BytesIO
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

FILE_BYTES = 256 * 1024
LEVELS = 10
MOST_VALUES = 20_000
MOST_SHOWN = 20
LONGEST_PATH = 300  # letters of it in a sentence
NULL = ("", "~", "null", "Null", "NULL")
# YAML allows tab, line feed, carriage return, next line and printable characters.
FORBIDDEN = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

Keys = tuple[str | int, ...]


class Problem(NamedTuple):
    """One thing that is wrong with a file: line and column (1-based), field, and a sentence with the remedy."""

    line: int
    column: int
    field: str
    sentence: str


class FileError(ValueError):
    """A file of the user's cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


def complaint(path: Path, problems: list[Problem]) -> str:
    """Write problems in the order of the file, one line each, and the number of those left out."""
    file = "".join(c if c.isprintable() else "?" for c in str(path))
    file = file if len(file) <= LONGEST_PATH else f"...{file[-LONGEST_PATH:]}"
    lines = [f"{file}:{p.line}:{p.column}: {p.field}: {p.sentence}" for p in sorted(set(problems))]
    hidden = len(lines) - MOST_SHOWN
    if hidden > 0:
        lines[MOST_SHOWN:] = [f"{file}: {hidden} further problems; correct these first"]
    return "\n".join(lines)


def refuse(path: Path, problems: list[Problem], error: type[FileError] = FileError) -> None:
    """Raise the complaint about the problems of a file, if there are any."""
    if problems:
        raise error(complaint(path, problems))


class Unreadable(Exception):
    """Reading cannot go on; the argument is the last `Problem`."""


@dataclass
class Located:
    """Content of a file (mappings, lists, strings, None) with the positions of its values and keys."""

    content: Any = None
    values: dict[Keys, tuple[int, int]] = field(default_factory=dict)
    keys: dict[Keys, tuple[int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def position(self, keys: Keys) -> tuple[int, int]:
        """Line and column of a value, or of the nearest group around it."""
        while keys and keys not in self.values:
            keys = keys[:-1]
        return self.values.get(keys, (1, 1))


def name(keys: Keys) -> str:
    """Spell a field: ("load_torque", "lines", 0, "order") is "load_torque.lines[0].order"."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{_shown(key)}" for key in keys)
    return text.removeprefix(".") or "file"


def _shown(key: str) -> str:
    plain = key if key.isprintable() else key.encode("unicode_escape").decode("ascii")
    return plain if len(plain) <= 40 else plain[:37] + "..."


def kind_of(value: object) -> str:
    """Name the kind of a value: "a list", "a group of fields" or "a text"."""
    if isinstance(value, list):
        return "a list"
    return "a group of fields" if isinstance(value, dict) else "a text"


def shown(value: object) -> str:
    """Quote a value in a sentence: a text in quotes and on one line, else its kind."""
    return repr(value if len(value) <= 40 else value[:37] + "...") if isinstance(value, str) else kind_of(value)


def read_text(
    path: Path, kind: str = "project file", largest: int = FILE_BYTES, notes: list[str] | None = None
) -> str | Problem:
    """Return the text of a file, or why there is none; a file larger than `largest` bytes is not read.

    Where `notes` are given, a text that is not UTF-8 is read as Windows-1252, and a note says so.
    """
    try:
        if path.is_dir():
            return Problem(1, 1, "file", f"is a directory; give the {kind} inside it")
        size = path.stat().st_size
        if size > largest:
            return Problem(1, 1, "file", f"has {size} bytes; a {kind} has at most {largest}, is it another file?")
        if not path.is_file():
            return Problem(1, 1, "file", f"is a device or a pipe; give a {kind}")
        data = path.read_bytes()[: largest + 1]
        if data.startswith(b"\x1f\x8b"):
            data = gzip.GzipFile(fileobj=BytesIO(data)).read(largest + 1)
            if len(data) > largest:
                return Problem(1, 1, "file", f"unpacks to more than {largest} bytes; is it another file?")
    except FileNotFoundError:
        return Problem(1, 1, "file", "does not exist; check the name and the folder")
    except PermissionError:
        return Problem(1, 1, "file", "no permission to read it; change its rights")
    except (OSError, ValueError, EOFError, zlib.error) as error:
        reason = "null character in the name" if "\0" in str(path) else getattr(error, "strerror", None) or str(error)
        return Problem(1, 1, "file", f"cannot be read ({reason}); check the name and the disk")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return _wide(data)
    if b"\0" in data[:8192]:
        form = " in YAML" if kind == "project file" else ""
        return Problem(1, 1, "file", f"is binary, not text; give a {kind}{form}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if notes is not None:
            with suppress(UnicodeDecodeError):
                western = data.decode("cp1252")
                notes.append("the file is not UTF-8 and was read as Windows-1252 (Latin-1)")
                return western
        before = data[: error.start].decode("utf-8", "replace")
        line, column = _position(before, len(before))
        return Problem(line, column, "file", f"has the byte {data[error.start]:#04x}, not UTF-8; save it as UTF-8 text")


def text_of(
    path: Path, kind: str = "project file", largest: int = FILE_BYTES,
    error: type[FileError] = FileError, notes: list[str] | None = None,
) -> str:  # fmt: skip
    """Return the text of a file, or raise the complaint that says why there is none; see `read_text`."""
    text = read_text(path, kind, largest, notes)
    if isinstance(text, Problem):
        raise error(complaint(path, [text]))
    return text


def _wide(data: bytes) -> str | Problem:
    """Text that some editors save as UTF-16, with the mark at its beginning that says so."""
    try:
        return data.decode("utf-16")
    except UnicodeDecodeError:
        return Problem(1, 1, "file", "starts as UTF-16 text but is not UTF-16; save it as UTF-8 text")


def _position(text: str, index: int) -> tuple[int, int]:
    lines = re.split(r"\r\n|\r|\n", text[:index])
    return len(lines), len(lines[-1]) + 1


@lru_cache(maxsize=4)
def read(text: str) -> Located:
    """Read YAML text; `.problems` holds the faults, and `.content` the readable rest.

    The result is kept for the next call with the same text: change a copy.
    """
    # ruamel is imported here: only a project file needs it.
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    tree = Located(problems=_strange(text))
    if tree.problems:
        return tree
    try:
        _document(_counted(YAML(typ="safe", pure=True).parse(text)), tree)
        return tree
    except Unreadable as stop:
        problem = stop.args[0]
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        problem = Problem(line, column, "file", _syntax(str(error.problem or error.context), text, line))
    except (YAMLError, ValueError, LookupError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        problem = Problem(1, 1, "file", f"is not YAML ({reason[:80]}); see the example projects")
    return Located(problems=[*tree.problems, problem], values=tree.values, keys=tree.keys)


def read_again(text: str) -> Located:
    """Read JSON text of strings that was written from the content of a file; positions give the order alone."""
    out = Located(problems=_strange(text))
    if not out.problems:
        out.content = json.loads(text)
        _number(out.content, (), out)
    return out


def _number(value: object, keys: Keys, out: Located) -> None:
    out.values[keys] = out.keys[keys] = (len(out.values) + 1, 1)
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        _number(item, (*keys, key), out)


def _strange(text: str) -> list[Problem]:
    strange = FORBIDDEN.search(text)
    if strange is None:
        return []
    sentence = f"has the control character U+{ord(strange.group()):04X}; remove it"
    return [Problem(*_position(text, strange.start()), "file", sentence)]


def _syntax(reason: str, text: str, line: int) -> str:
    """Sentence for a syntax error, with the usual cause in front of the parser's own words."""
    lines = text.splitlines()
    faulty = lines[line - 1] if line <= len(lines) else ""
    if re.match(r" *\t", faulty):
        return "the line is indented with a tab; indent with spaces"
    if "mapping values are not allowed" in reason:
        return "a second ': ' in one line; put text with a colon in quotes, and each field on its own line"
    if "end of the stream" in reason or "<stream end>" in reason:
        return f"the file ends too early ({reason}); close the bracket or quote"
    return f"not YAML ({reason}); check indentation, colons, brackets and quotes"


def _counted(events: Iterator[Any]) -> Iterator[Any]:
    for count, event in enumerate(events):
        if count > MOST_VALUES:
            raise Unreadable(Problem(*_mark(event), "file", f"has more than {MOST_VALUES} values; is it another file?"))
        yield event


def _mark(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1


def _document(events: Iterator[Any], tree: Located) -> None:
    documents = 0
    for event in events:
        kind = type(event).__name__
        if kind == "DocumentStartEvent":
            documents += 1
            if documents > 1:
                sentence = "a second document begins; a project file has one, remove the line '---'"
                raise Unreadable(Problem(*_mark(event), "file", sentence))
        elif kind not in ("StreamStartEvent", "StreamEndEvent", "DocumentEndEvent"):
            tree.content = _value(event, events, (), tree)


def _value(event: Any, events: Iterator[Any], keys: Keys, tree: Located) -> Any:
    start = _mark(event)
    tree.values[keys] = start
    if len(keys) > LEVELS:
        raise Unreadable(Problem(*start, "file", f"is nested more than {LEVELS} levels deep; reduce the nesting"))
    kind = type(event).__name__
    if kind == "AliasEvent":
        tree.problems.append(Problem(*start, name(keys), f"'*{event.anchor}' is an alias; write the value out"))
        return None
    if event.tag not in (None, "!"):
        tag = str(event.tag).removeprefix("tag:yaml.org,2002:")
        tree.problems.append(Problem(*start, name(keys), f"has the tag {tag[:40]!r}; remove the tag"))
    if kind == "SequenceStartEvent":
        items = takewhile(lambda item: type(item).__name__ != "SequenceEndEvent", events)
        return [_value(item, events, (*keys, i), tree) for i, item in enumerate(items)]
    if kind == "MappingStartEvent":
        return _mapping(events, keys, tree)
    if event.style is None and event.value in NULL:
        # The parser places a value that is not there at the next word, perhaps lines below.
        start = start if event.value else tree.keys.get(keys, start)
        tree.problems.append(Problem(*start, name(keys), "is empty; write a value or remove the field"))
        return None
    return event.value


def _mapping(events: Iterator[Any], keys: Keys, tree: Located) -> dict[str, Any]:
    items: dict[str, Any] = {}
    for event in takewhile(lambda item: type(item).__name__ != "MappingEndEvent", events):
        if type(event).__name__ != "ScalarEvent":
            raise Unreadable(Problem(*_mark(event), name(keys), "has a key that is not a word; write 'name: value'"))
        key = (*keys, event.value)
        if event.value in items:
            first = tree.keys[key][0]
            tree.problems.append(Problem(*_mark(event), name(key), f"appears twice, first in line {first}; remove one"))
            _value(next(events), events, (*keys, "second " + event.value), Located())
            continue
        tree.keys[key] = _mark(event)
        value = _value(next(events), events, key, tree)
        before = next(reversed(items), None)
        if value is None and before is not None and _is_decimal_comma(items[before], event.value):
            # {inertia: 1,3 kg*m^2} is two fields to YAML; put together again, the number gets its own complaint.
            items[before] += "," + event.value
            tree.problems.pop()
            continue
        items[event.value] = value
    return items


def _is_decimal_comma(before: object, after: str) -> bool:
    return isinstance(before, str) and bool(re.search(r"[0-9]$", before) and re.match(r"[0-9]", after))
