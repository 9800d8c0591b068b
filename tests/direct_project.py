"""Projects made of a drive, where a test has no file."""

from pathlib import Path

from strainwave import Project
from strainwave.base.units import Speeds


def project_of(
    drive, speeds, *, gear=None, motor="held", motor_torque=None, load_torque=None, kinematic_error=None, **more
):  # fmt: skip
    """Project of a drive over a range of speeds [rad/s] of its motor; what else it has goes by the project's fields."""
    torques = motor_torque, load_torque, kinematic_error
    return Project("drive", Path("drive.yaml"), "", drive, gear, motor, Speeds(speeds), *torques, **more)
