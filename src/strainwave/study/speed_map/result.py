"""`SpeedMap`: what `speed_map` returns."""

from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.facts import Fact
from ...base.number_text import number, unit_text
from ...base.quantities import index
from ...base.records import Labelled, Result
from ...base.results import Floats
from ...base.units import ARCSEC, RPM
from ...drive.postures import titled
from ...drive.speeds import BASES, Speeds
from .campbell import CampbellLine
from .decide import POSTURE
from .intervals import common, listed, swept
from .rules import Rules
from .vendor_rule import VendorRule, vendor_sentence

JUMP_VERBS = {True: "jumps up", False: "drops"}  # of the error at a jump
UNITS = {"load torque": "N*m", "load inertia": "kg*m^2", POSTURE: ""}


def load_text(load: float, name: str, title: str = "") -> str:
    """A load with its unit, or a posture with its number and title."""
    if name != POSTURE:
        return f"{number(load, 3)} {unit_text(UNITS[name].replace('^', '**'))}"
    return title or titled(load, "")


class JumpSpeed(NamedTuple):
    """Jump of a slow run-up (`up`) or run-down: number of the load, and speed of the base angle [rad/s].

    The error jumps up there (`rises`), or drops.
    """

    load: int
    speed: float
    up: bool
    rises: bool = False

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        run, error = "up" if self.up else "down", JUMP_VERBS[self.rises]
        speed = Fact("rpm", self.speed / RPM), Fact("rad_per_s", self.speed)
        return *speed, Fact("run", run), Fact("error", error)


class Scatter(NamedTuple):
    """The map over units of a drive that scatter.

    Attributes
    ----------
    shares : (quantiles,) array
        Shares of the units.
    oscillation : (quantiles, loads, speeds) array
        Quantiles of the largest oscillation [rad]; inf where that share has no stable motion.
    worst : (loads, speeds) array
        Largest oscillation [rad] of all units.
    forbidden : (loads, speeds) array
        Share of the units for which a speed is forbidden.
    units : int
        Number of units.
    """

    shares: Floats
    oscillation: Floats
    worst: Floats
    forbidden: Floats
    units: int


