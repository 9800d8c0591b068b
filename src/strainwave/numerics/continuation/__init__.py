"""Arc-length continuation: one branch of periodic motions, from its start to its end."""
