"""Worst margins of a drive's loop over its loads and postures, as its controller samples it.

A gear is stiffer under a torque, so that a loop which is stable with one load need not be so with another. Dry friction
is left out: where a shaft slides at a constant torque it damps nothing, and where it sticks nothing moves.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import degrees, inf, isfinite, log10, pi
from typing import Any, NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.law import breakpoints_of, depends, spring_stiffness
from ...base.number_text import number
from ...base.results import SolveError
from ...model.controllers.closed_loop import Sampling
from ...model.laws.dry import without_dry_friction
from ...model.train.controls import PositionLoop, SpeedLoop
from ...model.train.drive_train import DriveTrain
from ...numerics.operating_point import loaded_state
from ..operating_point import mean_state
from .margins import Margins, loop_of, margins

LOADS = 9  # torques of a range, and of each part of it between two bends of the law
STIFFNESS_DIGITS = 9  # digits of a stiffness
PASSIVE_LOOPS = (PositionLoop, SpeedLoop)  # loops that act where they measure put in no energy
CLOSE_SENSITIVITY, CLOSE_PHASE_DEG, CLOSE_GAIN = 2.0, 30.0, 10.0**0.3  # (6 dB): beyond, a loop is near instability


class Loaded(NamedTuple):
    """A train under a load [N*m], None for its own; with the name of its posture."""

    posture: str
    load: float | None
    train: DriveTrain

    @property
    def text(self) -> str:
        """Load and posture, as the end of a sentence."""
        load = "" if self.load is None else f" under a load of {number(self.load)} N·m"
        return load + (f" in {self.posture}" if self.posture else "")


@dataclass(frozen=True, eq=False)
class WorstMargins:
    """Margins of the loop of a drive under every load, and the worst of each.

    Attributes
    ----------
    loads : tuple of Loaded
        The drive under its loads, one for each stiffness.
    margins : tuple of Margins
        Of each.
    sampling : Sampling or None
        Period and delay of the controller; None where the file has none, and the loop is one without samples.
    """

    loads: tuple[Loaded, ...]
    margins: tuple[Margins, ...]
    sampling: Sampling | None

    @classmethod
    def of(cls, loads: list[Loaded], sampling: Sampling | None) -> "WorstMargins":
        """Margins under every load, at the speed of its train."""
        rows = [margins(t, at=mean_state(t), speed=t.omega, sampling=sampling) for t in (one.train for one in loads)]
        return cls(tuple(loads), tuple(rows), sampling)

    @property
    def stable(self) -> bool:
        """True if the loop is stable under every load."""
        return all(one.stable for one in self.margins)

    @property
    def worst(self) -> tuple[Loaded, Margins]:
        """Load under which the loop grows fastest, or, where it is stable, has the largest sensitivity."""
        sizes = [one.peak_sensitivity if self.stable else one.slowest.real for one in self.margins]
        i = int(np.argmax(sizes))
        return self.loads[i], self.margins[i]

    @property
    def sizes(self) -> dict[str, float]:
        """The worst over all loads: margins, infinite where there are none, gain reduction and peak sensitivity."""
        names = "phase_margin", "gain_margin", "delay_margin"
        phase, gain, delay = [min(abs(getattr(one, name)) for one in self.margins) for name in names]
        down = max(one.gain_reduction for one in self.margins)
        return {"phase_margin_deg": degrees(phase), "gain_margin": gain, "gain_reduction": down,
                "delay_margin_s": delay, "peak_sensitivity": self.worst[1].peak_sensitivity}  # fmt: skip

    @property
    def sampled(self) -> str:
        """Sampling, as a part of a sentence."""
        if self.sampling is None:
            return "computed without sampling"
        period, delay = (number(1e3 * time, 3) for time in (self.sampling.period, self.sampling.delay))
        return f"sampled every {period} ms with {delay} ms of delay"

    @property
    def caption(self) -> str:
        """Sampling and load of the worst margins, as a part of a sentence."""
        return f"{self.sampled}{self.worst[0].text}"

    @property
    def fault(self) -> str:
        """Sentence on an unstable loop, with the frequency and the growth of its motion; empty of a stable one."""
        if self.stable:
            return ""
        _, worst = self.worst
        hertz, time = abs(worst.slowest.imag) / (2.0 * pi), 1.0 / worst.slowest.real if worst.slowest.real else inf
        what = f"a vibration of {number(hertz, 3)} Hz" if hertz else "a motion"
        grows = f"{what} grows by a factor e every {number(1e3 * time, 3)} ms"
        return f"The motor's loop is unstable with this gear: {grows}, {self.caption}."

    @property
    def weak(self) -> str:
        """Sentence on a loop that is close to instability; empty where it is not."""
        if not self.stable:
            return ""
        names = "phase_margin_deg", "gain_margin", "gain_reduction", "peak_sensitivity"
        phase, gain, down, rise = (self.sizes[name] for name in names)
        return weakness(phase, gain, down, rise, self.worst[0].text)

    @property
    def sentence(self) -> str:
        """The loop in a sentence or two."""
        if self.fault:
            return self.fault
        names = "phase_margin_deg", "gain_margin", "gain_reduction", "delay_margin_s"
        phase, gain, down, delay = (self.sizes[name] for name in names)
        angle = number(phase, 2) + "°" if isfinite(phase) else "infinite"
        late = f"; delay margin {number(1e3 * delay, 3)} ms" if isfinite(delay) else ""
        text = f"phase margin {angle}; the gain may rise {_by(gain)} or fall {_by(1.0 / down if down else inf)}{late}."
        return f"Stable, {self.sampled}: {text} {self.weak}".rstrip()

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers, and what is weak about it."""
        return Fact("loop_margins", self.data()), Fact("", (self.weak,) if self.weak else (), "note: {}")

    def data(self) -> dict[str, Any]:
        """Numbers for JSON, the worst of each; None where there is no such margin."""
        load, worst = self.worst
        sizes = {name: size if isfinite(size) else None for name, size in self.sizes.items()}
        sampling = self.sampling
        time = {"period_s": sampling and sampling.period, "delay_s": sampling and sampling.delay}
        growth = {"growth_per_s": worst.slowest.real, "at_hertz": abs(worst.slowest.imag) / (2.0 * pi)}
        return {"stable": self.stable} | sizes | growth | time | {"load_torque_Nm": load.load, "weak": self.weak}


