"""Cancelling the error: controllers designed on a drive, and what each leaves of it."""
