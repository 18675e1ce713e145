"""Growth of disturbances, with and without vibration: each kind as a kind, and on random beams that
spin up against the oracle."""

import numpy as np
import pytest
from helpers import slow
from oracle.bent import bent_truth

from beamviz import Beam, solve
from beamviz.errors import BeamvizError
from beamviz.solver.problem import METHODS
from beamviz.solver.stability import status_of

SLENDER = Beam(mu=10000)
COALESCENCE = 85.67013082529  # spin-up at which B1 and B2 of it coalesce


def solve_stable(beam, **options):
    """The stable state of a beam."""
    return solve(beam, state="stable", **options)


def oracle_s(solution):
    """s of the modes about the state of a solution by the differential equations, and their
    differences between two resolutions."""
    problem, state = solution.problem, solution.equilibrium
    model = problem.strain, problem.curvature, problem.gyroscopic, problem.modes
    truth = bent_truth(
        solution.beam, *model, lambda x: (state.position(x), state.angle(x), state.stretch(x))
    )
    return 1j * truth.omega, truth.differences


def test_divergence_comes_before_flutter():
    """A state that is left both with a vibration and without one is called unstable."""
    static, growing, decaying = 0.5 + 0j, 0.2 + 4j, -0.2 + 4j
    assert status_of(np.array([growing, static])) == "unstable"
    assert status_of(np.array([growing, decaying])) == "growing"
    assert status_of(np.array([3j, decaying])) == "stable"


@pytest.mark.parametrize(("spin_up", "rate"), [(100, 2.1203), (200, 5.7037)])
def test_two_modes_that_have_coalesced_grow_and_decay(spin_up, rate):
    """Without Coriolis forces: one frequency, opposite rates; the growing mode comes first."""
    solution = solve_stable(SLENDER.replace(spin_up=spin_up), modes=3)
    growing, decaying, third = solution.s
    assert solution.equilibrium.status == "growing"
    assert growing.real == pytest.approx(rate, abs=1e-4)
    assert decaying == pytest.approx(-growing.conjugate(), rel=1e-9)
    assert third.real == 0


def test_growth_begins_where_two_modes_coalesce():
    """s^2 is a square root there, so an error of rounding in the matrices is its root in s: neither
    side is taken for the other down to 1e-11 of the spin-up, and the rate is the square root."""
    for distance in 10.0 ** np.arange(-11, -3):
        below, above = (
            solve_stable(SLENDER.replace(spin_up=COALESCENCE * (1 + side * distance)), modes=2)
            for side in (-1, 1)
        )
        assert below.equilibrium.status == "stable"
        assert np.all(below.growth_rates == 0)
        assert above.equilibrium.status == "growing"
        assert above.growth_rates[0] == pytest.approx(5.27 * distance**0.5, rel=0.01)
        gap = np.diff(below.frequencies)[0]
        assert gap == pytest.approx(2 * above.growth_rates[0], rel=0.01)


def test_an_instability_just_above_the_modes_asked_for_is_seen():
    """B2 and B3 of this beam grow together; the lowest mode does not."""
    beam = SLENDER.replace(gamma=0.1, spin_up=1000)
    lowest = solve_stable(beam, modes=1)
    assert lowest.growth_rates[0] == 0
    assert lowest.equilibrium.status == "growing"
    assert max(solve_stable(beam, modes=2).growth_rates) == pytest.approx(16.54, abs=0.01)


@pytest.mark.parametrize("spin_up", [10, 1e-2])
def test_coriolis_forces_make_vibrations_grow_slowly(spin_up):
    """In proportion to the spin-up, as the Euler force does a little work in each period. All rates
    of an undamped beam add up to 0: some modes decay."""
    solution = solve_stable(Beam(gamma=5, spin_up=spin_up), coriolis=True, tolerance=1e-9)
    s, differences = oracle_s(solution)
    assert solution.equilibrium.status == "growing"
    assert solution.growth_rates.min() < 0 < solution.growth_rates.max()
    assert np.all(abs(solution.s - s) <= solution.errors + differences + 1e-9 * abs(s))


def test_a_beam_that_leaves_its_state_without_vibration_is_unstable():
    """An inward beam past its buckling: s is real and positive."""
    solution = solve(Beam(gamma=4, delta=-1))
    assert solution.equilibrium.status == "unstable"
    assert solution.s[0].real > 0 == solution.s[0].imag


@pytest.mark.parametrize("method", METHODS)
def test_a_beam_that_has_buckled_chordwise_says_so_when_it_vibrates_flapwise(method):
    """Flapwise it buckles at a higher speed, for nothing softens it; every method knows."""
    options = {"plane": "flapwise", "method": method, "modes": 2}
    if method == "zoac":  # it has no thrust to buckle it, chordwise it is softened all the same
        beams = Beam(gamma=3.4, delta=-1), Beam(gamma=3.6, delta=-1)
    else:
        beams = Beam(gamma=2.5, delta=-1, mu=1000), Beam(gamma=3.2, delta=-1, mu=1000)
    before, beyond = (solve(beam, **options).equilibrium for beam in beams)
    assert before.status == beyond.status == "stable"
    assert (before.buckled_chordwise, beyond.buckled_chordwise) == (False, True)


@pytest.mark.parametrize("seed", [0, 1, *slow(2, 3)])
def test_random_beams_that_spin_up(seed):
    """s of each mode is within its reported error of the oracle's, in the complex plane; the status
    is that of the oracle's modes wherever their growth exceeds these errors."""
    rng = np.random.default_rng([23, seed])
    beam = Beam(
        alpha=rng.choice([0.0, rng.uniform(0, 2)]),
        beta=rng.uniform(0.3, 1),
        gamma=rng.choice([0.0, rng.uniform(0, 15)]),
        delta=rng.uniform(0, 1),
        mu=10 ** rng.uniform(1.7, 4),
        spin_up=10 ** rng.uniform(0, 3),
    )
    try:
        solution = solve_stable(beam, modes=4, coriolis=bool(seed % 2))
    except BeamvizError:
        pytest.skip("no state with so much spin-up")
    s, differences = oracle_s(solution)
    errors = solution.errors + differences + 1e-9 * abs(s)
    assert np.all(abs(solution.s - s) <= errors)
    if np.any(s.real > errors):
        assert solution.equilibrium.status == "growing"
    if solution.equilibrium.status == "stable":
        assert np.all(solution.growth_rates <= 0)
