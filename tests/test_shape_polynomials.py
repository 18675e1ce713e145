"""Mode shapes as the polynomials of an ElastoDyn blade file."""

import json

import numpy as np
import pytest

from beamviz import Beam, export, solve
from beamviz.cli import main
from beamviz.output.shape_polynomials import POWERS, shape_polynomials
from beamviz.presets import preset
from beamviz.scene import Scene


def test_they_are_the_shapes():
    solution = solve(Beam(flap=0.25, pitch=10), modes=5, plane="both")
    x = np.linspace(0, 1, 57)
    names = [polynomial.name for polynomial in shape_polynomials(solution)]
    assert names == ["BldFl1Sh", "BldFl2Sh", "BldEdgSh"]
    for polynomial in shape_polynomials(solution):
        k = solution.labels.index(polynomial.label)
        shape = solution.shape(k, x)[:, 1 if polynomial.name == "BldEdgSh" else 2]
        fit = x[:, None] ** POWERS @ polynomial.coefficients
        assert polynomial.coefficients.sum() == pytest.approx(1)
        assert abs(fit - shape / shape[-1]).max() <= 1.1 * polynomial.fit_error < 5e-3


def test_those_of_the_reference_blade():
    """The coefficients of its ElastoDyn file (OpenFAST r-test, NRELOffshrBsline5MW_Blade.dat),
    which BModes computed at the rated speed: shapes within 2 % of the tip's motion."""
    published = {
        "BldFl1Sh": (0.0622, 1.7254, -3.2452, 4.7131, -2.2555),
        "BldEdgSh": (0.3627, 2.5337, -3.5772, 2.376, -0.6952),
    }
    x = np.linspace(0, 1, 51)[:, None]
    for plane, name in (("flapwise", "BldFl1Sh"), ("chordwise", "BldEdgSh")):
        solution = solve(preset("nrel-5mw-blade").beam, plane=plane)
        ours = next(each for each in shape_polynomials(solution) if each.name == name)
        difference = x**POWERS @ (ours.coefficients - np.array(published[name]))
        assert abs(difference).max() < 0.02


def test_the_command_line_and_a_file_have_them(tmp_path, capsys):
    command = ["modes", "--flap", "0.25", "--plane", "both", "--polynomials"]
    assert main([*command, "--format", "json"]) == 0
    first = json.loads(capsys.readouterr().out)["shape_polynomials"][0]
    assert main(command) == 0
    line = f"{first['coefficients'][0]:12.6f}   BldFl1Sh(2) - Flap mode 1, coeff of x^2"
    assert line in capsys.readouterr().out
    scene = Scene(Beam(flap=0.25)).changed(plane="both")
    export(tmp_path / "shapes.dat", scene)
    assert line in (tmp_path / "shapes.dat").read_text()
    assert main([*command, "--format", "csv"]) == 2
