"""Floquet multipliers and special points of branches."""
