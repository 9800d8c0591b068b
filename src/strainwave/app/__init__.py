"""Faces of the package: command line, project file, plots and report."""
