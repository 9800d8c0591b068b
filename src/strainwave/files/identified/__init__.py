"""Numbers of a project file, found from the log of a drive."""
