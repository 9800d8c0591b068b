"""The report: results as plain data, CSV files of every curve, one self-contained HTML page, and a summary."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ...files.project import Project
from ...files.reading import read_project
from ...study.analysis.runup import silent
from ..console import WHAT_X_IS, number, percent, to_json
from ..output import staged
from ..view import View
from . import curve_files
from .section import Part, Section, asked, sections_of
from .sections import SECTIONS
from .sections.whole_train import about_appendix

HERE = Path(__file__).parent


class Report(NamedTuple):
    """What was written: the content of results.json, the summary for a terminal, and what both are of."""

    results: dict[str, Any]
    summary: str
    view: View


def write(
    project: Project | str | Path,
    folder: str | Path,
    *,
    sections: Sequence[Section] = SECTIONS,
    progress: Callable[[str, float], None] = silent,
) -> Report:
    """Analyse a drive and write report.html, results.json and the CSV files of its curves into a folder.

    Parameters
    ----------
    project : Project, str or Path
        The project, or its file.
    folder : str or Path
        Where the files go, all at once when they are complete; it keeps its other files.
    sections : sequence of Section
        Parts of the report in order. Default: `SECTIONS`.
    progress : callable
        Told before every step what is done now, and the share of the work that is done; default: nobody.

    Raises
    ------
    ProjectError
        If the project file is invalid.
    ValueError
        If two sections have the same key, or the analysis refuses the drive.
    TypeError
        If something in `sections` is no section, or one gives something else than it should.
    SolveError
        If the law cannot carry the mean torque, or no simulation finishes.
    OSError
        If the folder cannot be written; nothing is left behind.
    RuntimeError
        If jinja2 is not installed.
    """
    sections = sections_of(sections)
    project = project if isinstance(project, Project) else read_project(project)
    with staged(Path(folder)) as part:
        view = View.of(project, project.analyze(progress))
        progress("writing the report", 0.99)
        return write_view(view, part, sections)


def write_view(view: View, folder: Path, sections: Sequence[Section] = SECTIONS) -> Report:
    """Write the report of an analysis; errors as `write`."""
    parts = [asked(section, view) for section in sections]
    files = [*curve_files.write(view, folder), "results.json", "report.html"]
    results = together([*(part.data for part in parts), {"files": files}])
    (folder / "results.json").write_text(to_json(results) + "\n", encoding="utf-8")
    (folder / "report.html").write_text(page(view, parts), encoding="utf-8")
    lines = [f"  {line}" for part in parts for line in part.lines]
    return Report(results, "\n".join([view.project.title, *lines, f"  {WHAT_X_IS}"]), view)


def together(parts: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Join the data of all sections, each of which has keys of its own (ValueError)."""
    found: dict[str, Any] = {}
    for part in parts:
        if both := sorted(found.keys() & part.keys()):
            raise ValueError(f"two sections of the report have the key {both[0]!r}; rename one of them")
        found |= part
    return found


def page(view: View, parts: Iterable[Part]) -> str:
    """Render the HTML page, each section by its own template; RuntimeError without jinja2."""
    try:
        import jinja2
    except ModuleNotFoundError as error:
        raise RuntimeError("the report needs jinja2; pip install 'strainwave[report]'") from error
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters |= _filters(view)
    environment.globals |= {
        "view": view,
        "unit": view.angle.name,
        "speed_unit": view.speeds.unit,
        "speed_name": view.speeds.name,
        "what_x_is": WHAT_X_IS,
    }

    def rendered(template: Path, names: dict[str, Any]) -> str:
        return environment.from_string(template.read_text(encoding="utf-8")).render(names)

    style = (HERE / "page.css").read_text(encoding="utf-8")
    bodies: dict[bool, list[tuple[str, str]]] = {False: [], True: []}
    for p in parts:
        body = rendered(p.template, p.data | p._asdict() | {"rows": p.rows})
        if body.strip():
            bodies[getattr(p.section, "appendix", False)].append((p.section.heading, body))
    about = about_appendix(view) if bodies[True] else ""
    names = {"bodies": bodies[False], "appendix": bodies[True], "style": style, "about_appendix": about}
    return rendered(HERE / "page.html.j2", names)


def _filters(view: View) -> dict[str, Callable[..., Any]]:
    """How the page writes numbers: those with a unit get it here, and speeds and angles are in the report's units."""
    angle, speeds = view.angle, view.speeds

    def speed(omega: float | None) -> str:
        return number(None if omega is None else omega * speeds.scale, 5)

    return {
        "number": number,
        "speed": speed,
        "speed_unit": lambda omega: f"{speed(omega)} {speeds.unit}",
        "angle": lambda rad: number(None if rad is None else rad * angle.factor),
        "angle_unit": angle.text,
        "percent": percent,
        "with_unit": lambda value, unit, digits=4: f"{number(value, digits)} {unit}",
        "sentence": lambda text: text[:1].upper() + text[1:].rstrip(".") + "." if text else "",
    }
