"""The finite-element methods: printed numbers, rates declared and measured, limits, failures."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from beamviz import Beam, solve
from beamviz.errors import InvalidInput, NoEquilibrium, NotConverged
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS

ANCF = ("ancf", "ancf-planar")
every_model = pytest.mark.parametrize(
    ("strain", "curvature"), list(itertools.product(STRAIN_LAWS, CURVATURES))
)


def family(letter, solution):
    """omega^2 of the bending (B) or stretching (S) modes."""
    return solution.omega_squared[[label[0] == letter for label in solution.labels]]


@pytest.mark.parametrize("method", ANCF)
def test_frequencies_of_the_paper(method):
    """20 elements give the paper's omega_2 and omega_3 of the bare beam at rest (figs. 16-19)."""
    solution = solve(Beam(), 3, method=method)
    assert solution.stats.elements == 20
    assert solution.frequencies.round(4).tolist()[1:] == [22.0345, 61.6982]


# method, beam, options, elements, label, declared order in the element length h of the error.
# Bending 4; stretching 6; with an interior mass 1, as the shared gradient cannot jump there.
RATES = [
    ("ancf", Beam(), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1), {"curvature": "material"}, 10, "B3", 4),
    ("ancf", Beam(gamma=10), {}, 20, "B3", 4),
    ("ancf", Beam(alpha=1, gamma=10), {}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10), {"strain": "hencky"}, 20, "B2", 4),
    ("ancf", Beam(alpha=1, gamma=10, delta=1), {}, 20, "B2", 4),
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


scenes = {
    "alpha": st.floats(0, 3),
    "beta": st.floats(0, 1),
    "gamma": st.floats(0.1, 30),
    "delta": st.floats(0, 2),
}


@settings(max_examples=25)
@given(
    **scenes,
    strain=st.sampled_from(sorted(STRAIN_LAWS)),
    curvature=st.sampled_from(sorted(CURVATURES)),
    coriolis=st.booleans(),
)
def test_planar_elements_agree_with_those_by_parts(
    alpha, beta, gamma, delta, strain, curvature, coriolis
):
    """The full planar tangent and half its coordinates at a time are the same discretisation."""
    beam = Beam(alpha, beta, gamma, delta, mu=100)
    options = {"strain": strain, "curvature": curvature, "coriolis": coriolis, "elements": 10}
    try:
        parts, planar = (solve(beam, method=method, **options) for method in ANCF)
    except (NoEquilibrium, NotConverged):  # of either, alike
        return
    scale = abs(parts.omega_squared) + gamma**2
    assert np.all(abs(planar.omega_squared - parts.omega_squared) <= 1e-7 * scale)
    assert planar.equilibrium.tip == pytest.approx(parts.equilibrium.tip, rel=1e-9)


@settings(max_examples=25)
@given(**scenes)
def test_flapwise_and_chordwise(alpha, beta, gamma, delta):
    """omega_flap^2 - omega_chord^2 = gamma^2 in bending; stretching is the same."""
    beam = Beam(alpha, beta, gamma, delta)
    chordwise, flapwise = (
        solve(beam, 8, method="ancf", elements=10, plane=plane)
        for plane in ("chordwise", "flapwise")
    )
    chord, flap = (family("B", solution) for solution in (chordwise, flapwise))
    count = min(len(chord), len(flap))
    difference = flap[:count] - chord[:count]
    assert difference == pytest.approx(gamma**2, rel=1e-6, abs=1e-6 * flap[count - 1])
    S, same = (family("S", solution) for solution in (chordwise, flapwise))
    assert S[: len(same)] == pytest.approx(same[: len(S)], rel=1e-8)


def test_families_do_not_mix():
    """A shape along the beam has nothing across it and the reverse, even where a bending and a
    stretching frequency are equal to 1e-3."""
    solution = solve(Beam(alpha=1, gamma=4.46417), 6, method="ancf-planar")
    assert min(np.diff(solution.frequencies)) < 1e-2
    shapes = solution.displacement(np.linspace(0, 1, 11))
    assert np.all(shapes[0] == 0)
    assert np.all(np.any(shapes, axis=0).sum(axis=0) == 1)


