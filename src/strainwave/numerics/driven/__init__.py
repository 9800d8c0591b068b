"""Systems driven by measured signals, run freely in lanes."""
