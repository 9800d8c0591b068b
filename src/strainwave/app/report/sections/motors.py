"""Effect of the choice of the motor, where the project file names none."""

from typing import Any

from ....base.sentences import Angle, Sentence, Speed, listed
from ....study.analysis.train_study import spread
from ...console import number
from ...view import View, sizes
from .whole_train import motor_in_words

MATTERS = 1.1  # ratio of the largest oscillations from which on the choice decides


class Motors:
    """The drive with a motor ideally held, free, and in a position loop, side by side."""

    heading = "What the motor changes"

    def data(self, view: View) -> dict[str, Any]:
        """Largest oscillation, its speed and the jumps with each motor; empty where the file names its motor."""
        rows = [
            {
                "motor": case.name,
                **sizes(None if case.drive is None else case.oscillation, "oscillation"),
                **view.place(case.omega),
                "jumps": case.jumps,
                "remark": "no steady curve" if case.drive is None else "",
            }
            for case in view.analysis.motors
        ]
        return {"motors": rows, "motor_ratio": spread(view.analysis.motors) if rows else None}

    def sentences(self, view: View) -> list[Any]:
        """Effect of the choice of the motor, and the field to write into the file."""
        cases = [case for case in view.analysis.motors if case.drive is not None]
        if not cases:
            return []
        ratio = spread(view.analysis.motors)
        oscillations = listed(
            Sentence(
                f"{{}} at {{}} with {motor_in_words(case.name)}", Angle(case.oscillation), Speed(case.omega, digits=4)
            )
            for case in cases
        )
        decides = f"the choice changes it {number(ratio, 2)} times" if ratio > MATTERS else "the choice changes little"
        return [
            "The file names no motor: this report is about one that is ideally held. The error oscillates with "
            + oscillations
            + f"; {decides}. Write the loop of the drive, for example 'loop: {{bandwidth: 30 Hz, damping: 0.7}}'."
        ]
