"""The formats of a scene in a file: each is written, and wherever they are listed, it is."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from beamviz.cli.commands import EXPORT_HELP, app
from beamviz.cli.motion import OUT
from beamviz.explorer.features.files import KINDS
from beamviz.export_formats import EXPORT_FORMATS
from beamviz.exports import export
from beamviz.exports.motion_files import SUFFIXES
from beamviz.presets import PRESETS
from beamviz.scene import Scene

REFERENCE = (Path(__file__).parents[2] / "assets" / "reference.md").read_text()
each_format = pytest.mark.parametrize("row", EXPORT_FORMATS.values(), ids=EXPORT_FORMATS)


@each_format
def test_every_format_is_written(row, tmp_path):
    files = export(tmp_path / f"beam{row.suffix}", Scene(PRESETS["tapered-steel-blade"].beam))
    assert sorted(tmp_path.iterdir()) == sorted(files)
    assert all(file.stat().st_size > 100 for file in files)


@each_format
def test_every_format_is_listed(row):
    """In the help of the command, on the page, and in the reference."""
    usage = CliRunner().invoke(app, ["export", "--help"]).output.splitlines()[1]
    assert f"{row.suffix[1:]}|" in usage
    assert row.text in EXPORT_HELP
    assert row.suffix in KINDS, "add it to KINDS of beamviz/explorer/features/files.py"
    row_of_command = rf"^\| `beamviz export \w+{re.escape(row.suffix)}` \|"
    assert re.search(row_of_command, REFERENCE, re.MULTILINE), (
        "add it to the table of files in assets/reference.md"
    )


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_of_a_motion_is_listed(suffix):
    """In the help of the command; the page offers a choice of them."""
    assert suffix[1:] in re.split(r"\W", OUT.metavar), "add it to OUT of beamviz/cli/motion.py"
    assert suffix[1:] in re.split(r"\W", OUT.help), "add it to OUT of beamviz/cli/motion.py"
