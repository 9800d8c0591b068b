"""`Analysis`: what `analyze` returns, with the largest error and oscillation in it."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from ...base.facts import Fact
from ...base.records import Labelled, Result
from ...drive.demands.usage import MotorUse, Usage
from ...drive.drive_response import DriveResponse
from ...drive.hysteresis_bands import HysteresisBand
from ...drive.project import Project
from ...model.gears.limits import Finding
from ...model.oscillator import Oscillator, VaryingOscillator
from ...theory.parametric import ParametricResonance
from ...theory.resonance import Resonance
from ...theory.stability_proof import StabilityProof
from ..gear.hysteresis_loop import GearLoop
from ..move.result import Move
from ..speed_map.avoid import Avoid
from ..speed_map.error_equation import OperatingPoint
from ..speed_map.ramp import Ramp
from . import verdict_words
from .cautions import cautions
from .load_cases import AtTorque
from .regimes import Regime
from .remedies import Remedy
from .time_domain.beat import Beat
from .time_domain.run_up_check import RunUp
from .time_domain.time_case import TimeCase
from .train_study import MotorCase, TrainStudy
from .verdict import TIE_RATIO, JudgedPosture, Verdict


class Largest(NamedTuple):
    """The largest |error| [rad] of an analysis, the base-angle speed [rad/s] there, its motion and its method.

    `torque` is the constant torque [N*m] of the load there, where the drive has a range of them; None otherwise. Where
    the motion beats, `smallest` is the oscillation [rad] in its smallest turn, and `beat` its period [s].
    """

    peak: float
    omega: float
    of: str
    method: str
    torque: float | None = None
    smallest: float | None = None
    beat: float | None = None


@dataclass(frozen=True, eq=False)
class Analysis(Result):
    """Everything that the report shows about a drive.

    Attributes
    ----------
    system : Oscillator or VaryingOscillator
        The error equation at the middle of the range.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    point : OperatingPoint
        Equilibrium under the mean torque.
    stability : StabilityProof
        Lyapunov's certificate of the drive without excitation.
    regimes : tuple of Regime
        Resonances of all excitation lines, by ascending speed.
    exact : DriveResponse
        Response of the error equation through the range, with stability, folds and jumps.
    close : dict of Resonance to DriveResponse
        The response once more around those resonances that are too narrow for the points of `exact`.
    run_up : RunUp
        Simulated run-up and run-down, its independent check.
    cases : tuple of TimeCase
        Single speeds in time.
    drive : DriveResponse
        Steady motions of the drive: of the whole train where there is a curve of it, else of the error equation.
    load_cases : tuple of AtTorque
        The same under the torques of the load's range, ascending; empty where it has one torque.
    motors : tuple of MotorCase
        The drive with other motors, where nothing says which it has; empty otherwise.
    usage : Usage
        What the steady motions ask of the gear: those of the whole drive train and its run-up, where there are any.
    limits : tuple of Finding
        The same against each limit of the gear's datasheet, and of the motor in the file; empty where none is known.
    loop : GearLoop or None
        Hysteresis loop of a law with friction or memory.
    parametric : tuple of ParametricResonance
        Of a stiffness that varies, in the speed range.
    train : TrainStudy or None
        The whole drive train, where the error equation leaves something of it out.
    avoid : Avoid or None
        Speeds to avoid; None where no motion is stable.
    remedies : tuple of Remedy
        What would make the error smaller, the most helpful first; empty where no speed is to be avoided. Where the load
        has a range of torques they are for the torque with the largest oscillation.
    not_tried : tuple of str
        What else would have been tried, and why it was not.
    verdict : Verdict
        Whether the drive is all right at its speeds, in every posture, and the smallest change that brings it under its
        limit under the load of the file.
    remarks : tuple of str
        Why a part is missing.
    doubts : tuple of str
        Results that no gear gives.
    motor : MotorUse or None
        What the steady motions and the run-up ask of the motor; None where it is not known.
    other_damping : tuple of Remedy
        The largest oscillation with two thirds and with five thirds of the gear's damping; empty without advice.
    postures : tuple of JudgedPosture
        The drive in every posture of the project; each counts in the verdict.
    beat : Beat or None
        The largest motion turn by turn, where motions beat.
    moved : Move or None
        The move that the file asks for; a limit that it passes counts in the verdict.
    project : Project
        What was analysed.
    """

    system: Oscillator | VaryingOscillator
    speeds: tuple[float, float]
    point: OperatingPoint
    stability: StabilityProof
    regimes: tuple[Regime, ...]
    exact: DriveResponse
    close: dict[Resonance, DriveResponse]
    run_up: RunUp
    cases: tuple[TimeCase, ...]
    drive: DriveResponse
    load_cases: tuple[AtTorque, ...]
    motors: tuple[MotorCase, ...]
    usage: Usage
    limits: tuple[Finding, ...]
    loop: GearLoop | None
    parametric: tuple[ParametricResonance, ...]
    train: TrainStudy | None
    avoid: Avoid | None
    remedies: tuple[Remedy, ...]
    not_tried: tuple[str, ...]
    verdict: Verdict
    remarks: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    motor: MotorUse | None = None
    other_damping: tuple[Remedy, ...] = ()
    postures: tuple[JudgedPosture, ...] = ()
    beat: Beat | None = None
    moved: Move | None = None
    project: Project = field(kw_only=True)

    def facts(self) -> tuple[Fact, ...]:
        """The verdict: told once for a terminal, as JSON and for the pages of the report."""
        return verdict_words.facts(self)

    def coordinates(self) -> Labelled:
        """As of the steady motions."""
        return self.drive.coordinates()

    def variables(self) -> Labelled:
        """Those of the steady motions that the drive's largest error is read from."""
        return self.drive.variables()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences about what went wrong or needs care."""
        return tuple(cautions(self))

    @property
    def posture(self) -> JudgedPosture | None:
        """The worst posture; None for a project without postures."""
        return max(self.postures, key=lambda row: row.rank, default=None)

    @property
    def train_curve(self) -> DriveResponse | None:
        """Steady motions of the whole drive train, where it has any that repeat."""
        return None if self.train is None else self.train.curve

    @property
    def run_alone(self) -> Ramp | None:
        """Run-up of the whole drive train, where it alone has all torques of it."""
        return None if self.train is None else self.train.run_alone

    @property
    def curves(self) -> tuple[tuple[float | None, DriveResponse], ...]:
        """Every curve of the drive, with the constant torque [N*m] of the load where it has a range of them."""
        return tuple((case.torque, case.drive) for case in self.load_cases) or ((None, self.drive),)

    @property
    def jumping(self) -> tuple[tuple[float | None, HysteresisBand], ...]:
        """Every band between jumps of a slow run-up or run-down, with the constant torque [N*m] of its curve."""
        return tuple((torque, band) for torque, drive in self.curves if drive.sweep for band in drive.sweep.jumping)

    @property
    def loudest(self) -> DriveResponse:
        """The curve with the largest oscillation."""
        return dict(self.curves)[self.largest_oscillation().torque]

    def largest(self) -> Largest:
        """Largest |error| that a sweep meets, of the whole train where there is one: steady, or in its run-up.

        Of the error equation it is on the curve, or simulated where the curve has no motion as large.
        """
        model = "error equation" if self.train_curve is None else "whole drive train"
        tops = [(drive.largest(), drive, torque) for torque, drive in self.curves]
        crests = [(float(d.peak[i]), float(d.omega[i]), d.method, torque) for i, d, torque in tops if i is not None]
        peaks = [Largest(p, omega, model, method, torque) for p, omega, method, torque in crests]
        best = max(peaks, key=lambda largest: largest.peak, default=None)
        if (ramp := self.run_alone) is not None:
            run = Largest(*ramp.largest(ramp.run.pointing), "run-up of the whole drive train", "integration")
            return run if best is None or self.train_curve is None or run.peak > TIE_RATIO * best.peak else best
        worst = self.run_up.worst()
        if worst is not None and (best is None or (self.train_curve is None and best.peak < worst.peak / TIE_RATIO)):
            return Largest(worst.peak, worst.omega, "error equation", "integration")
        assert best is not None
        return best

    def largest_oscillation(self) -> Largest:
        """Largest |error - mean| on the curves of the drive, where a slow run-up or run-down goes."""
        of = "error equation" if self.train_curve is None else "whole drive train"
        crests = []
        for torque, drive in self.curves:
            top, sizes = drive.top, drive.oscillation
            largest = Largest(float(sizes[top]), float(drive.omega[top]), of, drive.method, torque)
            if (envelope := drive.curve.envelope) is not None and (turns := drive.curve.beat) is not None:
                period = 2.0 * math.pi * turns / largest.omega
                largest = largest._replace(smallest=float(envelope[top, 1]), beat=period)
            crests.append(largest)
        return max(crests, key=lambda largest: largest.peak)
