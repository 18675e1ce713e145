"""Bending in both planes at once: a pitch, a twist, and stiffnesses that differ.

The table of frequencies was computed outside this project, by collocation of the coupled equations;
pyBModes 1.19.1 with 80 elements agrees to five digits where the beam is slender.
"""

import pickle

import numpy as np
import pytest

from beamviz import (
    Beam,
    Blade,
    InvalidInput,
    Mass,
    Scene,
    export,
    loci,
    motion,
    screenshot,
    solve,
    solve_many,
)

FLAT = {"mu": 70, "flap": 0.25}
SLENDER = {"mu": 1e4, "flap": 1 / 16}
BODY = Mass(1, 0.6, (0.05, 0.02, 0.06))
STATIONS = np.linspace(0, 1, 8)
TWISTED = Blade(
    tuple(STATIONS),
    tuple(1 - 0.5 * STATIONS),
    tuple((1 - 0.5 * STATIONS) ** 3),
    tuple(1 - 0.5 * STATIONS),
    tuple(0.3 * (1 - 0.6 * STATIONS) ** 3),
    twist=tuple(20 * STATIONS**2),
)

# Frequencies, shares of the kinetic energy in the plane of rotation, frequencies with Coriolis.
TABLE = [
    (
        FLAT | {"pitch": 30, "gamma": 5},
        (3.6103282, 5.8985770, 16.5995884, 25.0133733, 37.1558532),
        (0.957, 0.043, 0.277, 0.723, 0.253),
        (3.5969097, 5.8976465, 16.5969658, 25.0018343, 37.1539402),
    ),
    (
        FLAT | {"pitch": 30, "gamma": 10},
        (4.6045932, 10.7249965, 26.9472786, 32.4060791, 51.2539230),
        (0.996, 0.004, 0.374, 0.625, 0.264),
        (4.5343327, 10.7244106, 26.9264350, 32.3605712, 51.2433325),
    ),
    (
        FLAT | {"twist": 45, "alpha": 1, "beta": 0.5, "gamma": 10},
        (4.3865080, 10.4354982, 20.1817512, 22.5944252, 55.0365770),
        (1, 0, 0.475, 0.525, 0.279),
        (4.2521264, 10.4354954, 20.1361716, 22.5398850, 55.0253989),
    ),
    (
        SLENDER | {"twist": 60},
        (0.8894909, 2.8671378, 6.8285560, 13.2378677, 25.3871095),
        (0.040, 0.883, 0.267, 0.466, 0.627),
        (0.8894909, 2.8671378, 6.8285560, 13.2378677, 25.3871095),
    ),
    (
        SLENDER | {"twist": 90},
        (0.9021929, 2.4903090, 7.9115598, 11.9044495, 26.1494153),
        (0.085, 0.862, 0.507, 0.465, 0.752),
        (0.9021929, 2.4903090, 7.9115598, 11.9044495, 26.1494153),
    ),
]
DIGITS = 1e-6  # of frequencies with Coriolis: the source has seven digits, the last is not rounded


def both(beam, **options):
    return solve(beam, plane="both", **options)


@pytest.mark.parametrize(("numbers", "frequencies", "shares", "with_coriolis"), TABLE)
def test_the_table(numbers, frequencies, shares, with_coriolis):
    """By `auto` to its digits, by the cubic elements to their error."""
    beam = Beam(**numbers)
    solution = both(beam, tolerance=1e-9)
    assert solution.frequencies == pytest.approx(frequencies, abs=6e-8)
    assert solution.in_plane_fraction == pytest.approx(shares, abs=6e-4)
    gyroscopic = both(beam, tolerance=1e-9, coriolis=True)
    assert gyroscopic.frequencies == pytest.approx(with_coriolis, abs=DIGITS)
    elements = both(beam, method="ancf", elements=40, coriolis=True)
    assert (abs(elements.frequencies - gyroscopic.frequencies) <= 1.01 * elements.errors).all()
    assert elements.frequencies == pytest.approx(with_coriolis, rel=1e-4)


