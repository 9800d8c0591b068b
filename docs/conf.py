"""Sphinx settings: `make docs` builds into docs/_build/html, a warning being an error."""

import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx import addnodes

import strainwave

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
SKILL = Path(strainwave.__file__).parent / "app" / "skill.md"
SECTIONS = ("speeds", "moves", "gear", "design", "measurements", "control", "closed_forms")  # of the gallery
sys.path.insert(0, str(EXAMPLES))

project = "strainwave"
author = "the strainwave developers"
copyright = f"2026, {author}"
version = release = strainwave.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
]
exclude_patterns = ["_build", "auto_examples/*.ipynb"]

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
mathjax_path = "mathjax/tex-svg.js"  # from _static: pages make no request to another host

myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 3

napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

autosummary_generate = False
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"

if any(EXAMPLES.glob("GALLERY_HEADER.*")) or any(EXAMPLES.glob("README.*")):
    extensions.append("sphinx_gallery.gen_gallery")
    sphinx_gallery_conf = {
        "examples_dirs": str(EXAMPLES),
        "gallery_dirs": "auto_examples",
        "subsection_order": [f"../examples/{section}" for section in SECTIONS],
        "within_subsection_order": "FileNameSortKey",
        "filename_pattern": r"\.py$",
        "download_all_examples": False,
        "show_memory": False,
        "write_computation_times": False,
    }


def short_types(app, what, name, thing, options, signature, returned):
    """Write ArrayLike for the twelve types that it stands for."""
    spelt_out = r"_Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]"
    return re.sub(spelt_out, "ArrayLike", signature or "") or None, returned


def skip_fields(app, what, name, member, skip, options):
    """Leave out what the class builder writes about a NamedTuple's fields: the signature has them with units."""
    return True if type(member).__name__ == "_tuplegetter" else None


def escape_formulas(app, what, name, thing, options, lines):
    """Docstrings are plain text with formulas such as 2 * |x|, which reStructuredText would take for markup."""
    for i, line in enumerate(lines):
        parts = re.split(r"(``.*?``|`.*?`)", line)
        parts[::2] = (re.sub(r"([|*]|(?<=\w)_(?!\w))", r"\\\1", part) for part in parts[::2])
        lines[i] = "".join(parts)


def join_names(app, what, name, thing, options, lines):
    """Write "K1,K2" for "K1, K2" in what napoleon makes of attributes: Sphinx would take the first for a type."""
    for i, line in enumerate(lines):
        if match := re.match(r":(?:ivar|vartype) [\w, ]+:", line):
            kind, _, names = match.group().partition(" ")
            lines[i] = f"{kind} {names.replace(', ', ',')}{line[match.end() :]}"


def add_summary(app, docname, source):
    """Put a table of a page's names, a sentence each, in the place of {{ summary }}."""
    names = re.findall(r"^\.\. auto(?:class|function):: (\S+)$", source[0], re.MULTILINE)
    lines = ["```{eval-rst}", ".. autosummary::", "   :nosignatures:", "", *(f"   ~{name}" for name in names), "```"]
    source[0] = source[0].replace("{{ summary }}", "\n".join(lines))


def link_names(app, doctree):
    """Make `sw.name` and `sw.name(...)` links to the page of that name; `project` is a Project, `drive` a Drive."""
    for code in list(doctree.findall(nodes.literal)):
        match = re.match(r"(?:sw\.([\w.]+)|((?:project|drive)\.\w+)\()", code.astext())
        if match and not isinstance(code.parent, (nodes.reference, nodes.title, addnodes.pending_xref)):
            name = (match[1] or match[2].capitalize()).replace("report.", "app.report.")
            page = app.env.docname
            where = {"refdomain": "py", "reftype": "obj", "reftarget": f"strainwave.{name}", "refdoc": page}
            link = addnodes.pending_xref("", code.deepcopy(), refexplicit=True, refwarn=page == "command-line", **where)
            code.replace_self(link)


def write_doors(app, error):
    """Write llms.txt, the text of `strainwave skill`, beside the start page."""
    if error is None:
        (Path(app.outdir) / "llms.txt").write_bytes(SKILL.read_bytes())


def setup(app):
    app.connect("build-finished", write_doors)
    app.connect("doctree-read", link_names)
    app.connect("source-read", add_summary)
    app.connect("autodoc-process-docstring", escape_formulas, priority=400)  # before napoleon writes its own markup
    app.connect("autodoc-process-docstring", join_names, priority=600)
    app.connect("autodoc-process-signature", short_types)
    app.connect("autodoc-skip-member", skip_fields)
