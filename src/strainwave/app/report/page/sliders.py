"""The numbers of a drive on a page, and the sliders that move them.

A page knows nothing of a project file. A slider moves numbers along a line, or numbers are sums of products of powers
of what sliders have, as a gain times another is; only numbers of the file for which that holds have a slider.
"""

from contextlib import suppress
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ....base.law import breakpoints_of
from ....base.results import Floats
from ....base.sentences import sign
from ....compile.tree import leaves
from ....drive.project import Project
from ....drive.train_curve import at_load, has_curve
from ....files.variants.names import label_of, nominal_of, numbers_of, of_record
from ....files.variants.replaced import OF_RECORD, replaced
from ....files.yaml_text import read
from ....numerics.curves.drive_numbers import beginning, drive_numbers, problem_for

EXACT, SMALL = 1e-12, 1e-13  # relative distance from the powers at which a number still follows; less is no term
AGREES = 1e-10  # the same of all sliders at once
SPAN = 4.0  # a slider goes from a fourth of its value to four times it
RATIOS = 1.0, 0.6, 1.5, 0.8, 1.9, 0.7, 1.25  # of its value where it is asked
POWERS = (1,), (-1,), (1, 2), (-1, -2), (1, -1), (1, -1, 2, -2)
MOST_PLACES = 130  # places at which sliders that move a number together are asked
LEFT_OUT = ".order", ".T1", ".T2"  # whole numbers, and torques whose order the law asks for
LOAD = "load.inertia"  # that every file gives
TORQUE = "excitation.load_torque.mean"  # that every page has


class Slider(NamedTuple):
    """A number of the project file; `moves` are numbers of the page that it alone moves along a line, and their slopes.

    `powers` are those of its share of `unity` in the other numbers that it moves.
    """

    name: str
    label: str
    value: float
    unit: str
    low: float
    high: float
    moves: tuple[tuple[int, float], ...]
    unity: float = 1.0
    powers: tuple[int, ...] = (1,)

    def data(self) -> dict[str, Any]:
        """The slider as the page has it, with the unit as it is printed."""
        return self._asdict() | {"shown": sign(self.unit.replace("^", "**"))}

    @property
    def ends(self) -> tuple[float, float]:
        """Ratios of `at` at the ends of the slider."""
        return 1.0 + (self.low - self.value) / self.unity, 1.0 + (self.high - self.value) / self.unity

    def at(self, ratio: float) -> float:
        """Value at a ratio to that of the file; as far from 0 where that is none."""
        return self.value + (ratio - 1.0) * self.unity


class Kernel:
    """A system as the kernel of a page gets it."""

    def __init__(self, system: Any, speeds: tuple[float, float]) -> None:
        problem = problem_for(system, speeds)
        self.laws: tuple[Any, ...] = problem.part.laws
        self.drive, self.begin = drive_numbers(problem), beginning(problem)

    @cached_property
    def arrays(self) -> list[Floats]:
        """Arrays in their order: matrices, numbers of the laws, what drives."""
        drive = self.drive
        system = [drive.matrices, drive.disturbed, np.array(drive.damping)]
        laws = [np.array(leaves(law), float) for law in self.laws]
        return [*system, *laws, drive.forces, drive.per_speed, drive.zero_mean, drive.pointing, drive.lines]

    @property
    def sizes(self) -> list[Floats]:
        """Sizes beside which a change of each number is rounding: those of the largest of its kind."""
        rows = [np.abs(array) for array in self.arrays]
        for i, array in enumerate(rows[:2]):
            rows[i] = np.broadcast_to(np.max(array, axis=(1, 2), keepdims=True), array.shape)
        rows[-1] = np.column_stack([rows[-1][:, :1], np.broadcast_to(np.max(rows[-1][:, 1:]), rows[-1][:, 1:].shape)])
        rows[-5] = np.broadcast_to(np.max(rows[-5]), rows[-5].shape)
        return rows

    @property
    def whole(self) -> tuple[int, ...]:
        """Its whole numbers, in the order of the kernel."""
        drive = self.drive
        return drive.follows, drive.loose, drive.controls, drive.every, drive.alone

    @property
    def kind(self) -> Any:
        """What no slider may change."""
        laws = [(type(law), len(breakpoints_of(law))) for law in self.laws]
        return [array.shape for array in self.arrays], self.whole[:-1], self.begin, laws


