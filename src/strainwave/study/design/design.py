"""The search: cheap rules for every gear, averaging for every drive that passes them, harmonic balance for what counts.

A design is a gear with a motor, which must serve every load of the specification. Averaging decides where the limit is
outside its bounds; designs with the limit inside, and those on the Pareto front, are computed by harmonic balance of
the whole drive.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Interrupted, SolveError
from ...base.sentences import listed, silent
from ...base.units import ARCSEC, RPM
from ...model.drive import Drive
from ...model.error_spectrum import accuracy_spectrum
from ...model.excitation import Harmonic, KinematicError
from ...model.gears import catalogue
from ...model.gears.gear import Gear
from ...model.train.controls import Held
from ...model.train.drive_train import DriveTrain
from .averaged import Balanced, Drives, Largest, balanced, largest, sensitivities, worth
from .result import Candidate, Design, front
from .specification import DRIVE, SURE, WORDS, Check, Specification, checks, digits_apart, life, needed

MOST_BALANCED = 400  # designs by harmonic balance
MOST_DRIVES = 2000  # at once by averaging
BEST = 3  # designs whose sensitivities are told
AVERAGING, BALANCE = "averaging", "harmonic balance"
OSCILLATION = "oscillation"
Told = Callable[[str, float], None]


class Option(NamedTuple):
    """A gear with one rotor: what averaging says of it under its worst load."""

    gear: Gear
    rules: Check
    rotor: float
    load: float
    size: float
    low: float
    high: float
    speed: float
    error: float
    torque: float
    balanced: bool = False

    @property
    def J_m(self) -> float:
        """Inertia of the motor with the wave generator [kg*m^2]."""
        return self.rotor + (self.gear.input_inertia or 0.0)


def design(
    specification: Specification, *, gears: Iterable[Gear] | None = None, progress: Told = silent
) -> Design:  # fmt: skip
    """Search the catalogue for the gears and motors that meet a specification.

    Parameters
    ----------
    specification : Specification
        What the axis must do; `read_specification` reads it from a file.
    gears : iterable of Gear, optional
        Records to choose from. Default: the whole catalogue.
    progress : callable
        Told what is done now, and the share of the work that is done.

    Returns
    -------
    Design
        `feasible` and `pareto` designs by ascending oscillation [rad], and why each other gear is `rejected`;
        where nothing serves `nearest` says what binds.

    Raises
    ------
    Interrupted
        On Ctrl-C during harmonic balance, with what averaging says of the designs that it had not reached.
    ValueError
        If the specification contradicts itself, or a number of it is out of range.

    References
    ----------
    Harmonic Drive LLC, CSF/CSG catalogue, p. 14 (selection by average, peak and momentary torque, speeds and life).
    """
    specification.check()
    return _Search(specification, progress).run(catalogue.select(gears))


class _Search:
    """One search; its lists grow as it goes."""

    def __init__(self, spec: Specification, progress: Told) -> None:
        self.spec, self.progress = spec, progress
        self.misses: dict[str, Check] = {}  # of each gear the constraint that it misses most
        self.good: list[Option] = []
        self.known: dict[Any, tuple[Balanced, float] | None] = {}
        self.drives = 0
        self.stopped = False  # by Ctrl-C: what is left is decided by averaging

    def run(self, gears: list[Gear]) -> Design:
        """Search through gears."""
        passed = []
        for gear in gears:
            rules = max(checks(gear, self.spec), key=lambda check: check.use)
            if rules.violated:
                self.misses[gear.name] = rules
            else:
                passed.append((gear, rules))
        options: list[Option] = []
        for i, (gear, rules) in enumerate(passed):
            self.progress(f"averaging, {gear.name}", 0.5 * i / len(passed))
            options += self._averaged(gear, rules)
        self._decide(options)
        best = self._front()
        feasible = sorted(map(self._candidate, self.good), key=lambda c: (c.oscillation, c.reflected_inertia))
        for option in self.good:
            self.misses.pop(option.gear.name, None)
        nearest = "" if feasible else self._nearest(gears)
        chosen = [(o, self._drives(o.gear, [o.rotor], [o.load])) for o in best[:BEST]]
        result = Design(
            self.spec,
            tuple(feasible),
            tuple(map(self._candidate, best)),
            {name: _told(check) for name, check in self.misses.items()},
            nearest,
            tuple(sensitivities([(o.gear.name, o.J_m, drives) for o, drives in chosen])),
            self.drives,
            len(self.known),
            tuple(self._remarks()),
        )
        if self.stopped:
            raise Interrupted(
                f"interrupted; {len(self.known)} designs were computed by harmonic balance, the others by averaging",
                result,
            )
        return result

    def _drives(self, gear: Gear, motors: Any, loads: Any) -> Drives:
        """Drives of a gear: every motor with every load."""
        spec = self.spec
        J_m = np.repeat(np.asarray(motors, float), len(loads)) + (gear.input_inertia or 0.0)
        J_l = np.tile(np.asarray(loads, float), len(motors))
        ratio = float(gear.ratio)
        loop = spec.control(1.0)
        gain = J_m + J_l / ratio**2 if loop is not None and loop is not spec.loop else 1.0
        low, high = ratio * spec.speeds[0], ratio * spec.speeds[1]
        return Drives(
            gear.law, ratio, spec.average_load, _error(gear, spec), (low, high), J_m, J_l,
            spec.damping(gear.law.K1, J_l), loop, gain,
        )  # fmt: skip

    def _averaged(self, gear: Gear, rules: Check) -> list[Option]:
        """One option for every motor, each under the load with the largest oscillation."""
        spec, loads = self.spec, self.spec.load_inertias
        each = max(1, MOST_DRIVES // len(loads))
        options: list[Option] = []
        nearest: tuple[float, Drives, Largest, int] | None = None
        for start in range(0, len(spec.rotor_inertias), each):
            motors = spec.rotor_inertias[start : start + each]
            drives = self._drives(gear, motors, loads)
            result = largest(drives)
            self.drives += len(drives.J_l)
            values = np.array([result.oscillation, result.low, result.high, result.omega])
            size, low, high, speed = values.reshape(4, len(motors), len(loads))
            worst = np.argmax(size, axis=1)
            rows = np.arange(len(motors))
            for row, column in zip(rows.tolist(), worst.tolist(), strict=True):
                bounds = float(low[row].max()), float(high[row].max())
                there = float(size[row, column]), *bounds, float(speed[row, column])
                options.append(Option(gear, rules, motors[row], loads[column], *there, 0.0, -spec.average_load))
            distance = np.abs(np.log(size[rows, worst] / spec.limit))
            row = int(np.argmin(distance))
            if nearest is None or distance[row] < nearest[0]:
                nearest = float(distance[row]), drives, result, int(row * len(loads) + worst[row])
        assert nearest is not None
        certified = worth(*nearest[1:])
        return [_bounded(option, certified) for option in options]

    def _decide(self, options: list[Option]) -> None:
        """Sort options into those that serve and those that do not; what averaging leaves open goes to the balance."""
        limit, open_ = self.spec.limit * SURE, []
        for option in sorted(options, key=lambda o: o.size):
            if option.high <= limit:
                self.good.append(option)
            elif option.low > limit:
                self._miss(option)
            else:
                open_.append(option)
        served = {option.gear.name for option in self.good}
        first = {o.gear.name: o for o in reversed(open_) if o.gear.name not in served}  # the best of each gear
        ahead = list(first.values())
        open_ = ahead + [o for o in open_ if o not in ahead]
        for i, option in enumerate(open_):
            option = self._balanced(option, 0.5 + 0.4 * i / len(open_))
            if option.size <= limit:
                self.good.append(option)
            else:
                self._miss(option)

    def _front(self) -> list[Option]:
        """The front, every member by harmonic balance: what fails there leaves, and others take its place."""
        while True:
            chosen = front([self._candidate(option) for option in self.good])
            names = {(c.gear, c.rotor_inertia) for c in chosen}
            members = [o for o in self.good if (o.gear.name, o.rotor) in names]
            open_ = [o for o in members if not o.balanced]
            if not open_ or self.stopped or len(self.known) >= MOST_BALANCED:
                return sorted(members, key=lambda o: o.size)
            for option in open_:
                self.good.remove(option)
                option = self._balanced(option, 0.95)
                if option.size <= self.spec.limit * SURE:
                    self.good.append(option._replace(balanced=not self.stopped or option.balanced))
                else:
                    self._miss(option)

    def _balanced(self, option: Option, share: float) -> Option:
        """An option by harmonic balance of its whole drive; unchanged without a motion, or after too many of them."""
        motor = None if self.spec.loop is None else option.rotor  # which a held motor's error does not depend on
        key = option.gear.name, motor, option.load
        if key not in self.known:
            if self.stopped or len(self.known) >= MOST_BALANCED:
                return option
            try:
                self.progress(f"harmonic balance, {option.gear.name}", share)
                self.known[key] = self._worst(option)
            except KeyboardInterrupt:
                self.stopped = True
                return option
        found = self.known[key]
        if found is None:
            return option
        (size, speed, error), torque = found
        return option._replace(
            size=size, speed=speed, error=error, low=size, high=size, torque=torque, balanced=True
        )  # fmt: skip

    def _worst(self, option: Option) -> tuple[Balanced, float] | None:
        """Largest oscillation of an option, and the mean torque [N*m] under which it occurs; None where one fails.

        The torque has either sign. With the motor held both are alike where a shift of the angle turns the error into
        its negative: where the orders of its lines have the same power of 2.
        """
        speeds = self._drives(option.gear, [option.rotor], [option.load]).speeds
        lines = _error(option.gear, self.spec).lines
        alike = self.spec.loop is None and len({line.order & -line.order for line in lines if line.amplitude}) < 2
        cases = []
        for torque in (option.torque,) if alike or not option.torque else (option.torque, -option.torque):
            try:
                motion = balanced(self._train(option, torque), speeds)
            except SolveError:
                return None
            if motion is None:
                return None
            cases.append((motion, torque))
        return max(cases, key=lambda both: both[0].oscillation)

    def _train(self, option: Option, torque: float) -> DriveTrain:
        """The whole drive of an option, under a mean torque [N*m] on its load."""
        gear, spec, ratio = option.gear, self.spec, float(option.gear.ratio)
        J_m = option.J_m
        drive = Drive(J_m, option.load, ratio, float(spec.damping(gear.law.K1, option.load)), gear.law)
        control = spec.control(J_m + option.load / ratio**2)
        return drive.train(
            load_torque=Harmonic(0.0, mean=torque),
            kinematic_error=_error(gear, spec),
            omega=ratio * math.sqrt(spec.speeds[0] * spec.speeds[1]),
            control=Held() if control is None else control,
        )

    def _miss(self, option: Option) -> None:
        """Note what a gear misses: of its motors the one with the smallest oscillation counts."""
        spec, c = self.spec, self._candidate(option)
        sure = "" if option.balanced else f", at least {option.low / ARCSEC:.4g} arcsec"
        if not option.balanced and math.isfinite(option.high):
            sure = f", between {option.low / ARCSEC:.4g} and {option.high / ARCSEC:.4g} arcsec"
        use = c.oscillation / spec.limit
        digits = digits_apart(use)
        said = (
            f"The pointing error of {c.gear} oscillates by {c.oscillation / ARCSEC:.{digits}g} arcsec at "
            f"{c.speed / RPM:.4g} rpm of the motor with a rotor of {c.rotor_inertia:.3g} kg*m^2 ({c.method}{sure}), "
            f"above the limit of {spec.limit / ARCSEC:.{digits}g} arcsec."
        )
        check = Check(OSCILLATION, use, said, option.gear.doubts_about(*DRIVE))
        before = self.misses.get(c.gear)
        if before is None or before.name != OSCILLATION or check.use < before.use:
            self.misses[c.gear] = check

    def _candidate(self, option: Option) -> Candidate:
        gear, spec = option.gear, self.spec
        used = option.size / spec.limit
        binding = (OSCILLATION, used) if used >= option.rules.use else (option.rules.name, option.rules.use)
        return Candidate(
            gear.name, gear.ratio, gear.size or 0, math.nan if gear.mass is None else gear.mass, option.J_m,
            gear.ratio**2 * option.J_m, option.load, float(spec.damping(gear.law.K1, option.load)), option.size,
            option.speed, option.error, BALANCE if option.balanced else AVERAGING, life(gear, spec),
            1.0 - binding[1], binding[0], option.torque, option.rotor, gear.doubts_about(*needed(spec)),
        )  # fmt: skip

    def _nearest(self, gears: list[Gear]) -> str:
        """The gear that misses least of all, with the oscillation of those that the rules had turned away already."""
        known = sorted(
            ((self.misses[gear.name], gear) for gear in gears if math.isfinite(self.misses[gear.name].use)),
            key=lambda miss: miss[0].use,
        )
        best: tuple[str, Check] | None = None
        for rules, gear in known:
            if best is not None and rules.use >= best[1].use:
                break
            check = rules
            if rules.name != OSCILLATION:
                for option in self._averaged(gear, rules):
                    self._miss(option)
                check = max(rules, self.misses[gear.name], key=lambda miss: miss.use)
                self.misses[gear.name] = check
            if best is None or check.use < best[1].use:
                best = gear.name, check
        if best is None:
            return _lacking([self.misses[gear.name].name for gear in gears])
        return f"No gear serves. The nearest is {best[0]}: {_told(best[1])}"

    def _remarks(self) -> Iterator[str]:
        yield from self.spec.remarks
        if self.spec.accuracy is None and self.spec.kinematic_error is None:
            yield (
                "The kinematic error is each gear's accuracy class, shared by the orders 1, 2, 4 as 1 : 4 : 1 by "
                "assumption; units of one type differ by a factor of about 3."
            )
        if self.stopped:
            yield f"Interrupted: {len(self.known)} designs are by harmonic balance, the others by averaging."
        if len(self.known) >= MOST_BALANCED:
            yield f"Only {MOST_BALANCED} designs were computed by harmonic balance; the others are by averaging."


def _error(gear: Gear, spec: Specification) -> KinematicError:
    """Kinematic error of a gear under a specification."""
    if spec.kinematic_error is not None:
        return spec.kinematic_error
    return accuracy_spectrum(spec.accuracy or gear.accuracy or 0.0)


def _bounded(option: Option, error: float) -> Option:
    """An option with what its certificate adds to the bounds of averaging."""
    low, high = option.low / (1.0 + error), option.high * (1.0 + error)
    return option._replace(low=low, high=high, error=max(high / option.size - 1.0, 1.0 - low / option.size))


def _told(check: Check) -> str:
    """Sentence of a constraint with by how much it is missed."""
    said = check.sentence
    if math.isfinite(check.use):
        use = f"{check.use:.{digits_apart(check.use)}g} times"
        said = f"{said[:-1]}: {use} {'too short' if check.name == 'life' else 'the allowance'}."
    return " ".join((said, *check.doubts))


def _lacking(names: list[str]) -> str:
    """What no source gives, where every gear lacks a number that the specification needs."""
    counts = Counter(WORDS.get(name, name.replace("_", " ")) for name in names)
    said = listed(f"the {name} of {count} gear{'s' if count > 1 else ''}" for name, count in counts.most_common())
    ways = ["leave out what needs it", *(["give excitation.accuracy"] if "accuracy" in names else [])]
    return f"No gear serves: no source gives {said}, which the specification needs; {' or '.join(ways)}."
