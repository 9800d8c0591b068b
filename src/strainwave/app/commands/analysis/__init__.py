"""The analysis of one project file or of several."""
