"""strainwave: the nonlinear dynamic error of strain wave gears (harmonic drives).

`__init__.pyi` beside this file is the table of contents. A name is loaded when it is first used, so that importing the
package costs nothing.
"""

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from .base.above import DRAWERS, FORMER, Former, drawer

__version__ = "0.2.0"


def _contents(file: Path, room: str = "") -> Iterator[tuple[str, str]]:
    """Public names that a table of contents lists, each with its home; a star stands for another table."""
    for line in file.read_text(encoding="utf-8").splitlines():
        match line.split():
            case ["from", home, "import", "*"]:
                yield from _contents(file.parent.joinpath(*home.split("."), "__init__.py"), home)
            case ["from", home, "import", name, "as", _]:
                yield name, (room + home).rstrip(".")


sys.meta_path.append(Former())
_HOME = dict(_contents(Path(__file__).with_suffix(".pyi")))

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name in DRAWERS:
        return drawer(name)
    if f"{__name__}.{name}" in FORMER:
        return import_module(f"{__name__}.{name}")
    if name not in _HOME:
        raise AttributeError(f"strainwave has no name {name!r}; dir(strainwave) lists what it has")
    home = import_module(_HOME[name] or ".", __name__)
    return vars(home)[name] if name in vars(home) else import_module(f"{home.__name__}.{name}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
