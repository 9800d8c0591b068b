"""Averages of the torque along a motion: of straight lines, of samples, of settled loops, and of what varies."""
