"""The README is true: its numbers, its commands and its Python."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from beamviz import Beam, solve
from beamviz.beam import PARAMETERS
from beamviz.cli.commands import app
from beamviz.solver import METHODS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
BEAM = Beam(alpha=1, beta=0.5, gamma=10)


def test_the_table_of_frequencies_is_computed():
    """Every frequency, error and paper's value is what the two methods print today."""
    rows = re.findall(r"\| ([BS]\d) \| ([\d.]+) \| ([\de-]+) \| ([\d.]+) \|", README)
    exact, paper = solve(BEAM), solve(BEAM, method="ancf", elements=20)
    assert len(rows) == 5
    for k, (label, frequency, error, ancf) in enumerate(rows):
        assert label == exact.labels[k] == paper.labels[k]
        assert frequency == f"{exact.frequencies[k]:.6f}"
        assert error == f"{exact.errors[k]:.0e}"
        assert ancf == f"{paper.frequencies[k]:.6f}"


def test_the_one_number_is_true():
    """0.09 % off with 20 elements, 44 unknowns, 9 digits."""
    exact, paper = solve(BEAM), solve(BEAM, method="ancf")
    assert "0.09 % off" in README
    assert "44\nunknowns" in README
    assert paper.frequencies[2] / exact.frequencies[2] - 1 == pytest.approx(9e-4, abs=5e-5)
    assert exact.stats.dof == 44
    assert exact.errors[2] / exact.frequencies[2] < 1e-9


@pytest.mark.parametrize("line", re.findall(r"^beamviz modes .*$", README, re.MULTILINE))
def test_the_commands_run(line):
    """Each `beamviz modes` line of the README ends well."""
    result = CliRunner().invoke(app, shlex.split(line)[1:])
    assert result.exit_code == 0, result.output
    assert "S1" in result.output


@pytest.mark.parametrize("line", re.findall(r"^beamviz serve .*$", README, re.MULTILINE))
def test_the_options_of_the_server_exist(line):
    """Each option of a `beamviz serve` line is in its help."""
    text = CliRunner().invoke(app, ["serve", "--help"], terminal_width=200).output
    options = re.findall(r"--[a-z-]+", line)
    assert options
    assert [option for option in options if option not in text] == []


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_the_python_runs(code, tmp_path, monkeypatch):
    """Each Python block runs as it stands, and writes the files it names."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")  # the film would take a minute
    exec(compile(code, "README.md", "exec"), {})
    assert {path.name for path in tmp_path.iterdir()} == set(re.findall(r'"(\w+\.\w+)"', code))


@pytest.mark.parametrize("command", ["screenshot", "animate", "export"])
def test_the_files_it_names_can_be_written(command):
    """Each ending the README gives a command is in its help, and so is each option."""
    text = CliRunner().invoke(app, [command, "--help"], terminal_width=200).output
    (part,) = re.findall(rf"`beamviz {command} \w+\.(.*?)(?:`beamviz|No window)", README, re.DOTALL)
    for word in re.findall(r"--[a-z]+", part) + re.findall(r"\.(gif|webp|mp4|glb|csv|npz)\b", part):
        assert word in text


def test_the_tables_name_every_method_and_limit():
    """Methods and limits are those of the code."""
    assert set(re.findall(r"^\| `([a-z-]+)` \|", README, re.MULTILINE)) == set(METHODS)
    for name, parameter in PARAMETERS.items():
        low, high = parameter.limits
        assert re.search(rf"^\| {name} \|.*\| {low:g} \.\. {high:g}", README, re.MULTILINE)


def test_every_file_it_points_to_is_there():
    """Pictures, scripts and modules named in the README exist."""
    names = re.findall(
        r"\]\((assets/[^)]+)\)|python3? (scripts/\w+\.py)|^    (\S+)  ", README, re.M
    )
    paths = ["".join(match) for match in names]
    assert len(paths) >= 8
    for path in paths:
        assert (ROOT / path).exists(), path
