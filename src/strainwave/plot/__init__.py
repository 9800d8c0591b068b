"""Figures of results: plain panels, drawn as SVG or on axes of matplotlib."""

from .axes import draw as draw
from .panels import Axis as Axis
from .panels import Panel as Panel
from .panels import panels_of as panels_of
from .svg import figure as figure
