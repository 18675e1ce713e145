"""What cannot be written, or not in full: one line with the remedy, exit code 1, no half file."""

import ctypes
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from helpers import contents

ROOT = Path(__file__).parents[2]
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
SAID = rf"beamviz: cannot write (to )?{{}}.*: .+; {REMEDY}\n"
OVERRIDE, READ_SEARCH, DROP = 1, 2, 24  # capabilities, and what prctl calls giving one up

RUN_ALL = """
import contextlib, io, json, sys
from beamviz.cli import main

found = []
for line in json.loads(sys.argv[1]):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(line)
    found.append((code, out.getvalue(), err.getvalue()))
print(json.dumps(found))
"""


@pytest.mark.parametrize("name", COMMANDS)
def test_a_path_in_what_is_no_folder(name, tmp_path, run):
    """Not even root can write below a file."""
    place = tmp_path / "file"
    place.write_text("kept")
    code, out, err = run(*(word.format(place) for word in COMMANDS[name]))
    assert (code, out) == (1, "")
    assert re.fullmatch(SAID.format(re.escape(str(place))), err), err
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


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="permissions are those of Unix")
def test_a_folder_without_permission(tmp_path):
    """Every command that writes, in a process that permissions bind, root or not."""
    tmp_path.chmod(0o555)
    lines = [[word.format(tmp_path) for word in line] for line in COMMANDS.values()]
    command = [sys.executable, "-c", RUN_ALL, json.dumps(lines)]
    bound: Any = {"cwd": ROOT, "timeout": 120, "preexec_fn": bound_by_permissions}
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, **bound)
    finally:
        tmp_path.chmod(0o755)
    said = re.compile(SAID.format(re.escape(str(tmp_path))))
    for name, (code, out, err) in zip(COMMANDS, json.loads(done.stdout), strict=True):
        assert (name, code, out) == (name, 1, "")
        assert said.fullmatch(err), (name, err)
        assert "Permission denied" in err
    assert list(tmp_path.iterdir()) == []


def bound_by_permissions() -> None:
    """Let root, from here on, do no more than the owner of a file may."""
    if os.geteuid() == 0:
        for capability in (OVERRIDE, READ_SEARCH):
            assert ctypes.CDLL(None).prctl(DROP, capability, 0, 0, 0) == 0
