"""Experiment of an identification: a system with measured inputs inside, and the measured part of its motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, get_args

import numpy as np

from ...base.protocols import System, names_of, omega_of
from ...base.quantities import checked, choice, shown
from ...base.results import Floats
from ...compile.tree import leaf_of, numbers, part, replaced, with_leaf
from .fitted import bounds
from .input_signals import Between, Signal, pieces, places_of, resampled
from .lane_march import Lanes, lanes_of

OUTPUT_NUMBERS = {"gain": 1.0, "offset": 0.0, "delay": 0.0}  # of an input too: the first fields of a `Signal`
SIGNED_NUMBERS = ("phase", "mean", "offset", "delay")  # numbers that have no sign of their own
APPROACH, LEAST_SHARE = 0.2, 0.1  # of its value now, and of the first: how near zero a number comes at once, and ever
START_SAMPLES = 7  # samples that the first rate of a measured state is taken from


@dataclass(frozen=True)
class Experiment:
    """A system, its measured inputs and outputs, and which of its numbers are free.

    Attributes
    ----------
    system : NamedTuple
        As it was given.
    driven : NamedTuple
        The same with a `Signal` at the place of every input.
    inputs, outputs : dict of str to str
        Channel of every input's path and of every output's state.
    free : tuple of str
        Paths of the free numbers: of `driven`, or a state's name with gain, offset or delay.
    between : {"band-limited", "linear", "held"}
        What the inputs do between samples.
    """

    system: Any
    driven: Any
    inputs: dict[str, str]
    outputs: dict[str, str]
    free: tuple[str, ...]
    between: Between

    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return names_of(self.driven)

    def seen(self) -> Any:
        """Places of the measured states."""
        return np.array([self.states().index(name) for name in self.outputs], int)

    def first(self) -> Floats:
        """Values (free,) that the given system has."""
        values = zip(self.of_free(), self.free, strict=True)
        return np.array([OUTPUT_NUMBERS[of[1]] if of else float(part(self.driven, path)) for of, path in values])

    def without_crossing(self, values: Floats, change: Floats) -> Floats:
        """A change (free,) that brings no number of the model near zero; phases, offsets and delays may cross it."""
        least = np.minimum(np.abs(values), np.maximum(APPROACH * np.abs(values), LEAST_SHARE * np.abs(self.first())))
        signed = [path.rpartition(".")[2] in SIGNED_NUMBERS for path in self.free]
        crossing = (np.sign(values) * (values + change) < least) & (values != 0.0) & ~np.array(signed)
        return np.where(crossing, np.sign(values) * least - values, change)

    def within_bounds(self, values: Floats, change: Floats) -> Floats:
        """A change (free,) that takes no inertia, no damping and no number of a law to zero or beyond."""
        low, high = bounds(self.system, self.free)
        beyond = (values + change <= low) | (values + change >= high)
        return np.where(beyond, (APPROACH - 1.0) * values, change)

    def _of_output(self, path: str) -> tuple[int, str] | None:
        name, _, what = path.rpartition(".")
        return (list(self.outputs).index(name), what) if name in self.outputs and what in OUTPUT_NUMBERS else None

    @cached_property
    def _leaves(self) -> list[tuple[int, int]]:
        """Numbers of the free ones that are no output's, and their places in the driven system."""
        inner = [i for i, of in enumerate(self.of_free()) if of is None]
        return [(i, leaf_of(self.driven, self.free[i])) for i in inner]

    def _with(self, values: Floats) -> Any:
        model = self.driven
        for i, leaf in self._leaves:
            model = with_leaf(model, leaf, float(values[i]))
        return model

    def model(self, values: Floats, step: float, parts: int, delays: Floats | None = None) -> Any:
        """The driven system with these values of the free numbers; delays of signals are those beyond `delays`."""
        model = self._with(values)
        scales = {"per_omega": 1.0 / float(omega_of(model)), "per_length": parts / step}
        for i, path in enumerate(self.inputs):
            signal = part(model, path)
            less = 0.0 if delays is None else float(delays[i])
            model = replaced(model, path, signal._replace(**scales, delay=signal.delay - less))
        return model

    def fitted(self, values: Floats) -> Any:
        """The system as it was given, with these values of its free numbers."""
        model = self._with(values)
        for path in self.inputs:
            model = replaced(model, path, part(self.system, path))
        return model

    def delays(self, values: Floats) -> Floats:
        """Delays (inputs,) [s] of the inputs."""
        return np.array([self._given(f"{path}.delay", values, 0.0) for path in self.inputs])

    def _given(self, path: str, values: Floats, otherwise: float) -> float:
        return float(values[self.free.index(path)]) if path in self.free else otherwise

    def of_outputs(self, values: Floats) -> dict[str, Floats]:
        """Gain, offset and delay (outputs,) of what was measured: measured(t) = offset + gain state(t - delay)."""
        return {
            what: np.array([self._given(f"{name}.{what}", values, first) for name in self.outputs])
            for what, first in OUTPUT_NUMBERS.items()
        }

    def lanes(self, variants: Sequence[Floats], step: float, parts: int) -> Lanes:
        """Variants of the system, one a set of values; the first one's delays are in the pieces."""
        delays = self.delays(variants[0])
        return lanes_of([self.model(values, step, parts, delays) for values in variants])

    def of_free(self) -> list[tuple[int, str] | None]:
        """Of every free number, if it is one of an output, which output and what."""
        return [self._of_output(path) for path in self.free]


