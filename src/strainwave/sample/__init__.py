"""Many drives once: how they vary, one store, and what is made of the results."""
