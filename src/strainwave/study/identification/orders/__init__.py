"""Orders from runs over any part of a turn."""