@dataclass(frozen=True, eq=False)
class SpeedMap(Result):
    """Speeds at which a drive may run under each load, from all its stable steady motions.

    The error is the pointing error of the load, its oscillation the largest distance from its mean. Bands are computed
    from the curves, not from the cells.

    Attributes
    ----------
    speeds : (m,) array
        Speeds of the motor, or of a forcing, [rad/s] of the cells.
    loads : (n,) array
        Mean torques on the load [N*m, a resisting one is negative], its inertias [kg*m^2], or numbers of postures.
    load_name : {"load torque", "load inertia", "posture"}
        Which of them.
    oscillation, torque : (n, m) arrays
        Largest oscillation of the error [rad] and largest torque in the gear [N*m] of all stable motions; inf where
        none is known.
    smallest : (n, m) array or None
        Of motions that beat: oscillation [rad] of the smallest turn of that motion.
    motions : (n, m) int array
        How many stable motions there are.
    subharmonic : (n, m) bool array
        Whether one of them may repeat after more than one turn, or not at all.
    forbidden, allowed : tuple of (k, 2) arrays
        For each load, intervals (low, high) of the motor speed [rad/s].
    windows : (k, 2) array
        Speeds [rad/s] that are allowed under all loads and those between them.
    jumps : tuple of JumpSpeed
        Where slow run-ups and run-downs jump.
    lines : tuple of CampbellLine
        Where orders meet resonances, against amplitude.
    vendor : tuple of VendorRule
        The vendors' rule under each load; empty where the gear has no stiffness at rest, and of a forcing.
    rules : Rules
        What forbids a speed.
    quasi_static : (n,) array
        Oscillation [rad] when the drive turns slowly.
    scatter : Scatter or None
        Quantiles over units, where these were given.
    remarks : tuple of str
        What a reader must know.
    failures : tuple of str
        Limits of the gear and the motor by which the drive fails in the range, and a limit that no speed meets.
    postures : tuple of str
        Names of the loads, where these are postures and the load of the file.
    shaft : {"motor", "forcing"}
        What turns at the speeds.
    run_up : (k, 2) array or None
        Speeds [rad/s] that a run-up adds to the forbidden ones; None where no torque follows the angle of the load, or
        the range or the loads are not those of the project.
    crests : (n, 2) array
        Speed [rad/s] and oscillation [rad] of the largest known motion under each load, between the `speeds` too.
    """

    speeds: Floats
    loads: Floats
    load_name: str
    oscillation: Floats
    torque: Floats
    motions: NDArray[np.int64]
    subharmonic: NDArray[np.bool_]
    forbidden: tuple[Floats, ...]
    allowed: tuple[Floats, ...]
    windows: Floats
    jumps: tuple[JumpSpeed, ...]
    lines: tuple[CampbellLine, ...]
    vendor: tuple[VendorRule, ...]
    rules: Rules
    quasi_static: Floats
    scatter: Scatter | None = None
    remarks: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    postures: tuple[str, ...] = ()
    smallest: Floats | None = None
    shaft: str = "motor"
    run_up: Floats | None = None
    crests: Floats = field(kw_only=True)
    rows: ClassVar[str] = "speed"

    @property
    def axis(self) -> Speeds:
        """Name and unit of the speeds."""
        return BASES[self.shaft]

    @property
    def load_unit(self) -> str:
        """Unit of the loads."""
        return UNITS[self.load_name]

    @property
    def vendor_sentence(self) -> str:
        """Sentence on the vendors' rule over all loads; empty where it has no frequency."""
        return vendor_sentence(self.vendor)

    @property
    def unit_windows(self) -> Floats:
        """Speeds (k, 2) [rad/s] that neither the map nor any unit forbids, to the nearest cell."""
        if self.scatter is None:
            return np.empty((0, 2))
        good = np.concatenate([[False], np.all(self.scatter.forbidden == 0.0, axis=0), [False]])
        ends = np.flatnonzero(good[1:] != good[:-1]).reshape(-1, 2)
        return common(np.column_stack([self.speeds[ends[:, 0]], self.speeds[ends[:, 1] - 1]]), self.windows)

    def is_allowed(self, speed: float, load: float) -> bool:
        """True if a motor speed [rad/s] is allowed under a load.

        Between two loads of the map it is where neither of them forbids it and no band passes it from one to the
        other. What the map does not cover is not allowed: speeds and loads beyond its ranges, and what is no posture.
        """
        if self.load_name == POSTURE and load not in self.loads:
            return False
        if not (self.loads[0] <= load <= self.loads[-1] and self.speeds[0] <= speed <= self.speeds[-1]):
            return False
        above = int(np.searchsorted(self.loads, load))
        below = above if self.loads[above] == load else above - 1
        return not any(low < speed < high for low, high in swept(self.forbidden[below], self.forbidden[above]))

    def coordinates(self) -> Labelled:
        """Loads and speeds."""
        return {"load": ("load", self.loads, self.load_unit), "speed": ("speed", self.speeds, "rad/s")}

    def variables(self) -> Labelled:
        """Cells, bands, jumps and lines."""
        grid = ("load", "speed")
        columns: dict[str, Any] = {
            "oscillation": (grid, self.oscillation, "rad"),
            "torque": (grid, self.torque, "N*m"),
            **({} if self.smallest is None else {"smallest": (grid, self.smallest, "rad")}),
            "motions": (grid, self.motions, ""), "subharmonic": (grid, self.subharmonic, ""),
            "quasi_static": ("load", self.quasi_static, "rad"),
        }  # fmt: skip
        for name, some in (("forbidden", self.forbidden), ("allowed", self.allowed)):
            counts = [len(bands) for bands in some]
            columns[f"{name}_load"] = (name, np.repeat(self.loads, counts), self.load_unit)
            for j, end in enumerate(("low", "high")):
                columns[f"{name}_{end}"] = (name, np.concatenate(some)[:, j], "rad/s")
        columns["jump_load"] = ("jump", np.array([self.loads[j.load] for j in self.jumps]), self.load_unit)
        columns["jump_speed"] = ("jump", np.array([j.speed for j in self.jumps]), "rad/s")
        for name in ("up", "rises"):
            columns[f"jump_{name}"] = ("jump", np.array([getattr(j, name) for j in self.jumps], bool), "")
        if self.scatter is not None:
            columns["quantile"] = (("share", *grid), self.scatter.oscillation, "rad")
            columns["worst"] = (grid, self.scatter.worst, "rad")
            columns["forbidden_share"] = (grid, self.scatter.forbidden, "")
        return columns

    def to_xarray(self) -> Any:
        """Cells over load and speed; bands, jumps, each a table of its own; units in `attrs["units"]`."""
        dataset = super().to_xarray()
        return dataset if self.scatter is None else dataset.assign_coords(share=self.scatter.shares)

    def load_text(self, i: int) -> str:
        """A load with its unit."""
        i = index("i", i, len(self.loads), "loads")
        title = self.postures[i] if self.postures else ""
        return load_text(float(self.loads[i]), self.load_name, title)

    @property
    def worst(self) -> int:
        """Number of the load with the largest oscillation, or without a known motion at some speed."""
        return int(np.argmax(np.max(self.oscillation, axis=1)))

    @property
    def allowed_text(self) -> str:
        """The speeds that every load allows, in words."""
        return f"allowed under every load: {listed(self.windows, self.axis) or 'no speed'}"

    def _worst_sentence(self) -> str:
        i = int(np.argmax(self.crests[:, 1]))
        speed, size = self.crests[i].tolist()
        text = f"{self.load_text(i)}, {number(size / ARCSEC)} arcsec at {self.axis.said(speed, 5)}"
        lost, places = np.nonzero(np.isinf(self.oscillation))
        for j in lost[:1].tolist():
            where = self.axis.said(float(self.speeds[places[0]]), 5)
            text += f"; {self.load_text(j)}: no steady motion was found at {where}; this speed is forbidden"
        return text

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of a map, once."""
        rules, scatter, loads = self.rules, self.scatter, range(len(self.loads))
        passed = np.empty((0, 2)) if self.run_up is None else self.run_up
        return (
            Fact("failures", self.failures, "FAIL: {}"),
            Fact("shaft", self.shaft),
            Fact("load_unit", self.load_unit),
            Fact("rule", self.rule, f"speeds of the {self.shaft} are {{}}"),
            Fact("limit_rad", rules.limit),
            Fact("amplification", rules.amplification),
            Fact("margin", rules.margin),
            Fact("largest_speed_rpm", rules.speed),
            Fact("largest_motor_torque_N_m", rules.motor_torque),
            Fact("loads", tuple(self._under(i) for i in loads)),
            Fact("", tuple(self._row(i) for i in loads), "{}"),
            Fact("worst_load", float(self.loads[self.worst])),
            Fact("", self._worst_sentence(), "largest oscillation: {}" if len(self.loads) > 1 else ""),
            Fact("allowed_under_every_load_rpm", self.windows),
            Fact("allowed_under_every_load_rad_per_s", self.windows),
            Fact("", self.allowed_text, "{}"),
            Fact("run_up_adds_rpm", self.run_up),
            Fact("", listed(passed, self.axis), "also forbidden in a run-up: {}" * bool(len(passed))),
            Fact("units", None if scatter is None else scatter.units),
            Fact("allowed_for_every_unit_rpm", self.unit_windows),
            Fact("worst_unit_arcsec", None if scatter is None else float(np.max(scatter.worst))),
            Fact("", self.units_sentence, "{}" if scatter else ""),
            Fact("vendor", tuple(rule.facts() for rule in self.vendor)),
            Fact("vendor_sentence", self.vendor_sentence, "{}" if self.vendor else ""),
            Fact("remarks", self.remarks, "note: {}"),
        )

    def _largest(self, i: int) -> float:
        """Largest oscillation [rad] under a load, between the speeds too; inf without a known motion at one of them."""
        return max(float(np.max(self.oscillation[i])), float(self.crests[i, 1]))

    def _under(self, i: int) -> tuple[Fact, ...]:
        """Facts under one load."""
        return (
            Fact(self.load_name.replace(" ", "_"), float(self.loads[i])),
            *(Fact(f"forbidden_{unit}", self.forbidden[i]) for unit in ("rpm", "rad_per_s")),
            *(Fact(f"allowed_{unit}", self.allowed[i]) for unit in ("rpm", "rad_per_s")),
            Fact("largest_oscillation_arcsec", self._largest(i)),
            Fact("largest_gear_torque_N_m", float(np.max(self.torque[i]))),
            Fact("most_stable_motions", int(np.max(self.motions[i]))),
            Fact("subharmonics", bool(np.any(self.subharmonic[i]))),
            Fact("jumps", tuple(jump.facts() for jump in self.jumps if jump.load == i)),
        )

    def _row(self, i: int) -> tuple[Fact, ...]:
        """Row of a table: the forbidden speeds and the jumps under a load, in the words of a response."""
        parts = []
        for rises, verb in JUMP_VERBS.items():
            speeds = sorted({j.speed for j in self.jumps if j.load == i and j.rises == rises})
            each = dict.fromkeys(number(speed * self.axis.scale, 5) for speed in speeds)
            parts += [f"{verb} at {', '.join(each)} {self.axis.unit}"] if speeds else []
        forbidden = listed(self.forbidden[i], self.axis) or "none"
        row = Fact("", self.load_text(i), "load"), Fact("", forbidden, "forbidden speeds")
        return (*row, Fact("", " and ".join(parts) or "none", "jumps of the error" if self.jumps else ""))

    @property
    def units_sentence(self) -> str:
        """Sentence on the units that scatter."""
        if self.scatter is None:
            return ""
        spans, worst = listed(self.unit_windows, self.axis) or "no speed", float(np.max(self.scatter.worst))
        size = f"{worst / ARCSEC:.4g} arcsec" if np.isfinite(worst) else "unknown at some speeds"
        return (
            f"allowed for all {self.scatter.units} units under every load (main curves only): {spans}; largest "
            f"oscillation {size}"
        )

    @property
    def rule(self) -> str:
        """Rules that forbid a speed, in words."""
        rules = self.rules
        rows = (
            ("oscillation above {:.4g} arcsec", rules.limit, ARCSEC),
            ("oscillation above {:g} times that at very low speed", rules.amplification, 1.0),
            ("nearer than {:g} % to a resonance", rules.margin, 0.01),
            ("faster than {:.5g} rpm", rules.speed, RPM),
            ("motor torque above {:.4g} N*m", rules.motor_torque, 1.0),
            ("gear torque above {:.4g} N*m", rules.gear_torque, 1.0),
            ("cubic mean of the gear torque above {:.4g} N*m", rules.mean_torque, 1.0),
        )
        conditions = [text.format(value / unit) for text, value, unit in rows if value is not None]
        if rules.sheet is not None and rules.sheet.peak_torque:
            conditions.append("motor torque above the peak torque of its datasheet")
        if rules.sheet is not None and rules.sheet.lasts:
            conditions.append("rms motor torque above the continuous torque")
        return "forbidden if: " + " or ".join(conditions)
