"""A scene as TOML: there and back, and every way to get one wrong."""

from dataclasses import replace

import pytest
from helpers import same_beam
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.beam import PARAMETERS, SPIN_UP, Beam
from beamviz.errors import InvalidInput
from beamviz.explorer.features.real_beam import STEEL_BEAM
from beamviz.lessons import lesson
from beamviz.scene import COLOURINGS, UPPER_LIMITS, Camera, Scene, ViewOptions, parse_query
from beamviz.solver.problem import CHOICES
from beamviz.units import Units

REAL = "[si]\n" + "".join(f"{key} = {value}\n" for key, value in STEEL_BEAM.values.items())
FLAGS = (
    *("playing", "rotating_frame", "ghosts", "nodes", "tip_path", "forces", "thicken"),
    *("all_modes", "dark"),
)
points = st.tuples(*[st.floats(-1000, 1000)] * 3)
numbers = {name: st.floats(*one.limits) for name, one in PARAMETERS.items()}
numbers |= {"gamma": st.floats(0, 50), "spin_up": st.just(0.0) | st.floats(*SPIN_UP.limits)}
sizes = st.floats(1e-3, 1e3), st.floats(1e-6, 1e3), st.floats(1e-3, 1e6)
beams = st.builds(Beam, **numbers, units=st.none() | st.builds(Units, *sizes))
looks = st.builds(
    ViewOptions,
    shares=st.lists(st.floats(0, 1), max_size=20),
    colouring=st.sampled_from(COLOURINGS),
    **{name: st.floats(0, limit) for name, limit in UPPER_LIMITS.items()},
    **dict.fromkeys(FLAGS, st.booleans()),
)
models = st.fixed_dictionaries(
    {name: st.sampled_from(sorted(CHOICES[name])) for name in ("strain", "curvature", "plane")},
    optional={"tolerance": st.floats(1e-12, 0.1)},
)
cameras = st.none() | points.flatmap(
    lambda at: points.filter(lambda point: point != at).map(lambda point: Camera(point, at))
)
axes = st.sampled_from(sorted(PARAMETERS))


positive = st.lists(st.floats(1e-6, 1e6), min_size=3, max_size=3)
tables = st.just({}) | st.fixed_dictionaries(
    {"frequency": positive},
    optional={
        "error": positive,
        "mode": st.lists(st.sampled_from(["B1", "S2", "F3"]), min_size=3, max_size=3),
        "beta": st.lists(st.floats(0, 1), min_size=3, max_size=3),
    },
)


@given(st.builds(Scene, beams, models, looks, cameras, axes, st.booleans(), measured=tables))
@settings(max_examples=60)
def test_a_saved_scene_comes_back_as_it_was_and_a_link_shows_it(scene):
    """Through TOML, to the last bit. Every key goes through the query of an address, over the usual
    scene and over that of a lesson; units go with a beam whose mass is known."""
    assert Scene.from_bytes(scene.to_toml().encode(), "scene.toml") == scene
    for base in (Scene(), lesson("veering").scene):
        shown = Scene.from_query(parse_query(scene.to_query(base)), base)
        same_beam(shown.beam, scene.beam)
        assert replace(shown, beam=scene.beam, measured=scene.measured) == scene


def test_a_link_says_only_what_is_not_as_usual():
    """By the names of the keys, a real beam by its sizes, as in a file."""
    assert Scene().to_query() == ""
    assert Scene.of(gamma=3, mode=3, coriolis=True).to_query() == "gamma=3.0&coriolis=true&mode=3"
    scene = Scene.from_bytes(REAL.encode(), "scene.toml")
    assert scene.beam == STEEL_BEAM.beam
    query = parse_query(scene.to_query())
    assert query.keys() == STEEL_BEAM.values.keys()
    shown = Scene.from_query(query).beam
    assert shown.numbers == pytest.approx(scene.beam.numbers, rel=1e-12)
    assert shown.si == pytest.approx(scene.beam.si, rel=1e-12)


def test_a_file_needs_to_say_only_what_is_not_as_usual(tmp_path):
    """Two lines make a scene; `mode` shows one mode alone. Saved, it has one key a line."""
    path = tmp_path / "scene.toml"
    path.write_text("[beam]\ngamma = 10\n[view]\nmode = 3\n")
    scene = Scene.from_toml(path)
    assert scene == Scene.of(gamma=10, mode=3)
    assert scene.view.shares == (0.0, 0.0, 1.0)
    assert Scene.from_bytes(b"", "empty.toml") == Scene()
    lines = scene.to_toml().splitlines()
    tables = [line for line in lines if line.startswith("[")]
    assert tables == ["[beam]", "[model]", "[view]", "[chart]"]
    assert {"gamma = 10.0", "shares = [0.0, 0.0, 1.0]"} <= set(lines)


