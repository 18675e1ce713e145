"""Errors of one line: a wrong command line ends with exit code 2 and names the mistake; what cannot
be written, or not in full, with exit code 1 and the remedy. Neither leaves half a file."""

import ctypes
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from string import Template

import pytest
from helpers import contents, slow, strict

from beamviz import Beam, sweep
from beamviz.beam import NUMBERS
from beamviz.lessons import NAMES
from beamviz.solver.problem import CHOICES, MAX_MODES

LOCI, OVER = "loci --over gamma --start 0 --stop 5", "sweep a.zarr --over gamma=0,1 --over"
LINE, AT = "loci --over gamma --sweep $STORE --at", "alpha=1,beta=0.5"
MAP = "--over gamma,alpha --at beta=0.5 --sweep $STORE"
ALL_AXES = "alpha=0,1 --over beta=0,1 --over delta=0,1 --over mu=50,70 --over spin_up=0,1"
NAMED = {  # what a message names, separated by |: the option, the value, the values allowed
    "modes --alpha -1": "alpha = -1|0 .. 100",
    "modes --beta half": "beta = 'half'|0 .. 1",
    "modes --modes 2.5": f"modes = 2.5|1 .. {MAX_MODES}",
    "modes --modes many": f"modes = 'many'|1 .. {MAX_MODES}",
    "modes --elements 8": "elements = 8|auto|ancf, linear",
    "modes --si none.toml": "none.toml",
    "modes --si größe.toml": "größe.toml",
    "modes --si none.toml --gamma 0": "--gamma 0|--si none.toml",
    "screenshot a.png --scene $SCENE": "$SCENE|[beam]|'gama'|" + "|".join(NUMBERS),
    "screenshot a.png --lesson magic": "lesson = 'magic'|" + "|".join(NAMES),
    "modes --alhpa 1": "--alhpa|--alpha",
    "modes --alpha": "--alpha",
    **{  # exactly what solve() knows
        f"modes --{name} none": f"--{name}|'none' is not one of {', '.join(map(repr, known))}."
        for name, known in CHOICES.items()
    },
    "modes --format xml": "--format|'xml'|table|json|csv",
    "modes 1": "1",
    "mods": "mods",
    "screenshot": "OUT.png",
    "screenshot a.png --width 9.5": "width = 9.5|64 .. 4096",
    "screenshot a.png --height tall": "height = 'tall'|64 .. 4096",
    "screenshot a.png --mode 0": f"mode = 0|1 .. {MAX_MODES}",
    "screenshot a.png --phase nan": "phase = nan|0 .. 1",
    "screenshot a.png --from 1,2": "--from|1,2|0,-1,0.5",
    "screenshot a.png --from 0,0,0": "--from|0,0,0|not all 0",
    "screenshot a.jpg": "a.jpg|.png",
    "screenshot a.png --lesson nodes --scene $SCENE": "--scene $SCENE and --lesson nodes",
    "screenshot a.png --lesson a.toml": "--lesson a.toml|only `beamviz serve`|beamviz lessons",
    "serve --lesson none.toml": "none.toml",
    "serve --port 70000": "port = 70000|1 .. 65535",
    "loci --over gamma --start 0 --stop 0": "--start 0 --stop 0",
    "loci --over gamma --start 0 --stop nan": "--stop: gamma = nan|0 .. 200",
    "loci --over gamma --start -1 --stop 5": "--start: gamma = -1|0 .. 200",
    "loci --over gamma --start 0 --stop fast": "--stop: gamma = 'fast'",
    f"{LOCI} --points 1": "--points = 1|2 .. 10000",
    "loci --over gamma --start 0 --stop 90 --mu 10": "gamma / mu = ",
    f"{LOCI} --plot x.gif": "x.gif|.png|.svg|.pdf",
    f"{LOCI} --per-rev -1": "per-rev = -1|0 .. 100",
    "loci --over gamma --start 0": "Missing option '--stop'",
    "loci --over speed --start 0 --stop 1": ", ".join(map(repr, NUMBERS)),
    "loci --over mu --start 10 --stop 100 --gamma 150": "5|gamma = 150|mu = 10",
    "loci --over beta --start 0 --stop 1 --per-rev 2": "per-rev|gamma|beta",
    "motion --until 1 --plane both": "--plane both: a motion in time is in the plane of rotation",
    "motion --no-stiffening": "--no-stiffening: a motion in time has no such option",
    "sweep a.zarr": "Missing option '--over'",
    "sweep a.zarr --over gamma": "--over gamma|NAME=START:STOP:POINTS",
    "sweep a.zarr --over gamma=0:5": "--over gamma=0:5",
    "sweep a.zarr --over gamma=1,,2": "--over gamma=1,,2",
    "sweep a.zarr --over speed=0:5:3": "speed|alpha, beta, gamma",
    "sweep a.zarr --over gamma=5:0:3": ": start 5 stop 0",
    "sweep a.zarr --over gamma=0:5:1": "points = 1|2 ..",
    "sweep a.zarr --over gamma=3,2": "gamma|3|2",
    f"{OVER} gamma=2,3": "--over gamma=2,3|gamma",
    f"{OVER} {ALL_AXES}": "6 axes|gamma, alpha, beta, delta, mu, spin_up|5",
    "sweep a.zarr --over gamma=0,1 --workers 0": "workers = 0",
    f"{OVER} delta=0,1 --scheduler at --workers 2": "--workers 2|--scheduler at",
    "sweep file.zarr --over gamma=0,1": "file.zarr",
    "loci --over mu --sweep $STORE": "mu",
    "loci --over gamma --sweep $STORE": "alpha|0 .. 2",
    f"{LINE} alpha=1,beta=0.6": "beta=0.6|0.5",
    f"{LINE} alpha=x": "--at alpha=x|NAME=VALUE",
    f"{LINE} alpha=1:2": "--at alpha=1:2|NAME=VALUE",
    f"{LINE} gamma=1": "gamma=1",
    f"{LINE} {AT} --start 1": "--start|--sweep",
    f"{LINE} {AT} --coriolis": "--coriolis|--sweep",
    f"export a.png --gap --mode 1 {MAP}": "mode|gap",
    f"export a.png --mode 4 {MAP}": "mode = 4",
    f"export a.glb {MAP}": "a.glb|.png|.svg|.pdf",
    "export a.png --over gamma --sweep $STORE": "gamma",
    f"export a.png --alpha 1 {MAP}": "--alpha|--sweep",
    "export a.png --sweep $STORE": "gamma",
    "export a.html --gap": "--gap|--sweep",
    "export a.html --over gamma,alpha": "--over|--sweep",
    "loci --over gamma --start 0 --stop 1 --at alpha=1": "--at|--sweep",
    "loci --over gamma --stop 1": "--start",
    "loci --over gamma --sweep no.zarr": "no.zarr",
    "export a.png --sweep no.zarr --over gamma,alpha": "no.zarr",
    "export a.png --sweep file.zarr --over gamma,alpha": "file.zarr",
}
NOWHERE = "sweep a.zarr --over gamma=0,1 --scheduler nowhere"  # which Dask is imported for


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A sweep, and a scene with an unknown key: what the names in capitals stand for."""
    folder = tmp_path_factory.mktemp("files")
    axes = {"gamma": [0, 1], "alpha": [0, 0.5, 1, 2], "beta": [0.5, 1]}
    sweep(axes, folder / "a.zarr", 3, beam=Beam(mu=60), workers=1)
    (folder / "scene.toml").write_text("[beam]\ngama = 1\n")
    return {"STORE": str(folder / "a.zarr"), "SCENE": str(folder / "scene.toml")}


@pytest.mark.parametrize("line", [*NAMED, *slow(NOWHERE)])
def test_a_wrong_command_line_is_named(run, files, tmp_path, monkeypatch, line):
    """stdout is empty, or with --format json the error as JSON, in ASCII: a terminal may lack the
    letters of a path."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.zarr").write_text("kept")
    command, *options = Template(line).substitute(files).split()
    expected = Template(NAMED.get(line, "nowhere")).substitute(files)
    code, out, err = run(command, *options)
    assert (code, out, err.count("\n")) == (1 if line == NOWHERE else 2, "", 1)
    assert err.startswith("beamviz: ")
    message = err.removeprefix("beamviz: ").removesuffix("\n")
    assert [part for part in expected.split("|") if part not in message] == []
    if command in ("modes", "loci"):
        json_option = ["--format", "json"] if len(options) % 2 else ["--format=json"]
        code, out, again = run(command, *json_option, *options)
        error = {"kind": "invalid-input", "message": message}
        assert (code, strict(out), again) == (2, {"error": error}, err)
        assert out.isascii()
    assert [path.name for path in tmp_path.iterdir()] == ["file.zarr"]
    assert (tmp_path / "file.zarr").read_text() == "kept"


