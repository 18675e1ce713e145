"""The planar beam: an equilibrium is a motion in which nothing moves, modes are solutions of its
tangent, and the straight assembly gives the same."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eig
from strategies import beams, blades

from beamviz import Beam, solve
from beamviz.blade import Blade, Mass
from beamviz.mechanics.inertia import Loading
from beamviz.solver.bent.beam import BentBeam
from beamviz.solver.bent.equilibrium import newton, straight_state
from beamviz.solver.problem import Problem

BODY = Mass(0.2, 0.7, (0.05, 0.08, 0.1))
JUMPS = Blade((0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4))
DEFLECTED = {
    "past buckling": Beam(delta=-1, gamma=4, alpha=1, beta=0.5),
    "spin-up": Beam(gamma=5, spin_up=2.0, alpha=0.5, beta=0.6),
    "blade": Beam(gamma=3, spin_up=1.0, blade=JUMPS, masses=(BODY,), root=20.0),
}


@pytest.mark.parametrize("name", DEFLECTED)
@pytest.mark.parametrize("coriolis", [False, True])
def test_an_equilibrium_is_a_motion_in_which_nothing_moves(name, coriolis):
    """Its residual vanishes, and the modes are those of the tangent of the equation of motion."""
    solution = solve(DEFLECTED[name], state="bent", coriolis=coriolis, modes=4)
    state = solution.equilibrium.bent_state.restored()
    none = np.zeros_like(state.q)
    moving = state.beam.moving(state.q, none, none, state.beam.loading)
    forces = state.beam.section.forces(state.f, state.kappa)
    assert abs(moving.residual).max() < 1e-9 * max(abs(force).max() for force in forces)
    (K, C, M), _ = moving.tangents()
    assert pytest.approx(state.stiffness, abs=1e-9 * abs(K).max()) == K
    n = len(K)
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-K, -C * coriolis]])
    s = eig(first_order, np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), M]]))[0]
    for found, error in zip(solution.s, solution.errors, strict=True):
        assert abs(s - found).min() < error + 1e-6 * abs(found)


@given(
    beams(gamma=(0.0, 20.0), mu=(20.0, 200.0)),
    st.none() | blades(),
    st.lists(st.just(BODY), max_size=1),
    st.sampled_from([np.inf, 0.0, 10.0]),
    st.sampled_from(["chordwise", "flapwise"]),
)
@settings(max_examples=15, deadline=None)
def test_both_assemblies_agree_at_a_straight_state(beam, blade, masses, root, plane):
    """The planar tangent has the frequencies of the straight assembly, which is decoupled."""
    beam = beam.replace(blade=blade, masses=tuple(masses), root=root)
    if not (beam.gamma and beam.delta):
        beam = beam.replace(root=np.inf)  # nothing holds a hinged beam
    problem = Problem(plane=plane, modes=3, tolerance=1e-8)
    straight = solve(beam, modes=3, plane=plane, tolerance=1e-9)
    elements = straight.fields.modes.grid.breaks
    assert elements[0] == 0
    state = planar_state(beam, problem)
    K, M = state.stiffness, state.inertia
    omega2 = np.sort(eig(K, M)[0].real)[:3]
    allowed = 2e-5 * (abs(straight.omega_squared) + beam.gamma**2 + 1)
    assert (abs(omega2 - straight.omega_squared) < allowed).all()


def planar_state(beam, problem):
    """The straight state on the elements of a deflected one, refined once."""
    from beamviz.mechanics.planar_mesh import first_elements

    elements = first_elements(beam, problem).halved
    bent = BentBeam(elements, beam, problem)
    guess = straight_state(bent)
    return newton(bent, guess.q)


def test_loads_of_a_frame_that_turns():
    """A unit of mass: Coriolis, Euler and centrifugal force, each by its definition."""
    r, v, a = 0.5 + 0.2j, 0.1 - 0.3j, 0.4 + 0.6j
    p = Loading(gamma=3.0, rate=0.7).inertia(r, v, a)
    axis = np.array([0, 0, 1.0])
    R, V, A = (np.array([z.real, z.imag, 0.0]) for z in (r, v, a))
    spin = np.cross(3 * axis, np.cross(3 * axis, R))
    expected = A + 2 * np.cross(3 * axis, V) + np.cross(0.7 * axis, R) + spin
    assert (p.real, p.imag) == pytest.approx(expected[:2])
    assert Loading(gamma=3.0, in_plane=False).inertia(r) == pytest.approx(-9 * 0.5)
