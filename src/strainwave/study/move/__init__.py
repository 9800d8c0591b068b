"""A move of a drive: what its motion asks of motor and gear, how far the load is off, when it has settled; run-ups."""
