"""The project file, for the record."""

from typing import Any

from ...view import View


class ProjectFile:
    """The text of the project file, and the conventions of the report."""

    heading = "Project"

    def data(self, view: View) -> dict[str, Any]:
        """Its text."""
        return {"project": view.project.text}

    def lines(self, _: View, __: dict[str, Any]) -> list[str]:
        """Nothing: the reader has the file."""
        return []
