"""Mode shapes as mass-weighted vectors: orthonormal in a point, matched between two solutions."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from strategies import beams

from beamviz import Beam, loci, solve
from beamviz.blade import Blade, Mass
from beamviz.frequency_loci.identity import (
    ModeIdentity,
    identify_modes,
    match_modes,
    names_of_branches,
)
from beamviz.frequency_loci.mode_vectors import gauss_points, mode_vectors

TIP = Beam(alpha=1, beta=1)
HEAVY = Beam(alpha=2, beta=0.7, mu=500)


@pytest.mark.parametrize("delta", [0.0, -0.1, -1.9])
@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize("method", ["auto", "zoac"])
def test_modes_of_one_point_are_orthonormal(method, coriolis, delta):
    """With Coriolis forces and without, where all swing and where some grow; the mass is in it.
    A beam far inward is in some ten half-waves, and its modes are still told apart."""
    beams = [HEAVY.replace(gamma=gamma, delta=delta) for gamma in (5, 40)]
    solutions = [solve(beam, 7, method=method, coriolis=coriolis) for beam in beams]
    vectors = mode_vectors(np.array([5.0, 40.0]), solutions, gauss_points(solutions))
    products = vectors.products(vectors)
    assert products == pytest.approx(np.tile(np.eye(7), (2, 1, 1)), abs=3e-3)


@pytest.mark.parametrize("count", [6, 12])
@pytest.mark.parametrize("state", ["straight", "stable"])
def test_a_rigid_rotation_about_a_hinge_is_orthogonal_to_the_other_modes(state, count):
    """Of frequency 0, and so of a product with itself that would vanish."""
    beam = Beam(root=0.0, alpha=0.7, beta=0.6, gamma=6.0)
    solution = solve(beam, count, coriolis=True, state=state)
    vectors = mode_vectors(np.array([6.0]), [solution], gauss_points([solution]))
    assert vectors.products(vectors)[0] == pytest.approx(np.eye(count), abs=0.02)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_modes_turn_a_body_at_a_hinge(plane):
    """Its rotation is that at the root itself, which differs from that beside it."""
    body = Mass(0.4, 0.0, (0.02, 0.012, 0.01))
    solution = solve(Beam(root=0.0, delta=0.5, gamma=6.0, masses=(body,)), 12, plane=plane)
    vectors = mode_vectors(np.array([6.0]), [solution], gauss_points([solution]))
    assert vectors.products(vectors)[0] == pytest.approx(np.eye(12), abs=1e-3)


def test_the_finest_of_all_shapes_are_told_apart():
    """Without a mass nothing depends on its place: a hundred half-waves are found again."""
    buckled = Beam(gamma=200, delta=-1.9, mu=7000)
    solutions = [solve(buckled.replace(beta=beta), 7) for beta in (0.2, 0.3)]
    vectors = mode_vectors(np.array([0.2, 0.3]), solutions, gauss_points(solutions))
    products = vectors.chosen(np.array([0])).products(vectors.chosen(np.array([1])))[0]
    assert abs(products) == pytest.approx(np.eye(7), abs=1e-2)


def test_modes_of_a_blade_with_stations_close_to_its_tip_are_orthonormal():
    """One long part and forty short ones, which need few points of a quadrature."""
    x = np.append(0.0, np.linspace(0.9, 1.0, 41))
    taper = 1 - 0.5 * x
    blade = Blade(*map(tuple, (x.tolist(), taper.tolist(), (taper**3).tolist(), taper.tolist())))
    solution = solve(Beam(blade=blade, gamma=3), 9)
    vectors = mode_vectors(np.array([3.0]), [solution], gauss_points([solution]))
    products = vectors.products(vectors)[0]
    assert products == pytest.approx(np.eye(9), abs=1e-6)


def test_modes_of_another_blade_or_with_other_bodies_are_matched():
    """A body that moves a little, one more that is light, and a blade that hardly tapers leave
    every mode what it is; the correlation is the same both ways."""
    bodies = (Mass(0.3, 0.5, (0.001, 0.004, 0.004)), Mass(0.1, 1.0))
    blade = Beam(blade=Blade.tapered(0.3, 0.2), masses=bodies, gamma=3)
    here = solve(blade)
    others = [
        blade.replace(masses=(replace(bodies[0], beta=0.51), bodies[1])),
        blade.replace(masses=(*bodies, Mass(1e-3, 0.3))),
        blade.replace(blade=Blade.tapered(0.35, 0.2)),
        blade.replace(blade=Blade((0, 0.2, 1), (1, 1, 0.6), (1, 1, 0.4), (1, 1, 0.6))),
    ]
    for other in map(solve, others):
        there, back = match_modes(here, other), match_modes(other, here)
        assert there.partner.tolist() == list(range(5))
        assert there.mac == pytest.approx(np.eye(5), abs=0.05)
        assert there.mac == pytest.approx(back.mac.T)
        assert there.mac.max() <= 1 + 1e-12
        assert here.labels == other.labels
    uniform = match_modes(here, solve(Beam(gamma=3)))
    assert uniform.mac.shape == (5, 5)


def test_names_stay_with_the_shapes_through_a_veering():
    """Coriolis on, gamma from rest to 20: each mode is called as the one it is like without these
    forces, S1/B3 are mixed at 4.65 only, and the branches that veer exchange their names."""
    for gamma, mixed in ((0.0, False), (4.0, False), (4.65, True), (5.0, False)):
        solution = solve(TIP.replace(gamma=gamma), coriolis=True)
        names, mixtures = identity = identify_modes(solution)
        assert names == solve(TIP.replace(gamma=gamma)).labels
        pair = {k for k, name in enumerate(names) if name in ("S1", "B3")}
        assert {k for k, mixture in enumerate(mixtures) if mixture} == (pair if mixed else set())
        assert identity.summary == ("S1 and B3 mixed 50:50" if mixed else "")
    found = loci(TIP, "gamma", np.linspace(0, 10, 21), coriolis=True)
    before, after = (names_of_branches(found, value) for value in (0.0, 10.0))
    assert (before["B3"], before["S1"]) == ("B3", "S1")
    assert (after["B3"], after["S1"]) == ("S1", "B3")


@pytest.mark.parametrize("modes", [5, 9, 10])
def test_names_are_found_by_a_method_with_few_modes(modes):
    """Also where all ten modes of its ten terms were asked for, and two more cannot be solved."""
    solution = solve(TIP.replace(gamma=4.4), modes, method="assumed-modes", coriolis=True)
    assert identify_modes(solution).summary.startswith("B3 and S1 mixed")


def test_a_mixture_with_a_mode_that_is_not_shown_is_told_in_full():
    """As of the last mode of a table."""
    identity = ModeIdentity(("B3", "B4"), ("", "B4/S2 mixed 80:20"))
    assert identity.summary == "B4: B4/S2 mixed 80:20"


@given(beams(delta=(0, 2), mu=(20, 200)))
def test_names_are_all_different(beam):
    """However strongly Coriolis forces mix the modes."""
    names, _ = identify_modes(solve(beam, coriolis=True))
    assert len(set(names)) == len(names) == 5
    assert all(re.fullmatch(r"[BS]\d", name) for name in names)
