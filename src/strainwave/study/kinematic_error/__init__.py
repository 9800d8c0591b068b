"""Scans and budgets of the kinematic error."""