class OnPage:
    """A drive as the kernel of a page gets it, and behind a train with a driven motor that of an ideally held one."""

    def __init__(self, project: Project) -> None:
        train, limits = project.train, project.speeds.limits
        systems: list[Any] = [at_load(train)] if train is not None and has_curve(train) else []
        if train is None or not systems or (project.motor == "held" and not train.motor.held):
            systems.append(project.system(reduced=train is not None))
        self.kernels = [Kernel(system, limits) for system in systems]
        self.ends = np.array([*limits, project.limit if project.limit is not None else 0.0])
        self.scale = project.speeds.scale

    @cached_property
    def numbers(self) -> Floats:
        """All numbers of the page: those of the kernels, speeds and limit."""
        arrays = [array.ravel() for kernel in self.kernels for array in kernel.arrays]
        return np.concatenate([*arrays, self.ends])

    @cached_property
    def sizes(self) -> Floats:
        """Sizes beside which a change of each number is rounding."""
        rows = [row.ravel() for kernel in self.kernels for row in kernel.sizes]
        return np.concatenate([*rows, np.abs(self.ends)])

    @property
    def kind(self) -> Any:
        """What no slider may change."""
        return [kernel.kind for kernel in self.kernels], self.scale


def sliders(project: Project) -> tuple[Project, list[Slider], list[Any]]:
    """Numbers of the file that move those of the page, and the numbers that several move; and their project.

    Each of the last is (place, terms), a term (factor, ((number of a slider, power), ...)). A damping that the file
    gives as a ratio is there a number, as in `replaced`.
    """
    content = read(project.text).content
    records = [f"gear.{name}" for name in OF_RECORD] if isinstance(content.get("gear"), str) else []
    names = [name for name in numbers_of(content) if name.startswith("gear.")] + records
    value, unit = nominal_of(content, project.gear, LOAD)
    base = project
    if TORQUE not in numbers_of(content):
        base = replaced(base, {TORQUE: "0 N*m"})
    for factor in (1.5, 1.0):  # what is no other number stays as it is, and is a number then
        base = replaced(base, {LOAD: _quantity(factor * value, unit)})
    content = read(base.text).content
    moved: list[tuple[Slider, set[int]]] = []
    assumed = {source.name for source in (*project.sources, *base.sources) if source.word == "assumed"}
    for name in dict.fromkeys([*numbers_of(content), *of_record(content, base.gear), *names]):
        one = None if name.endswith(LEFT_OUT) else _slider(base, content, name)
        if one is not None:
            label = one[0].label + (" (assumed)" if name in assumed else "")
            moved.append((one[0]._replace(label=label), one[1]))
    while True:
        rows = [row for row, _ in moved]
        terms = [term for places, group in _groups(moved) for term in _terms(base, rows, group, places)]
        missed = _missed(base, rows, terms)
        if missed is None:
            return base, rows, terms
        del moved[max(i for i, (_, places) in enumerate(moved) if places & missed)]


def _slider(project: Project, content: dict[str, Any], name: str) -> tuple[Slider, set[int]] | None:
    """The slider of a number of the file, without what it moves, and what that is; None where it has none."""
    try:
        value, unit = of_record(content, project.gear).get(name) or nominal_of(content, project.gear, name)
    except ValueError:
        return None
    step = abs(value) or (1.0 if "N" not in unit else 0.1 * (project.rated_torque or 10.0))
    ends = (value / SPAN, value * SPAN) if value > 0.0 else (value - 5.0 * step, value + 5.0 * step)
    slider = Slider(name, label_of(content, name), value, unit, *ends, (), step)
    try:
        drives = {ratio: _with(project, {slider: slider.at(ratio)}) for ratio in RATIOS}
    except ValueError:
        return None
    for ratio in slider.ends:  # which may be refused, as a speed below the lowest is
        with suppress(ValueError):
            drives[ratio] = _with(project, {slider: slider.at(ratio)})
    first, *others = drives.values()
    if any(drive.kind != first.kind for drive in others):
        return None
    numbers = np.array([drive.numbers for drive in drives.values()])
    close = EXACT * np.max([drive.sizes for drive in drives.values()], axis=0)
    share = np.array([slider.at(ratio) / step for ratio in drives])
    places = {*np.flatnonzero(np.any(np.abs(numbers - numbers[0]) > close, axis=0)).tolist()}
    for powers in POWERS[: None if value > 0.0 else 3]:
        if value <= 0.0 and min(powers) < 0:
            continue
        table = share[:, None] ** np.array((0, *powers))
        factors = np.linalg.lstsq(table, numbers, rcond=None)[0]
        if places and np.all(np.abs(table @ factors - numbers) <= close):
            if powers == (1,):
                slider = slider._replace(moves=tuple((i, float(factors[1, i] / step)) for i in sorted(places)))
            return slider._replace(powers=powers), places
    return None


