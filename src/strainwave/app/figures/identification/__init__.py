"""Figures of measurements and of what they tell."""
