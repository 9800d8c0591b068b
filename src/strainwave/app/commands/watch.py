"""`strainwave watch`: the verdict on a project file again at each save."""

from pathlib import Path
from time import sleep, strftime

import click

from ...files.reading import ProjectError, from_text
from ...files.yaml_text import FileError, text_of
from ...study.analysis.verdict_words import first_lines
from ..console import Progress, echo, in_options
from ..view import View
from .options import project_argument

LOOK_S = 0.2  # between two looks at the file


@click.command()
@project_argument
def watch(project: Path) -> None:
    """Judge a drive again at each save of its project file."""
    seen = judged = ("", "")
    try:
        while True:
            before, seen = seen, _content(project)
            if seen == before != judged:  # two looks alike: the save is whole
                judged = seen
                echo(f"{strftime('%H:%M:%S')} {_verdict(project, *seen)}")
            sleep(LOOK_S)
    except KeyboardInterrupt:
        return


def _content(path: Path) -> tuple[str, str]:
    """Text of a file, and the complaint where it has none that can be read."""
    try:
        return text_of(path, error=ProjectError), ""
    except FileError as error:
        return "", str(error)


def _verdict(path: Path, text: str, complaint: str) -> str:
    """Headline, sentence and remedy of a project file, or its complaint."""
    if complaint:
        return complaint
    try:
        project = from_text(text, path)
        with Progress(project.title) as progress:
            analysis = project.analyze(progress.show, resonances=False)
        headline, *lines = View.of(project, analysis).rendered(list(first_lines(analysis)))
    except (ValueError, TypeError, RuntimeError) as error:  # a refused file or drive: the next save may mend it
        return in_options(str(error))
    return "\n  ".join(filter(None, [f"{project.title}: {headline}", *lines]))
