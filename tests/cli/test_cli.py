"""The command line: what it prints, where, and the exit code of every kind of end; also as a
process of its own, with its pipes."""

import csv
import io
import math
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers import slow, strict

from beamviz import Beam, __version__, export, solve
from beamviz.beam import NUMBERS
from beamviz.cli.commands import app
from beamviz.errors import InvalidInput, NoEquilibrium, NotConverged
from beamviz.lessons import lesson
from beamviz.scene import START, Scene
from beamviz.solver.problem import CHOICES, OPTIONS
from beamviz.tables import significant_decimals as decimals

ROOT = Path(__file__).parents[2]
PAPER = ("--alpha", "1", "--beta", "0.5", "--gamma", "10")  # physics: green, spatial, mu 70


def test_modes_as_json(run):
    """Every key that programs rely on, with the published frequencies."""
    code, out, err = run("modes", *PAPER, "--format", "json")
    data = strict(out)
    assert (code, err) == (0, "")
    assert data["beam"] == {"alpha": 1, "beta": 0.5, "gamma": 10, "delta": 0, "mu": 70}
    model = {"method": "auto", "strain": "green", "curvature": "spatial", "coriolis": False}
    model |= {"plane": "chordwise", "state": "straight", "stiffening": True, "softening": True}
    assert data["model"] == model
    keys = {"status", "buckled_chordwise", "shape", "iterations", "tip", "max_stretch"}
    keys |= {"root_force", "root_shear", "root_moment"}
    assert data["equilibrium"].keys() == keys
    assert data["equilibrium"]["status"] == "stable"
    assert data["stats"].keys() >= {"dof", "seconds"}
    found = [(mode.pop("index"), mode.pop("label")) for mode in data["modes"]]
    assert found == [(1, "B1"), (2, "B2"), (3, "S1"), (4, "B3"), (5, "B4")]
    frequencies = [mode.pop("frequency") for mode in data["modes"]]
    expected = [4.3905981, 22.0954901, 76.8632663, 78.3525694, 111.1520304]
    assert frequencies == pytest.approx(expected, rel=1e-6)
    assert data["modes"][2].keys() == {"family", "error", "bending_fraction", "nodes"}


def test_a_factor_of_the_coriolis_forces(run):
    """A number in JSON between the two switches, a truth value at its ends; out of range or beside
    the switch it is an error, and so with a motion, which has the whole of them."""
    first = []
    for given, told in (("0", False), ("0.3", 0.3), ("1", True)):
        code, out, _ = run("modes", *PAPER, "--coriolis-factor", given, "--format", "json")
        data = strict(out)
        assert (code, data["model"]["coriolis"]) == (0, told)
        first.append(data["modes"][0]["frequency"])
    assert first == sorted(first, reverse=True)
    for command, words, message in (
        ("modes", ("1.5",), "--coriolis-factor = 1.5: must lie in 0 .. 1"),
        ("modes", ("0.3", "--coriolis"), "--coriolis-factor 0.3 and --coriolis exclude each other"),
        ("motion", ("0.3", "--until", "1"), "--coriolis-factor: a motion in time has the whole"),
    ):
        code, _, err = run(command, "--coriolis-factor", *words)
        assert code == 2
        assert message in err


@pytest.mark.parametrize(("first", "shown"), [(1.0, 0.25), (40.0, 40.0)])
def test_the_time_of_modes_is_without_the_first_imports(run, monkeypatch, first, shown):
    """That of a second solve, unless the first has taken so long that they hardly count."""
    for form, expected in (("json", f'"seconds": {shown}'), ("table", f", {1000 * shown:.3g} ms")):
        seconds = iter((first, 0.25))

        def timed(beam: Beam, seconds=seconds, **options: Any):
            solution = solve(beam, **options)
            solution.stats.seconds = next(seconds)
            return solution

        monkeypatch.setattr("beamviz.solver.solve", timed)
        assert expected in run("modes", "--format", form)[1]


