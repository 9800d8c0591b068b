"""Make docs/_static/axis.svg, the figure of the README, from the README's project."""

import re
from pathlib import Path
from tempfile import TemporaryDirectory

from strainwave.app.commands.cli import cli

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs/_static/axis.svg"


def main() -> None:
    """Draw the response of the project, the same bytes each time."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    with TemporaryDirectory() as folder:
        project = Path(folder) / "axis.yaml"
        project.write_text(re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)[0], encoding="utf-8")
        cli(["response", str(project), "-o", str(TARGET)], standalone_mode=False)


if __name__ == "__main__":
    main()
