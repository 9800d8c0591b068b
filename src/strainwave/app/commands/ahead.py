"""Make the machine code that most commands run, in a process beside the first one on a machine (`console.Progress`).

The order differs from that of `analyze`, so that each process finds what the other has made.
"""

from importlib.resources import as_file, files

from ...drive.run import drive_run
from ...files.reading import read_project
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.setting import PRIMARY


def main() -> None:
    """Compute one answer of each kind for the drive of `demo`."""
    with as_file(files("strainwave.app") / "projects" / "CSG-40-50.yaml") as path:
        project = read_project(path)
    slow_flow(project.system(reduced=True), PRIMARY).steady_states()
    if project.train is not None:
        project.train_response()
        drive_run(project.train, None, 0.1)
    project.analyze()


if __name__ == "__main__":
    main()
