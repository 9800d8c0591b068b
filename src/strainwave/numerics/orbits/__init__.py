"""One periodic motion."""
