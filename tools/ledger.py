"""Write some thousand numbers of all that the package answers, and compare two such lists.

    python tools/ledger.py write FILE.json [--only PREFIX ...]
    python tools/ledger.py compare OLD.json NEW.json [--only PREFIX ...]

The list is written at the commit before a big change and after it; `compare` names what differs by more than the error
that stands beside each number in OLD. Both lists are of one machine, as last digits differ between processors.

A capability is one function in `tools/ledgers/`, a generator of (label, thing, relative error); its name is the prefix
of the names of its numbers. `flat` takes things apart: results, models, dictionaries, arrays. Only public names are
used, so that the same file runs before and after. What is not in the list stands in `LEFT_OUT`.
"""

import argparse
import inspect
import json
import math
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import chdir
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

ROOMS = ("closed_forms", "motions", "studies", "measured", "files", "commands")
LEFT_OUT = {
    "demo": "the analyses of three axes",
    "draw": "pictures; `draw` of the results is called by the commands that write figures",
    "app": "serves a page; its answers are those of the verbs",
    "read_specification": "read by the command design",
    "replaced": "changes a number of a model, which the verbs then show",
    "speed_table": "a controller made of a prediction_table",
    "completion, schema, new": "texts, which their tests compare",
    "doctor": "tells of the machine",
    "scattered": "drawn by exceedance",
}
SKIPPED = {"steps", "rejected", "switches", "path", "text", "project"}
MOST = 8  # elements of an array that are written one by one
Entry = tuple[str, Any, float]


def flat(name: str, thing: Any, error: float) -> Iterator[Entry]:
    """Numbers and words of a thing with absolute errors; an array has the error of its largest element."""
    if isinstance(thing, Enum):
        yield name, thing.name, 0.0
    elif thing is None or isinstance(thing, str | bool | np.bool_ | int):
        yield name, thing if thing is None or isinstance(thing, str) else int(thing), 0.0
    elif isinstance(thing, np.integer):
        yield name, int(thing), 0.0
    elif isinstance(thing, float):
        yield name, float(thing), error * abs(thing) if math.isfinite(thing) else 0.0
    elif isinstance(thing, complex):
        yield from flat(name, np.array([thing]), error)
    elif isinstance(thing, np.ndarray):
        yield from array(name, thing, error)
    elif isinstance(thing, Fraction):
        yield name, str(thing), 0.0
    elif hasattr(thing, "data_vars"):
        yield from flat(name, {key: value.values for key, value in thing.data_vars.items()}, error)
    elif isinstance(thing, Mapping):
        for key, value in thing.items():
            if key not in SKIPPED:
                yield from flat(f"{name}/{key}", value, error)
    elif hasattr(thing, "_asdict"):
        yield from flat(name, {"": type(thing).__name__} | thing._asdict(), error)
    elif isinstance(thing, list | tuple):
        if thing and all(isinstance(value, float) for value in thing):
            yield from array(name, np.array(thing), error)
        else:
            for i, value in enumerate(thing):
                yield from flat(f"{name}/{i}", value, error)
    elif is_dataclass(thing):
        yield from flat(name, {field.name: getattr(thing, field.name) for field in fields(thing)}, error)
    elif not callable(thing) and not isinstance(thing, Path):
        raise TypeError(f"{name} is a {type(thing).__name__}, which cannot be taken apart")


def array(name: str, values: np.ndarray, error: float) -> Iterator[Entry]:
    """Elements of a small array; of a long one its size, both ends, the root mean square and both extremes."""
    if values.dtype.kind in "OSU":
        yield from flat(name, [str(v) for v in values.ravel()[:MOST]], error)
        return
    if values.dtype.kind == "c":
        values = np.stack([values.real, values.imag])
    whole = values.dtype.kind in "bi"
    values = values.astype(float).ravel()
    finite = values[np.isfinite(values)]
    scale = 0.0 if whole else error * float(np.max(np.abs(finite), initial=0.0))
    if len(values) > MOST:
        yield f"{name}/size", len(values), 0.0
        yield f"{name}/finite", len(finite), 0.0
        picked = {"first": values[0], "last": values[-1]}
        if len(finite):
            picked |= {"rms": np.sqrt(np.mean(finite**2)), "least": finite.min(), "most": finite.max()}
    else:
        picked = {f"{i}": value for i, value in enumerate(values)}
    for key, value in picked.items():
        yield f"{name}/{key}", float(value), scale if math.isfinite(value) else 0.0


