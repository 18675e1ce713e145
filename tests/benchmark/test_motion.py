"""The comparison of integrators: failures are told apart, and the error falls with the step."""

import numpy as np

from beamviz.benchmark.motion import FINEST, case_of, integrate, trial


def test_outcomes():
    """The explicit method is unstable above 2.8 over the highest frequency, about 2500 / T* at
    mu = 70; the trapezoidal rule is less accurate than Radau's with four times its step."""
    reference, _ = integrate(case_of(70.0, "radau", FINEST), "radau")
    assert trial("explicit", 70.0, 0.02, reference).outcome == "unstable"
    assert trial("radau", 1000.0, 2.0, reference).outcome == "does not converge"
    coarse, fine = (trial("radau", 70.0, step, reference) for step in (0.08, 0.02))
    low = trial("trapezoidal", 70.0, 0.005, reference)
    assert fine.error < coarse.error
    assert fine.error < low.error
    assert np.isfinite(fine.seconds)
