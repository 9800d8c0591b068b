"""The questions of `strainwave new`: each has an option, a unit, a default and one sentence."""

from typing import NamedTuple

NONE = "none"


class Question(NamedTuple):
    """One number or word of a new project file.

    Attributes
    ----------
    name, prompt, unit : str
        Name of the option and the question, and the unit in which it is answered.
    default : str
        What Enter takes; "" where an answer is needed. Only a terminal asks for one with a default.
    sentence : str
        What it means.
    """

    name: str
    prompt: str
    unit: str
    default: str
    sentence: str

    @property
    def option(self) -> str:
        """The option that gives the answer."""
        return "--" + self.name.replace("_", "-")

    @property
    def help(self) -> str:
        """The sentence with the unit and the default."""
        unit = f" [{self.unit}]" if self.unit else ""
        return self.sentence + unit + (f" Default: {self.default}." if self.default else "")


QUESTIONS = (
    Question("title", "Title", "", NONE, "One line above the report; none takes the name of the file."),
    Question("gear", "Gear", "", "", "Name of a gear of the catalogue; a part of a name lists those that hold it."),
    Question("load_inertia", "Inertia of the load", "kg*m^2", "", "On the output side, without the gear."),
    Question(
        "motor_inertia", "Inertia of the motor", "kg*cm^2", "catalogue",
        "Motor and wave generator, on the motor side; catalogue takes that of the wave generator alone.",
    ),
    Question(
        "loop", "Loop of the motor", "Hz", NONE,
        "Bandwidth of the position loop that holds the motor; none is a motor that keeps its speed ideally.",
    ),
    Question("gravity", "Gravity", "N*m", NONE, "Torque of the load's weight on a level arm, on the output side."),
    Question(
        "kinematic_error", "Kinematic error", "arcsec", "catalogue",
        "Amplitude of order 2 of the motor, 0-to-peak; catalogue shares the gear's accuracy by the usual orders.",
    ),
    Question("damping", "Damping ratio", "%", "3 %", "Share of the critical damping; 1 to 5 % are usual."),
    Question(
        "budget", "Budget of the oscillation", "arcsec", NONE,
        "Largest distance of the pointing error from its mean; none takes the bands of the peaks.",
    ),
    Question("speed_from", "Lowest speed", "rpm", "500 rpm", "Of the motor."),
    Question("speed_to", "Highest speed", "rpm", "3000 rpm", "Of the motor."),
)  # fmt: skip
