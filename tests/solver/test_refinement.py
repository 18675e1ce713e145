"""Refinement of the default method: the tolerance is met with few unknowns, and errors hold.

Those of random beams at any tolerance are tested against the oracle (test_error_bars.py).
"""

import numpy as np
import pytest
from beamviz.solver.hp.mesh_design import MAX_ORDER
from helpers import within_the_bars

from beamviz import Beam, solve
from beamviz.errors import NoEquilibrium
from beamviz.solver import solve_many
from beamviz.solver.hp.refinement import Refinement

EXACT = 1e-11
BIOT = {"strain": "biot", "curvature": "material", "tolerance": 1e-6}
HENCKY = {"strain": "hencky", "plane": "flapwise", "tolerance": 3.5e-8}


@pytest.mark.parametrize("beam", [Beam(), Beam(0, 1, 20), Beam(1, 0.5, 10), Beam(1, 0.3, 30, 0.2)])
def test_the_default_converges_exponentially(beam):
    """Nine digits more take at most 2.7 times the unknowns: order 4 in h would take 170 times."""
    finest = solve(beam, tolerance=1e-12)
    rough, fine = (solve(beam, tolerance=tolerance) for tolerance in (1e-2, 1e-11))
    assert fine.stats.dof <= 2.7 * rough.stats.dof
    assert fine.frequencies == pytest.approx(finest.frequencies, rel=1e-10)
    assert within_the_bars(rough, finest)


def test_modes_along_the_beam_need_fewer_unknowns():
    """Than those across it, which are shorter; with Coriolis forces, which couple both, a few
    more."""
    few, all_coupled = (solve(Beam(gamma=5), coriolis=c).stats for c in (False, True))
    assert few.order == all_coupled.order
    assert few.dof < 0.9 * all_coupled.dof < 0.9 * 2 * all_coupled.order


@pytest.mark.parametrize("coriolis", [False, True])
def test_a_wide_boundary_layer_takes_no_second_mesh(coriolis, monkeypatch):
    """Layers of a twentieth of the beam need no element of their own, but a higher order."""
    attempts, solve_stack = [], Refinement.solve_stack

    def counted(refinement, indices, mesh):
        attempts.append(mesh.orders)
        solve_stack(refinement, indices, mesh)

    monkeypatch.setattr(Refinement, "solve_stack", counted)
    solve(Beam(alpha=1.5, beta=0.5, gamma=20), 6, coriolis=coriolis)
    assert [len(orders) for orders in attempts] == [2]


def test_a_small_strain_needs_no_newton_iteration():
    """The first guess suffices for a large tolerance, one iteration for the default one."""
    found = [solve(Beam(alpha=1, gamma=5), tolerance=t).equilibrium for t in (1e-3, 1e-6, 1e-11)]
    first, second, third = (state.iterations for state in found)
    assert 0 == first <= second <= third > 0


HARD = {
    "a stretch that falls off almost singularly": (Beam(83, 0.8125, 25, 0, 10), {}),
    "the same at a mass inside": (Beam(51.65, 0.4847, 200, 0, 101.14), {}),
    "the same with a hub": (Beam(gamma=200, delta=2.58, mu=109.8), {}),
    "3e-4 below its limit": (Beam(0.0, 0.1, 28.691018, -0.66, 19.0), {"strain": "hencky"}),
    "2e-4 below its limit": (Beam(4.4, 0.6, 6.3986495, -0.71, 18.0), {}),
    # It stretches 16,000-fold at its clamp: the estimates contain what no mesh resolves.
    "1e-4 below its limit": (Beam(0, 1, 10 * np.pi * (1 - 1e-4), 1, 20), {"strain": "biot"}),
    "buckled": (Beam(alpha=6, beta=0.25, gamma=5, delta=-1.9, mu=200), {"modes": 20}),
    "far beyond buckling": (Beam(alpha=6, beta=0.25, gamma=18, delta=-1.9, mu=200), {"modes": 20}),
}


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("name", HARD)
def test_error_bars_of_hard_beams(name, tolerance):
    """Near a limit the tangent is almost singular: a small residual is a long way from
    equilibrium. The stiffness of a buckled beam is indefinite."""
    beam, options = HARD[name]
    rough = solve(beam, tolerance=tolerance, **options)
    assert within_the_bars(rough, solve(beam, tolerance=EXACT, **options))
    if "buckl" in name:
        assert rough.equilibrium.status == "unstable"


