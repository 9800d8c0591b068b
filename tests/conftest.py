"""Settings shared by all tests."""

from hypothesis import settings

# The same examples on every run, and no deadline: the first call of a compiled kernel takes seconds.
settings.register_profile("strainwave", derandomize=True, deadline=None)
settings.load_profile("strainwave")