def test_modes_in_si_and_as_csv(run, steel):
    """A file in SI gives Hz and rad/s too: those of the bar's dimensionless frequency. The CSV says
    the same as the JSON, one line for each mode, to full precision."""
    beam, command = Beam.from_toml(steel), ("modes", "--si", steel, "--modes", "3", "--format")
    assert beam.units is not None
    data = strict(run(*command, "json")[1])
    assert data["beam"] == beam.numbers
    assert data["units"] == {"length": 2, "time": beam.units.time, "mass": beam.units.mass}
    rows = list(csv.DictReader(io.StringIO(run(*command, "csv")[1])))
    assert len(rows) == 3
    for row, mode in zip(rows, data["modes"], strict=True):
        assert mode["rad_per_s"] == pytest.approx(mode["frequency"] / beam.units.time, rel=1e-14)
        assert mode["hertz"] == pytest.approx(mode["rad_per_s"] / (2 * math.pi), rel=1e-14)
        assert (row["label"], row["growth_rate"]) == (mode["label"], "")
        for name in ("frequency", "error", "bending_fraction", "hertz", "rad_per_s"):
            assert float(row[name]) == mode[name]
        assert [float(x) for x in row["nodes"].split()] == mode["nodes"]


BUCKLED = "--delta -1 --gamma 5"
LOCI = "loci --over gamma --start 0 --stop"
# By all commands with a beam: the whole beam and the whole model.
SHARED = [name.replace("_", "-") for name in (*NUMBERS, *OPTIONS, "si") if name != "modes"]
NARROW = r"\A([ -~]{,100}\n)+\Z"
SHOWN = {  # regular expressions of lines
    "": ["modes", "serve", "screenshot"],
    "--help": ["modes", "serve", "screenshot"],
    **{
        f"{command} --help": [f"--{name}\\b" for name in SHARED]
        for command in ("modes", "serve", "screenshot")
    },
    f"modes {' '.join(PAPER)}": [
        "alpha 1, beta 0.5, gamma 10, delta 0, mu 70", "stable", "S1", r"76\.86326", NARROW,
    ],
    # The terms that are solved, not those asked for that a plane or a method does not have.
    "modes --coriolis": ["green strain, spatial curvature, chordwise, with Coriolis$"],
    "modes --coriolis --plane flapwise": ["Model .*flapwise, without Coriolis$"],
    "modes --method zoac": ["Model .*chordwise, without Coriolis, without stiffening$"],
    "modes --si STEEL": [r"\[Hz\]", "238.7324 rpm"],  # 25 rad/s
    f"modes {BUCKLED}": ["unstable"],
    # The first mode grows and has no frequency.
    f"modes {BUCKLED} --format csv": ["^1,B1,bending,,4.708"],
    f"modes {BUCKLED} --format json": [
        '"status": "unstable"', r'"frequency": null,\s+"growth_rate": 4\.7084',
        r'"B2",\s+"family": "bending",\s+"frequency": 20[.\d]+,\s+"error"',
    ],
    # At most 21 values; a family other than the label's is marked.
    f"{LOCI} 10 --alpha 1 --coriolis": [
        r"^Frequencies \[1/T\*\], one value in 10 \(--format csv has all\)$",
        r"veering +B3 S1 +4\.650\d{3} +61\.297\d\d +0\.241 +1\.000",
        r"61\.\d+ s +62\.\d+ b",
        r"^ *gamma .*\n(?: +\d+(?:\.\d)?  .*\n){21}(?! +\d)",
    ],
    f"{LOCI} 8 --points 5 --delta -1": [
        r"divergence for gamma = 2\.99604 \.\. 8", r"No crossing or veering in this range\.",
        "^ +8 +unstable ",
    ],
    f"{LOCI} 20 --points 3 --si STEEL --per-rev 2": ["rpm ", "resonance 2x"],
}  # fmt: skip