@every_model
def test_all_models_agree_at_rest(strain, curvature):
    """Strain laws and curvature measures differ in nothing at rest."""
    beam = Beam(alpha=0.5, beta=0.4)
    found = solve(beam, method="ancf", strain=strain, curvature=curvature)
    assert found.frequencies == pytest.approx(solve(beam, method="ancf").frequencies, rel=1e-8)
    assert found.equilibrium.iterations == 0
    assert found.equilibrium.tip.tolist() == [1, 0]


def test_linear_law_in_closed_form():
    """A biot bar has u'' + (gamma / mu)^2 (u + delta) = 0: r1 + delta = (sin + delta cos) / cos."""
    gamma, delta, mu = 50.0, 0.5, 70.0
    solution = solve(Beam(gamma=gamma, delta=delta, mu=mu), method="ancf", strain="biot")
    k, x = gamma / mu, np.linspace(0, 1, 21)
    A = (1 / k + delta * math.sin(k)) / math.cos(k)
    r = delta * np.cos(k * x) + A * np.sin(k * x) - delta
    assert solution.equilibrium.position(x)[:, 0] == pytest.approx(r, abs=1e-7)
    assert solution.equilibrium.status == "stable"


@settings(max_examples=40)
@given(
    mu=st.floats(10, 10000),
    speed=st.floats(0, 1),
    alpha=st.floats(0, 100),
    delta=st.floats(0, 20),
    curvature=st.sampled_from(sorted(CURVATURES)),
)
def test_green_always_has_an_outward_state(mu, speed, alpha, delta, curvature):
    """With green strain and delta >= 0 every beam with no mass or a tip mass has an equilibrium,
    in tension everywhere and stable."""
    beam = Beam(alpha=alpha, gamma=speed * min(200, 5 * mu), delta=delta, mu=mu)
    state = solve(beam, method="ancf", curvature=curvature).equilibrium
    assert state.status == "stable"
    assert state.stretch(np.linspace(0, 1, 41)).min() > 1 - 1e-6


# Biot: mu pi / 2 whatever the hub radius. Hencky, computed independently: a fold of the whole beam
# at delta 0; at delta 1 the root reaches f = e, in a layer that 20 elements resolve to 1e-4.
@pytest.mark.parametrize(
    ("strain", "delta", "limit", "tolerance", "reason"),
    [
        ("biot", 0, 35 * math.pi, 1e-9, r"no equilibrium beyond gamma = 109\.955743"),
        ("biot", 1, 35 * math.pi, 1e-9, r"no equilibrium beyond gamma = 109\.955743"),
        ("biot", 5, 35 * math.pi, 1e-9, r"no equilibrium beyond gamma = 109\.955743"),
        ("hencky", 0, 45.420, 1e-5, "stiffness of the beam"),
        ("hencky", 1, 31.4887, 1e-4, "hencky force law ends"),
    ],
)
def test_limit_of_the_speed(strain, delta, limit, tolerance, reason):
    """A limit is found, named and explained; just below it there is an equilibrium."""
    options = {"method": "ancf", "strain": strain}
    with pytest.raises(NoEquilibrium, match=reason) as error:
        solve(Beam(gamma=150 if strain == "biot" else 50, delta=delta), **options)
    found = error.value.limit
    assert found == pytest.approx(limit, rel=tolerance)
    if strain == "hencky":
        below, above = (Beam(gamma=found * (1 + off), delta=delta) for off in (-1e-7, 1e-7))
        assert solve(below, **options).equilibrium.status == "stable"
        with pytest.raises(NoEquilibrium):
            solve(above, **options)


