"""`strainwave analyze` and `demo`: from project files to folders with the report, results.json and CSV files."""

from collections.abc import Sequence
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path
from shlex import quote

import click

from ...drive.project import Project
from ...drive.run import drive_run
from ...files.reading import read_project
from ...files.yaml_text import FileError
from ...theory.resonance import PRIMARY
from ...theory.slow_flow.flow import slow_flow
from ..console import Progress, echo, in_options, staged, to_json, write_all
from ..report.comparison import verdicts_page
from ..report.report import Report, write
from .options import file_type, json_option, output_option

COMPARISON = "verdicts.html"
DRIVES = ("antenna", "robot-joint", "index-table")


@click.command()
@click.argument("projects", metavar="PROJECT...", nargs=-1, required=True, type=file_type)
@output_option(
    "Folder for report.html, results.json and CSV files; each of several projects has a subfolder. Default: "
    "PROJECT-report, or reports for several projects; nothing is written with --json but without --compare."
)
@click.option("--compare", is_flag=True, help="Also write verdicts.html: pass or fail of all projects side by side.")
@click.option("--check", is_flag=True, help="Only check whether the project files are valid.")
@json_option
def analyze(projects: tuple[Path, ...], output: Path | None, compare: bool, check: bool, as_json: bool) -> None:
    """Judge drives and their control loops; write a report of each."""
    if check:
        echo(_checked(projects, as_json))
        return
    if output is None and (compare or not as_json):
        output = Path(f"{projects[0].stem}-report" if len(projects) == 1 else "reports")
    echo(_analyzed(projects, output, compare, as_json))


@click.command()
@output_option("Folder for reports.", default=Path("strainwave-demo"))
@json_option
def demo(output: Path, as_json: bool) -> None:
    """Analyse three axes: an antenna, a robot joint, an index table."""
    sources = {name: files("strainwave.app") / "projects" / f"{name}.yaml" for name in DRIVES}
    reports = _reports({name: _read(source) for name, source in sources.items()}, output)
    for name, source in sources.items():
        write_all(output / name, {source.name: source.read_text(encoding="utf-8")})
    first = quote(str(output / DRIVES[0] / f"{DRIVES[0]}.yaml"))
    echo(_summaries(reports, output, as_json, f"project files are in the report folders: strainwave analyze {first}"))


def _read(source: Traversable) -> Project:
    with as_file(source) as path:
        return read_project(path)


def compile_ahead() -> None:
    """Compute one answer of each kind for a drive of `demo`: machine code for a first process beside this one.

    The order differs from that of `analyze`, so that each process finds what the other has made.
    """
    project = _read(files("strainwave.app") / "projects" / f"{DRIVES[0]}.yaml")
    slow_flow(project.system(reduced=True), PRIMARY).steady_states()
    if project.train is not None:
        project.train_response()
        drive_run(project.train, None, 0.1)
    project.analyze()


def _analyzed(paths: Sequence[Path], folder: Path | None, compare: bool, as_json: bool) -> str:
    """Analyse project files and return the text to print; several get a folder each, named like their files."""
    if compare and len(paths) < 2:
        raise ValueError(f"--compare needs two project files or more, but {len(paths)} is given; name the others too")
    if len(paths) == 1:
        report = report_of(read_project(paths[0]), folder)
        return to_json(report.results) if as_json else _summary(report, folder)
    names = [path.stem for path in paths]
    twice = next((name for name in names if names.count(name) > 1), None)
    nowhere = next((path for path, name in zip(paths, names, strict=True) if name in (".", "..", COMPARISON)), None)
    if nowhere is not None:
        raise ValueError(f"a report folder cannot have the name of {nowhere.name!r}; rename the project file")
    if twice is not None:
        raise ValueError(f"two project files have the name {twice!r}, but need separate folders; rename one of them")
    projects = dict(zip(names, _read_all(paths), strict=True))
    if compare and len({project.speeds.by_motor for project in projects.values()}) > 1:
        raise ValueError("some projects give forcing frequencies, others shaft speeds; compare one kind at a time")
    reports = _reports(projects, folder)
    more = []
    if compare and folder is not None:
        with staged(folder) as part:
            (part / COMPARISON).write_text(verdicts_page(reports), encoding="utf-8", newline="\n")
        more.append(f"comparison: {folder / COMPARISON}")
    return _summaries(reports, folder, as_json, *more)


def _checked(paths: Sequence[Path], as_json: bool) -> str:
    """Read project files and return the text to print: that they are valid, and notes. All complaints come together."""
    projects = _read_all(paths)
    if as_json:
        rows = [{"valid": True, "title": project.title, "notes": project.notes} for project in projects]
        return to_json(rows[0] if len(rows) == 1 else {str(path): row for path, row in zip(paths, rows, strict=True)})
    lines = list[str]()
    for path, project in zip(paths, projects, strict=True):
        lines += [f"{path}: valid", str(project), *(f"  note: {note}" for note in project.notes)]
    return "\n".join(lines)


def _read_all(paths: Sequence[Path]) -> list[Project]:
    projects, complaints = list[Project](), list[str]()
    for path in paths:
        try:
            projects.append(read_project(path))
        except FileError as error:
            complaints.append(str(error))
    if complaints:
        raise FileError("\n".join(complaints))
    return projects


def _reports(projects: dict[str, Project], folder: Path | None) -> dict[str, Report]:
    """Write the report of every project into a folder of its name; Ctrl-C keeps those that are finished."""
    reports: dict[str, Report] = {}
    for name, project in projects.items():
        try:
            reports[name] = report_of(project, folder and folder / name)
        except KeyboardInterrupt:
            kept = ", ".join(str(folder / done / "report.html") for done in reports if folder)
            raise KeyboardInterrupt(f"interrupted; {f'kept: {kept}' if kept else 'nothing was written'}") from None
    return reports


def report_of(project: Project, folder: Path | None) -> Report:
    """Write the report of a project into a folder, if there is one, with its progress on stderr."""
    with Progress(project.title) as progress:
        return write(project, folder, progress=progress.show)


def _summary(report: Report, folder: Path | None) -> str:
    """The summary of a report with its place."""
    title, _, lines = report.summary.partition("\n")
    summary = f"{title}\n{in_options(lines)}"
    return summary if folder is None else f"{summary}\n  report: {folder / 'report.html'}"


def _summaries(reports: dict[str, Report], folder: Path | None, as_json: bool, *more: str) -> str:
    """Several reports as JSON, or their summaries and further lines."""
    if as_json:
        return to_json({name: report.results for name, report in reports.items()})
    return "\n\n".join([*(_summary(report, folder and folder / name) for name, report in reports.items()), *more])
