"""The drive with each usual motor, and in each posture of its machine, side by side."""

from ....base.sentences import Angle, Sentence, Speed, listed
from ....study.analysis.train_study import spread
from ....study.analysis.words import postures_data
from ...console import number
from ...view import View, sizes
from ..section import Part, Table

MOTOR_RATIO = 1.1  # ratio of the largest oscillations from which on the choice of the motor decides
LITTLE = "the choice of the motor has little effect"


def motor_in_words(name: str) -> str:
    """The motor of a `motor_name`: ideally held, free, in a loop, or with a control of the user's own."""
    ideal = {"held": "a motor that is ideally held", "free": "a free motor"}
    return ideal.get(name, f"a motor in a {name}" if "loop" in name else f"a motor with the control {name}")


def motors(view: View) -> Part:
    """The drive with a motor ideally held, free, and in a position loop, side by side, and the field to write.

    Largest oscillation, its speed and the jumps with each motor; empty where the file names its motor.
    """
    rows = [
        {
            "motor": case.name,
            **sizes(None if case.drive is None else case.oscillation, "oscillation"),
            **view.speed_data(case.omega),
            "jumps": case.jumps,
            "remark": "no steady curve" if case.drive is None else "",
        }
        for case in view.analysis.motors
    ]
    ratio, texts = spread(view.analysis.motors) if rows else None, list[str]()
    if cases := [case for case in view.analysis.motors if case.drive is not None]:
        motions = [Sentence("{} at {} with ", Angle(case.oscillation), Speed(case.omega, digits=4)) for case in cases]
        oscillations = listed(one + motor_in_words(case.name) for one, case in zip(motions, cases, strict=True))
        decides = f"the largest is {number(ratio, 2)} times the smallest" if ratio and ratio > MOTOR_RATIO else LITTLE
        texts = [
            "The project file names no motor: the report assumes an ideally held one. The oscillation is "
            + oscillations
            + f"; {decides}. Write the loop of the drive, for example 'loop: {{bandwidth: 30 Hz, damping: 0.7}}'."
        ]
    return Part("What the motor changes", {"motors": rows, "motor_ratio": ratio}, texts, [Table(rows)], lines=texts)


def postures(view: View) -> Part:
    """The drive in every posture of the file, whose numbers are in `verdict.postures`."""
    return Part("Postures", tables=[Table(postures_data(view.analysis))])