@pytest.mark.parametrize("coriolis", [False, True])
def test_without_a_turned_section_the_planes_are_those_of_two_solves(coriolis):
    """Also with the labels, the errors and the shapes of these; a section that bends as easily in
    every direction may be turned."""
    beam = Beam(gamma=10, delta=0.5, flap=0.25)
    chordwise = solve(beam, coriolis=coriolis, modes=10)
    flapwise = solve(beam, plane="flapwise", modes=10)
    solution = both(beam, coriolis=coriolis, modes=6)
    k = dict(zip(solution.labels, range(6), strict=True))
    for label, partner, of_plane, component in (
        ("L1", "B1", chordwise, 1),
        ("L2", "B2", chordwise, 1),
        ("F1", "B1", flapwise, 2),
        ("F2", "B2", flapwise, 2),
    ):
        j = of_plane.labels.index(partner)
        assert solution.frequencies[k[label]] == pytest.approx(of_plane.frequencies[j], rel=1e-7)
        shape = solution.shape(k[label], [0.3, 1.0])
        assert shape[:, component] == pytest.approx(of_plane.shape(j, [0.3, 1.0])[:, 1], rel=1e-5)
        assert not shape[:, 3 - component].any()
    assert set(solution.in_plane_fraction) == {0.0, 1.0}
    round_beam = Beam(gamma=10, delta=0.5)
    pitched = round_beam.replace(pitch=30, twist=70)
    given = both(round_beam, coriolis=coriolis).frequencies
    assert both(pitched, coriolis=coriolis).frequencies == pytest.approx(given, rel=1e-12)
    in_plane = solve(round_beam, coriolis=coriolis)
    assert solve(pitched, coriolis=coriolis).frequencies == pytest.approx(in_plane.frequencies)


@pytest.mark.parametrize("numbers", [{"gamma": 8}, {"gamma": 3, "delta": -0.5, "alpha": 1}])
def test_a_pitch_of_90_degrees_exchanges_the_stiffnesses(numbers):
    """A section turned from its flat side onto its edge: in units of the other stiffness."""
    edge = both(Beam(**numbers, flap=0.25, pitch=90)).omega_squared
    stiffer = {name: 2 * value if name == "gamma" else value for name, value in numbers.items()}
    upright = both(Beam(**stiffer, mu=140, flap=4)).omega_squared / 4
    assert edge == pytest.approx(upright, rel=1e-6)
    assert both(Beam(**numbers, flap=0.25, pitch=180)).omega_squared == pytest.approx(
        both(Beam(**numbers, flap=0.25)).omega_squared, rel=1e-6
    )


@pytest.mark.parametrize("coriolis", [False, True])
def test_bodies_turn_with_the_section(coriolis):
    """A round beam with a body that is not: turned by 90 degrees its moments change places; in
    between it couples the planes. The elements agree."""
    turned = Beam(gamma=4, delta=0.3, masses=(BODY,), pitch=90)
    Jx, Jy, Jz = BODY.inertia
    swapped = Beam(gamma=4, delta=0.3, masses=(Mass(1, 0.6, (Jx, Jz, Jy)),))
    given = both(swapped, coriolis=coriolis).frequencies
    assert both(turned, coriolis=coriolis).frequencies == pytest.approx(given, rel=1e-6)
    pitched = turned.replace(pitch=30)
    found = both(pitched, coriolis=coriolis)
    assert ((found.in_plane_fraction > 0.001) & (found.in_plane_fraction < 0.999)).any()
    elements = both(pitched, coriolis=coriolis, method="ancf", elements=60)
    assert elements.frequencies == pytest.approx(found.frequencies, rel=1e-4)


@pytest.mark.parametrize("method", ["auto", "ancf", "linear"])
def test_a_hinge_on_the_axis(method):
    """In the plane of rotation nothing holds it; out of it the rigid rotation swings once in a
    revolution. At rest both are free."""
    beam = Beam(gamma=5, root=0, flap=0.25, pitch=20, mu=1e4)
    frequencies = both(beam, method=method).frequencies
    assert frequencies[:2] == pytest.approx([0.0, 5.0], abs=1e-3 if method == "linear" else 1e-5)
    assert both(beam.replace(gamma=0), method=method).frequencies[:2].tolist() == [0.0, 0.0]


def test_a_blade_with_a_table_of_twist():
    """By the default method as by 80 elements; its twist goes through JSON and a pickle."""
    beam = Beam(gamma=4, delta=0.3, blade=TWISTED, pitch=10)
    solution = both(beam, coriolis=True)
    elements = both(beam, coriolis=True, method="ancf", elements=80)
    assert elements.frequencies == pytest.approx(solution.frequencies, rel=1e-6)
    again = Beam.from_record(beam.record)
    assert both(again, coriolis=True).frequencies.tolist() == solution.frequencies.tolist()
    kept = pickle.loads(pickle.dumps(solution))
    assert kept.shape(1, [0.2, 1.0]).tolist() == solution.shape(1, [0.2, 1.0]).tolist()
    assert dict(solution.to_xarray().sizes)["component"] == 3
    assert "pitch=10" in repr(solution)


