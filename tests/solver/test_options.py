"""Options of solve(), solve_many() and loci(): an error names the value, and what is allowed."""

import math

import pytest

from beamviz import Beam, loci, solve
from beamviz.errors import InvalidInput
from beamviz.solver import METHODS, solve_many

BEAM = Beam(alpha=1, beta=0.5, gamma=3)

WRONG = [
    (
        {"method": "magic"},
        "method = 'magic': must be one of auto, ancf, ancf-planar, linear, foac, zoac,"
        " assumed-modes, power-series, chebyshev",
    ),
    ({"method": []}, "method = []: must be one of auto"),
    ({"strain": "cauchy"}, "strain = 'cauchy': must be one of green, biot, hencky"),
    ({"curvature": "flat"}, "curvature = 'flat': must be one of spatial, material"),
    ({"plane": "diagonal"}, "plane = 'diagonal': must be one of chordwise, flapwise"),
    ({"modes": 0}, "modes = 0: must be a whole number in 1 .. 20"),
    ({"modes": 2.5}, "modes = 2.5: must be a whole number in 1 .. 20"),
    ({"coriolis": "no"}, "coriolis = 'no': must be True or False"),
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
        "elements = 20: method auto takes no number of elements; methods that do: ancf,"
        " ancf-planar, linear",
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
        " auto, ancf, ancf-planar, linear, foac, zoac, assumed-modes",
    ),
    ({"metod": "auto"}, "unknown option 'metod': did you mean 'method'?"),
    ({"zzz": 1}, "unknown option 'zzz': known: modes, method"),
]


@pytest.mark.parametrize(("options", "message"), WRONG)
def test_wrong_options_are_named(options, message):
    """The error names the option, the value and what is allowed; the same for one beam and many."""
    for call in (lambda: solve(BEAM, **options), lambda: solve_many([BEAM], **options)):
        with pytest.raises(InvalidInput) as caught:
            call()
        assert str(caught.value).startswith(message)


def test_wrong_options_of_loci_are_named():
    """By the same messages."""
    for options, message in (WRONG[0], WRONG[-2], WRONG[-1]):
        with pytest.raises(InvalidInput) as caught:
            loci(BEAM, "gamma", [1, 2], **options)
        assert str(caught.value).startswith(message)


def test_every_method_has_a_source_and_a_reason():
    """The table says where a method comes from and when to choose it."""
    assert all(method.source and method.choose for method in METHODS.values())


def test_every_method_accepts_coriolis_out_of_plane():
    """Flapwise there are no Coriolis forces to treat."""
    options = {"method": "chebyshev", "plane": "flapwise"}
    with_them = solve(BEAM, coriolis=True, **options)
    assert with_them.frequencies.tolist() == solve(BEAM, **options).frequencies.tolist()
