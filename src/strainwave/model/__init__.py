"""Physics: laws, excitations, systems, drives and gears. Every object is a NamedTuple of floats with plain methods."""
