"""Settings for every test."""

from hypothesis import settings

# Wall time says little on a shared machine; examples are drawn alike in every run.
settings.register_profile("project", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("project")
