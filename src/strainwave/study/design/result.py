"""Result of the search: designs that serve, the best of them, and reasons against the other gears."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.number_text import counted, number
from ...base.records import Labelled, Result
from ...base.units import RPM
from ..pareto import unbeaten
from .specification import Specification

SHOWN = 8  # of the best designs
BEST = "Pareto-optimal designs in oscillation, size and inertia, by harmonic balance:"
UNITS = {
    "ratio": "1", "size": "", "mass": "kg", "motor_inertia": "kg*m**2", "reflected_inertia": "kg*m**2",
    "load_inertia": "kg*m**2", "B": "N*m*s/rad", "oscillation": "rad", "speed": "rad/s", "error": "1", "life": "h",
    "margin": "1", "load_torque": "N*m", "hysteresis_loss": "rad",
}  # fmt: skip


class Candidate(NamedTuple):
    """A gear with a motor.

    Attributes
    ----------
    gear, ratio, size : str, int, int
        Name in the catalogue, its ratio and size.
    mass : float
        Mass of the gear [kg]; nan where no source gives it.
    motor_inertia : float
        Inertia of the motor with the wave generator [kg*m^2].
    reflected_inertia : float
        The same at the load, N^2 J_m [kg*m^2].
    load_inertia : float
        The one of the specification's under which the oscillation is largest [kg*m^2].
    B : float
        Damping across the spring there [N*m*s/rad].
    oscillation : float
        Largest oscillation of the pointing error over the speeds [rad].
    speed : float
        Speed of the motor there [rad/s].
    error : float
        Estimated relative error of the oscillation.
    method : str
        "averaging" (first order) or "harmonic balance" of the whole drive: what gave the oscillation.
    life : float
        L10 life [h]; inf where nothing loads the gear.
    margin : float
        Share of the allowance that is left of the constraint that binds.
    binding : str
        The constraint that binds.
    load_torque : float
        Torque on the load [N*m] under which the oscillation is largest, of the duty in either sign or none; a resisting
        one is negative.
    rotor_inertia : float
        Inertia of the rotor without the wave generator [kg*m^2], as the specification has it.
    doubts : tuple of str
        Doubts of the gear's record about the numbers that the specification needs, and of the best designs that one
        oscillates by more than the limit between the torques of the duty.
    hysteresis_loss : float
        Largest hysteresis loss of the gear's record [rad], not in the oscillation; nan where no source gives it.
    """

    gear: str
    ratio: int
    size: int
    mass: float
    motor_inertia: float
    reflected_inertia: float
    load_inertia: float
    B: float
    oscillation: float
    speed: float
    error: float
    method: str
    life: float
    margin: float
    binding: str
    load_torque: float = 0.0
    rotor_inertia: float = math.nan
    doubts: tuple[str, ...] = ()
    hysteresis_loss: float = math.nan

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("gear", self.gear, "gear"), Fact("ratio", self.ratio), Fact("size", self.size, "size"),
            Fact("mass_kg", self.mass), Fact("motor_inertia_kg_m2", self.motor_inertia),
            Fact("rotor_inertia_kg_m2", self.rotor_inertia, "rotor"),
            Fact("reflected_inertia_kg_m2", self.reflected_inertia, "at the load"),
            Fact("load_inertia_kg_m2", self.load_inertia), Fact("load_torque_N_m", self.load_torque),
            Fact("oscillation_arcsec", self.oscillation, "oscillation"), Fact("motor_speed_rpm", self.speed, "at"),
            Fact("hysteresis_loss_arcsec", self.hysteresis_loss, "hysteresis loss"),
            Fact("method", self.method), Fact("relative_error", self.error), Fact("life_h", self.life, "life"),
            Fact("margin", self.margin), Fact("", f"{number(100.0 * self.margin, 3)} %", "margin"),
            Fact("binding", self.binding), Fact("", self.binding.replace("_", " "), "limited by"),
            Fact("doubts", " ".join(self.doubts)),
        )  # fmt: skip


class Sensitivity(NamedTuple):
    """Sensitivity of the largest oscillation of a design to a number of it.

    `slope` is the relative change of the oscillation over the relative change of the number, by averaging.
    """

    gear: str
    motor_inertia: float
    parameter: str
    slope: float

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("gear", self.gear), Fact("motor_inertia_kg_m2", self.motor_inertia),
            Fact("parameter", self.parameter), Fact("slope", self.slope),
        )  # fmt: skip

    def __str__(self) -> str:
        change = f"{self.slope:+.2g}".replace("-", "−")
        return f"{self.gear}: 1 % more {self.parameter} changes the oscillation by {change} %"


@dataclass(frozen=True, eq=False)
class Design(Result):
    """The answer to a specification.

    Attributes
    ----------
    specification : Specification
        The specification.
    feasible : tuple of Candidate
        Every gear with every motor that meets it, by ascending oscillation.
    pareto : tuple of Candidate
        Those of them that no other beats in oscillation, size and reflected inertia at once; all by harmonic balance,
        and with every speed allowed under the torques of the duty, as a speed map decides it.
    rejected : dict of str to str
        Reason against each other gear, by its name: the constraint that it misses most, and the excess.
    not_judged : dict of str to str
        Numbers that no source gives, of the gears that no known number turns away, by their names.
    nearest : str
        Where nothing serves: the gear that misses least, and its constraint; empty otherwise.
    sensitivities : tuple of Sensitivity
        Of the best designs.
    drives, balanced : int
        Drives computed by averaging (gear, motor and load), and designs by harmonic balance.
    remarks : tuple of str
        Remarks on the numbers.
    """

    specification: Specification
    feasible: tuple[Candidate, ...]
    pareto: tuple[Candidate, ...]
    rejected: Mapping[str, str]
    not_judged: Mapping[str, str]
    nearest: str
    sensitivities: tuple[Sensitivity, ...]
    drives: int
    balanced: int
    remarks: tuple[str, ...] = ()

    rows: ClassVar[str] = "design"

    def variables(self) -> Labelled:
        """Every number of the designs; `pareto` is true for one on the front."""
        columns: dict[str, tuple[str, object, str]] = {
            name: ("design", np.array([getattr(c, name) for c in self.feasible], float), unit)
            for name, unit in UNITS.items()
        }
        columns["pareto"] = ("design", np.array([c in self.pareto for c in self.feasible], bool), "")
        return columns

    def coordinates(self) -> Labelled:
        """Gear, method and binding constraint of every design."""
        words = ("gear", "method", "binding")
        return {name: ("design", [getattr(c, name) for c in self.feasible], "") for name in words}

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of the designs, once."""
        gears, unlisted = len({c.gear for c in self.feasible}), len(self.pareto) - SHOWN
        low, high = [number(speed / RPM) for speed in self.specification.speeds]
        others = counted(len(self.rejected), "gear")
        serve = f"{len(self.feasible)} designs with {counted(gears, 'gear')} meet the specification; {others} do not"
        if self.not_judged:
            serve += f"; {len(self.not_judged)} are not judged because a number is missing"
        first = (s for s in self.sensitivities if s[:2] == self.sensitivities[0][:2])
        doubts = dict.fromkeys(text for c in self.pareto[:SHOWN] for text in c.doubts if text not in self.remarks)
        return (
            Fact("", serve, "{}"),
            Fact(
                "limit_rad", self.specification.limit, f"limit of oscillation: {{}} at {low} to {high} rpm of the load"
            ),
            Fact("nearest", self.nearest or None, "{}" if self.nearest else ""),
            Fact("feasible", tuple((*c.facts(), Fact("pareto", c in self.pareto)) for c in self.feasible)),
            Fact("", (BEST,) if self.pareto else (), "{}"),
            Fact("", tuple(c.facts() for c in self.pareto[:SHOWN]), "{}"),
            Fact("", (f"and {unlisted} more; `pareto` has all",) if unlisted > 0 else (), "{}"),
            Fact("rejected", dict(self.rejected)),
            Fact("not_judged", dict(self.not_judged)),
            Fact("sensitivities", tuple(one.facts() for one in self.sensitivities)),
            Fact("", tuple(map(str, first)), "{}"),
            Fact("drives", self.drives),
            Fact("balanced", self.balanced),
            Fact("remarks", self.remarks, "note: {}"),
            Fact("", tuple(doubts), "note: {}"),
        )


def front(candidates: list[Candidate]) -> list[Candidate]:
    """Those that no other beats in oscillation, size and reflected inertia at once, by ascending oscillation."""
    by_goals: dict[tuple[float, ...], Candidate] = {}
    for c in candidates:
        by_goals.setdefault((c.oscillation, c.size, c.reflected_inertia), c)
    return [by_goals[mark] for mark in unbeaten(by_goals)]
