"""Options of solve(), solve_many() and loci(): an error names the value, and what is allowed; and
the effect of stiffening, softening and Coriolis forces, which may be left out."""

import inspect
import math

import numpy as np
import pytest

from beamviz import Beam, loci, solve
from beamviz.errors import InvalidInput
from beamviz.solver import solve_many
from beamviz.solver.constitutive import STRAIN_LAWS
from beamviz.solver.problem import METHODS, OPTIONS, Problem, parse_keywords

LAWS = ", ".join(STRAIN_LAWS)
BEAM = Beam(alpha=1, beta=0.5, gamma=3)
SWITCHED = Beam(alpha=1, beta=0.5, gamma=10, delta=0.5)
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(60)

WRONG = [
    (
        {"method": "magic"},
        "method = 'magic': must be one of auto, ancf, linear, foac, zoac, assumed-modes,"
        " power-series, chebyshev",
    ),
    ({"method": []}, "method = []: must be one of auto"),
    ({"strain": "cauchy"}, f"strain = 'cauchy': must be one of {LAWS}"),
    ({"curvature": "flat"}, "curvature = 'flat': must be one of spatial, material"),
    ({"plane": "diagonal"}, "plane = 'diagonal': must be one of chordwise, flapwise"),
    ({"modes": 0}, "modes = 0: must be a whole number in 1 .. 20"),
    ({"modes": 2.5}, "modes = 2.5: must be a whole number in 1 .. 20"),
    ({"coriolis": "no"}, "coriolis = 'no': must be True, False or a factor 0 .. 1"),
    ({"coriolis": 1.5}, "coriolis = 1.5: must lie in 0 .. 1"),
    ({"coriolis": -0.1}, "coriolis = -0.1: must lie in 0 .. 1"),
    ({"stiffening": 0}, "stiffening = 0: must be True or False"),
    ({"tolerance": 1.0}, "tolerance = 1: must lie in 1e-12 .. 0.1"),
    ({"tolerance": math.nan}, "tolerance = nan: must lie in 1e-12 .. 0.1"),
    ({"tolerance": [1]}, "tolerance = [1]: must be a number"),
    ({"method": "ancf", "elements": 0}, "elements = 0: must be a whole number in 1 .. 1000"),
    ({"method": "ancf", "elements": 1001}, "elements = 1001: must be a whole number in 1 .. 1000"),
    ({"method": "ancf", "elements": 2}, "modes = 5: at most 4 with elements = 2"),
    ({"method": "assumed-modes", "terms": 4}, "modes = 5: at most 4 with terms = 4"),
    ({"method": "chebyshev", "terms": 4}, "modes = 5: at most 4 with terms = 4"),
    ({"method": "power-series", "terms": 5}, "terms = 5: must be a whole number in 6 .. 1000"),
    (
        {"elements": 20},
        "elements = 20: method auto takes no number of elements; methods that do: ancf, linear",
    ),
    (
        {"method": "ancf", "terms": 3},
        "terms = 3: method ancf takes no number of terms; methods that do: assumed-modes,"
        " power-series, chebyshev",
    ),
    (
        {"method": "ancf", "softening": False},
        "softening = False: method ancf takes no switched-off term; methods that do: auto, foac,"
        " zoac",
    ),
    (
        {"method": "power-series", "coriolis": True},
        "coriolis = True: method power-series takes no Coriolis forces; methods that do:"
        " auto, ancf, linear, foac, zoac, assumed-modes",
    ),
    (
        {"strain": "gren"},
        f"strain = 'gren': must be one of {LAWS}; did you mean 'green'?",
    ),
    ({"metod": "auto"}, "unknown option 'metod': did you mean 'method'?"),
    ({"zzz": 1}, "unknown option 'zzz': known: modes, method"),
]


@pytest.mark.parametrize(("options", "message"), WRONG)
def test_wrong_options_are_named(options, message):
    """The error names the option, the value and what is allowed; the same for one beam, for many
    and for loci."""
    for function, *arguments in (
        (solve, BEAM),
        (solve_many, [BEAM]),
        (loci, BEAM, "gamma", [1, 2]),
    ):
        with pytest.raises(InvalidInput) as caught:
            function(*arguments, **options)
        assert str(caught.value).startswith(message)


def test_the_keywords_of_solve_are_the_options():
    """In their order, with their types and defaults; help() documents each."""
    keywords = list(inspect.signature(solve).parameters.values())[1:-1]
    shown = [(one.name, one.annotation, one.default) for one in keywords]
    kinds = {name: one.kind | float if one.partial else one.kind for name, one in OPTIONS.items()}
    assert shown == [(one.name, kinds[one.name], one.default) for one in OPTIONS.values()]
    for function in (solve, solve_many):
        lines = inspect.getdoc(function).splitlines()
        assert [one.name for one in OPTIONS.values() if one.documentation not in lines] == []


@pytest.mark.parametrize("name", OPTIONS)
def test_the_declared_values_of_an_option_are_those_accepted(name):
    """All choices, both ends of a range, and nothing beyond."""
    option = OPTIONS[name]
    values, beyond = list(option.choices), ["", "none"]
    if option.limits:
        values, beyond = list(option.limits), [option.limits[0] / 2, option.limits[1] * 2]
    elif option.kind is bool:
        values, beyond = [False, True], [0, 1, "yes"]
        if option.partial:
            values, beyond = [False, True, 0, 0.3, 1], [-0.1, 1.1, "yes"]
    for value in values:
        assert getattr(parse_keywords(**{name: value}), name) == value
    for value in beyond:
        with pytest.raises(InvalidInput):
            solve(Beam(), **{"method": option.methods[-1], name: value})