@pytest.mark.parametrize(
    ("beam", "strain"),
    [
        (Beam(0, 1, 50, -0.656, 25.8), "green"),
        (Beam(0, 1, 50, -1.615, 96.8), "green"),
        (Beam(1.4, 0.163, 50, -1.595, 67.7), "green"),
        (Beam(1, 0.5, 100, -1.2, 20), "biot"),
        (Beam(2, 0.7, 100, 1, 20), "hencky"),
    ],
)
def test_towards_the_end_of_an_equilibrium_the_bars_hold(beam, strain):
    """A fold, a stretch that falls to zero, the greatest force; each beam alone and in a sweep."""
    with pytest.raises(NoEquilibrium) as ended:
        solve(beam, strain=strain)
    speeds = ended.value.limit * (1 - np.geomspace(1e-4, 0.1, 12))
    sweep = [beam.replace(gamma=gamma) for gamma in speeds]
    together = solve_many(sweep, strain=strain, tolerance=1e-4)
    for near, in_sweep in zip(sweep, together, strict=True):
        fine = solve(near, strain=strain, tolerance=1e-8)
        assert within_the_bars(in_sweep, fine)
        assert within_the_bars(solve(near, strain=strain, tolerance=1e-4), fine)


@pytest.mark.parametrize(
    ("beam", "options"),
    [
        (Beam(0.0017162224, 0.9999850882, 195.643763, 7.81546017, 5581.03943), BIOT),
        (Beam(0.0045099961, 0.9996084399, 198.408316, 8.49544911, 5664.11510), HENCKY),
    ],
)
def test_where_order_is_not_enough_elements_are_halved(beam, options):
    """A light mass just inside the tip of a very fast beam: the tolerance is met all the same."""
    solution, tolerance = solve(beam, **options), options["tolerance"]
    assert solution.stats.order <= MAX_ORDER
    assert np.all(solution.errors <= 1.01 * tolerance * solution.frequencies)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_a_beam_that_stretches_inwards_of_its_clamp_has_layers(plane):
    """The force at the clamp is small for the unstretched beam; it stretches fivefold."""
    beam = Beam(0, 1, 44.77, -0.4, 30)
    solution = solve(beam, strain="biot", plane=plane)
    assert solution.equilibrium.max_stretch > 5
    assert solution.stats.order <= 20


def test_rounding_near_an_end_asks_for_no_finer_mesh():
    """3e-4 below its limit rounding dominates: the mesh is not refined, the estimate is larger."""
    near = Beam(2, 1, 19.592256, -0.6, 30)
    solution = solve(near, modes=3, strain="biot", plane="flapwise")
    elsewhere = solve(near.replace(gamma=15), modes=3, strain="biot", plane="flapwise")
    assert solution.stats.elements == 3
    assert solution.omega_squared_errors[1] > 10 * elsewhere.omega_squared_errors[1]


@pytest.mark.parametrize("tolerance", [0.1, 1e-3, 1e-5])
@pytest.mark.parametrize(
    "beam", [Beam(gamma=200), Beam(alpha=1, beta=0.5, gamma=100), Beam(gamma=134, mu=27.5)]
)
def test_a_fast_beam_has_the_mesh_it_needs_at_once(beam, tolerance, monkeypatch):
    """Although softening cancels most digits of the lowest mode."""
    solved = []
    solve_stack = Refinement.solve_stack
    monkeypatch.setattr(
        Refinement, "solve_stack", lambda *args: (solved.append(args), solve_stack(*args))
    )
    solve(beam, tolerance=tolerance)
    assert len(solved) == 1


def test_extra_modes_of_a_sweep_need_not_meet_the_tolerance():
    """They take fewer unknowns than the same modes asked for, and their errors hold."""
    sweep = [Beam(alpha=1, gamma=gamma) for gamma in np.linspace(1, 20, 40)]
    asked, extra = solve_many(sweep, modes=8), solve_many(sweep, extra_modes=2, modes=6)
    assert sum(s.stats.dof for s in extra) < sum(s.stats.dof for s in asked)
    for beam, six, eight in zip(sweep, extra, asked, strict=True):
        assert six.labels == eight.labels
        assert np.all(six.errors[:6] <= 1.01e-6 * six.frequencies[:6])
        assert within_the_bars(six, solve(beam, modes=8, tolerance=EXACT))