@pytest.mark.parametrize("line", SHOWN)
def test_a_person_finds_what_to_look_for(run, steel, monkeypatch, line):
    """The commands and options; the beam, its model and equilibrium, frequencies, events."""
    monkeypatch.setenv("COLUMNS", "120")
    code, out, err = run(*line.replace("STEEL", steel).split())
    assert (code, err) == (0, "")
    assert [words for words in SHOWN[line] if not re.search(words, out, re.MULTILINE)] == []


@pytest.mark.parametrize(
    ("error", "places"), [(3e-7, 7), (1e-7, 7), (0.2, 1), (5, 0), (1e-15, 9), (math.nan, 9), (0, 9)]
)
def test_a_frequency_shows_the_digits_its_error_leaves(error, places):
    """The last digit shown is the first one in doubt."""
    assert decimals(error) == places


@pytest.mark.parametrize(
    "options",
    [
        {"strain": "hencky", "curvature": "material", "plane": "flapwise", "tolerance": 1e-3},
        {"method": "ancf", "elements": 8, "modes": 3},
        {"method": "chebyshev", "terms": 24},
        {"coriolis": True, "state": "stable"},
        {"stiffening": False, "softening": False},
    ],
    ids=str,
)
def test_every_option_reaches_the_solver(run, options):
    """The frequencies and the size are those of `solve` with the same option."""
    words = [
        *(f"--{name}={value}" for name, value in options.items() if not isinstance(value, bool)),
        *(f"--{name}" for name, value in options.items() if value is True),
        *(f"--no-{name}" for name, value in options.items() if value is False),
    ]
    data = strict(run("modes", *PAPER, *words, "--format", "json")[1])
    solution = solve(Beam(alpha=1, beta=0.5, gamma=10), **options)
    assert data["model"] == solution.problem.model
    assert data["stats"]["dof"] == solution.stats.dof
    assert [mode["frequency"] for mode in data["modes"]] == solution.frequencies.tolist()


@pytest.mark.parametrize(
    ("line", "advice", "in_python"),
    [
        ("--spin-up 2", "--state stable", "state='stable'"),
        ("--state bent --method linear", "--method auto", "method='auto'"),
        ("--spin-up 2 --state stable --plane flapwise", "--plane chordwise", "plane='chordwise'"),
    ],
)
def test_advice_is_in_the_syntax_of_its_reader(run, line, advice, in_python):
    """The command line names its own options, Python its keywords."""
    code, _, err = run("modes", *line.split())
    assert code == 2
    assert advice in err
    assert in_python not in err
    words = line.split()
    given = {a[2:].replace("-", "_"): b for a, b in zip(words[::2], words[1::2], strict=True)}
    beam = Beam(spin_up=float(given.pop("spin_up", 0)))
    with pytest.raises(InvalidInput) as caught:
        solve(beam, **given)
    assert in_python in str(caught.value)
    assert in_python in str(pickle.loads(pickle.dumps(caught.value)))


@pytest.mark.parametrize("command", ["modes --gamma 50", "loci --over gamma --start 99 --stop 110"])
def test_no_equilibrium_gives_its_limit(run, command):
    """Exit code 3 with the largest gamma that has an equilibrium (hencky, alpha 0: 45.420)."""
    code, out, err = run(*command.split(), "--strain", "hencky", "--format", "json")
    error = strict(out)["error"]
    assert (code, error["kind"]) == (3, "no-equilibrium")
    assert error["limit"] == pytest.approx(45.420, abs=5e-4)
    assert "no equilibrium beyond gamma = 45.42" in err


