"""Logs: measured channels from CSV and binary files."""
