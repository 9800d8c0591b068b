"""All figures of results, which register themselves: `panels_of` loads them for a class that it does not know yet."""

from types import ModuleType

from . import compensation, curves, drive, fits, studies


def figures() -> tuple[ModuleType, ...]:
    """Return the modules of the figures."""
    return compensation, curves, drive, fits, studies
