"""All figures of results, which register themselves: `panels_of` loads them for a class that it does not know yet."""

from collections.abc import Iterator


def figures() -> Iterator[object]:
    """Load the modules of the figures, those last that need the most."""
    from . import compensation, curves, drive, loop, portrait

    yield compensation, curves, drive, loop, portrait
    from . import designs, moves, speed_maps

    yield designs, moves, speed_maps
    from . import fits

    yield fits
