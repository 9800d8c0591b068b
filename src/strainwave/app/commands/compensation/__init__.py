"""`strainwave compensate` and what it prints."""
