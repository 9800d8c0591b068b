"""Curves of periodic motions: continuation, response, folds."""
