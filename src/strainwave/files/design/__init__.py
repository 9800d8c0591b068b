"""Specifications of a design in files, and designs as project files."""
