"""Gears of the catalogue: records, fits, limits, error spectra."""