@pytest.mark.parametrize(
    ("error", "code", "kind", "line"),
    [
        (NoEquilibrium("at no gamma", limit=math.nan), 3, "no-equilibrium", "at no gamma"),
        (NotConverged("not within 1e-12"), 4, "not-converged", "not within 1e-12"),
        (ZeroDivisionError("by\nzero"), 1, "internal", "unexpected ZeroDivisionError: by zero"),
    ],
)
def test_every_failure_has_its_code_and_one_line(run, monkeypatch, error, code, kind, line):
    """What physics, numerics or a fault of the program prevents is told apart, without a traceback;
    a limit that is not a number is null, as JSON has no NaN."""

    def fail(*_, **__):
        raise error

    monkeypatch.setattr("beamviz.solver.solve", fail)
    found, out, err = run("modes", "--format", "json")
    assert (found, err) == (code, f"beamviz: {line}\n")
    error = strict(out)["error"]
    assert (error["kind"], error.get("limit")) == (kind, None)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("function", ["beamviz.solver.solve", "beamviz.cli.commands.app"])
def test_a_signal_is_one_line(run, monkeypatch, interruptible, function, number):
    """With the shell's own code for it."""
    monkeypatch.setattr(function, lambda *_, **__: signal.raise_signal(number))
    line = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}[number]
    assert run("modes") == (128 + number, "", f"beamviz: {line}\n")


def test_the_command_line_goes_before_the_scene_file(run, tmp_path, monkeypatch):
    """What is named on it is changed in the scene, also back to the usual value; nothing else is.
    `serve SCENE.toml` and `--scene SCENE.toml` are the same. Without any of them the explorer has a
    scene of its own."""
    scenes = []
    monkeypatch.setattr("beamviz.explorer.serve", lambda scene, *_: scenes.append(scene))
    file = tmp_path / "scene.toml"
    saved = Scene.of(alpha=1, gamma=10, coriolis=True, mode=3, dark=True)
    file.write_text(saved.to_toml())
    expected = {
        f"{file}": saved,
        f"--scene {file}": saved,
        f"{file} --gamma 20 --no-coriolis --mode 2 --light": Scene.of(alpha=1, gamma=20, mode=2),
        "--lesson nodes --mode 3": lesson("nodes").scene.changed(mode=3),
        "": START,
        "--no-open": START,
        "--alpha 0": Scene(),
        "--mode 3": Scene.of(mode=3),
        "--coriolis-factor 0.3": Scene.of(coriolis=0.3),
    }
    assert {run("serve", *options.split())[0] for options in expected} == {0}
    assert scenes == list(expected.values())


def test_a_format_beside_a_file_is_printed_too(run, tmp_path):
    """As the chart of `loci` is written beside its output; a file alone prints nothing."""
    command = ("motion", str(tmp_path / "a.csv"), "--until", "0.1", "--points", "3")
    assert run(*command) == (0, "", "")
    (tmp_path / "a.csv").unlink()
    code, out, _ = run(*command, "--format", "json")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text())))
    assert code == 0
    assert [float(row["t"]) for row in rows] == strict(out)["t"]


HELPS = [command.name or command.callback.__name__ for command in app.registered_commands]
WORK = (
    *("explorer.serve", "evidence.benchmark.benchmark", "evidence.failure_maps.stability"),
    *("exports.animate", "exports.export", "exports.screenshot"),
)


class Done(str):
    """What a function returns whose work is left out: no text, no more files, no note."""

    note = ""


