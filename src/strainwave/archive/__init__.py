"""Results as files."""

from .archive import as_file as as_file
from .archive import atomic as atomic
from .archive import listed as listed
from .archive import load as load
from .archive import version as version
from .archive import write as write
from .formats import ENDINGS as ENDINGS
