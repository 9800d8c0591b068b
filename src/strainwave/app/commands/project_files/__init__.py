"""Commands about the project file itself: a new one, its schema; and completion of the command line."""
