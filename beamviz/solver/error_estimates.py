"""Errors of the methods that have no estimate of their own: how far they are from the default
method, which converges to the same model."""

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver.hp.refinement import solve_straight
from beamviz.solver.physics import Physics

REFERENCE_TOLERANCE = 1e-9


def differences(
    beam: Beam, physics: Physics, squares: np.ndarray, fractions: np.ndarray
) -> np.ndarray:
    """Distances (modes,) of omega^2 from the default method's, with the error of those.

    Modes are paired within their family: a coarse basis may shift one past another. Infinite
    where the default method has no answer to compare with.
    """
    modes = len(squares)
    try:
        exact = solve_straight(beam, 2 * modes, physics, REFERENCE_TOLERANCE)
    except (NoEquilibrium, NotConverged):
        return np.full(modes, np.inf)
    exact_errors = exact.truncation + exact.rounding
    errors = np.empty(modes)
    for bending in (True, False):
        ours = np.flatnonzero((fractions >= 0.5) == bending)
        theirs = np.flatnonzero((exact.bending_fractions >= 0.5) == bending)[: len(ours)]
        if len(theirs) < len(ours):  # so far off that its partner is out of sight
            theirs = np.append(theirs, [2 * modes - 1] * (len(ours) - len(theirs)))
        errors[ours] = abs(squares[ours] - exact.squares[theirs]) + exact_errors[theirs]
    return errors
