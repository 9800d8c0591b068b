"""Where the numbers of a project file stand in its drive train."""

from typing import Any

from ...base.quantities import shown
from ...compile.tree import leaf_of, numbers
from ...drive.project import Project
from ..variants.names import keys_of
from ..yaml_text import read

SIGNALS = {"torsion": "x", "motor_angle": "reference", "load_torque": "load.excitation"}
OF_SIGNAL = {"gain": "", "offset": "rad", "delay": "s"}  # what may be free of a signal, with its unit
SINGLE = {"damping.B": "B", "load.inertia": "load.J", "load_friction": "friction.mu"}


class Places:
    """Names of a project's numbers, as its file, a sweep and a scatter have them, and their paths in the train."""

    def __init__(self, project: Project, train: Any) -> None:
        self.content: Any = read(project.text).content
        self.train = train
        beside = "law.first" if "hysteresis" in self.content else "law"
        gear = f"{beside}.law" if "backlash" in self.content else beside
        self.groups = {
            "gear": gear, "gear.law": gear, "hysteresis": "law.second", "backlash": beside, "load.drag": "load.drag",
            "excitation.kinematic_error": "error.lines",
        }  # fmt: skip

    def path(self, name: str) -> str:
        """Path in the train of a number of the file, or of a signal's gain, offset or delay (ValueError)."""
        signal, _, what = name.rpartition(".")
        if signal in SIGNALS and what in OF_SIGNAL:
            return f"{SIGNALS[signal]}.{what}"
        whole = ".".join(keys_of(self.content, name))
        group, _, field = whole.rpartition(".")
        while group and group not in self.groups:
            group, _, before = group.rpartition(".")
            field = f"{before}.{field}"
        path = "B" if whole.startswith("damping") else SINGLE.get(whole, f"{self.groups.get(group, '')}.{field}")
        try:
            leaf_of(self.train, path)
        except ValueError:
            raise ValueError(
                f"{shown(name)} is no number that the angles of motor and load tell; those are "
                f"{', '.join(self.names())}"
            ) from None
        return path

    def name(self, path: str) -> str:
        """Name in the file of a number of the train; empty where the file has none."""
        for name, single in SINGLE.items():
            if path == single:
                return name
        inside = [(name, group) for name, group in self.groups.items() if path.startswith(f"{group}.")]
        whole = next((name + path.removeprefix(group) for name, group in inside), "")
        return whole.removeprefix("excitation.")  # which a name may leave out

    def names(self) -> list[str]:
        """Names of all numbers that may be free."""
        found = [self.name(path) for path, _, _, value in numbers(self.train) if isinstance(value, float)]
        return [name for name in found if name] + [f"torsion.{what}" for what in OF_SIGNAL]
