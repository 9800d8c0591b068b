"""Means of a torque along a motion: of laws that are linear between breakpoints, and of laws with memory."""
