"""Late imports of upper layers by name, so that lower modules need not import them.

Namespaces take their names from a table of contents, `__init__.pyi`, in the same way.
"""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

ROOT = __package__.partition(".")[0]
HOMES = {
    "figure_loaders": "plot.every_figure",
    "analyze": "study.analysis.analyze",
    "card": "app.notebook",
    "cases_of": "drive.postures",
    "draw": "plot",
    "html": "app.notebook",
    "how_sure": "files.variants.sureness",
    "judged": "study.analysis.verdict",
    "panels_of": "plot",
    "profile_part": "files.fields.profile_text",
    "project_entry": "files.fields.entries",
    "sweep_project": "files.variants.project_sweep",
    "to_control": "drive.state_space",
}
NAMESPACES = ("laws", "train", "controllers", "gears", "fit", "sample", "numerics", "theory", "study", "results")


def above(name: str) -> Any:
    """One of the functions of HOMES."""
    return thing(f"{ROOT}.{HOMES[name]}", name)


def thing(module: str, name: str) -> Any:
    """Attribute of a module, which is loaded if it was not."""
    return getattr(import_module(module), name)


def listed_in(file: Path) -> Iterator[tuple[str, str]]:
    """Public names that a table of contents lists, each with its home as the table writes it."""
    for line in file.read_text(encoding="utf-8").splitlines():
        match line.split():
            case ["from", home, "import", name, "as", _]:
                yield name, home


def contents(package: str, file: str) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """`__all__`, `__getattr__` and `__dir__` of a namespace whose table, a file .pyi, lies beside `file`.

    A name is loaded when it is first used.
    """
    homes = dict(listed_in(Path(file).with_suffix(".pyi")))
    inside = package if Path(file).stem == "__init__" else package.rpartition(".")[0]

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"{package} has no name {name!r}; dir({package}) lists what it has{_nearest(name)}")
        home = import_module(resolve_name(homes[name], inside))
        value = vars(home)[name] if name in vars(home) else import_module(f"{home.__name__}.{name}")
        setattr(sys.modules[package], name, value)
        return value

    return list(homes), load, lambda: sorted(homes)


@cache
def namespaces() -> dict[str, str]:
    """Names that the namespaces of the package list, each with the first namespace that has it."""
    root, homes = Path(__file__).parents[1], dict[str, str]()
    places = dict(listed_in(root / "__init__.pyi"))
    for space in NAMESPACES:
        path = root.joinpath(*filter(None, places[space].split(".")), space)
        table = path.with_suffix(".pyi")
        for name, _ in listed_in(table if table.exists() else path / "__init__.pyi"):
            homes.setdefault(name, space)
    return homes


def _nearest(name: str) -> str:
    """Question after the public name nearest to an unknown one, the end of a sentence; empty where none is near."""
    from difflib import get_close_matches  # a millisecond, which a start does not take

    if name.startswith("_"):  # what a tool asks every object for
        return ""
    places = {n: f"{space}.{n}" for n, space in namespaces().items()} | {n: n for n in import_module(ROOT).__all__}
    return "".join(f"; did you mean {ROOT}.{places[n]}?" for n in get_close_matches(name, places, 1))
