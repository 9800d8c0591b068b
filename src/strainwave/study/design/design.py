"""The search: cheap rules for every gear, averaging for every drive that passes them, harmonic balance for what counts.

A design is a gear with a motor, which must serve every load of the specification. Averaging decides where the limit is
outside its bounds; designs with the limit inside, and those on the Pareto front, are computed by harmonic balance of
the whole drive.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ...base.results import Interrupted, SolveError
from ...base.sentences import listed
from ...base.terminal import Progress, silent
from ...base.units import ARCSEC, RPM
from ...drive.loops.instability import instability
from ...drive.train_curve import POINTS, Crest, largest_crest
from ...model.drive import Drive
from ...model.excitation import Harmonic
from ...model.gears import catalogue
from ...model.gears.gear import Gear
from ...model.train.controls import Held
from ...model.train.drive_train import DriveTrain
from .averaged import Drives, Largest, certified_error, largest, sensitivities
from .options import Case, Option, cases_to_balance, error_of, forbidden, option_of, rotor_doubts, with_error
from .result import Candidate, Design, front
from .specification import DRIVE, SURE, WORDS, Check, Specification, checks, digits_apart, life, miss_of, needed

MOST_BALANCED = 400  # designs by harmonic balance
MOST_DRIVES = 2000  # at once by averaging
MOST_SENSITIVITIES = 3  # designs whose sensitivities are given
AVERAGING, BALANCE = "averaging", "harmonic balance"
NO_CHECK = Check("", 0.0, "")
OSCILLATION, LOOP = "oscillation", "loop"


def design(
    specification: Specification, *, gears: Iterable[Gear] | None = None, progress: Progress = silent
) -> Design:  # fmt: skip
    """Search the catalogue for the gears and motors that meet a specification.

    Parameters
    ----------
    specification : Specification
        Requirements of the axis; `read_specification` reads it from a file.
    gears : iterable of Gear, optional
        Records to choose from. Default: the whole catalogue.
    progress : callable
        progress(stage, share): called before each stage.

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

    def __init__(self, spec: Specification, progress: Progress) -> None:
        self.spec, self.progress = spec, progress
        self.misses: dict[str, Check] = {}  # of each gear the constraint that it misses most
        self.lacking: dict[str, list[Check]] = {}  # of each gear numbers that no source gives
        self.options: list[Option] = []  # of the gears that keep every rule
        self.good: list[Option] = []
        self.balances: dict[Any, tuple[Crest, float, float] | None] = {}
        self.between: dict[tuple[str, float], tuple[str, ...]] = {}  # of the best, by gear and rotor
        self.drives = 0
        self.stopped = False  # by Ctrl-C: what is left is decided by averaging

    def run(self, gears: list[Gear]) -> Design:
        """Search through gears."""
        passed = []
        for gear in gears:
            every = list(checks(gear, self.spec))
            rules = max((check for check in every if check.recorded), key=lambda check: check.use, default=NO_CHECK)
            if lacking := [check for check in every if not check.recorded]:
                self.lacking[gear.name] = lacking
            if rules.violated:
                self.misses[gear.name] = rules
            elif not lacking:
                passed.append((gear, rules))
        for i, (gear, rules) in enumerate(passed):
            self.progress(f"averaging, {gear.name}", 0.5 * i / len(passed))
            self.options += self._averaged(gear, rules)
        self._decide([*filter(self._is_stable, self.options)])
        best = self._front()
        feasible = sorted(map(self._candidate, self.good), key=lambda c: (c.oscillation, c.reflected_inertia))
        for option in self.good:
            self.misses.pop(option.gear.name, None)
        nearest = "" if feasible else self._nearest(gears)
        first = best[:MOST_SENSITIVITIES]
        chosen = [(o, self._drives(o.gear, [o.rotor], [o.worst.load], o.worst.torque)) for o in first]
        without = {name: some for name, some in self.lacking.items() if name not in self.misses}
        result = Design(
            specification=self.spec, feasible=tuple(feasible), pareto=tuple(map(self._candidate, best)),
            rejected={name: miss_of(check) for name, check in self.misses.items()},
            not_judged={name: " ".join(map(miss_of, some)) for name, some in without.items()},
            nearest=nearest, sensitivities=tuple(sensitivities([(o.gear.name, o.J_m, drives) for o, drives in chosen])),
            drives=self.drives, balanced=len(self.balances), remarks=tuple(self._remarks()),
        )  # fmt: skip
        if self.stopped:
            count = f"{len(self.balances)} designs were computed by harmonic balance"
            raise Interrupted(f"interrupted; {count}, the others by averaging", result)
        return result

    def _drives(self, gear: Gear, motors: Any, loads: Any, torque: float) -> Drives:
        """Drives of a gear: every motor with every load, under one torque on the load [N*m]."""
        spec = self.spec
        J_m = np.repeat(np.asarray(motors, float), len(loads)) + (gear.input_inertia or 0.0)
        J_l = np.tile(np.asarray(loads, float), len(motors))
        ratio = float(gear.ratio)
        loop, tuned = spec.control(1.0), np.array([*map(spec.tuned, J_l.tolist())])
        gain = J_m + tuned / ratio**2 if loop is not None and loop is not spec.loop else 1.0
        speeds, damping = (ratio * spec.speeds[0], ratio * spec.speeds[1]), spec.damping(gear.law.K1, tuned)
        return Drives(
            gear.law, ratio, -torque, error_of(gear, spec), speeds, J_m=J_m, J_l=J_l, B=damping, loop=loop, gain=gain
        )

    def _averaged(self, gear: Gear, rules: Check) -> list[Option]:
        """One option for every motor, with every load under every torque."""
        spec, loads, options = self.spec, self.spec.load_inertias, list[Option]()
        each = max(1, MOST_DRIVES // len(loads))
        nearest: tuple[float, Drives, Largest, int] | None = None
        for start in range(0, len(spec.rotor_inertias), each):
            motors = spec.rotor_inertias[start : start + each]
            cases: list[list[Case]] = [[] for _ in motors]
            for torque in spec.torques:
                drives = self._drives(gear, motors, loads, torque)
                peaks = largest(drives)
                self.drives += len(drives.J_l)
                rows = np.transpose([peaks.oscillation, peaks.low, peaks.high, peaks.omega]).tolist()
                for i, row in enumerate(rows):
                    cases[i // len(loads)].append(Case(loads[i % len(loads)], torque, *row))
                distance = np.abs(np.log(peaks.oscillation / spec.limit))
                if nearest is None or np.min(distance) < nearest[0]:
                    nearest = float(np.min(distance)), drives, peaks, int(np.argmin(distance))
            options += [option_of(gear, rules, rotor, some) for rotor, some in zip(motors, cases, strict=True)]
        assert nearest is not None
        error = certified_error(*nearest[1:])
        return [with_error(option, error) for option in options]

    def _is_stable(self, option: Option) -> bool:
        """True where the loop of an option is stable with the smallest and the largest load; else a miss is noted.

        What fails by its oscillation anyway passes.
        """
        spec, ratio = self.spec, option.gear.ratio
        if spec.loop is None or option.worst.low > spec.limit * SURE:
            return True
        for load in {min(spec.load_inertias), max(spec.load_inertias)}:
            train = self._train(option, option.cases[0]._replace(load=load, torque=0.0))
            if fault := instability(train, option.J_m + spec.tuned(load) / ratio**2):
                rotor = f"with a rotor of {option.rotor:.3g} kg*m^2 and a load of {load:g} kg*m^2"
                check = Check(LOOP, math.inf, f"The loop of {option.gear.name} {rotor} {fault}.")
                self.misses.setdefault(option.gear.name, check)
                return False
        return True

    def _decide(self, options: list[Option]) -> None:
        """Sort options into those that serve and those that do not; what averaging leaves open goes to the balance."""
        limit, open_ = self.spec.limit * SURE, []
        for option in sorted(options, key=lambda o: o.worst.size):
            if option.worst.high <= limit:
                self.good.append(option)
            elif option.worst.low > limit:
                self._miss(option)
            else:
                open_.append(option)
        served = {option.gear.name for option in self.good}
        first = {o.gear.name: o for o in reversed(open_) if o.gear.name not in served}  # the best of each gear
        ahead = list(first.values())
        open_ = ahead + [o for o in open_ if o not in ahead]
        for i, option in enumerate(open_):
            option = self._balanced(option, 0.5 + 0.4 * i / len(open_))
            if option.worst.size <= limit and not self._has_failed(option):
                self.good.append(option)
            else:
                self._miss(option)

    def _front(self) -> list[Option]:
        """The front, every member by harmonic balance, all of its speeds allowed; what fails leaves, others come."""
        while True:
            chosen = front([self._candidate(option) for option in self.good])
            names = {(c.gear, c.rotor_inertia) for c in chosen}
            members = sorted((o for o in self.good if (o.gear.name, o.rotor) in names), key=lambda o: o.worst.size)
            if self.stopped or len(self.balances) >= MOST_BALANCED:
                return members
            open_ = [o for o in members if not o.balanced and not self._has_failed(o)]
            refused = [] if open_ else [o for o in members if not self._is_allowed(o)]
            if not open_ and not refused:
                return members
            self.good = [o for o in self.good if o not in (*open_, *refused)]
            for option in open_:
                option = self._balanced(option, 0.95)
                bound = option.worst.high if self._has_failed(option) else option.worst.size
                if bound <= self.spec.limit * SURE:
                    self.good.append(option)
                else:
                    self._miss(option)

    def _balanced(self, option: Option, share: float) -> Option:
        """An option by harmonic balance of its whole drive; unchanged without a motion, or after too many of them."""
        key = self._key(option)
        if key not in self.balances:
            if self.stopped or len(self.balances) >= MOST_BALANCED:
                return option
            try:
                self.progress(f"harmonic balance, {option.gear.name}", share)
                self.balances[key] = self._worst(option)
            except KeyboardInterrupt:
                self.stopped = True
                return option
        worst = self.balances[key]
        if worst is None:
            return option
        crest, load, torque = worst
        case = Case(load, torque, crest.size, crest.size, crest.size, crest.speed)
        return option._replace(worst=case, error=crest.tail.share, balanced=True)

    def _key(self, option: Option) -> tuple[str, float | None]:
        """Gear and rotor of an option; no rotor with a held motor, whose error does not depend on it."""
        return option.gear.name, None if self.spec.loop is None else option.rotor

    def _has_failed(self, option: Option) -> bool:
        """True where harmonic balance was tried and found no motion: the bounds of averaging decide alone."""
        return self.balances.get(self._key(option), True) is None

    def _worst(self, option: Option) -> tuple[Crest, float, float] | None:
        """Largest oscillation of an option, with the load and the torque under which it occurs; None where one fails.

        Cases that averaging bounds below a computed motion are left out, and all others once one is too large.
        With the motor held both signs of a torque are alike where a shift of the angle turns the error into its
        negative: where the orders of its lines have the same power of 2.
        """
        lines = error_of(option.gear, self.spec).lines
        alike = self.spec.loop is None and len({line.order & -line.order for line in lines if line.amplitude}) < 2
        best: tuple[Crest, float, float] | None = None
        for case in cases_to_balance(option):
            if (alike and case.torque > 0.0) or (best is not None and case.high <= best[0].size):
                continue
            train = self._train(option, case)
            speeds = option.gear.ratio * self.spec.speeds[0], option.gear.ratio * self.spec.speeds[1]
            try:
                motion = largest_crest(train, speeds, None, points=POINTS)
            except SolveError:
                return None
            if motion is None:
                return None
            if best is None or motion.size > best[0].size:
                best = motion, case.load, case.torque
            if motion.size > self.spec.limit * SURE:
                break
        return best

    def _is_allowed(self, option: Option) -> bool:
        """True where every speed is allowed under the torques of the duty, by all motions, as a speed map decides it.

        Speeds forbidden between these torques are noted with the option.
        """
        gear, key = option.gear, (option.gear.name, option.rotor)
        if key in self.between:
            return True
        self.progress(f"other periodic motions, {gear.name}", 0.95)
        drive = f"{gear.name} with a rotor of {option.rotor:.3g} kg*m^2"
        try:
            train = self._train(option, option.cases[0]._replace(load=option.worst.load))
            size, under, between = forbidden(train, gear, self.spec)
        except KeyboardInterrupt:
            self.stopped = True
            return True
        if under:
            check = Check(OSCILLATION, size / self.spec.limit, f"{drive} does not meet the specification: {under}.")
            self.misses.setdefault(gear.name, check)
        sentence = f"{drive} meets the specification at the torques of the duty cycle, but not between them: {between}."
        self.between[key] = (sentence,) if between else ()
        return not under

    def _train(self, option: Option, case: Case) -> DriveTrain:
        """The whole drive of an option in a case."""
        gear, spec, ratio, tuned = option.gear, self.spec, float(option.gear.ratio), self.spec.tuned(case.load)
        drive = Drive(option.J_m, case.load, ratio, float(spec.damping(gear.law.K1, tuned)), gear.law)
        control = spec.control(option.J_m + tuned / ratio**2)
        return drive.train(
            load_torque=Harmonic(0.0, mean=case.torque),
            kinematic_error=error_of(gear, spec),
            omega=ratio * math.sqrt(spec.speeds[0] * spec.speeds[1]),
            control=Held() if control is None else control,
        )

    def _miss(self, option: Option) -> None:
        """Note what a gear misses: of its motors the one with the smallest oscillation counts."""
        spec, c = self.spec, self._candidate(option)
        low, high = option.worst.low / ARCSEC, option.worst.high / ARCSEC
        bounds = f"between {low:.4g} and {high:.4g} arcsec" if math.isfinite(high) else f"at least {low:.4g} arcsec"
        sure = "" if option.balanced else f", {bounds}"
        use = c.oscillation / spec.limit
        digits = digits_apart(use)
        limit = f"the limit of {spec.limit / ARCSEC:.{digits}g} arcsec"
        sentence = (
            f"The pointing error of {c.gear} oscillates by {c.oscillation / ARCSEC:.{digits}g} arcsec at "
            f"{c.speed / RPM:.4g} rpm of the motor with a rotor of {c.rotor_inertia:.3g} kg*m^2, a load of "
            f"{c.load_inertia:g} kg*m^2 and {c.load_torque:.4g} N*m on it ({c.method}{sure}), above {limit}."
        )
        if self._has_failed(option) and option.worst.low <= spec.limit:
            use = max(use, high * ARCSEC / spec.limit if math.isfinite(high) else 1.0)
            sentence = (
                f"Harmonic balance finds no motion of {c.gear}, and averaging ({bounds}) does not decide {limit}."
            )
        check = Check(OSCILLATION, use, sentence, (*option.gear.doubts_about(*DRIVE), *rotor_doubts(option)))
        if not (before := self.misses.get(c.gear)) or before.name != OSCILLATION or check.use < before.use:
            self.misses[c.gear] = check

    def _candidate(self, option: Option) -> Candidate:
        gear, spec, worst, key = option.gear, self.spec, option.worst, (option.gear.name, option.rotor)
        used = worst.size / spec.limit
        binding = (OSCILLATION, used) if used >= option.rules.use else (option.rules.name, option.rules.use)
        return Candidate(
            gear=gear.name, ratio=gear.ratio, size=gear.size or 0, mass=math.nan if gear.mass is None else gear.mass,
            motor_inertia=option.J_m, reflected_inertia=gear.ratio**2 * option.J_m, load_inertia=worst.load,
            B=float(spec.damping(gear.law.K1, spec.tuned(worst.load))), oscillation=worst.size, speed=worst.speed,
            error=option.error, method=BALANCE if option.balanced else AVERAGING, life=life(gear, spec),
            margin=1.0 - binding[1], binding=binding[0], load_torque=worst.torque, rotor_inertia=option.rotor,
            doubts=(*gear.doubts_about(*needed(spec)), *rotor_doubts(option), *self.between.get(key, ())),
            hysteresis_loss=math.nan if gear.hysteresis_loss is None else gear.hysteresis_loss,
        )  # fmt: skip

    def _nearest(self, gears: list[Gear]) -> str:
        """The gear that misses least of all, with the oscillation of those that the rules had turned away already."""
        judged = [gear for gear in gears if gear.name in self.misses and gear.name not in self.lacking]
        misses = [(self.misses[gear.name], gear) for gear in judged]
        missing = sorted((miss for miss in misses if math.isfinite(miss[0].use)), key=lambda miss: miss[0].use)
        best: tuple[str, Check] | None = None
        for rules, gear in missing:
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
            loops = [check.sentence for check in self.misses.values() if check.name == LOOP]
            names = [check.name for some in self.lacking.values() for check in some]
            return f"No gear meets the specification. {loops[0]}" if loops else _lacking(names)
        return f"No gear meets the specification. The nearest is {best[0]}: {miss_of(best[1])}"

    def _remarks(self) -> Iterator[str]:
        yield from self.spec.remarks
        heavy = max(self.options, key=lambda o: o.gear.input_inertia or 0.0, default=None)
        yield from (text for o in self.options if heavy and o.gear is heavy.gear for text in rotor_doubts(o))
        if self.spec.accuracy is None and self.spec.kinematic_error is None:
            yield (
                "Assumed kinematic error: each gear's accuracy class, divided among the orders 1, 2, 4 as 1 : 4 : 1; "
                "units of one type differ by a factor of about 3."
            )
        if any(option.gear.hysteresis_loss is not None for option in self.good):
            yield (
                "The hysteresis loss of the gears is neglected: its damping, and a lag of the load of up to half the "
                "loss after a reversal. 'hysteresis: catalogue' in a project file includes it."
            )
        if self.stopped:
            yield f"Interrupted: {len(self.balances)} designs computed by harmonic balance, the others by averaging."
        if len(self.balances) >= MOST_BALANCED:
            yield f"Only {MOST_BALANCED} designs were computed by harmonic balance; the others are by averaging."


def _lacking(names: list[str]) -> str:
    """Sentence on numbers that no source gives, where no gear that could be judged is left."""
    if not names:
        return "No gear meets the specification: no gear has the required series and ratio."
    counts = Counter(WORDS.get(name, name.replace("_", " ")) for name in names)
    numbers = listed(f"the {name} of {count} gear{'s' if count > 1 else ''}" for name, count in counts.most_common())
    assumed = " or give excitation.accuracy, or excitation.assumed for these gears" if "accuracy" in names else ""
    return f"No gear can be judged: no source gives {numbers}; remove the requirements that need them{assumed}."
