"""The README and the pages under assets/ are true: their numbers, commands, options and Python."""

import re
import shlex
import tomllib
from functools import cache
from math import pi
from pathlib import Path

import pytest
from typer.testing import CliRunner

from beamviz import Beam, solve
from beamviz.beam import PARAMETERS
from beamviz.cli.commands import app
from beamviz.solver.problem import METHODS, OPTIONS, Option
from beamviz.version import __version__

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
NAMES = ("reference.md", "deployment.md", "sweeps.md", "motion.md", "both_planes.md")
PAGES = {"README.md": README, **{name: (ROOT / "assets" / name).read_text() for name in NAMES}}
REFERENCE = PAGES["reference.md"]
BEAM = Beam(alpha=1, beta=0.5, gamma=10)


def test_the_frequencies_are_computed():
    """Every frequency, error and paper's value is what the two methods print today; the paper's is
    0.09 % off with 20 elements, the converged one has 8 digits with 34 unknowns."""
    rows = re.findall(r"\| ([BS]\d) \| ([\d.]+) \| ([\de-]+) \| ([\d.]+) \|", README)
    converged, paper = solve(BEAM), solve(BEAM, method="ancf", elements=20)
    assert len(rows) == 5
    for k, (label, frequency, error, ancf) in enumerate(rows):
        assert label == converged.labels[k] == paper.labels[k]
        assert frequency == f"{converged.frequencies[k]:.6f}"
        assert error == f"{converged.errors[k]:.0e}"
        assert ancf == f"{paper.frequencies[k]:.6f}"
    assert "0.09 % off" in README
    assert "34 unknowns" in README
    assert paper.frequencies[2] / converged.frequencies[2] - 1 == pytest.approx(9e-4, abs=5e-5)
    assert converged.stats.dof == 34
    assert converged.errors[2] / converged.frequencies[2] < 1e-8


def test_details_are_on_pages_that_are_linked():
    """By the README or by the reference."""
    for name in NAMES:
        assert f"assets/{name}" in README or f"]({name})" in REFERENCE


@pytest.mark.parametrize("line", re.findall(r"^beamviz modes .*$", README, re.MULTILINE))
def test_the_commands_run(line):
    result = CliRunner().invoke(app, shlex.split(line)[1:])
    assert result.exit_code == 0, result.output
    assert "S1" in result.output


@pytest.mark.parametrize("page", PAGES)
def test_the_options_exist(page):
    """Each option and each kind of file on a line or in a row about a command is in its help."""
    for line in PAGES[page].splitlines():
        for command, rest in re.findall(r"`?beamviz ([a-z]+)([^|`]*)", line):
            about = line if line.startswith("| `beamviz") else rest
            words = re.findall(r"--[a-z-]+|(?<=\.)(?:gif|webp|mp4|html|glb|csv|npz|png)\b", about)
            assert [word for word in words if word not in help_of(command)] == [], line


@cache
def help_of(command: str) -> str:
    return CliRunner().invoke(app, [command, "--help"], terminal_width=200).output


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_the_python_runs(code, tmp_path, monkeypatch):
    """Each Python block runs as it stands, and writes the files it names."""
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    assert {path.name for path in tmp_path.iterdir()} == set(re.findall(r'"(\w+(?:\.\w+)+)"', code))


def test_the_sample_of_a_beam_in_si_runs():
    """It is linked, and is the bar that its comments describe: its first frequency at rest is that
    of Dunkerley's sum of the bar and of the mass, to two percent."""
    assert "](assets/beam.toml)" in README
    file = ROOT / "assets" / "beam.toml"
    result = CliRunner().invoke(app, ["modes", "--si", str(file)])
    assert result.exit_code == 0, result.output
    assert "300 rpm" in result.output
    still = Beam.from_toml(file).replace(gamma=0)
    L, EI, m, tip = 1.2, 2.1e11 * 0.03 * 0.02**3 / 12, 7850 * 0.03 * 0.02, 2.0
    bar, mass = 3.516015**2 * EI / (m * L**4), 3 * EI / (tip * L**3)  # omega^2 of each alone
    dunkerley = (bar * mass / (bar + mass)) ** 0.5 / (2 * pi)
    (found,) = still.units.hertz(solve(still, modes=1).frequencies)
    assert found == pytest.approx(dunkerley, rel=0.02)


def test_the_tables_name_every_method_and_limit():
    """Methods as they are declared; tests/frequency_loci/test_event_kinds.py has the events."""
    for name, method in METHODS.items():
        assert f"| `{name}` | {method.source} | {method.choose} |" in REFERENCE
    for symbol, row in PARAMETERS.items():
        limits = "{:g} .. {:g}".format(*row.limits)
        assert re.search(rf"^\| {symbol} \|.*\| {re.escape(limits)}", README, re.MULTILINE)


def option_row(option: Option) -> str:
    """The row of an option in the reference."""
    flag, default = option.name.replace("_", "-"), option.default
    switch = f", `--no-{flag}`" if option.kind is bool else ""
    limits = "{:g} .. {:g}".format(*option.limits) if option.limits else "depends on the method"
    values = ", ".join(f"`{choice}`" for choice in option.choices)
    values = values or ("on, off" if option.kind is bool else limits)
    usual = "-" if default is None else "on" if default is True else default or "off"
    return f"| `--{flag}`{switch} | {values} | {usual} | {option.text} |"


@pytest.mark.parametrize("option", OPTIONS.values(), ids=OPTIONS)
def test_the_reference_has_every_option_as_it_is_declared(option):
    """With its values, its default and its documentation."""
    row = option_row(option)
    assert row in REFERENCE, f"assets/reference.md: the row of --{option.name} has to be\n{row}"


def test_the_citation_is_of_this_version():
    """With the authors and the licence of the project file, and the paper that the README names."""
    citation = (ROOT / "CITATION.cff").read_text()
    assert f"\nversion: {__version__}\n" in citation
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f"\n  - name: {project['authors'][0]['name']}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation
    (paper,) = re.findall(r"\*(Modal.*?)\*", README, re.DOTALL)
    assert " ".join(paper.split()) in " ".join(citation.split())


def test_every_file_it_points_to_is_there():
    """Pictures, pages, scripts, tests and modules named in the documents exist."""
    paths = []
    for name, text in PAGES.items():
        folder = ROOT if name == "README.md" else ROOT / "assets"
        paths += [folder / link for link in re.findall(r"\]\(([\w./-]+)\)", text)]
        paths += [ROOT / link for link in re.findall(r"\b(?:scripts|tests|beamviz)/[\w./]+", text)]
    assert [path for path in paths if not path.exists()] == []
