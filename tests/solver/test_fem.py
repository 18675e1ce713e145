"""The finite-element methods: printed numbers, rates declared and measured, limits, failures."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import beams

from beamviz import Beam, solve
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS

ANCF = ("ancf", "ancf-planar")
every_model = pytest.mark.parametrize(
    ("strain", "curvature"), list(itertools.product(STRAIN_LAWS, CURVATURES))
)


# method, beam, options, elements, label, declared order in the element length h of the error.
# Bending 4; stretching 6; with an interior mass 1, as the shared gradient cannot jump there.
RATES = [
    ("ancf", Beam(), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1), {"curvature": "material"}, 10, "B3", 4),
    ("ancf", Beam(gamma=10), {}, 20, "B3", 4),
    ("ancf", Beam(alpha=1, gamma=10), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10), {"strain": "hencky"}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10, delta=1), {}, 20, "B2", 4),
    ("ancf", Beam(gamma=30, delta=0.5), {"strain": "biot"}, 40, "B2", 4),
    ("ancf", Beam(gamma=10, delta=1), {"curvature": "material"}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10), {"coriolis": True}, 20, "B1", 4),
    ("ancf", Beam(gamma=10, delta=1), {}, 8, "S1", 6),
    ("ancf", Beam(alpha=1, beta=0.5), {}, 20, "S1", 1),
    ("ancf", Beam(alpha=1, beta=0.5, gamma=10), {}, 20, "S1", 1),
    ("ancf", Beam(alpha=2, beta=0.25, gamma=20), {}, 20, "S1", 1),
    ("ancf-planar", Beam(gamma=10), {}, 20, "B3", 4),
    ("ancf-planar", Beam(alpha=1, beta=0.5, gamma=10), {}, 20, "S1", 1),
    ("linear", Beam(gamma=10, delta=1), {}, 20, "B2", 4),
    ("linear", Beam(alpha=1, gamma=10), {}, 20, "B2", 4),
    ("linear", Beam(alpha=1, beta=0.5), {}, 20, "S1", 1),
]


@pytest.mark.parametrize(("method", "beam", "options", "elements", "label", "declared"), RATES)
def test_finite_elements_converge_as_declared(method, beam, options, elements, label, declared):
    """The error against the exact solution of the same model, at each halving of the elements."""
    limit = "foac" if method == "linear" else "auto"
    exact = frequency(label, beam, method=limit, tolerance=1e-11, **options)
    errors = [
        abs(frequency(label, beam, method=method, elements=n, **options) - exact)
        for n in (elements, 2 * elements, 4 * elements)
    ]
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert observed == pytest.approx(declared, abs=0.3)


def frequency(label, beam, **options):
    solution = solve(beam, 6, **options)
    return solution.frequencies[solution.labels.index(label)]


@settings(max_examples=25)
@given(
    beam=beams(alpha=(0, 3), gamma=(0.1, 30), delta=(0, 2), mu=(100, 100)),
    strain=st.sampled_from(sorted(STRAIN_LAWS)),
    curvature=st.sampled_from(sorted(CURVATURES)),
    coriolis=st.booleans(),
    plane=st.sampled_from(["chordwise", "flapwise"]),
)
def test_planar_elements_agree_with_those_by_parts(beam, **options):
    """The full planar tangent and half its coordinates at a time are the same discretisation."""
    try:
        parts, planar = (solve(beam, method=method, elements=10, **options) for method in ANCF)
    except (NoEquilibrium, NotConverged):  # of either, alike
        return
    scale = abs(parts.omega_squared) + beam.gamma**2
    assert np.all(abs(planar.omega_squared - parts.omega_squared) <= 1e-7 * scale)
    assert planar.labels == parts.labels
    assert planar.equilibrium.tip == pytest.approx(parts.equilibrium.tip, rel=1e-9)


def test_families_do_not_mix():
    """A shape has one component, even where bending and stretching are equal to 1e-3."""
    solution = solve(Beam(alpha=1, gamma=4.46417), 6, method="ancf-planar")
    assert min(np.diff(solution.frequencies)) < 1e-2
    shapes = solution.displacement(np.linspace(0, 1, 11))
    assert np.all(shapes[0] == 0)
    assert np.all(np.any(shapes, axis=0).sum(axis=0) == 1)


@every_model
@pytest.mark.parametrize("method", ["auto", "ancf"])
def test_all_models_agree_at_rest(strain, curvature, method):
    """Strain laws and curvature measures differ in nothing at rest."""
    beam = Beam(alpha=0.5, beta=0.4)
    found = solve(beam, method=method, strain=strain, curvature=curvature)
    assert found.frequencies == pytest.approx(solve(beam, method=method).frequencies, rel=1e-8)
    assert found.equilibrium.iterations == 0
    assert found.equilibrium.tip == pytest.approx([1, 0], abs=1e-14)


@settings(max_examples=40)
@given(
    beam=beams(alpha=(0, 100), beta=(1, 1), gamma=(0, 0), delta=(0, 20), mu=(10, 10000)),
    speed=st.floats(0, 1),
    curvature=st.sampled_from(sorted(CURVATURES)),
)
def test_green_always_has_an_outward_state(beam, speed, curvature):
    """With no mass or a tip mass and delta >= 0: in tension everywhere and stable."""
    beam = beam.replace(gamma=speed * min(200, 5 * beam.mu))
    state = solve(beam, method="ancf", curvature=curvature).equilibrium
    assert state.status == "stable"
    assert state.stretch(np.linspace(0, 1, 41)).min() > 1 - 1e-6
