"""What stands above a model or a result, loaded by its name where it is asked for: no other file imports by string."""

from importlib import import_module
from typing import Any

HOMES = {
    "analyze": "study.analysis.analyze",
    "draw": "plot",
    "html": "app.notebook",
    "judged": "study.analysis.verdict",
    "project_entry": "files.entries",
    "to_control": "drive.state_space",
}


def above(name: str) -> Any:
    """One of the functions of HOMES."""
    return thing(f"{__package__}.{HOMES[name]}", name)


def thing(module: str, name: str) -> Any:
    """What a module has under a name, the module loaded where it was not."""
    return getattr(import_module(module), name)
