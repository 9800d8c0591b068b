"""Share of the time of `analyze` that is gone when a stage begins."""

from enum import Enum

import numpy as np

from ...base.terminal import Progress
from ...drive.postures import cases_of
from ...drive.project import Project


class Stage(Enum):
    """Stages of an analysis, in their order, with the time of each in that of a response curve: LOADS for each load."""

    POINT = "operating point and stability", 0.0
    CURVE = "response curve", 1.0
    RESONANCES = "resonances by multiple scales", 1.5
    RUN_UP = "run-up and run-down", 0.5
    IN_TIME = "single speeds in time", 1.0
    TRAIN = "whole drive train", 5.0
    LOADS = "motions under every load", 3.0
    ADVICE = "what would help", 1.0

    def __init__(self, text: str, weight: float) -> None:
        self.text, self.weight = text, weight

    def at(self, share: float = 0.0) -> float:
        """Place within all stages after a share of this one: stages that are over, and the share."""
        return list(Stage).index(self) + share


def paced(project: Project, progress: Progress) -> Progress:
    """A report of progress by time, for stages that tell their place by `Stage.at`."""
    times = {stage: stage.weight for stage in Stage}
    times[Stage.TRAIN] *= project.train is not None
    times[Stage.LOADS] *= len(cases_of(project))
    begins = np.append(0.0, np.cumsum(list(times.values())))
    return lambda text, place: progress(text, float(np.interp(place, np.arange(len(begins)), begins / begins[-1])))
