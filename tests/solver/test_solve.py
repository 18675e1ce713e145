"""solve() and solve_many(): one beam against many, the accepted domain, shapes and nodes."""

import itertools

import numpy as np
import pytest
from helpers import within_the_bars
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import beams

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.solver import solve, solve_many


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@pytest.mark.parametrize("coriolis", [False, True])
def test_every_corner_of_the_accepted_domain_solves(plane, coriolis):
    """With green strain and delta >= 0 every beam has a stable answer within the tolerance."""
    alpha, gamma, mu = (PARAMETERS[name].limits for name in ("alpha", "gamma", "mu"))
    betas = (0.0, 1e-6, 0.5, 1.0)
    for corner in itertools.product(alpha, betas, gamma, (0.0, 20.0), mu):
        beam = Beam(*corner[:2], min(corner[2], MAX_GAMMA_OVER_MU * corner[4]), *corner[3:])
        solution = solve(beam, plane=plane, coriolis=coriolis)
        assert solution.equilibrium.status == "stable", beam
        assert solution.equilibrium.stretch(np.linspace(0, 1, 9)).min() > 0.999, beam
        assert np.all(np.diff(solution.frequencies) >= 0), beam
        rounding = 1e-9 * solution.frequencies[-1]  # gamma^2 may cancel all but this
        assert np.all(solution.errors <= 1e-6 * solution.frequencies + rounding), beam


@settings(max_examples=12)
@given(beam=beams(gamma=(0, 10)), k=st.integers(0, 4), coriolis=st.booleans())
def test_shapes_have_unit_modal_mass(beam, k, coriolis):
    """int rho |phi|^2 = 1, the concentrated mass included, by a quadrature of its own."""
    solution = solve(beam, coriolis=coriolis, tolerance=1e-9)
    points, weights = np.polynomial.legendre.leggauss(60)
    parts = [0.0, beam.beta, 1.0] if 0 < beam.beta < 1 else [0.0, 1.0]
    mass = beam.alpha * (abs(solution.shape(k, beam.beta)) ** 2).sum()
    for a, b in itertools.pairwise(parts):
        x = a + (b - a) * (points + 1) / 2
        mass += (b - a) / 2 * weights @ (abs(solution.shape(k, x)) ** 2).sum(axis=1)
    assert mass == pytest.approx(1, abs=1e-6)


def test_many_at_once_are_the_same_as_one_by_one():
    """solve_many() differs from solve() only within the error bars, and holds errors in place."""
    sweep = [Beam(alpha=1, beta=0.5, gamma=gamma, mu=30) for gamma in np.linspace(0, 60, 8)]
    unloaded = {"stiffening": False, "softening": False}
    for options in ({}, {"strain": "biot"}, {"coriolis": True}, {"method": "ancf"}, unloaded):
        for beam, found in zip(sweep, solve_many(sweep, **options), strict=True):
            if isinstance(found, NoEquilibrium):
                with pytest.raises(NoEquilibrium) as caught:
                    solve(beam, **options)
                assert caught.value.limit == found.limit
                continue
            alone = solve(beam, **options)
            assert found.labels == alone.labels
            assert within_the_bars(found, alone)
    assert solve_many([]) == []


@pytest.mark.slow
def test_an_error_among_answers_keeps_nothing_of_what_was_computed():
    """Neither it nor those that it followed refer to the frames of the solver: a chart keeps a
    hundred answers, and of a deflected blade each frame has megabytes of matrices."""
    sweep = [Beam(1, 0.5, gamma, delta=-1, mu=20) for gamma in (5.0, 30.0)]
    found = solve_many(sweep, strain="biot", state="stable")
    errors = [one for one in found if isinstance(one, BeamvizError)]
    assert errors
    for one in errors:
        while one is not None:
            assert one.__traceback__ is None
            one = one.__context__


def test_beams_with_their_masses_at_different_places_have_their_own_shapes():
    """Each beam of a stack of meshes moves as it does alone."""
    sweep, x = [Beam(alpha=1, beta=beta, gamma=5) for beta in (0.3, 0.5, 0.7)], np.linspace(0, 1, 9)
    for beam, found in zip(sweep, solve_many(sweep, modes=3), strict=True):
        alone = solve(beam, modes=3).displacement(x)
        assert found.displacement(x) == pytest.approx(alone, abs=1e-4)


def test_an_error_that_cannot_be_known_is_infinite():
    """The paper's elements answer just beyond the limit, where no converged solution exists."""
    beyond = solve(Beam(alpha=0, beta=0, gamma=92, delta=-2, mu=264), method="ancf")
    assert np.all(np.isinf(beyond.errors))


@settings(max_examples=8)
@given(beam=beams())
def test_every_bending_mode_has_one_node_more_than_the_last(beam):
    """B1 has none, B2 one, and so on, at any speed and with any mass; stretching alike."""
    solution = solve(beam, modes=12)
    for label, nodes in zip(solution.labels, solution.nodes, strict=True):
        assert len(nodes) == int(label[1:]) - 1


@pytest.mark.parametrize("tolerance", [1e-6, 0.1])
@pytest.mark.parametrize("delta", [0.0, -1.0])
def test_a_mass_beside_the_hub_is_almost_at_the_hub(delta, tolerance):
    """The element between has hardly any mass; all its modes are far above those asked for."""
    options = {"modes": 20, "tolerance": tolerance}
    beside = solve(Beam(alpha=100, beta=1e-9, delta=delta), **options)
    at_hub = solve(Beam(delta=delta), **options)
    assert beside.equilibrium.stable
    difference = abs(beside.frequencies - at_hub.frequencies)
    assert (difference <= beside.errors + at_hub.errors).all()


@pytest.mark.parametrize("distance", [0.999e-13, 1.001e-13, 1.14e-13, 2e-13])
def test_a_mass_at_rounding_distance_from_an_end_is_at_the_end(distance):
    """Whether an element is given to what lies between or not."""
    for beta, end in ((distance, 0.0), (1 - distance, 1.0)):
        beside = solve(Beam(alpha=1, beta=beta, gamma=1))
        at_end = solve(Beam(alpha=1, beta=end, gamma=1))
        difference = abs(beside.frequencies - at_end.frequencies)
        assert (difference <= beside.errors + at_end.errors).all()


def test_coriolis_vanishes_with_the_speed():
    """The coupled answer tends to the uncoupled one as gamma^2."""
    apart = solve(Beam(alpha=1, beta=0.7, gamma=1e-4), tolerance=1e-10)
    coupled = solve(Beam(alpha=1, beta=0.7, gamma=1e-4), tolerance=1e-10, coriolis=True)
    assert coupled.frequencies == pytest.approx(apart.frequencies, rel=1e-8)
    assert coupled.labels == apart.labels


def test_a_mode_seen_out_of_range_is_an_index_error():
    """Modes count from 0; the message says which there are."""
    with pytest.raises(IndexError, match=r"modes 0 \.\. 4"):
        solve(Beam()).shape(5, 0.5)
    with pytest.raises(ValueError, match=r"0 \.\. 1"):
        solve(Beam()).shape(0, 1.5)
