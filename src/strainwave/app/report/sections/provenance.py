"""Origin of the report: the project file with its hash, the versions, and the command that makes it again."""

import platform
from hashlib import sha256
from importlib.metadata import version
from shlex import quote
from typing import Any

from .... import __version__
from ....base.facts import Fact, data
from ....base.sentences import printable
from ....files.notes import source_facts
from ...view import View

SOFTWARE = ("numpy", "scipy", "numba")


class Provenance:
    """Source of each number, the whole project file, the SHA-256 of its text (UTF-8), versions, and the command."""

    heading = "Project and provenance"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """Hash, versions and command."""
        path = view.project.path
        versions = {"strainwave": __version__, "python": platform.python_version()}
        return {
            "sources": data([Fact("rows", source_facts(view.project))])["rows"],
            "provenance": {
                "project_sha256": sha256(view.project.text.encode()).hexdigest(),
                "versions": versions | {name: version(name) for name in SOFTWARE},
                "command": f"strainwave analyze {_word(path.name)} -o {_word(path.stem)}",
            },
        }


def _word(name: str) -> str:
    """A file name as one word of a shell, which no command takes for an option."""
    return quote(printable(f"./{name}" if name.startswith("-") else name))
