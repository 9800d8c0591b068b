"""Means of a torque along a motion: by samples, exact between breakpoints, and of laws with memory."""
