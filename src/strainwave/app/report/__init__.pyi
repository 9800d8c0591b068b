"""The report of a drive: `write` and its `SECTIONS`, each of them one object, to which your own can be added."""

from ..view import View as View
from .report import Report as Report
from .report import write as write
from .section import Part as Part
from .section import Section as Section
from .section import Table as Table
from .sections import SECTIONS as SECTIONS
