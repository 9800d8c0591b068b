"""What stands above a model or a result, loaded by its name where it is asked for: no other file imports by string.

Modules by the names that they had in version 0.2, too.
"""

import warnings
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location, spec_from_loader
from typing import Any

ROOT = __package__.partition(".")[0]
HOMES = {
    "figures": "plot.every_figure",
    "analyze": "study.analysis.analyze",
    "draw": "plot",
    "html": "app.notebook",
    "judged": "study.analysis.verdict",
    "panels_of": "plot",
    "project_entry": "files.fields.entries",
    "to_control": "drive.state_space",
}
IN_BASE = ("choices", "law", "protocols", "quantities", "records", "results", "sentences", "series", "units")
FORMER = {f"{ROOT}.{name}": f"{ROOT}.base.{name}" for name in IN_BASE} | {
    f"{ROOT}.tree": f"{ROOT}.compile.tree", f"{ROOT}.app.figures.svg": f"{ROOT}.plot",
}  # fmt: skip

DRAWN = (
    "basins bode branch decay design drive general_validity identified log orbit orbit_diagram order_scan response "
    "response_fit run slow_response speed_map trajectory validity variability"
)
DRAWERS = {f"draw_{what}" for what in DRAWN.split()}  # public functions of version 0.2, in the place of `draw`


def above(name: str) -> Any:
    """One of the functions of HOMES."""
    return thing(f"{ROOT}.{HOMES[name]}", name)


def thing(module: str, name: str) -> Any:
    """What a module has under a name, the module loaded where it was not."""
    return getattr(import_module(module), name)


def drawer(name: str) -> Any:
    """Return a function of DRAWERS, with a warning that says what is in its place."""
    warnings.warn(f"{ROOT}.{name}(axes, result) is result.plot(axes) now", FutureWarning, stacklevel=3)
    return lambda axes, result: above("draw")(result, axes)


class Former(MetaPathFinder, Loader):
    """Finder of the modules of FORMER by their former names: importing one warns and says where it is now."""

    def find_spec(self, name: str, _path: Any = None, _target: Any = None) -> ModuleSpec | None:
        """Return the place of a module that has moved."""
        if name not in FORMER:
            return None
        warnings.warn(f"the module {name} is {FORMER[name]} now; import it from there", FutureWarning, stacklevel=2)
        return spec_from_loader(name, self)

    def create_module(self, spec: ModuleSpec) -> Any:
        """Return the module itself."""
        return import_module(FORMER[spec.name])

    def exec_module(self, module: Any) -> None:
        """Give it its own place back, which the import has changed."""
        module.__spec__ = spec_from_file_location(module.__name__, module.__file__)
