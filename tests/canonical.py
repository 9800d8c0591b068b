"""One instance of every model class, for the contract tests; import fails when a class is missing.

Two laws are defined here, as a user would define them: a smooth one and one with a kink.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import NamedTuple

import strainwave as sw
import strainwave.model
from strainwave.base.quantities import Angle, TorsionalStiffness
from strainwave.compile.tree import is_model
from strainwave.maths import exp, sign, sqrt
from strainwave.model.oscillator import Powers
from strainwave.model.train.commanded import Commanded, TorqueDriven
from strainwave.model.train.filters import around
from strainwave.model.train.train_forms import AtLoad, Metered


class Saturating(NamedTuple):
    """A user's law: T = K x/sqrt(1 + (x/s)^2), which grows no further than K s. Odd."""

    K: TorsionalStiffness
    s: Angle

    def torque(self, x):
        return self.K * x / sqrt(1.0 + (x / self.s) * (x / self.s))

    def stiffness(self, x):
        w = 1.0 + (x / self.s) * (x / self.s)
        return self.K / (w * sqrt(w))

    def energy(self, x):
        return self.K * self.s * self.s * (sqrt(1.0 + (x / self.s) * (x / self.s)) - 1.0)


class Stop(NamedTuple):
    """A user's law: a spring that stiffens as T = K s (exp(x/s) - 1) and meets an end stop at x_stop."""

    K: TorsionalStiffness
    s: Angle
    K_stop: TorsionalStiffness
    x_stop: Angle

    def torque(self, x):
        beyond = x - self.x_stop
        return self.K * self.s * (exp(x / self.s) - 1.0) + 0.5 * self.K_stop * (beyond + abs(beyond))

    def stiffness(self, x):
        return self.K * exp(x / self.s) + 0.5 * self.K_stop * (1.0 + sign(x - self.x_stop))

    def energy(self, x):
        beyond = 0.5 * ((x - self.x_stop) + abs(x - self.x_stop))
        spring = self.K * self.s * self.s * (exp(x / self.s) - 1.0 - x / self.s)
        return spring + 0.5 * self.K_stop * beyond * beyond

    def breakpoints(self):
        return (self.x_stop,)


# (K1, K2, K3) and (T1, T2) of a CSF-40-50: Harmonic Drive LLC, CSF/CSG catalogue, p. 50.
CSF_40_50 = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)

LAWS = {
    "Linear": sw.Linear(7160.0),
    "Cubic": sw.Cubic(1.0, 0.1),
    "Cubic, softening": sw.Cubic(2.0, -0.1),
    "Polynomial": sw.Polynomial((0.3, 1.0, -0.2, 0.5)),
    "Polynomial, odd": sw.Polynomial((0.0, 1.0, 0.0, 0.1)),
    "PiecewiseLinear": CSF_40_50,
    "Backlash": sw.Backlash(1.0, 0.5),
    "Play": sw.Play(1e-4, CSF_40_50),
    "Play, Cubic": sw.Play(0.4, sw.Cubic(1.0, 0.1)),
    "RoundedPiecewiseLinear": sw.laws.RoundedPiecewiseLinear(1.0, 1.4, 1.8, 0.54, 1.21, 0.2),
    "Tabulated": sw.tabulated([(-1.1, -2.0), (-0.4, -0.5), (0.0, 0.0), (0.45, 0.4), (0.9, 1.3), (1.4, 3.0)]),
    "Saturating": Saturating(2.0, 0.7),
    "Stop": Stop(2.0, 0.9, 30.0, 0.4),
    "AngleTorque": sw.train.AngleTorque(0.3, order=2),
    "AngleTorque, off centre": sw.train.AngleTorque(0.3, phase=0.4),
}
ODD = {name for name in LAWS if name not in ("Polynomial", "Stop", "Tabulated", "AngleTorque, off centre")}
SMOOTH = {name for name in LAWS if name not in ("PiecewiseLinear", "Backlash", "Play", "Play, Cubic", "Stop")}