@pytest.mark.parametrize("command", HELPS)
def test_the_help_of_a_command_ends_with_an_example(run, tmp_path, monkeypatch, command):
    """It runs as it stands: up to its work, which others test, where that takes long."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(tmp_path)
    _, out, _ = run(command, "--help")
    (line,) = re.findall(r"^ *Example: beamviz (.+?) *$", out, re.MULTILINE)
    assert line.split()[0] == command
    worked = []

    def work(*given: Any, **options: Any) -> Done:
        worked.append(given)
        return Done()

    for function in WORK:
        monkeypatch.setattr(f"beamviz.{function}", work)
    code, out, err = run(*line.split())
    assert code == 0, err
    assert out or worked or any(tmp_path.iterdir())


# As a process


@pytest.fixture
def completed(tmp_path) -> Callable[..., list[str]]:
    """What bash offers after some words, the last of which is begun, by the script that
    `beamviz --show-completion` prints there."""
    command = tmp_path / "beamviz"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m beamviz "$@"\n')
    command.chmod(0o755)
    script = (
        'eval "$(beamviz --show-completion)"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1));'
        " _beamviz_completion beamviz; echo ${COMPREPLY[@]}"
    )

    def completed(words: str) -> list[str]:
        env = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
        command = ["bash", "-c", script, "-", *words.split(" ")]
        done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True)
        assert done.stderr == ""
        return done.stdout.split()

    return completed


COMPLETED = {
    "beamviz mo": ["modes", "motion"],
    "beamviz modes --str": ["--strain"],
    "beamviz modes --strain ": list(CHOICES["strain"]),
    "beamviz serve --lesson no": ["nodes", "no-equilibrium"],
    "beamviz reproduce tab": ["table1", "table2", "table3", "table4"],
}


@pytest.mark.parametrize("words", COMPLETED)
def test_what_a_shell_is_told_to_complete(run, monkeypatch, words):
    """Commands, options, their values, and names, as the script of bash asks for them."""
    monkeypatch.setenv("_BEAMVIZ_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    code, out, err = run()
    assert (code, out.split(), err) == (0, COMPLETED[words], "")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash")
def test_bash_completes(completed):
    """By the script that is printed for it."""
    words = "beamviz modes --strain "
    assert completed(words) == COMPLETED[words]


def process(*arguments: str, **settings: Any) -> subprocess.CompletedProcess[str]:
    """A command line as a process of its own, whose output is buffered as usual."""
    command = [sys.executable, "-m", "beamviz", *arguments]
    env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    settings = {"stdout": subprocess.PIPE, **settings, "env": env | settings.get("env", {})}
    return subprocess.run(command, cwd=ROOT, stderr=subprocess.PIPE, text=True, **settings)


LONG = {  # and short
    "json": "modes --format json",
    "help": "modes --help",
    "error": "modes --gamma -1 --format json",
    "loci": "loci --over gamma --start 0 --stop 1 --points 200 --format csv",
}


@pytest.mark.parametrize("name", ["loci", "error", *slow("json", "help")])
def test_a_reader_that_leaves_early_has_what_it_wants(name):
    """`beamviz modes | true` is no failure and says nothing: what is written goes nowhere, at once
    or when the buffer is full. A failure stays one."""
    reader, writer = os.pipe()
    os.close(reader)
    done = process(*LONG[name].split(), stdout=writer)
    os.close(writer)
    expected = (2, 1) if name == "error" else (0, 0)
    assert (done.returncode, done.stderr.count("\n")) == expected


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_line():
    with open("/dev/full", "w") as full:
        done = process("modes", stdout=full)
    assert (done.returncode, done.stderr) == (1, "beamviz: [Errno 28] No space left on device\n")


@pytest.mark.slow
def test_a_file_does_not_depend_on_the_encoding_of_the_system(tmp_path):
    """Greek letters are written where the locale has none; a CSV file needs none."""
    ascii_only = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = process("export", str(tmp_path / "beam.html"), env=ascii_only)
    assert (done.returncode, done.stderr) == (0, "")
    assert "γ = " in (tmp_path / "beam.html").read_text("utf-8")
    export(tmp_path / "beam.csv", Scene())
    assert (tmp_path / "beam.csv").read_bytes().isascii()


def test_as_a_module_the_exit_code_reaches_the_shell():
    """`python -m beamviz` ends with the code of main()."""
    assert process("modes", "--alpha", "-1").returncode == 2


def test_the_version_is_that_of_the_package(run):
    assert run("--version") == (0, f"beamviz {__version__}\n", "")


def test_a_beam_is_held_where_it_is_pulled(run):
    """A small force F at x = a deflects the tip of a beam at rest by F a^2 (3 - a) / 6."""
    command = "motion --until 0.1 --points 2 --release 0.01 --release-at 0.5 --format json"
    moved = strict(run(*command.split())[1])
    assert moved["tip"][0][1] == pytest.approx(0.01 * 0.5**2 * 2.5 / 6, rel=1e-3)
