"""Projects made of a drive, where a test has no file."""

from pathlib import Path

import strainwave as sw
from strainwave import Project
from strainwave.drive.speeds import Speeds


def project_of(drive, speeds, *, gear=None, motor="held", **parts):
    """Project of a drive, with parts of its train, over a range of speeds [rad/s] of its motor."""
    train = drive.train(control=sw.train.Held() if motor == "held" else sw.train.Free(), **parts)
    return Project("drive", Path("drive.yaml"), "", train, gear, Speeds(speeds))
