"""All figures of results: functions that register themselves for their classes as their modules are imported.

`panels_of` calls the loaders in turn for a class that it does not know yet.
"""

from collections.abc import Callable


def load_drives() -> None:
    """Import the figures of curves and drives."""
    from . import compensation, curves, drive, loop, portrait  # noqa: F401


def load_studies() -> None:
    """Import the figures of studies."""
    from . import designs, moves, speed_maps  # noqa: F401


def load_fits() -> None:
    """Import the figures of fits."""
    from . import fits  # noqa: F401


def figure_loaders() -> tuple[Callable[[], None], ...]:
    """The loaders, those last that need the most."""
    return load_drives, load_studies, load_fits
