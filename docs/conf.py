"""Sphinx settings: `make docs` builds into docs/_build/html, a warning being an error."""

import sys
from pathlib import Path

import strainwave

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
sys.path.insert(0, str(EXAMPLES))

project = "strainwave"
author = "the strainwave developers"
copyright = f"2026, {author}"
version = release = strainwave.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
exclude_patterns = ["_build", "auto_examples/*.ipynb"]

html_theme = "furo"
html_static_path = ["_static"]
mathjax_path = "mathjax/tex-svg.js"  # from _static: pages make no request to another host

myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 3

napoleon_google_docstring = False
napoleon_use_rtype = False

if any(EXAMPLES.glob("GALLERY_HEADER.*")) or any(EXAMPLES.glob("README.*")):
    extensions.append("sphinx_gallery.gen_gallery")
    sphinx_gallery_conf = {
        "examples_dirs": str(EXAMPLES),
        "gallery_dirs": "auto_examples",
        "filename_pattern": r"\.py$",
        "download_all_examples": False,
        "show_memory": False,
        "write_computation_times": False,
    }
