"""Settings of every test, made before numpy is imported."""

import os

import hypothesis

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # timings compare one thread with one thread

hypothesis.settings.register_profile("beamviz", deadline=None, derandomize=True)
hypothesis.settings.load_profile("beamviz")