def test_every_method_has_a_source_and_a_reason():
    """The table says where a method comes from and when to choose it."""
    assert all(method.source and method.choose for method in METHODS.values())


def test_every_method_accepts_coriolis_out_of_plane():
    """Flapwise there are no Coriolis forces to treat."""
    options = {"method": "chebyshev", "plane": "flapwise"}
    with_them = solve(BEAM, coriolis=True, **options)
    assert with_them.frequencies.tolist() == solve(BEAM, **options).frequencies.tolist()


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_without_softening_every_square_is_higher_by_gamma_squared(plane):
    """The softening is a multiple of the mass; flapwise bending has none to leave out."""
    options = {"modes": 6, "plane": plane, "tolerance": 1e-10}
    whole, without = (solve(SWITCHED, softening=on, **options) for on in (True, False))
    for family, soft in (("bending", plane == "chordwise"), ("stretching", True)):
        a, b = (one.omega_squared[np.array(one.families) == family] for one in (whole, without))
        np.testing.assert_allclose(b, a + SWITCHED.gamma**2 * soft, rtol=1e-9 * soft)


def test_without_stiffening_a_slender_beam_softens_only():
    """A beam too stiff to stretch keeps its modes at rest: omega^2 = omega_0^2 - gamma^2, which is
    what zoac says, and falls to zero at gamma = 3.516."""
    rest = solve(Beam(), tolerance=1e-10).frequencies[0]
    turning = Beam(gamma=3, mu=1e4)
    without = solve(turning, stiffening=False, tolerance=1e-10).frequencies[0]
    assert without**2 == pytest.approx(rest**2 - 9, rel=1e-5)
    assert solve(turning, method="zoac").frequencies[0] == pytest.approx(without, rel=1e-5)
    assert solve(Beam(gamma=3.52, mu=1e4), stiffening=False).equilibrium.status == "unstable"


def test_rigid_tension_without_stiffening_is_no_coupling():
    """foac without its tension is zoac."""
    a = solve(SWITCHED, method="foac", stiffening=False)
    b = solve(SWITCHED, method="zoac")
    np.testing.assert_array_equal(a.omega_squared, b.omega_squared)


@pytest.mark.parametrize("softening", [True, False])
def test_coriolis_forces_with_and_without_softening(softening):
    """Frequencies are those of the uncoupled modes with the gyroscopic term between them."""
    apart = solve(SWITCHED, modes=20, softening=softening)
    x = (GAUSS + 1) / 4
    x, w = np.append(np.append(x, x + 0.5), 0.5), np.append(np.tile(WEIGHTS / 4, 2), SWITCHED.alpha)
    u, v = np.moveaxis(apart.displacement(x), 1, 0)
    C = 2 * SWITCHED.gamma * (v.T @ (w[:, None] * u) - u.T @ (w[:, None] * v))
    n = len(C)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(apart.omega_squared), -C]])
    expected = np.sort(np.linalg.eigvals(A).imag)[n : n + 3]
    coupled = solve(SWITCHED, modes=3, coriolis=True, softening=softening).frequencies
    np.testing.assert_allclose(coupled, expected, rtol=2e-3)


def test_a_part_of_the_coriolis_forces():
    """From none to all of them frequencies change without a jump, by every method that has them;
    to first order with the square of the factor."""
    numbers, factors = {"alpha": 1, "beta": 0.5, "gamma": 10}, (0, 0.01, 0.02, 1)
    for options in ({}, {"method": "ancf"}, {"plane": "both"}):
        rows = [solve(Beam(**numbers), coriolis=factor, **options) for factor in factors]
        first = [row.frequencies[0] for row in rows]
        assert (first[2] - first[0]) == pytest.approx(4 * (first[1] - first[0]), rel=1e-3)
        whole = solve(Beam(**numbers), coriolis=True, **options)
        assert first[3] == whole.frequencies[0]
    bent = [
        solve(Beam(gamma=4, delta=-1), state="stable", coriolis=factor) for factor in (0, 0.3, 1)
    ]
    assert bent[0].frequencies[0] > bent[1].frequencies[0] > bent[2].frequencies[0]
    assert Problem(coriolis=0.3).described.endswith("with 0.3 of Coriolis")


@pytest.mark.parametrize(
    ("numbers", "options"),
    [
        ({"alpha": 1, "beta": 1, "gamma": 4.6}, {}),  # inside a veering
        ({"alpha": 1, "beta": 0.5, "gamma": 30, "delta": 1}, {}),
        ({"gamma": 10, "flap": 0.25, "pitch": 30}, {"plane": "both"}),
        ({"gamma": 4, "delta": -1}, {"state": "stable"}),  # deflected
    ],
)
def test_error_bars_with_a_part_of_the_coriolis_forces(numbers, options):
    """At a loose tolerance each holds the distance to the answer at a fine one."""
    for factor in (0.05, 0.5):
        loose = solve(Beam(**numbers), coriolis=factor, tolerance=1e-2, **options)
        fine = solve(Beam(**numbers), coriolis=factor, tolerance=1e-11, **options)
        distance = np.abs(loose.frequencies - fine.frequencies)
        assert (distance <= loose.errors + fine.errors).all()
