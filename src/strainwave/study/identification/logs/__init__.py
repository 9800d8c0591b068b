"""Logs: measured channels over one time, and the stretches of their motion."""
