"""Settings of all tests."""

from hypothesis import settings

# The same examples on every machine: a red test is red for everybody.
settings.register_profile("springopt", derandomize=True, deadline=None, database=None)
settings.load_profile("springopt")