@pytest.mark.parametrize(("strain", "delta"), [("green", -1), ("biot", 0.5), ("hencky", 0.5)])
def test_limit_does_not_depend_on_the_speed(strain, delta):
    """However far beyond the limit the speed is, the same limit is found for the same reason."""
    found = []
    for over in (None, 0.001, 0.03, 0.38237, 0.7):
        gamma = 130.0 if over is None else found[0].limit * (1 + over)
        with pytest.raises(NoEquilibrium) as error:
            solve(Beam(gamma=gamma, delta=delta), method="ancf", strain=strain)
        found.append(error.value)
    assert [error.limit for error in found[1:]] == pytest.approx([found[0].limit] * 4, rel=1e-8)
    assert len({str(error).partition(":")[2] for error in found}) == 1


@pytest.mark.parametrize(("strain", "end"), [("green", "0.5774"), ("biot", "0")])
def test_inward_limit(strain, end):
    """An inward beam is compressed to the end of its force law, never through it: at the speed
    that the default method finds too."""
    beam, reason = Beam(gamma=150, delta=-2), f"{strain} force law ends there, at .* {end}$"
    with pytest.raises(NoEquilibrium, match=reason) as error:
        solve(beam, method="ancf", strain=strain, elements=80)
    with pytest.raises(NoEquilibrium) as exact:
        solve(beam, strain=strain)
    assert error.value.limit == pytest.approx(exact.value.limit, rel=2e-3)


@pytest.mark.parametrize(
    "beam",
    [
        Beam(alpha=98, beta=0.725, gamma=97, delta=10.8),  # false limit
        Beam(alpha=33, beta=0.966, gamma=26, delta=19.8, mu=1533),  # false buckling
    ],
)
@pytest.mark.parametrize("method", ANCF)
def test_overshoot_at_a_mass_is_not_physics(beam, method):
    """Where the gradient shared at a heavy inner mass overshoots into compression, neither a limit
    nor an instability of the beam is reported: the method did not converge."""
    with pytest.raises(NotConverged, match="a limit of the method, not of the beam"):
        solve(beam, method=method)


def ritz_buckling_speed(delta):
    """The least gamma at which an inextensible inward beam buckles chordwise, by polynomials."""
    x, weights = np.polynomial.legendre.leggauss(40)
    x, weights = (x + 1) / 2, weights / 2
    tension = (1 - x**2) / 2 + delta * (1 - x)
    powers = np.arange(2, 10)[:, None]
    w, dw, ddw = x**powers, powers * x ** (powers - 1), powers * (powers - 1) * x ** (powers - 2)
    K = (weights * ddw) @ ddw.T
    softening = (weights * w) @ w.T - (weights * tension * dw) @ dw.T
    return 1 / math.sqrt(np.linalg.eigvals(np.linalg.solve(K, softening)).real.max())


@pytest.mark.parametrize("method", ANCF)
@pytest.mark.parametrize("delta", [-1.0, -0.3, -2.0])  # -0.3: it buckles in tension
def test_buckling_speed(delta, method):
    """The straight inward beam becomes unstable at the speed of the inextensible one."""

    def state(gamma):
        return solve(Beam(gamma=gamma, delta=delta, mu=1000), 1, method=method)

    critical = ritz_buckling_speed(delta)
    found = brentq(lambda gamma: state(gamma).omega_squared[0], critical - 0.5, critical + 0.5)
    assert found == pytest.approx(critical, rel=1e-4)
    statuses = [state(factor * critical).equilibrium.status for factor in (0.99, 1.01)]
    assert statuses == ["stable", "unstable"]


def test_flapwise_buckling():
    """Flapwise, without the softening, the inward beam buckles later."""
    for gamma, status in ((5, "stable"), (6.5, "unstable")):
        solution = solve(Beam(gamma=gamma, delta=-1), method="ancf", plane="flapwise")
        assert solution.equilibrium.status == status


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"elements": 0}, r"elements = 0: must be a whole number in 1 \.\. 1000"),
        ({"elements": 1001}, r"elements = 1001: must be a whole number in 1 \.\. 1000"),
        ({"elements": 2}, "modes = 5: at most 4 with elements = 2"),
    ],
)
def test_too_few_or_too_many_elements(options, message):
    """The message names the value and the numbers allowed."""
    with pytest.raises(InvalidInput, match=message):
        solve(Beam(), method="ancf", **options)
