"""Loci, mode vectors and run-ups of blades."""

import numpy as np
import pytest
from helpers import KNOWN_KINDS

from beamviz import Beam, InvalidInput, loci, resonances, solve
from beamviz.blade import Blade, Mass
from beamviz.frequency_loci.forced_response import run_up, static_deflection
from beamviz.frequency_loci.identity import match_modes
from beamviz.frequency_loci.mode_vectors import mode_vectors
from beamviz.presets import preset
from beamviz.solver.bent import other_stable_states
from beamviz.solver.quadrature import quadrature

ONES = (1, 1, 1)
UNIFORM = Blade((0, 0.4, 1), ONES, ONES, ONES)
JUMP = Blade(
    (0, 0.4, 0.4, 1), (1, 0.8, 0.5, 0.2), (1, 0.7, 0.3, 0.1), (1, 0.9, 0.6, 0.4), (2, 1.8, 1.7, 1)
)
BODY = Mass(0.1, 0.5, (0.02, 0.05, 0.07))
BLADE = Beam(alpha=0.2, beta=0.8, gamma=3, delta=0.1, blade=JUMP, masses=(BODY,), root=20)


@pytest.mark.parametrize("options", [{}, {"plane": "flapwise"}, {"coriolis": True}])
def test_mode_vectors_are_orthogonal(options):
    """In the product with the mass of the blade and the rotary inertia of its body: 5e-3 is that of
    the body, 1e-4 the error of a quadrature across the concentrated mass."""
    vectors = mode_vectors(np.array([1.0]), [solve(BLADE, 6, **options)], 28)
    products = vectors.products(vectors)[0]
    assert products == pytest.approx(np.eye(6), abs=3e-4)


@pytest.mark.parametrize("state", ["straight", "stable"])
def test_mode_vectors_of_a_rigid_rotation_are_orthogonal(state):
    """Also normalised, though its frequency is 0: nothing holds the hinge on the axis of rotation.
    1.4e-4 is due to the frequency used in place of 0."""
    solution = solve(Beam(gamma=5, root=0), 6, coriolis=True, state=state)
    assert solution.frequencies[0] == 0
    vectors = mode_vectors(np.array([1.0]), [solution], 28)
    products = vectors.products(vectors)[0]
    assert products == pytest.approx(np.eye(6), abs=3e-4)


def test_loci_of_a_blade_that_is_uniform():
    """The events of the uniform beam, with its body as the concentrated mass or one of several."""
    speeds = np.linspace(0, 20, 21)
    beam = Beam(alpha=1, beta=0.8)
    plain = loci(beam, "gamma", speeds)
    for same in (beam.replace(blade=UNIFORM), Beam(blade=UNIFORM, masses=(Mass(1, 0.8),))):
        found = loci(same, "gamma", speeds)
        for branch in plain.branches:
            frequencies = found[branch.label].frequency
            assert frequencies == pytest.approx(branch.frequency, rel=2e-6, nan_ok=True)
        kinds = [(event.kind, event.branches) for event in found.events]
        assert kinds == [(event.kind, event.branches) for event in plain.events]


@pytest.mark.parametrize("method", ["auto", "ancf"])
def test_a_locus_that_lies_on_a_line_is_in_resonance_all_along(method):
    """The rigid rotation out of plane of a beam hinged on the axis has the frequency gamma. It is
    one event, whose place is a range; those of other modes are at their intersections."""
    options = {"plane": "flapwise", "method": method}
    found = loci(Beam(root=0), "gamma", [0, 12], 3, per_rev=4, **options)
    assert found["B1"].frequency == pytest.approx(found.values)
    names = [(event.branches, event.per_rev) for event in found.events]
    assert names == [(("B1",), 1), (("B2",), 4), (("B2",), 3)]
    along, *others = found.events
    assert (along.kind, along.at, along.until, along.modes) == ("resonance", 0, 12, (0,))
    assert (along.frequency, along.frequency_until) == (0, 12)
    assert resonances(found, 1) == [along]
    for event in others:
        there = solve(Beam(root=0, gamma=event.at), 3, **options)
        assert there.frequencies[1] == pytest.approx(event.per_rev * event.at, rel=1e-6)
        assert (event.until, event.modes) == (None, (1,))


def test_a_part_of_a_locus_on_a_line_ends_where_equilibrium_does():
    """Of a logarithmic strain, and in each of the parts of a chart."""
    options = {"plane": "flapwise", "strain": "hencky"}
    found = loci(Beam(root=0), "gamma", [1, 60], 3, per_rev=1, **options)
    (along,) = (event for event in found.events if event.until is not None)
    (limit,) = (limit for limit in found.limits if limit.kind == "no-equilibrium")
    assert (along.branches, along.at) == (("B1",), 1)
    assert along.until == pytest.approx(limit.start, rel=1e-3)