# Laws of friction and memory, of the scale J = K = 1.
DISSIPATIVE = {
    "Viscous": sw.laws.Viscous(0.05, warming=20.0, load=3.0, per_torque=0.02),
    "Coulomb": sw.laws.Coulomb(0.02, 0.05),
    "ContactDamping": sw.laws.ContactDamping(0.2, 0.1, 0.05),
    "QuadraticDamping": sw.laws.QuadraticDamping(0.3),
    "Stribeck": sw.laws.Stribeck(0.02, 0.03, 0.3, 0.05),
    "LuGre": sw.laws.LuGre(3.0, 0.1, 0.1, 0.03, 0.05, 0.3),
    "BoucWen": sw.BoucWen(1.0, 0.3, 0.4, 1.0, 0.6, 0.4, 1),
    "BoucWen, n = 3, gamma < 0": sw.BoucWen(2.0, 0.0, 0.4, 1.2, 0.7, -0.5, 3),
    "Parallel, springs": sw.Parallel(LAWS["Cubic"], LAWS["Backlash"]),
    "Parallel, nested": sw.Parallel(
        sw.BoucWen(0.5, 0.0, 0.2),
        sw.Parallel(
            sw.laws.Coulomb(0.02, 0.05), sw.Parallel(LAWS["Cubic"], sw.laws.LuGre(3.0, 0.1, 0.1, 0.03, 0.05, 0.3))
        ),
    ),
}

EXCITATIONS = {
    "Harmonic": sw.Harmonic(0.18, order=2, phase=0.3, mean=0.1),
    "Harmonics": sw.Harmonics((sw.Harmonic(0.18), sw.Harmonic(0.05, order=3, phase=-1.0, mean=0.2))),
}

ERRORS = {
    "KinematicError": sw.KinematicError((sw.Line(2, 0.1), sw.Line(4, 0.02, 0.7))),
    "KinematicError, two turns": sw.KinematicError((sw.Line(2.0, 0.1), sw.Line(2.0 - 2.0 / 51.0, 0.02, 0.7))),
    "NoError": sw.NoError(),
}

VARIATIONS = {
    "Variation": sw.gears.Variation((sw.gears.Ripple(1, 0.2, 0.4), sw.gears.Ripple(2, -0.1))),
    "NoVariation": sw.gears.NoVariation(),
}

SYSTEMS = {
    "Duffing": sw.Oscillator(1.0, 0.05, LAWS["Cubic"], sw.Harmonic(0.18), 1.0),
    "everything": sw.Oscillator(0.7, 0.1, LAWS["Saturating"], EXCITATIONS["Harmonics"], 1.3, ERRORS["KinematicError"]),
    "backlash": sw.Oscillator(1.0, 0.1, LAWS["Backlash"], sw.Harmonic(0.6), 0.8),
    "varying": sw.gears.VaryingOscillator(
        0.7,
        sw.gears.GearDamping(0.1, sw.gears.Variation((sw.gears.Ripple(3, 0.3, 0.2),)), 5.0, fast=0.4, v_fast=0.3),
        LAWS["Cubic"],
        sw.Harmonic(0.3, mean=0.1),
        1.3,
        ERRORS["KinematicError"],
        VARIATIONS["Variation"],
    ),
    "varying, plain": sw.gears.VaryingOscillator(
        1.0, sw.gears.GearDamping(0.1), LAWS["Backlash"], sw.Harmonic(0.3), 1.1
    ),
}

DISSIPATIVE_SYSTEMS = {
    name: sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.3), 1.1, ERRORS["KinematicError"])
    for name, law in DISSIPATIVE.items()
}

DRIVES = {"HDC_40_050": sw.HDC_40_050}

REFERENCES = {
    "Steady": sw.train.Steady(),
    "AtRest": sw.train.AtRest(),
    "SpeedProfile": sw.train.SpeedProfile((-2.0, 1.0, 3.0), (0.5, 2.0, -1.0)),
    "Segment": sw.train.Segment(-1.0, 0.3, 0.5, -0.4, 0.2),
}

PROFILES = {"TorqueProfile": sw.train.TorqueProfile((-2.0, 1.0, 3.0), (0.5, 2.0, -1.0))}