@pytest.mark.parametrize(
    ("numbers", "options", "message"),
    [
        (FLAT | {"pitch": 30}, {}, "pitch = 30: a turned section .* use plane='both'"),
        (FLAT | {"twist": 30}, {"plane": "flapwise"}, "twist = 30: .* use plane='both'"),
        ({"blade": TWISTED}, {}, "the twist of the blade: .* use plane='both'"),
        ({}, {"plane": "both", "method": "foac"}, "method foac: .* one plane"),
        ({}, {"plane": "both", "state": "stable"}, "state = 'stable': a deflected state"),
        ({"spin_up": 3}, {"plane": "both"}, "spin_up = 3: .* plane of rotation only"),
        ({"pitch": 181}, {}, "pitch = 181: must lie in -180 .. 180"),
        ({"flap": 0}, {}, "flap = 0: must lie in 0.0001 .. 10000"),
        ({"flap": 2, "blade": TWISTED}, {}, "flap = 2: .* a blade has its own"),
        ({"flap": 0.5}, {"plane": "flapwise", "method": "chebyshev"}, "as stiff out of the plane"),
    ],
)
def test_what_is_refused(numbers, options, message):
    """In one line that names the value and the remedy."""
    with pytest.raises(InvalidInput, match=message):
        solve(Beam(**numbers), **options)


def test_a_motion_refuses_a_turned_section():
    with pytest.raises(InvalidInput, match="pitch = 10"):
        motion(Beam(**FLAT, pitch=10), 1.0)


def test_the_flapwise_plane_has_its_own_stiffness():
    """In units of which the beam is as any other; the chordwise plane does not see it."""
    flat = solve(Beam(gamma=6, flap=0.25), plane="flapwise")
    other = solve(Beam(gamma=12, mu=140), plane="flapwise")
    assert flat.frequencies == pytest.approx(other.frequencies / 2, rel=1e-6)
    assert solve(Beam(gamma=6, flap=0.25)).frequencies.tolist() == (
        solve(Beam(gamma=6)).frequencies.tolist()
    )


def test_flap_and_lag_cross_without_a_pitch_and_veer_with_one():
    """In proportion to the pitch; and the labels follow the loci."""
    gaps = []
    for pitch in (0.0, 0.1, 1.0):
        beam = Beam(**FLAT, pitch=pitch)
        (event,) = loci(beam, "gamma", np.linspace(0, 10, 11), plane="both").events
        assert event.kind == ("veering" if pitch else "crossing")
        assert event.branches == ("F1", "L1")
        assert event.at == pytest.approx(3.0754, abs=1e-3)
        gaps.append(event.gap)
    assert gaps[2] == pytest.approx(10 * gaps[1], rel=1e-3)
    assert gaps[0] == 0


@pytest.mark.parametrize("over", ["pitch", "twist", "flap"])
def test_loci_over_the_section(over):
    """Are those of single solves."""
    beam, values = Beam(gamma=5, flap=0.25, pitch=10), np.array([0.3, 1.5])
    found = loci(beam, over, values, plane="both")
    answers = solve_many([beam.replace(**{over: value}) for value in values], plane="both")
    for k, answer in enumerate(answers):
        rows = sorted(branch.frequency[k] for branch in found.branches if branch.mode_index[k] >= 0)
        assert rows == pytest.approx(answer.frequencies, rel=1e-6)
    assert found.branches[0].in_plane_fraction.shape == (2,)
    assert "in_plane_fraction" in found.to_xarray()


def test_si():
    """A pitch, a twist along stations, and both ways."""
    stations = {"stations": [0.0, 1.0, 2.0], "mass_per_length": 3.0, "axial_stiffness": 1e7}
    stiff = {"bending_stiffness": [2000.0, 1500.0, 1000.0], "flap_stiffness": 500.0}
    beam = Beam.from_si(**stations, **stiff, twist=[12.0, 5.0, 0.0], pitch=3.0)
    assert beam.pitch == 3
    assert beam.blade.twist == (12, 5, 0)
    again = Beam.from_si(**beam.si)
    frequencies = both(beam).frequencies
    assert both(again).frequencies == pytest.approx(frequencies, rel=1e-9)
    with pytest.raises(InvalidInput, match="twist: 2 values, 3 stations"):
        Beam.from_si(**stations, **stiff, twist=[1.0, 2.0])


def test_files_of_both_planes(tmp_path):
    """Tables and arrays have all three components, and a picture shows them."""
    scene = Scene.of(Beam(**FLAT, gamma=5, pitch=30), plane="both")
    export(tmp_path / "numbers.npz", scene)
    arrays = np.load(tmp_path / "numbers.npz")
    assert arrays["shapes"].shape[::2] == (5, 3)
    assert arrays["in_plane_fractions"] == pytest.approx(TABLE[0][2], abs=6e-4)
    export(tmp_path / "numbers.csv", scene)
    assert "F1 out of plane" in (tmp_path / "numbers.shapes.csv").read_text()
    screenshot(tmp_path / "picture.png", scene)
    assert (tmp_path / "picture.png").stat().st_size > 1000
    again = Scene.from_bytes(scene.to_toml().encode(), "scene.toml")
    assert again.beam == scene.beam
    assert again.options["plane"] == "both"
