"""What stands above a model or a result, loaded by its name where it is asked for: no other file imports by string.

Tables of contents of namespaces, and modules by the names that they had in version 0.2, too.
"""

import sys
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import resolve_name, spec_from_file_location, spec_from_loader
from operator import attrgetter
from pathlib import Path
from typing import Any

ROOT = __package__.partition(".")[0]
HOMES = {
    "figures": "plot.every_figure",
    "analyze": "study.analysis.analyze",
    "draw": "plot",
    "html": "app.notebook",
    "how_sure": "files.variants.sureness",
    "judged": "study.analysis.verdict",
    "panels_of": "plot",
    "project_entry": "files.fields.entries",
    "sweep_project": "files.variants.project_sweep",
    "to_control": "drive.state_space",
}
NAMESPACES = ("laws", "train", "controllers", "gears", "fit", "sample", "numerics", "theory", "study", "results")
RENAMED = {  # public names of version 0.2 that are others now
    "compare_projects": "compare", "compensated_move": "compensate_move", "compensated_runup": "compensate_run_up",
    "derivation": "theory.derive", "measures": "numerics",
    "replace": "replaced", "sampling": "sample",
}  # fmt: skip
FORMER = dict(
    line.split() for line in Path(__file__).with_name("moved.txt").read_text("utf-8").splitlines() if line[:1] != "#"
)  # modules by the names that they had, which saved results name too, as a class that moved alone: where they are now

DRAWN = (
    "basins bode branch decay design drive identified log orbit orbit_diagram order_scan response "
    "response_fit run slow_response speed_map trajectory validity variability"
)
DRAWERS = {f"draw_{what}" for what in DRAWN.split()}  # public functions of version 0.2, in the place of `draw`


def above(name: str) -> Any:
    """One of the functions of HOMES."""
    return thing(f"{ROOT}.{HOMES[name]}", name)


def thing(module: str, name: str) -> Any:
    """What a module has under a name, the module loaded where it was not."""
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
            raise AttributeError(f"{package} has no name {name!r}; dir({package}) lists what it has")
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
        place = root.joinpath(*filter(None, places[space].split(".")), space)
        tables = (place.with_suffix(".pyi"), place / "__init__.pyi", place / "__init__.py")
        for name, _ in listed_in(next(table for table in tables if table.exists())):
            homes.setdefault(name, space)
    return homes


def former(name: str) -> Any:
    """What version 0.2 had at the top of the package under a name, with a warning that says where it is now."""
    if name == "sweep_project":
        call = f"{ROOT}.sweep({ROOT}.sample.largest, project, grid)"
        warnings.warn(f"{ROOT}.{name}(project, grid) is {call} now", FutureWarning, stacklevel=3)
        return above(name)
    if name in DRAWERS:
        warnings.warn(f"{ROOT}.{name}(axes, result) is result.plot(axes) now", FutureWarning, stacklevel=3)
        return lambda axes, result: above("draw")(result, axes)
    if f"{ROOT}.{name}" in FORMER:
        return import_module(f"{ROOT}.{name}")
    root = import_module(ROOT)
    places = {n: f"{space}.{n}" for n, space in namespaces().items()} | {n: n for n in root.__all__} | RENAMED
    if name not in places:
        from difflib import get_close_matches  # a millisecond, which a start does not take

        near = "".join(f"; did you mean {ROOT}.{places[n]}?" for n in get_close_matches(name, places, 1, 0.75))
        raise AttributeError(f"{ROOT} has no name {name!r}; dir({ROOT}) and its namespaces list what it has{near}")
    warnings.warn(f"{ROOT}.{name} is {ROOT}.{places[name]} now", FutureWarning, stacklevel=3)
    return attrgetter(places[name])(root)


class Former(MetaPathFinder, Loader):
    """Finder of the modules of FORMER by their former names: importing one warns and says where it is now."""

    def find_spec(self, name: str, _path: Any = None, _target: Any = None) -> ModuleSpec | None:
        """Return the place of a module that has moved, or an empty package around such modules."""
        if name not in FORMER:
            around = any(one.startswith(f"{name}.") for one in FORMER)
            return ModuleSpec(name, None, is_package=True) if around else None
        warnings.warn(f"the module {name} is {FORMER[name]} now; import it from there", FutureWarning, stacklevel=2)
        return spec_from_loader(name, self)

    def create_module(self, spec: ModuleSpec) -> Any:
        """Return the module itself."""
        return import_module(FORMER[spec.name])

    def exec_module(self, module: Any) -> None:
        """Give it its own place back, which the import has changed."""
        module.__spec__ = spec_from_file_location(module.__name__, module.__file__)
