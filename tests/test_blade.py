"""Properties along the span and bodies: what is stored, and what is refused."""

import json
import math
import pickle

import numpy as np
import pytest

from beamviz import Beam, Blade, InvalidInput, Mass
from beamviz.beam import from_record

JUMP = Blade(x=(0, 0.5, 0.5, 1), mass=(1, 1, 0.5, 0.5), bending=(1, 1, 0.3, 0.2), axial=(1,) * 4)


def test_properties_are_linear_between_stations_and_jump_where_one_is_named_twice():
    """A jump has at its place the value toward the tip."""
    assert JUMP.breaks == (0, 0.5, 1)
    assert JUMP.at("bending", [0, 0.25, 0.5, 0.75, 1]) == pytest.approx([1, 1, 0.3, 0.25, 0.2])
    assert JUMP.at("flap", [0.75]) == pytest.approx([0.25])


def test_a_taper_is_a_polynomial():
    """To rounding, at points that are no stations."""
    x = np.linspace(0, 1, 11)
    blade = Blade.tapered(height=0.5, width=0.2)
    height, width = 1 - 0.5 * x, 1 - 0.2 * x
    assert blade.at("bending", x) == pytest.approx(width * height**3, rel=1e-13)
    assert blade.at("mass", x) == pytest.approx(width * height, rel=1e-13)
    assert blade.breaks == (0, 1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x": (0, 0.5, 0.9)}, "must ascend from 0 at the root to 1 at the tip"),
        ({"mass": (1, 1)}, "mass of a blade: 2 values, 3 stations"),
        ({"axial": (2, 1, 1)}, "axial of a blade = 2 at the root: must be 1"),
        ({"bending": (1, -1, 1)}, "bending of a blade = -1: must lie in"),
        ({"degree": 3}, "fewer than 4 different stations"),
        ({"flap": "abc"}, "flap of a blade = 'abc': must be a sequence"),
    ],
)
def test_an_impossible_blade_is_refused_by_name(changes, message):
    """The property, its value and what it has to be."""
    row = (1.0, 1.0, 1.0)
    values = {"x": (0, 0.5, 1), "mass": row, "bending": row, "axial": row} | changes
    with pytest.raises(InvalidInput, match=message):
        Blade(**values)


def test_a_polynomial_below_zero_is_refused():
    """Though it is positive at the stations."""
    row = (1, 0.001, 1)
    with pytest.raises(InvalidInput, match="not above 0 everywhere"):
        Blade((0, 0.6, 1), mass=row, bending=(1, 1, 1), axial=(1, 1, 1), degree=2)


def test_a_beam_has_its_bodies_from_the_root_outward():
    """The concentrated mass is one of them; the whole is hashable and pickles."""
    beam = Beam(alpha=1, beta=0.7, blade=JUMP, masses=[Mass(2, 0.3, (0.1, 0.1, 0.2))], root=5)
    assert [body.beta for body in beam.bodies] == [0.3, 0.7]
    assert not beam.is_uniform
    assert pickle.loads(pickle.dumps(beam)) == beam
    assert len({beam, beam.replace()}) == 1
    assert Beam(alpha=1).is_uniform
    assert not Beam(root=0).is_uniform
    for wrong in ({"root": -1}, {"root": math.nan}, {"masses": [3]}, {"blade": 1}):
        with pytest.raises(InvalidInput, match=next(iter(wrong))):
            Beam(**wrong)


def test_a_beam_is_described_on_one_line():
    """Its numbers, and in words what is not uniform; nothing that is as usual."""
    assert repr(Beam(alpha=1)) == "Beam(alpha=1.0, beta=1.0, gamma=0.0, delta=0.0, mu=70.0)"
    beam = Beam(gamma=2, blade=JUMP, masses=[Mass(2, 0.3)], root=0)
    assert beam.described(["gamma"]) == "γ = 2, a blade of 4 stations, 1 mass, hinged root"
    assert "blade=<Blade of 4 stations: mass 1 .. 0.5, bending 1 .. 0.2, axial" in repr(beam)
    assert len(repr(beam)) < 300


def test_a_record_is_plain_and_makes_the_beam_again():
    """In the types of JSON; a mistyped or missing key is named."""
    beam = Beam(gamma=2, blade=Blade.tapered(0.5), masses=[Mass(2, 0.3, (0.1, 0.1, 0.2))], root=0)
    record = json.loads(json.dumps(beam.record))
    assert Beam.from_record(record) == beam
    assert Beam.from_record(beam.attributes) == beam
    assert Beam(alpha=1).record == Beam(alpha=1).numbers
    for wrong, message in (
        ({"blade": {"x": [0, 1]}}, "a blade: missing key 'mass'"),
        ({"blade": record["blade"] | {"bendin": []}}, "did you mean 'bending'"),
        ({"masses": [{"alpha": 1}]}, "a mass: missing key 'beta'"),
        ({"masses": [{"alpha": 1, "beta": 1, "J": 1}]}, "unknown key of a mass 'J'"),
    ):
        with pytest.raises(InvalidInput, match=message):
            Beam.from_record(record | wrong)


@pytest.mark.parametrize(
    "record", [{"blade": "x"}, {"masses": "x"}, {"masses": 3}, {"masses": Mass(1, 1)}]
)
def test_a_record_of_something_else_is_refused_by_name(record):
    """As a scene file or a link may have it."""
    with pytest.raises(InvalidInput, match=next(iter(record))):
        Beam(**from_record(record))