MISTYPED = {
    "modes --strain gren": "green",
    "modes --method assumed_modes": "assumed-modes",
    "modes --format Json": "json",
    "modes --si nrel-5mw-balde": "nrel-5mw-blade",
    "mods": "modes",
    "loci --over gama --start 0 --stop 1": "gamma",
    "sweep a.zarr --over gama=0,1": "gamma",
    "motion --integrator raudau": "radau",
    "screenshot a.png --lesson nods": "nodes",
    "screenshot a.png --scene $SCENE": "gamma",
    "reproduce tabel1 --out a": "table1",
}


@pytest.mark.parametrize("line", MISTYPED)
def test_the_name_that_is_meant_is_told(run, files, tmp_path, monkeypatch, line):
    """Of commands, options, their values, and keys of a file."""
    monkeypatch.chdir(tmp_path)
    _, _, err = run(*Template(line).substitute(files).split())
    assert err.lower().endswith(f"did you mean '{MISTYPED[line]}'?\n")


@pytest.mark.parametrize(
    "line", ["modes --strain rubber", "reproduce fig3 --out a", "modes --method 5"]
)
def test_nothing_is_guessed_where_no_name_is_near(run, line):
    """fig13 is another figure than fig3."""
    assert "you mean" not in run(*line.split())[2]


