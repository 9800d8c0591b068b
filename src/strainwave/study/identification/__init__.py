"""From measurements to laws: parameters with intervals that cover."""