WRONG = {
    "gamma = 10": ["unknown key 'gamma'", "known: beam, model"],
    "beam = 10": ["beam = 10: must be a table [beam]"],
    "[beams]\nalpha = 1": ["unknown key 'beams'", "known: beam, model"],
    "[beam]\ngama = 1": ["[beam]: unknown key 'gama'", "known: alpha"],
    "[beam]\nalpha = -1": ["alpha = -1: must lie in 0 .. 100"],
    "[beam]\nalpha = 1979-05-27": ["alpha = datetime", "0 .. 100"],
    "[beam]\ngamma = 200\nmu = 10": ["gamma / mu = 20"],
    "[model]\nelements = 20": ["elements = 20", "method auto"],
    "[model]\ncoriolis = 2": ["coriolis = 2"],
    "[view]\nshares = [2]": ["shares = 2: must lie in 0 .. 1"],
    "[view]\nshares = 1": ["shares = 1", "list of at most 20"],
    "[view]\nmode = 0": ["mode = 0", "1 .. 20"],
    "[view]\nmode = 1\nshares = [1]": ["exclude each other"],
    '[view]\ndark = "yes"': ["dark = 'yes'", "true or false"],
    '[view]\ncolouring = "pink"': ["colouring = 'pink'", "displacement, axial strain"],
    "[view]\npace = 9": ["pace = 9: must lie in 0 .. 4"],
    "[camera]\nlook_at = [0, 0, 0]": ["no position"],
    "[camera]\nposition = [0, 1]": ["position = [0, 1]: must be three numbers"],
    "[camera]\nposition = [0, 0, 0]": ["must differ from look_at"],
    "[camera]\nposition = [0, 0, 1e9]": ["position = 1000000000: must lie in -1000 .. 1000"],
    '[chart]\nover = "time"': ["over = 'time'", "alpha, beta"],
    "[chart]\nper_rev = 1": ["per_rev = 1", "true, false or a list of 1, 2"],
    "[chart]\nper_rev = [7]": ["per_rev = [7]", "true, false or a list of 1, 2"],
    "[units]\nlength = 1": ["[units]: missing key 'time'"],
    "[units]\nlength = 1\ntime = 0": ["time = 0: must be above 0"],
    REAL + "[beam]\nalpha = 1": ["[si] and [beam] exclude each other"],
    "[si]\nlength = 1": ["missing key 'density' [kg/m^3]"],
    "[beam": ["not a TOML file"],
    "measured = 1": ["measured = 1: must be a table [measured]"],
    "[measured]\nfrequncy = [1]": ["unknown column 'frequncy'", "frequency"],
    "[measured]\nfrequency = [1, 2]\nmode = [[1], [2]]": ["row 1, mode = '[1]'"],
    "[measured]\nfrequency = [1, -2]": ["measured: row 2, frequency = -2: must be above 0"],
    "[measured]\nfrequency = [1, 2]\ngamma = [3]": ["of the same length"],
    "[measured]\nhertz = [1]": ["hertz needs the size of the beam"],
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_file_is_refused_in_one_sentence(text):
    with pytest.raises(InvalidInput) as refused:
        Scene.from_bytes(text.encode(), "lecture.toml")
    for words in ["lecture.toml", *WRONG[text]]:
        assert words in str(refused.value)


@pytest.mark.parametrize("read", [Beam.from_toml, Scene.from_toml])
def test_a_file_that_cannot_be_read_is_named(tmp_path, read):
    """With a mistake, another encoding, a number too long, nested too deep; too large, a folder, or
    missing."""
    texts = {"syntax": b"length =\n", "encoding": b"\xff\xfe[beam]"}
    texts |= {"number": b"length = 1" + 5000 * b"0", "depth": b"a = " + 5000 * b"[" + b"\n"}
    messages = dict.fromkeys(texts, "not a TOML file")
    messages |= {"large": "larger than 64000 bytes", "folder": "Is a dir", "none": "No such file"}
    for name, text in (texts | {"large": b"#" * 70_000}).items():
        (tmp_path / name).write_bytes(text)
    (tmp_path / "folder").mkdir()
    for name, message in messages.items():
        with pytest.raises(InvalidInput, match=f"{name}: {message}"):
            read(tmp_path / name)
