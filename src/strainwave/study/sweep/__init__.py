"""Parameter sweeps with a store."""