def weakness(phase: float, gain: float, down: float, rise: float, where: str = "") -> str:
    """Sentence on a loop close to instability: phase margin [deg], gain margin, reduction of the gain, sensitivity."""
    signs = [f"peak sensitivity {number(rise, 3)} (at most {CLOSE_SENSITIVITY:g})"] * (rise > CLOSE_SENSITIVITY)
    signs += [f"phase margin {number(phase, 2)}° (at least {CLOSE_PHASE_DEG:g}°)"] * (phase < CLOSE_PHASE_DEG)
    signs += [f"gain margin {_decibels(gain)} dB (at least 6 dB)"] * (gain < CLOSE_GAIN)
    if CLOSE_GAIN * down > 1.0:
        signs.append(f"unstable with {_decibels(1.0 / down)} dB less gain (at least 6 dB)")
    return f"The loop is close to instability{where}: {', '.join(signs)}." if signs else ""


def _by(factor: float) -> str:
    return f"by {_decibels(factor)} dB" if isfinite(factor) else "without limit"


def _decibels(factor: float) -> str:
    return number(20.0 * log10(factor), 2)


def loaded_trains(project: Any, posture: str = "") -> Iterator[Loaded]:
    """The train of a project under loads that give its gear every tangent stiffness."""
    train, (low, high) = project.train, project.load_torques
    if train is None or train.motor.free or train.motor.held:
        return
    yield Loaded(posture, None, without_dry_friction(train))
    judged = {_stiffness(train, project.mean_load_torque)}
    for torque in _torques(train, low, high) if low < high else ():
        if (key := _stiffness(train, torque)) not in judged:
            judged.add(key)
            yield Loaded(posture, torque, without_dry_friction(project.under(torque, level=True).train))


def _torques(train: DriveTrain, low: float, high: float) -> list[float]:
    """Torques [N*m] of the load in a range, within every part of it between bends of the gear's law."""
    law = train.law
    bends = [float(law.torque(u)) for u in breakpoints_of(law)] if depends(law) == 1 else []
    inside = sorted({side * torque for torque in bends for side in (-1.0, 1.0) if low < side * torque < high})
    parts = [np.linspace(a, b, LOADS)[1:-1].tolist() for a, b in pairwise([low, *inside, high])]
    return [low, high, *(torque for part in parts for torque in part)]


def _stiffness(train: DriveTrain, torque: float) -> tuple[float, ...]:
    """Tangent stiffnesses of gear and couplings under a torque [N*m] of the load, rounded."""
    stiffnesses = []
    for law in (train.law, *train.load.couplings()):
        try:
            u = loaded_state(law, -torque)[0]
            stiffnesses.append(float(f"{spring_stiffness(law, u):.{STIFFNESS_DIGITS}g}"))
        except (ValueError, SolveError, AttributeError):  # a law that cannot carry it, or without a stiffness
            stiffnesses.append(-torque)
    return tuple(stiffnesses)


def worst_margins(project: Any) -> WorstMargins | None:
    """Margins of the motor's loop of a project under its loads and in its postures; None without a loop."""
    loads = [*loaded_trains(project)]
    for case in project.cases:
        loads += loaded_trains(case.on(project), case.name) if case.posture else ()
    return WorstMargins.of(loads, project.sampling) if loads else None


def loop_fault(project: Any) -> str:
    """Sentence on a project's loop that is unstable under a load; empty where it is stable or there is none."""
    train, sampling = project.train, project.sampling
    if train is None or (sampling is None and isinstance(train.motor.control, PASSIVE_LOOPS)):
        return ""
    loads = list(loaded_trains(project))
    stable = all(loop_of(one.train, mean_state(one.train), one.train.omega, sampling).stable for one in loads)
    return "" if stable else WorstMargins.of(loads, sampling).fault
