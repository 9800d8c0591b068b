"""The error equation of a drive: the torque in its gear, what it leaves out of the drive, and by how much."""
