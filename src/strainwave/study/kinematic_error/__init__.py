"""Budgets and parts of the kinematic error."""