def entries(only: list[str]) -> Iterator[Entry]:
    """Every number of the functions whose names begin with one of `only`; what a function raises is an entry too."""
    sys.path.insert(0, str(Path(__file__).parent))
    for room in ROOMS:
        module = import_module(f"ledgers.{room}")
        for name, function in vars(module).items():
            own = inspect.isgeneratorfunction(function) and function.__module__ == module.__name__
            if not own or name[0] == "_" or (only and not name.startswith(tuple(only))):
                continue
            began = time.process_time()
            count = 0
            try:
                for label, thing, error in function():
                    for entry in flat(f"{name}/{label}", thing, error):
                        yield entry
                        count += 1
            except Exception as failure:  # the list goes on, and the comparison tells
                yield f"{name}/raised", f"{type(failure).__name__}: {failure}", 0.0
                print(f"{name} raised {type(failure).__name__}: {failure}", file=sys.stderr)
            print(f"{name}: {count} numbers, {time.process_time() - began:.1f} s", file=sys.stderr, flush=True)


def write(path: Path, only: list[str]) -> int:
    """Compute everything in a folder of its own; the file appears when it is complete."""
    path, found = path.resolve(), {}
    with TemporaryDirectory() as folder, chdir(folder):
        for name, value, error in entries(only):
            if name in found:
                raise ValueError(f"two numbers have the name {name}")
            found[name] = [value, error]
    part = path.with_name(f"{path.name}.part")
    part.write_text(json.dumps(found, indent=0), encoding="utf-8")
    os.replace(part, path)
    print(f"{len(found)} numbers in {path}, {time.process_time():.0f} s of processor time", file=sys.stderr)
    return 0


def compare(old: Path, new: Path, only: list[str]) -> int:
    """Print what differs by more than its error, what is missing and what is new; 1 where something differs."""
    lists = [json.loads(path.read_text(encoding="utf-8")) for path in (old, new)]
    first, second = ({k: v for k, v in one.items() if not only or k.startswith(tuple(only))} for one in lists)
    changed: Counter[str] = Counter()
    for name, (value, error) in first.items():
        other = second.get(name, [None])[0]
        if name in second and same(value, other, error):
            continue
        numbers = isinstance(value, float) and isinstance(other, float)
        far = f", {abs(other - value) / error:.3g} times the error" if numbers and error > 0.0 else ""
        print(f"differs  {name}: {value!r} -> {other!r}{far}" if name in second else f"missing  {name}: {value!r}")
        changed[f"{name.split('/')[0]}, {'words' if isinstance(value, str) else 'numbers'}"] += 1
    for name in (name for name in second if name not in first):
        print(f"new      {name}: {second[name][0]!r}")
    for kind, count in changed.items():
        print(f"{kind}: {count} differ or are missing")
    print(f"{changed.total()} of {len(first)} differ or are missing, {len(second.keys() - first.keys())} are new")
    return int(changed.total() > 0)


def same(value: Any, other: Any, error: float) -> bool:
    """Whether two values agree within an error; words and counts are identical, and NaN is NaN."""
    if isinstance(value, float) and isinstance(other, float):
        return value == other or abs(value - other) <= error or (math.isnan(value) and math.isnan(other))
    return type(value) is type(other) and bool(value == other)


def main() -> int:
    """Run one of both verbs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    writing = verbs.add_parser("write")
    writing.add_argument("file", type=Path)
    comparing = verbs.add_parser("compare")
    comparing.add_argument("old", type=Path)
    comparing.add_argument("new", type=Path)
    for verb in (writing, comparing):
        verb.add_argument("--only", action="append", default=[], help="functions whose names begin so; repeatable")
    asked = parser.parse_args()
    return write(asked.file, asked.only) if asked.verb == "write" else compare(asked.old, asked.new, asked.only)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("interrupted; nothing was written")
