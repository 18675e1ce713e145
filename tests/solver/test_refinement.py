"""Refinement of the default method: the tolerance is met, with few unknowns, and errors hold.

Those of random beams at any tolerance are tested against the oracle (test_error_bars.py).
"""

from typing import Any

import numpy as np
import pytest
from helpers import within_the_bars

from beamviz import Beam, solve
from beamviz.errors import NoEquilibrium
from beamviz.frequency_loci import loci
from beamviz.presets import preset
from beamviz.solver import solve_many

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


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
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
    speeds = ended.value.limit * (1 - np.geomspace(1e-4, 0.1, 5))
    sweep = [beam.replace(gamma=gamma) for gamma in speeds]
    together = solve_many(sweep, strain=strain, tolerance=1e-4)
    for near, in_sweep in zip(sweep, together, strict=True):
        fine = solve(near, strain=strain, tolerance=1e-8)
        assert within_the_bars(in_sweep, fine)
        assert within_the_bars(solve(near, strain=strain, tolerance=1e-4), fine)


# Layers thinner than a thousandth, a light mass just inside the tip, a stretch that is nearly
# singular at the tip, softening that cancels all but 1e-4 of the strain energy of the lowest mode.
DEMANDING = {
    "layers": (Beam(alpha=1, beta=0.3, gamma=200, delta=5, mu=5000), {}),
    "layers at a mass near the tip": (Beam(0.00171622, 0.99998509, 195.6, 7.815, 5581), BIOT),
    "flapwise": (Beam(0.0045099961, 0.9996084399, 198.4, 8.495, 5664), HENCKY),
    "singular stretch": (Beam(77, 0.435, 44.8, 11, 15.3), {"tolerance": 1e-8}),
    "cancelled": (Beam(alpha=100, beta=0.5, gamma=67, mu=55), {}),
    "cancelled, coupled": (Beam(alpha=72, gamma=54, mu=10.84), {"coriolis": True}),
    "many waves": (Beam(alpha=1, beta=0.4, gamma=3), {"modes": 20}),
}


@pytest.mark.parametrize("name", DEMANDING)
def test_the_tolerance_is_met(name):
    """By every reported error, whatever the mesh that it takes."""
    beam, options = DEMANDING[name]
    solution = solve(beam, **options)
    tolerance = options.get("tolerance", 1e-6)
    assert np.all(solution.errors <= 1.01 * tolerance * solution.frequencies)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_a_beam_that_stretches_inwards_of_its_clamp_has_layers(plane):
    """The force at the clamp is small for the unstretched beam; it stretches fivefold."""
    beam = Beam(0, 1, 44.77, -0.4, 30)
    solution = solve(beam, strain="biot", plane=plane)
    assert solution.equilibrium.max_stretch > 5
    assert np.all(solution.errors <= 1.01e-6 * abs(solution.s))


def test_rounding_near_an_end_is_in_the_estimate():
    """3e-4 below its limit rounding dominates: there is an answer, and its estimate is larger."""
    near = Beam(2, 1, 19.592256, -0.6, 30)
    solution = solve(near, modes=3, strain="biot", plane="flapwise")
    elsewhere = solve(near.replace(gamma=15), modes=3, strain="biot", plane="flapwise")
    assert solution.omega_squared_errors[1] > 10 * elsewhere.omega_squared_errors[1]


def test_a_frequency_that_vanishes_is_solved_for():
    """It is zero at alpha = 0.76558177, where a relative error of it has no meaning."""
    blade = preset("nrel-5mw-blade").beam.replace(gamma=0.9486559190684223, delta=1 / 41)
    options: dict[str, Any] = {"method": "zoac", "coriolis": False, "modes": 5}
    stable, at_zero = (solve(blade.replace(alpha=a), **options) for a in (0.7, 0.7655818107264929))
    assert at_zero.stats.dof <= 2 * stable.stats.dof
    assert abs(at_zero.omega_squared[0]) < 1e-6
    assert np.all(at_zero.omega_squared_errors <= 2.02e-6 * np.maximum(at_zero.omega_squared, 1e-4))
    (limit,) = loci(blade, "alpha", [0.7, 0.73, 0.77, 0.8], **options).limits
    assert limit.kind == "unstable"
    assert limit.start == pytest.approx(0.76558177, abs=1e-7)


def test_extra_modes_of_a_sweep_need_not_meet_the_tolerance():
    """They take fewer unknowns than the same modes asked for, and their errors hold."""
    sweep = [Beam(alpha=1, gamma=gamma) for gamma in np.linspace(1, 20, 8)]
    asked, extra = solve_many(sweep, modes=8), solve_many(sweep, extra_modes=2, modes=6)
    assert sum(s.stats.dof for s in extra) < sum(s.stats.dof for s in asked)
    for beam, six, eight in zip(sweep, extra, asked, strict=True):
        assert six.labels == eight.labels
        assert np.all(six.errors[:6] <= 1.01e-6 * six.frequencies[:6])
        assert within_the_bars(six, solve(beam, modes=8, tolerance=EXACT))
