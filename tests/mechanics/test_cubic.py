"""The paper's cubic elements: their full planar tangent is the split assembly of method ancf at a
straight state, and their deflected states and modes converge to those of the default method."""

import numpy as np
import pytest
from helpers import slow
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag, eig
from scipy.sparse import block_array, csc_array, eye_array
from scipy.sparse.linalg import eigs
from strategies import beams, blades

from beamviz import Beam, solve
from beamviz.blade import Blade, Mass
from beamviz.dynamics import start
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.cubic import CubicBeam
from beamviz.mechanics.cubic_elements import CubicElements, assemble_band, dense, nodes_of
from beamviz.solver import fem
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.problem import Problem

INWARD, SPINS_UP = Beam(delta=-1, gamma=4), Beam(gamma=5, spin_up=10)
SOFT = INWARD.replace(mu=20)
X = np.linspace(0.1, 1, 10)
POINT = Mass(0.2, 0.7)
TAPER = Blade((0, 0.4, 1), (1, 0.8, 0.2), (1, 0.7, 0.1), (1, 0.9, 0.4), (2, 1.8, 1))
MODELS = st.builds(
    Problem,
    strain=st.sampled_from(sorted(STRAIN_LAWS)),
    curvature=st.sampled_from(sorted(CURVATURES)),
    plane=st.sampled_from(["chordwise", "flapwise"]),
    method=st.just("ancf"),
    elements=st.integers(3, 12),
    modes=st.just(3),
    coriolis=st.booleans(),
)
BEAMS = beams(alpha=(0, 3), beta=(0.05, 1), gamma=(0.1, 30), delta=(-0.5, 2), mu=(100, 100))


def exponents(state, count, coriolis):
    """s (count,) of the lowest modes with Im s > 0, of M q" + C q' + K q = 0."""
    (K, C, M), _ = state.tangents()
    K, C, M, one = *map(csc_array, (K, coriolis * C, M)), eye_array(len(K))
    zero = csc_array(K.shape)
    first_order = block_array([[zero, one], [-K, -C]], format="csc")
    rates = block_array([[one, zero], [zero, M]], format="csc")
    v0 = np.ones(2 * K.shape[0])
    s = eigs(first_order, 2 * count + 2, rates, sigma=0.0, v0=v0, return_eigenvectors=False)
    s = s[s.imag > 0]
    return s[np.argsort(s.imag)][:count]


@given(BEAMS, MODELS, st.none() | blades(), st.lists(st.just(POINT), max_size=1))
@settings(max_examples=15)
def test_the_planar_tangent_at_a_straight_state_is_the_split_assembly(beam, problem, blade, masses):
    """Along and across the beam, with nothing between them; so are its modes."""
    beam = beam.replace(blade=blade, masses=tuple(masses))
    model = CubicElements(nodes_of(beam, problem.elements), beam, problem.theory)
    try:
        position, _, Ka, Kb = fem.ASSEMBLERS["ancf"](model)
    except (NoEquilibrium, NotConverged):
        assume(False)
    cubic = CubicBeam(model.nodes, beam, problem.theory)
    q = np.zeros((len(model.nodes), 4))
    q[:, ::2] = position.reshape(-1, 2)
    state = cubic.state(q.ravel()[cubic.free])
    order = np.argsort(cubic.free % 2, kind="stable")  # even coordinates are along the beam
    K, M = (matrix[np.ix_(order, order)] for matrix in (state.stiffness, state.inertia))
    m = dense(assemble_band(model.m))
    Ma, Mb = m[1:, 1:], m[2:, 2:]
    split = block_diag(Ka - beam.gamma**2 * Ma, Kb - problem.chordwise * beam.gamma**2 * Mb)
    size = np.sqrt(abs(np.diag(block_diag(Ka, Kb)))) + beam.gamma * np.sqrt(np.diag(M))
    assert (abs(K - split) <= 1e-11 * np.outer(size, size)).all()
    assert pytest.approx(block_diag(Ma, Mb), abs=1e-13 * np.diag(M).max()) == M
    assert abs(state.residual).max() <= 1e-8 * beam.mu**2
    solution = solve(beam, **problem.options)
    n, none = len(K), np.zeros_like(K)
    (K, C, M), _ = state.tangents()
    first_order = np.block([[none, np.eye(n)], [-K, -problem.gyroscopic * C]])
    squares = eig(first_order, block_diag(np.eye(n), M), right=False) ** 2
    scale = abs(solution.s**2) + beam.gamma**2
    for s, allowed in zip(solution.s, 1e-6 * scale, strict=True):
        assert abs(squares - s**2).min() <= allowed


@pytest.mark.parametrize(
    ("beam", "order", "elements", "model", "coriolis"),
    [
        (INWARD.replace(alpha=1), 4, 28, {}, False),
        (SPINS_UP.replace(blade=TAPER), 4, 20, {}, True),
        (SOFT, 4, 28, {"strain": "biot", "curvature": "material"}, True),
        *slow(
            (SOFT, 4, 40, {"strain": "hencky"}, False),
            (SOFT, 4, 40, {"strain": "biot", "curvature": "material", "plane": "flapwise"}, False),
            (SOFT.replace(alpha=1, beta=0.5), 1, 60, {}, False),
        ),
    ],
)
def test_deflected_states_converge_to_those_of_the_default_method(
    beam, order, elements, model, coriolis
):
    """Positions, frequencies and growth rates, at the rate of cubic elements: of fourth order in
    their length, of first where the stretch jumps inside the beam, which share a gradient there."""
    model = model | {"modes": 4, "coriolis": coriolis}
    converged = solve(beam, tolerance=1e-10, state="bent", **model)
    problem, distances = Problem(**model), []
    for count in (elements, 2 * elements):
        cubic = CubicBeam(nodes_of(beam, count), beam, problem.theory)
        state = equilibrium(cubic, converged.equilibrium)
        s = exponents(state, 4, problem.gyroscopic)
        distance = abs(s.imag - converged.frequencies) / converged.frequencies
        assert s.real == pytest.approx(converged.growth_rates, abs=1e-4)
        away = state.positions(X) - converged.equilibrium.position(X) @ [1, 1j]
        distances.append(np.append(distance, abs(away).max()))
    rates = np.log2(distances[0] / distances[1])
    assert (rates > order - 0.3).all()
    assert np.median(rates) < order + 0.7
    assert distances[1].max() < (1e-5 if order == 4 else 2e-4)


def test_few_elements_of_a_folded_beam():
    """They are too long for the layer at the clamp, and yet the state that a motion starts from is
    the one next to the converged one, not that of a beam that is clamped pointing inward."""
    beam = Beam(delta=-0.333, gamma=57)
    converged = solve(beam, state="bent")
    cubic = CubicBeam(nodes_of(beam, 20), beam, Problem().theory)
    (tip,) = cubic.state(start.equilibrium(cubic, converged)).positions(np.ones(1))
    assert [tip.real, tip.imag] == pytest.approx(converged.equilibrium.tip, abs=0.025)


def equilibrium(cubic, converged):
    """The state of the elements next to a converged one, by Newton's method."""
    _, f, theta = converged.curve(cubic.points)
    q = cubic.nearest(f, theta)
    for _ in range(12):
        state = cubic.state(q)
        step = -np.linalg.solve(state.stiffness, state.residual)
        q = q + step
    assert abs(step).max() < 1e-9
    return cubic.state(q)
