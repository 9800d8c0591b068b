"""Moves in files: the group `move` of a project file, and profiles in CSV."""