# Drive trains of the scale J = K = 1, ratio 3: every control, law, drag and load.
PLAIN_TRAIN = sw.DriveTrain(sw.train.Motor(0.2, sw.Harmonic(0.3)), 3.0, 0.05, LAWS["Cubic"], sw.train.Load(1.5))
TRAINS = {
    "free": PLAIN_TRAIN,
    "held": sw.DriveTrain(
        sw.train.Motor(0.2, control=sw.train.Held()),
        3.0,
        0.05,
        LAWS["PiecewiseLinear"],
        sw.train.Load(1.5, PROFILES["TorqueProfile"], LAWS["AngleTorque"]),
        1.0,
        sw.NoError(),
        REFERENCES["SpeedProfile"],
    ),
    "position loop": PLAIN_TRAIN._replace(
        motor=sw.train.Motor(
            0.2, EXCITATIONS["Harmonics"], sw.laws.Stribeck(0.02, 0.03, 0.3), sw.train.PositionLoop(2.0, 0.3)
        ),
        reference=REFERENCES["SpeedProfile"],
    ),
    "commanded": PLAIN_TRAIN._replace(motor=sw.train.Motor(0.2, control=Commanded())),
    "torque-driven": PLAIN_TRAIN._replace(motor=sw.train.Motor(0.2, control=TorqueDriven())),
    "loop with a lag": PLAIN_TRAIN._replace(
        motor=sw.train.Motor(0.2, control=sw.train.Lagged(sw.train.SpeedLoop(0.3, 0.2, 0.05), 0.1)),
        reference=REFERENCES["SpeedProfile"],
    ),
    "cascade": PLAIN_TRAIN._replace(
        motor=sw.train.Motor(
            0.2, control=around(sw.train.CascadeLoop(0.5, 0.3, 2.0), 0.1, (sw.train.NotchFilter(9.0, 3.0),), 5.0)
        )
    ),
    "encoder of the load": PLAIN_TRAIN._replace(
        motor=sw.train.Motor(0.2, control=around(sw.train.CascadeLoop(0.1, 0.3, 2.0), encoder="load"))
    ),
    "both encoders": PLAIN_TRAIN._replace(
        motor=sw.train.Motor(
            0.2, control=around(sw.train.CascadeLoop(0.1, 0.3, 2.0), encoder="both", mixing_frequency=0.4)
        )
    ),
    "everything": sw.DriveTrain(
        sw.train.Motor(0.2, EXCITATIONS["Harmonics"], DISSIPATIVE["LuGre"], sw.train.SpeedLoop(0.3, 0.2, 0.05)),
        3.0,
        0.05,
        DISSIPATIVE["Parallel, nested"],
        sw.train.Elastic(
            0.1,
            0.02,
            LAWS["Saturating"],
            sw.train.Elastic(
                0.2, 0.01, DISSIPATIVE["BoucWen"], sw.train.Load(1.0, EXCITATIONS["Harmonic"], DISSIPATIVE["LuGre"])
            ),
        ),
        1.3,
        ERRORS["KinematicError"],
        REFERENCES["SpeedProfile"],
        sw.laws.LoadFriction(0.1, 0.2),
    ),
}
BALANCED = [name for name in TRAINS if name != "torque-driven"]  # of that one the motor's own motion is left out

TRAIN_FORMS = {
    "SteadyTrain": sw.train.SteadyTrain(PLAIN_TRAIN._replace(error=ERRORS["KinematicError"]), 1.3, bandwidth=0.1),
    "SteadyTrain, in time": sw.train.SteadyTrain(PLAIN_TRAIN._replace(reference=sw.train.AtRest()), 1.3, 0),
    "Metered": Metered(TRAINS["everything"]),
    "AtLoad": AtLoad(TRAINS["everything"], 1.3),
    "AtLoad, rigid": AtLoad(TRAINS["held"], 1.0),
    "Powers": Powers(SYSTEMS["everything"]),
}

MODELS = (
    LAWS
    | DISSIPATIVE
    | EXCITATIONS
    | ERRORS
    | VARIATIONS
    | SYSTEMS
    | DRIVES
    | REFERENCES
    | PROFILES
    | TRAINS
    | TRAIN_FORMS
)


def classes_of(model) -> set[type]:
    """The class of a model and of all models inside it."""
    inner = {cls for item in model if isinstance(item, tuple) for cls in classes_of(item)}
    return inner | ({type(model)} if is_model(model) else set())


def fast_forms() -> set[type]:
    """Classes of the forms that run many steps, also of a torque that has none of its own."""
    driven = SYSTEMS["Duffing"]._replace(excitation=PROFILES["TorqueProfile"])
    systems = [system for system in (*SYSTEMS.values(), driven) if hasattr(system, "prepared")]
    return {cls for system in systems for cls in classes_of(system.prepared())}


def model_classes() -> set[type]:
    """Every NamedTuple class that a module of strainwave.model defines and that takes part in an equation of motion.

    The forms that run many steps are left out: they are held equal to the models they are made from.
    """
    names = [f"strainwave.model.{module.name}" for module in iter_modules(strainwave.model.__path__)]
    things = [thing for name in names for thing in vars(import_module(name)).values() if isinstance(thing, type)]
    physics = ("torque", "value", "rhs")
    found = {cls for cls in things if hasattr(cls, "_fields") and any(hasattr(cls, method) for method in physics)}
    return found - fast_forms()


missing = model_classes() - {cls for model in MODELS.values() for cls in classes_of(model)}
if missing:
    raise AssertionError(f"tests/canonical.py has no instance of {', '.join(sorted(cls.__name__ for cls in missing))}")
