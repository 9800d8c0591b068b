"""Demands on a drive beside its speeds, and those of its motions on gear and motor."""
