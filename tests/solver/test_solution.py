"""Solutions: nodes, signs of shapes, read-only arrays, text, pickling."""

import pickle

import numpy as np
import pytest

from beamviz import Beam, solve, solve_many
from beamviz.solver import METHODS

CASES = [(method, False) for method in METHODS]
CASES += [(method, True) for method, row in METHODS.items() if "coriolis" not in row.unsupported]


@pytest.mark.parametrize("gamma", [2.9, 5.0])
def test_nodes_do_not_depend_on_the_phase_of_a_mode(gamma):
    """Before and after an inward beam buckles, weak Coriolis forces move its nodes by little."""
    beam = Beam(delta=-1, gamma=gamma)
    without, with_coriolis = solve(beam), solve(beam, coriolis=True)
    assert with_coriolis.labels == without.labels
    for expected, found in zip(without.nodes, with_coriolis.nodes, strict=True):
        assert found == pytest.approx(expected, abs=2e-3)
    assert without.nodes[1] == pytest.approx([0.779], abs=4e-3)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("method", ["auto", "ancf", "assumed-modes"])
def test_the_larger_component_is_real_and_positive_at_the_tip(method, coriolis):
    """For every mode and method, so that the sign of a shape is no accident of LAPACK, and the same
    along a sweep."""
    solution = solve(Beam(alpha=1, beta=0.5, gamma=3), method=method, coriolis=coriolis)
    for k, share in enumerate(solution.bending_energy_fraction):
        tip = solution.shape(k, 1.0)[0, int(share >= 0.5)]
        assert tip.real > 0
        assert abs(tip.imag) < 1e-9 * tip.real


def test_text_of_a_solution_is_one_line():
    """Its beam, method, status and frequencies; unstable modes as nan."""
    text = repr(solve(Beam(alpha=1, beta=0.5, gamma=10), modes=8))
    assert text.count("\n") == 0
    assert len(text) < 250
    assert "alpha=1" in text
    assert "4.3906" in text
    assert "unstable" in repr(solve(Beam(delta=-1, gamma=5)))


@pytest.mark.parametrize("method", METHODS)
def test_arrays_of_a_solution_are_read_only(method):
    """They are computed once and may be shared."""
    solution = solve(Beam(alpha=1, beta=0.5, gamma=2), method=method)
    names = "omega_squared omega_squared_errors frequencies errors growth_rates"
    results = [getattr(solution, name) for name in (*names.split(), "bending_energy_fraction")]
    for array in (*results, solution.nodes[1], solution.equilibrium.tip):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize(("method", "coriolis"), CASES)
def test_a_solution_pickles(method, coriolis):
    """Before anything lazy is computed and after, with shapes, errors and equilibrium the same."""

    def arrays(solution):
        state, x = solution.equilibrium, np.linspace(0, 1, 11)
        functions = (solution.displacement(x), state.position(x), state.stretch(x))
        return solution.frequencies, solution.errors, *functions

    solution = solve(Beam(alpha=0.5, beta=0.4, gamma=3), method=method, coriolis=coriolis)
    for _ in range(2):
        copy = pickle.loads(pickle.dumps(solution))
        for name in ("beam", "problem", "stats", "labels"):
            assert getattr(copy, name) == getattr(solution, name)
        assert all(map(np.array_equal, arrays(solution), arrays(copy)))


def test_an_error_in_place_of_a_solution_pickles():
    """With its limit, as `solve_many` returns it."""
    (error,) = solve_many([Beam(gamma=60)], strain="hencky")
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), str(copy), copy.limit) == (type(error), str(error), error.limit)