def experiment(
    system: System, inputs: Mapping[str, str], outputs: Mapping[str, str], free: Sequence[str], between: Between
) -> Experiment:
    """Check what is asked for and put a signal at the place of every input.

    Raises
    ------
    ValueError
        If a path or a state does not exist, or nothing is free or measured.
    TypeError
        If the system does not name its states.
    """
    choice("between", between, *get_args(Between))
    system = checked(system)
    driven = system
    for path in inputs:
        if not isinstance(part(system, path), tuple):
            raise ValueError(
                f"the input {shown(path)} is a number of the model; name the torque or the motion that it belongs to, "
                f"such as {shown(path.rpartition('.')[0] or 'excitation')}"
            )
        driven = replaced(driven, path, Signal())
    states = names_of(driven)
    if not states:
        raise TypeError(f"{type(system).__name__} has no state_names; identify needs to know which state was measured")
    if not outputs:
        raise ValueError("no output is given; say which state was measured, for example outputs={'x': 'torsion'}")
    for name in outputs:
        if name not in states:
            raise ValueError(f"the output {shown(name)} is no state of the system; it has {', '.join(states)}")
    if not len(free):
        raise ValueError("free is empty; give the paths of one number at least, for example ('law.K', 'B')")
    ready = Experiment(system, driven, dict(inputs), dict(outputs), tuple(free), between)
    places = places_of(driven)
    if omega_of(driven) == 0.0:
        raise ValueError("the system's base angle stands still; give its speed, any one where no signal turns with it")
    if len(set(ready.free)) < len(ready.free):
        raise ValueError(f"free names a number twice: {', '.join(ready.free)}")
    for path in (path for path in ready.free if ready._of_output(path) is None):
        if path not in (able := _able(ready)):
            raise ValueError(f"{shown(path)} is no number that can be free; those are {', '.join(able)}")
        leaf = leaf_of(driven, path)
        inside = any(begin <= leaf < begin + len(Signal()) for begin in places)
        if path == "omega" and inputs:
            raise ValueError("omega is free, but the inputs are measured in time; fix the speed of the base angle")
        if path.endswith(".delay") and inside and between == "held":
            raise ValueError(
                f"{shown(path)} is free, but a held input is no smooth function of a delay; take 'band-limited'"
            )
    return ready


def _able(setup: Experiment) -> list[str]:
    """Paths of the numbers that may be free."""
    parts = tuple(f"{path}." for path in setup.inputs)
    paths = [p for p, *_, v in numbers(setup.driven) if isinstance(v, float) and not p.startswith(parts)]
    return paths + [f"{signal}.{what}" for signal in (*setup.inputs, *setup.outputs) for what in OUTPUT_NUMBERS]


@dataclass(frozen=True)
class Record:
    """Signals of one uninterrupted measurement.

    `inputs` is (inputs, n), `outputs` (outputs, n) with NaN where nothing was measured, `step` [s] between samples, and
    `begin` the samples before it, from which time counts.
    """

    inputs: Floats
    outputs: Floats
    step: float
    begin: int = 0

    def __len__(self) -> int:
        return int(self.outputs.shape[1])

    def parted(self, samples: int, parts: int) -> list["Record"]:
        """So many samples in all, in parts that are evenly spread over the record."""
        if samples >= len(self):
            return [self]
        each = samples // parts
        begins = np.linspace(0, len(self) - each, parts).astype(int).tolist()
        return [self.part(i, i + each) for i in begins]

    def part(self, first: int, stop: int) -> "Record":
        """Samples `first` up to `stop`."""
        return Record(self.inputs[:, first:stop], self.outputs[:, first:stop], self.step, self.begin + first)

    def pieces(self, of: Experiment, values: Floats, parts: int) -> Floats:
        """Polynomials (inputs, pieces, 6) of the inputs, delayed."""
        delays = of.delays(values) / self.step
        many = parts * (len(self) - 1)
        made = [pieces(u, parts, of.between, d) for u, d in zip(self.inputs, delays, strict=True)]
        return np.array(made).reshape(len(made), many, 6)

    def shifted(self, delays: Floats) -> tuple[Floats, Floats]:
        """Outputs (outputs, n) at a later time, and their rates."""
        values, rates = self.outputs.copy(), np.gradient(self.outputs, axis=1)
        for i, delay in enumerate(delays / self.step):
            if delay:
                values[i], rates[i], _ = resampled(self.outputs[i], 1, -delay)
        return values, rates / self.step


def start_states(setup: Experiment, outputs: Floats, index: int, step: float) -> Floats:
    """States (states,) near a sample of the outputs: those measured, rates by a straight line, and 0 for others."""
    start: dict[str, float] = {}
    for name, row in zip(setup.outputs, outputs, strict=True):
        samples = row[index : index + START_SAMPLES]
        good = np.flatnonzero(np.isfinite(samples))
        if len(good):
            line = np.polyfit(good, samples[good], min(1, len(good) - 1))
            start |= {f"{name}'": line[0] / step, name: line[-1]} if len(line) == 2 else {name: line[-1]}
    return np.array([start.get(name, 0.0) for name in setup.states()])


def sizes_of(setup: Experiment, record: Record) -> Floats:
    """Sizes of the states (states,): of a measured one its scatter, of its rate that of its steps; 0 of others."""
    sizes: dict[str, float] = {}
    for name, row in zip(setup.outputs, record.outputs, strict=True):
        measured = row[np.isfinite(row)]
        if len(measured) >= 2:
            sizes |= {name: float(np.std(measured)), f"{name}'": change_of(row) / record.step}
    return np.array([sizes.get(name, 0.0) for name in setup.states()])


def change_of(row: Floats) -> float:
    """Scatter of the changes of a signal per sample, over its measured samples."""
    measured = np.flatnonzero(np.isfinite(row))
    return float(np.std(np.diff(row[measured]) / np.diff(measured))) if len(measured) > 1 else 0.0