def _groups(moved: list[tuple[Slider, set[int]]]) -> list[tuple[list[int], tuple[int, ...]]]:
    """Numbers with the sliders that move them, together where they are the same; `moves` are of one slider alone."""
    movers: dict[int, tuple[int, ...]] = {}
    for i, (_, places) in enumerate(moved):
        for place in places:
            movers[place] = (*movers.get(place, ()), i)
    groups: dict[tuple[int, ...], list[int]] = {}
    for place, group in sorted(movers.items()):
        if len(group) > 1 or moved[group[0]][0].powers != (1,):
            groups.setdefault(group, []).append(place)
    for i, (row, places) in enumerate(moved):
        moved[i] = row._replace(moves=tuple(move for move in row.moves if movers[move[0]] == (i,))), places
    return [(places, group) for group, places in groups.items()]


def _terms(project: Project, rows: list[Slider], group: tuple[int, ...], places: list[int]) -> list[Any]:
    """Terms of numbers that a group of sliders moves, from a grid of as many places as there are terms."""
    row_of = [rows[i] for i in group]
    ratios = [RATIOS[: 1 + len(row.powers)] for row in row_of]
    shape = tuple(map(len, ratios))
    if np.prod(shape) > MOST_PLACES:
        return []
    values, cells = np.empty((*shape, len(places))), [*product(*map(range, shape))]
    for cell in cells:
        changes = {row: row.at(ratio[i]) for row, ratio, i in zip(row_of, ratios, cell, strict=True)}
        values[cell] = _with(project, changes).numbers[places]
    for axis, (row, ratio) in enumerate(zip(row_of, ratios, strict=True)):
        table = np.array([[(row.at(r) / row.unity) ** p for p in (0, *row.powers)] for r in ratio])
        values = np.moveaxis(np.tensordot(np.linalg.inv(table), values, axes=(1, axis)), 0, axis)
    every = [(0, *row.powers) for row in row_of]
    powers = {cell: [(i, own[k]) for i, own, k in zip(group, every, cell, strict=True) if k] for cell in cells}
    terms = []
    for place, size in zip(places, np.moveaxis(values, -1, 0), strict=True):
        least = SMALL * np.max(np.abs(size))
        terms.append((place, [(float(size[c]), powers[c]) for c in cells if abs(size[c]) > least]))
    return terms


def _missed(project: Project, rows: list[Slider], terms: list[Any]) -> set[int] | None:
    """The first number that terms and moves of all sliders miss somewhere, or all if no place has a drive; or None."""
    base, places = OnPage(project).numbers, 0
    shares = [[RATIOS[1 + (3 * i + shift) % 6] for i in range(len(rows))] for shift in range(3)]
    for ratios in (*shares, *zip(*(row.ends for row in rows), strict=True)):
        changes = {row: row.at(ratio) for row, ratio in zip(rows, ratios, strict=True)}
        try:
            changed = _with(project, changes)
        except ValueError:
            continue
        places += 1
        numbers = moved_numbers(base, rows, terms, [*changes.values()])
        wrong = np.flatnonzero(np.abs(numbers - changed.numbers) > AGREES * changed.sizes)
        if len(wrong):
            return {int(wrong[0])}
    return None if places or not rows else {*range(len(base))}


def moved_numbers(numbers: Floats, rows: list[Slider], terms: list[Any], values: list[float]) -> Floats:
    """The numbers of a page at values of its sliders, as the page finds them."""
    moved = numbers.copy()
    for row, value in zip(rows, values, strict=True):
        for place, slope in row.moves:
            moved[place] += slope * (value - row.value)
    shares = [value / row.unity for row, value in zip(rows, values, strict=True)]
    for place, sums in terms:
        moved[place] = sum(
            factor * float(np.prod([shares[i] ** float(p) for i, p in powers])) for factor, powers in sums
        )
    return moved


def _with(project: Project, changes: dict[Slider, float]) -> OnPage:
    return OnPage(replaced(project, {row.name: _quantity(value, row.unit) for row, value in changes.items()}))


def _quantity(value: float, unit: str) -> str:
    return f"{value!r} {unit}".rstrip()