def test_the_static_deflection():
    """As in closed form of a uniform beam; a root spring adds the rotation under the moment."""
    beam = Beam(alpha=0.5, beta=0.3)
    same = Beam(blade=UNIFORM, masses=(Mass(0.5, 0.3),))
    assert static_deflection(same) == pytest.approx(static_deflection(beam), rel=1e-12)
    sprung = static_deflection(same.replace(root=2))
    assert sprung == pytest.approx(static_deflection(beam) + (0.5 + 0.15) / 2, rel=1e-12)


@pytest.mark.parametrize("coriolis", [False, True])
def test_an_integral_over_many_spans_needs_few_points(coriolis):
    """The modes of a blade with 48 spans are orthonormal at 500 points; 64 in each span took 15 ms
    of every frame of a run-up."""
    beam = preset("nrel-5mw-blade").beam
    x, mass = quadrature(beam)
    assert len(x) < 600
    fields = solve(beam, coriolis=coriolis).displacement(x)
    norms = mass @ (abs(fields) ** 2).sum(axis=1)
    assert norms == pytest.approx(np.ones(5), abs=1e-6)


def test_a_blade_runs_up():
    """Slowly it follows the force; a hinge has nothing to relate amplitudes to."""
    run = run_up(BLADE, 1, 0.02, 20.0)
    assert run.amplitudes[0] == pytest.approx(1, abs=1e-3)
    with pytest.raises(InvalidInput, match="root = 0"):
        run_up(BLADE.replace(root=0), 1, 0.02, 20.0)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"masses": (Mass(0.5, 0.3), Mass(1, 0.9))}, {"masses": (Mass(1, 0.9), Mass(0.5, 0.3))}),
        ({"alpha": 1, "beta": 0.9}, {"masses": (Mass(1, 0.9),)}),
        ({"masses": (Mass(1, 0.9),)}, {"masses": (Mass(1e-6, 0.3), Mass(1, 0.9))}),
        ({"masses": (BODY, Mass(1, 0.9))}, {"masses": (Mass(1, 0.9), BODY)}),
    ],
)
def test_modes_are_matched_whatever_the_order_of_the_bodies(one, other):
    """Two descriptions of one beam have the same modes, and 1e-6 of its mass changes nothing."""
    first, second = (solve(Beam(gamma=5, **numbers), 4) for numbers in (one, other))
    matched = match_modes(first, second)
    assert matched.partner.tolist() == [0, 1, 2, 3]
    assert np.diag(matched.mac) == pytest.approx(np.ones(4), abs=1e-3)


@pytest.mark.parametrize(("delta", "at"), [(-7.3e-5, 2.0002149231), (-0.01, 1.9619512067)])
def test_the_second_stable_state_of_a_blade(delta, at):
    """The blade is straight, or folded over beyond a limit point. The values were computed with an
    element for each interval between stations."""
    beam = preset("tapered-steel-blade").beam.replace(alpha=0.546, gamma=0.0, delta=delta)
    found = loci(beam, "gamma", [0, 5], plane="flapwise", state="stable", kinds=KNOWN_KINDS)
    (event,) = found.events
    assert event.kind == "second state"
    assert event.at == pytest.approx(at, rel=1e-9)


@pytest.mark.slow
def test_a_blade_of_many_stations_has_a_second_state_only_beyond_its_limit():
    """The limit point is at 4.3602113, computed as above; below it long elements have loops, which
    are no states of the blade."""
    beam = preset("nrel-5mw-blade").beam.replace(alpha=0.5, delta=-0.02)
    for gamma, count in ((2.5, 0), (5.0, 1)):
        solution = solve(beam.replace(gamma=gamma), plane="flapwise", state="stable")
        assert len(other_stable_states(solution)) == count


def test_a_second_state_is_followed_to_another_tolerance():
    """The elements of the finer one have other Gauss points. The frequencies differ by no more than
    their error bars."""
    beam = preset("tapered-steel-blade").beam.replace(alpha=0.546, gamma=3.0, delta=-0.01)
    coarse, fine = (
        solve(beam, plane="flapwise", state="stable", tolerance=each) for each in (1e-5, 1e-9)
    )
    (other,) = other_stable_states(coarse)
    (followed,) = other_stable_states(fine, [other])
    difference = abs(followed.frequencies - other.frequencies)
    assert (difference <= followed.errors + other.errors).all()
