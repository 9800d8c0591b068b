"""Results in notebooks: their summary as a table, and the figure of `plot` as SVG, without matplotlib."""

from .page import html as html
