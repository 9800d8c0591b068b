"""Share of the time of `analyze` that is gone when a stage begins."""

import numpy as np

from ...base.terminal import Progress
from ...drive.postures import cases_of
from ...drive.project import Project

PLACES = 0.0, 0.02, 0.2, 0.4, 0.6, 0.8, 0.86, 0.87, 1.0  # of stages, from the response curve to the advice
CURVES = 0.0, 1.0, 1.5, 0.5, 1.0, 5.0, 3.0, 1.0  # time from one to the next, in that of a response curve
OF_TRAIN, OF_LOADS = 5, 6  # what a drive train alone takes, and what each load does


def paced(project: Project, progress: Progress) -> Progress:
    """A report of progress by time, for stages that tell where they are among `PLACES`."""
    curves = np.array(CURVES)
    curves[OF_TRAIN] *= project.train is not None
    curves[OF_LOADS] *= len(cases_of(project))
    shares = np.append(0.0, np.cumsum(curves)) / np.sum(curves)
    return lambda stage, place: progress(stage, float(np.interp(place, PLACES, shares)))
