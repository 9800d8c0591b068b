"""Scatter from unit to unit."""
