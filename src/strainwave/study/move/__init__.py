"""A move of a drive: its demands on motor and gear, the pointing error of the load, its settling; run-ups."""
