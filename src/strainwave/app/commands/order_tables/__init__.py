"""Commands for order tables."""
