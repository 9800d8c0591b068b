"""Computing with any system that has `rhs(phase, y)` and `omega`; no model is imported here."""
