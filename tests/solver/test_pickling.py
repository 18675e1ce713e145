"""Solutions of every method, and errors, are pickled for process pools, caches and notebooks."""

import pickle

import numpy as np
import pytest

from beamviz import Beam, solve, solve_many
from beamviz.solver.problem import CORIOLIS, METHODS

X = np.linspace(0, 1, 11)
BEAM = Beam(alpha=0.5, beta=0.4, gamma=3)
CASES = [
    (method, coriolis)
    for method, row in METHODS.items()
    for coriolis in (False, True)
    if not (coriolis and CORIOLIS in row.unsupported)
]


@pytest.mark.parametrize(("method", "coriolis"), CASES)
def test_a_solution_pickles(method, coriolis):
    """Before anything lazy is computed and after, with shapes, errors and equilibrium the same."""
    solution = solve(BEAM, method=method, coriolis=coriolis)
    for _ in range(2):
        copy = pickle.loads(pickle.dumps(solution))
        assert (copy.beam, copy.problem, copy.stats) == (BEAM, solution.problem, solution.stats)
        assert copy.labels == solution.labels
        for original, copied in [
            (solution.frequencies, copy.frequencies),
            (solution.errors, copy.errors),
            (solution.displacement(X), copy.displacement(X)),
            (solution.equilibrium.position(X), copy.equilibrium.position(X)),
            (solution.equilibrium.stretch(X), copy.equilibrium.stretch(X)),
        ]:
            assert np.array_equal(original, copied)


def test_an_error_in_place_of_a_solution_pickles():
    """With its limit, as `solve_many` returns it."""
    (error,) = solve_many([Beam(gamma=60)], strain="hencky")
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), str(copy), copy.limit) == (type(error), str(error), error.limit)
