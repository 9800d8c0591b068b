"""Many trajectories at once, in lanes."""
