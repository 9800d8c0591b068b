"""The formats of order tables by name: a new one is its class and a line here."""

from types import MappingProxyType

from ...quantities import shown
from .format import OrderFormat
from .formats.beckhoff import Beckhoff
from .formats.c_header import CHeader
from .formats.csv_lines import CsvLines
from .formats.csv_points import CsvPoints
from .formats.hal import HalComponent
from .formats.json_file import JsonFile
from .formats.linuxcnc import LinuxCnc
from .formats.moteus import Moteus
from .formats.onstepx import OnStepX
from .formats.sinumerik import Sinumerik
from .formats.structured_text import StructuredText
from .formats.twincat import TwinCat

CLASSES: tuple[type[OrderFormat], ...] = (
    JsonFile, CsvLines, CsvPoints, CHeader, StructuredText, Beckhoff, Moteus, LinuxCnc, HalComponent, TwinCat,
    Sinumerik, OnStepX,
)  # fmt: skip
FORMATS = MappingProxyType({cls.name: cls for cls in CLASSES})
BY_ENDING = MappingProxyType({".json": "json", ".csv": "csv", ".h": "c"})


def named(name: str) -> type[OrderFormat]:
    """Format of a name (ValueError)."""
    if name not in FORMATS:
        raise ValueError(f"{shown(name)} is no format of order tables; known are {', '.join(FORMATS)}")
    return FORMATS[name]


def recognised(text: str) -> type[OrderFormat] | None:
    """The format that a text looks like, if there is one."""
    return next((cls for cls in CLASSES if cls.recognises(text)), None)
