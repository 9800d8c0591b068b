"""What an analysis of a drive holds, and the largest error and oscillation in it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...model.gears.limits import Finding
from ...model.oscillator import Oscillator
from ...model.varying import VaryingOscillator
from ...records import Labelled, Result
from ...sentences import on_screen
from ...theory.slow_flow.resonance import Resonance
from ...theory.stability_proof import StabilityProof
from ..gear.parametric import ParametricResonance
from ..response.resonances import OperatingPoint, Regime
from ..response.response import ExactResponse
from .avoid import Avoid
from .cautions import cautions
from .drive_response import DriveResponse
from .gear_studies import GearLoop
from .in_time import TimeCase
from .load_range import LoadCase
from .motor_cases import MotorCase
from .remedies import Remedy
from .runup import RunUp
from .train_study import Ramp, TrainStudy
from .usage import MotorUse, Usage
from .verdict import Verdict

LESS = 1.001  # relative difference of two largest errors below which the steady one is named


class Largest(NamedTuple):
    """The largest |error| [rad] of an analysis, the base-angle speed [rad/s] there, its motion and its method.

    `torque` is the constant torque [N*m] of the load there, where the drive has a range of them; None otherwise.
    """

    peak: float
    omega: float
    of: str
    method: str
    torque: float | None = None


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
    exact : ExactResponse
        Response of the error equation through the range, with stability, folds and jumps.
    close : dict of Resonance to ExactResponse
        The response once more around those resonances that are too narrow for the points of `exact`.
    run_up : RunUp
        Simulated run-up and run-down, its independent check.
    cases : tuple of TimeCase
        Single speeds in time.
    drive : DriveResponse
        Steady motions of the drive: of the whole train where there is a curve of it, else of the error equation.
    load_cases : tuple of LoadCase
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
        Whether the drive is all right at its speeds, and the smallest change that brings it under its limit.
    remarks : tuple of str
        Why a part is missing.
    doubts : tuple of str
        Results that no gear gives.
    motor : MotorUse or None
        What the steady motions and the run-up ask of the motor; None where it is not known.
    """

    system: Oscillator | VaryingOscillator
    speeds: tuple[float, float]
    point: OperatingPoint
    stability: StabilityProof
    regimes: tuple[Regime, ...]
    exact: ExactResponse
    close: dict[Resonance, ExactResponse]
    run_up: RunUp
    cases: tuple[TimeCase, ...]
    drive: DriveResponse
    load_cases: tuple[LoadCase, ...]
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

    def coordinates(self) -> Labelled:
        """As of the response."""
        return self.response.coordinates()

    def variables(self) -> Labelled:
        """Those of the response that the drive's largest error is read from."""
        return self.response.variables()

    def __str__(self) -> str:
        worst, (low, high) = self.largest(), self.speeds
        motor = f", of the motor {self.motor.torque:.6g} N*m" if self.motor is not None else ""
        lines = [
            f"Analysis: {low:.6g} .. {high:.6g} rad/s of the base angle, {len(self.regimes)} resonances",
            f"  largest {self.drive.name} {worst.peak:.6g} rad at {worst.omega:.6g} rad/s ({worst.of}, {worst.method})",
            f"  largest torque in the gear {self.usage.peak_torque:.6g} N*m at {self.usage.at_peak:.6g} rad/s{motor}",
            f"  {len(self.remedies)} remedies, {len(self.warnings)} warnings; `exact`, `train`, `avoid` and the others "
            "hold them",
        ]
        return on_screen("\n".join(lines))

    __repr__ = __str__

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences about what went wrong or needs care."""
        return tuple(cautions(self))

    @property
    def train_curve(self) -> DriveResponse | None:
        """Steady motions of the whole drive train, where it has any that repeat."""
        return None if self.train is None else self.train.curve

    @property
    def run_alone(self) -> Ramp | None:
        """Run-up of the whole drive train, where it alone has all torques of it."""
        return None if self.train is None else self.train.run_alone

    @property
    def response(self) -> ExactResponse:
        """The curve that the drive's largest error is read from: of the whole train where there is one."""
        return self.drive.response

    @property
    def curves(self) -> tuple[tuple[float | None, DriveResponse], ...]:
        """Every curve of the drive, with the constant torque [N*m] of the load where it has a range of them."""
        return tuple((case.torque, case.drive) for case in self.load_cases) or ((None, self.drive),)

    @property
    def loudest(self) -> DriveResponse:
        """The curve with the largest oscillation."""
        return dict(self.curves)[self.largest_oscillation().torque]

    def largest(self) -> Largest:
        """Largest |error| that a sweep meets, of the whole train where there is one: steady, or in its run-up.

        Of the error equation it is on the curve, or simulated where the curve has no motion as large.
        """
        of = "error equation" if self.train_curve is None else "whole drive train"
        found = []
        for torque, drive in self.curves:
            at = drive.response.largest()
            if at is not None:
                peak, omega = float(drive.peak[at]), float(drive.omega[at])
                found.append(Largest(peak, omega, of, drive.response.method, torque))
        best = max(found, key=lambda largest: largest.peak, default=None)
        if (ramp := self.run_alone) is not None:
            run = Largest(*ramp.largest(ramp.run.pointing), "run-up of the whole drive train", "integration")
            return run if best is None or self.train_curve is None or run.peak > LESS * best.peak else best
        worst = self.run_up.worst()
        if best is None or (self.train_curve is None and best.peak < worst.peak / LESS):
            return Largest(worst.peak, worst.omega, "error equation", "integration")
        return best

    def largest_oscillation(self) -> Largest:
        """Largest |error - mean| on the curves of the drive, where a slow run-up or run-down goes."""
        of = "error equation" if self.train_curve is None else "whole drive train"
        found = []
        for torque, drive in self.curves:
            visited, sizes = drive.visited(), drive.oscillation
            at = visited[int(np.argmax(sizes[visited]))]
            found.append(Largest(float(sizes[at]), float(drive.omega[at]), of, drive.response.method, torque))
        return max(found, key=lambda largest: largest.peak)
