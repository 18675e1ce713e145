"""The five numbers: their limits, their messages, and the way from and to SI units."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamviz import Beam, BeamvizError, InvalidInput, Units
from beamviz.beam import NUMBERS, PARAMETERS
from beamviz.si import SI_KEYS, SI_REQUIRED

STEEL = {
    "length": 2.0,
    "density": 7850.0,
    "area": 4e-4,
    "second_moment": 1.2e-8,
    "youngs_modulus": 2.1e11,
    "hub_radius": 0.3,
    "rotation_speed": 25.0,
    "mass": 0.5,
    "mass_position": 1.5,
}
LIMITS = {name: one.limits for name, one in PARAMETERS.items()} | {"gamma": (0.0, 50.0)}
INSIDE = {
    name: st.floats(a + 1e-9 * (b - a), b - 1e-9 * (b - a)) for name, (a, b) in LIMITS.items()
}


@given(st.sampled_from(list(NUMBERS)), st.floats() | st.floats(-2, 200))
def test_a_number_is_within_its_limits_or_named(name, value):
    low, high = NUMBERS[name].limits
    if low <= value <= high:
        assert getattr(Beam(**{name: value}), name) == value
        return
    with pytest.raises(InvalidInput) as caught:
        Beam(**{name: value})
    shown = repr(value).removesuffix(".0")
    assert str(caught.value) == f"{name} = {shown}: must lie in {low:g} .. {high:g}"


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        *(
            ({"alpha": x}, f"alpha = {x!r}: must be a number in 0 .. 100")
            for x in ("1", None, True, 1j, [1])
        ),
        ({"alpha": 10**400}, "alpha = inf: must lie in 0 .. 100"),
        ({"alpha": math.nextafter(100, 101)}, "alpha = 100.00000000000001: must lie in 0 .. 100"),
        ({"gamma": 51, "mu": 10}, "gamma / mu = 5.1: must be at most 5 (gamma = 51, mu = 10)"),
        (
            {"alpha": -1, "delta": 30, "gamma": 60, "mu": 10},
            "alpha = -1: must lie in 0 .. 100; delta = 30: must lie in -2 .. 20;"
            " gamma / mu = 6: must be at most 5 (gamma = 60, mu = 10)",
        ),
        (
            {"gamma": 500, "mu": 20},
            "gamma = 500: must lie in 0 .. 200;"
            " gamma / mu = 25: must be at most 5 (gamma = 500, mu = 20)",
        ),
        ({"gamma": 500}, "gamma = 500: must lie in 0 .. 200"),
        ({"gamma": 45, "mu": 5}, "mu = 5: must lie in 10 .. 1e+06"),
        ({"gama": 3}, "unknown number 'gama': did you mean 'gamma'?"),
    ],
)
def test_a_wrong_number_is_named(numbers, message):
    """A text or a truth is no number; an integer too large for a float does not overflow; a value
    just outside does not read like its limit; gamma / mu has a limit of its own, which is told
    beside others unless these would keep it; a mistyped name is answered with the nearest."""
    for make in (Beam, Beam().replace):
        with pytest.raises(InvalidInput) as caught:
            make(**numbers)
        assert str(caught.value) == message
    assert Beam(gamma=50, mu=10).gamma == 50


def test_a_changed_beam_is_a_checked_beam():
    """Its error may be caught as a ValueError or as one of the package; no output shows -0."""
    assert Beam().replace(alpha=3) == Beam(alpha=3)
    with pytest.raises(ValueError, match="delta = -3") as caught:
        Beam().replace(delta=-3)
    assert isinstance(caught.value, BeamvizError)
    assert math.copysign(1, Beam(delta=-0.0).delta) == 1


def test_si_defaults():
    """No mass, no hub and no rotation unless given; a mass without a position is at the tip."""
    needed = dict(list(STEEL.items())[:5])
    assert Beam.from_si(**needed).numbers == pytest.approx(
        {"alpha": 0, "beta": 1, "gamma": 0, "delta": 0, "mu": math.sqrt(4e-4 * 4 / 1.2e-8)}
    )
    assert Beam.from_si(**needed, mass=1.0).beta == 1


@pytest.mark.filterwarnings("ignore::beamviz.ImplausibleInput")
@given(st.fixed_dictionaries(INSIDE), st.floats(1e-3, 1e3), st.floats(1e-6, 1e3), st.floats(1, 1e5))
def test_si_and_back(numbers, length, time, density):
    """A beam of any size with the same five numbers is the same beam, and knows its size; each
    number by its definition in the paper, eq. 45."""
    area = 1e-2 * length**2
    beam = Beam.from_si(
        length=length,
        density=density,
        area=area,
        second_moment=area * (length / numbers["mu"]) ** 2,
        youngs_modulus=density * (length * numbers["mu"] / time) ** 2,
        hub_radius=numbers["delta"] * length,
        rotation_speed=numbers["gamma"] / time,
        mass=numbers["alpha"] * density * area * length,
        mass_position=numbers["beta"] * length,
    )
    assert beam.numbers == pytest.approx(numbers, rel=1e-9, abs=1e-300)
    assert beam.units is not None
    assert (beam.units.length, beam.units.time) == (length, pytest.approx(time, rel=1e-12))


def test_units_of_frequency():
    """One radian per T* of half a second is 2 rad/s, 1/pi Hz; gamma = pi is 60 rpm."""
    units = Units(length=3.0, time=0.5)
    assert units.angular_frequency(1.0) == pytest.approx(2)
    assert units.hertz(1.0) == pytest.approx(1 / math.pi)
    assert units.rpm(math.pi) == pytest.approx(60)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"length": 0}, r"^length = 0: must be above 0$"),
        ({"density": -1}, r"^density = -1: must be 0 or more$"),
        ({"area": math.nan}, r"^area = nan: must be 0 or more$"),
        ({"youngs_modulus": "steel"}, r"^youngs_modulus = 'steel': must be a number, 0 or more$"),
        ({"hub_radius": None}, r"^hub_radius = None: must be a finite number$"),
        ({"mass_position": 2.5}, r"^mass_position = 2.5: must lie in 0 .. 2$"),
        ({"hub_radius": math.inf}, r"^hub_radius = inf: must be finite$"),
        (
            {"rotation_speed": 1e6},
            r"^rotation_speed T\* = gamma = .*: must lie in 0 .. 200; speed of the tip",
        ),
        ({"mass": 1e6}, r"^mass / \(density area length\) = alpha = .*: must lie in 0 .. 100; "),
        ({"second_moment": 1e-3}, r"^length sqrt\(area / second_moment\) = mu = 1.26"),
        ({"density": 1e-300, "area": 1e-30}, r"^density area \[kg/m\] = 0: .* too extreme$"),
        ({"length": 1e300}, r"^T\* \[s\] = inf: the SI values are too extreme$"),
    ],
)
def test_bad_si_values_are_named(change, message):
    """The message names what was given in SI, not only the number that came of it."""
    with pytest.raises(InvalidInput, match=message):
        Beam.from_si(**{**STEEL, **change})


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("rpm", "rotation_rpm"),
        ("lenght", "length"),
        ("E", "youngs_modulus"),
        ("I", "second_moment"),
    ],
)
def test_a_mistyped_si_keyword_gets_the_nearest_name(given, meant):
    """With its unit, as other names are often in other units; also where others are missing."""
    for others in (STEEL, {}):
        with pytest.raises(InvalidInput) as caught:
            Beam.from_si(**others, **{given: 3})
        assert f"{meant!r} [{SI_KEYS[meant]}]" in str(caught.value)


@pytest.mark.parametrize("name", SI_REQUIRED)
def test_a_missing_si_value_is_named(name):
    with pytest.raises(InvalidInput, match=name):
        Beam.from_si(**{key: value for key, value in STEEL.items() if key != name})


def test_toml_holds_the_keywords(tmp_path):
    """A file with the keywords of from_si is the same beam, with or without a byte-order mark."""
    text, file = "".join(f"{name} = {value}\n" for name, value in STEEL.items()), tmp_path / "beam"
    for encoding in ("utf-8", "utf-8-sig"):
        file.write_text(text, encoding)
        assert Beam.from_toml(file) == Beam.from_si(**STEEL)


def test_an_unknown_or_missing_key_is_named(tmp_path):
    file = tmp_path / "beam.toml"
    messages = {"lenght": r"unknown key 'lenght': did you mean 'length' \[m\]\?"}
    messages["length"] = r"missing key 'density' \[kg/m\^3\]"
    for key, message in messages.items():
        file.write_text(f"{key} = 2\n")
        with pytest.raises(InvalidInput, match=f"beam.toml: {message}"):
            Beam.from_toml(file)
