"""The analysis of a project, from the drive to the advice."""