# What cannot be written


SWEEP = ("--over", "gamma", "--start", "0", "--stop", "5", "--points", "3")
SMALL = ("--width", "64", "--height", "64")
FILES = {
    "screenshot": ("screenshot", "{}/a.png", *SMALL),
    **{
        suffix: ("animate", f"{{}}/a.{suffix}", *SMALL, "--fps", "5")
        for suffix in ("gif", "webp", "mp4")
    },
    **{suffix: ("export", f"{{}}/a.{suffix}") for suffix in ("html", "glb", "csv", "npz")},
    "plot": ("loci", "--plot", "{}/a.png", *SWEEP),
    "motion": ("motion", "{}/a.csv", "--until", "0.1"),
}
COMMANDS = {
    **FILES,
    "reproduce": ("reproduce", "table1", "--out", "{}"),
    "reproduce, a new folder": ("reproduce", "table1", "--out", "{}/new"),
    "benchmark": ("benchmark", "--quick", "--out", "{}"),
    "stability": ("stability", "--quick", "--out", "{}"),
    "sweep": ("sweep", "{}/a.zarr", "--over", "gamma=0:5:3"),
}
REMEDY = "(make room there, or )?(choose another place|name another folder)"
VERSION, OVERRIDES = 0x20080522, 0b110  # of capabilities: CAP_DAC_OVERRIDE, _READ_SEARCH
SAID = rf"beamviz: cannot write (to )?{{}}.*: .+; {REMEDY}\n"


def refusal(run, name: str, place: Path) -> str:
    """What a command says that cannot write to a place."""
    code, out, err = run(*(word.format(place) for word in COMMANDS[name]))
    assert (code, out) == (1, "")
    assert re.fullmatch(SAID.format(re.escape(str(place))), err), err
    return err


@pytest.mark.parametrize("name", COMMANDS)
def test_a_path_in_what_is_no_folder(name, tmp_path, run):
    """Not even root can write below a file."""
    place = tmp_path / "file"
    place.write_text("kept")
    refusal(run, name, place)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert place.read_text() == "kept"


@pytest.mark.parametrize(
    "name", ["screenshot", "csv", "motion", "reproduce", *slow("mp4", "gif", "webp", "html", "glb")]
)
def test_a_full_disk_leaves_the_former_files(name, tmp_path, run, monkeypatch):
    """And no other one: a file that may not become large enough stays as it was."""
    # Python would keep the first part of a compiled module that it imports here for the first time.
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    resource = pytest.importorskip("resource", reason="limits of a process")
    words = [word.format(tmp_path) for word in COMMANDS[name]]
    former = Path(next(word for word in words if word.startswith(str(tmp_path))))
    (former if name in FILES else former / "table1.md").write_text("before")
    before, (soft, hard) = contents(tmp_path), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        code, _, err = run(*words)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert code == 1
    said = re.search(SAID.format(re.escape(str(tmp_path))) + r"\Z", err)  # after its progress
    assert said, err
    assert "File too large" in said[0]
    assert contents(tmp_path) == before


@pytest.fixture
def locked(tmp_path) -> Iterator[Path]:
    """A folder that nobody may write into; root has to respect permissions meanwhile."""
    libc, header, sets = ctypes.CDLL(None), (ctypes.c_uint32 * 2)(VERSION), (ctypes.c_uint32 * 6)()
    assert libc.capget(header, sets) == 0
    effective = sets[0]
    sets[0] &= ~OVERRIDES
    assert libc.capset(header, sets) == 0
    tmp_path.chmod(0o555)
    yield tmp_path
    tmp_path.chmod(0o755)
    sets[0] = effective
    assert libc.capset(header, sets) == 0


@pytest.mark.skipif(sys.platform != "linux", reason="capabilities of Linux")
@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_without_permission(name, locked, run):
    """Every command that writes, where permissions bind, root or not."""
    assert "Permission denied" in refusal(run, name, locked)
    assert list(locked.iterdir()) == []
