"""What cannot be written, or not in full: one line with the remedy, exit code 1, no half file."""

import ctypes
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers import contents

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


@pytest.mark.parametrize("name", [*FILES, "reproduce"])
def test_a_full_disk_leaves_the_former_files(name, tmp_path, run):
    """And no other one: a file that may not become large enough stays as it was."""
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
