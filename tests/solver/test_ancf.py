"""The planar ANCF elements against the paper's formulas.

With other strain laws, curvatures and planes bent states converge to those of the default method
(test_bent.py).
"""

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.mechanics.cubic_elements import CubicElements, element_coordinates, gauss, hermite
from beamviz.solver.problem import Problem

NODES = np.array([0, 0.12, 0.35, 0.6, 1])
TURN = np.array([[0, -1], [1, 0]])  # I~
SOFT = 10.0  # slenderness: bending is a hundredth of stretching, not a five-thousandth


@pytest.mark.parametrize("seed", range(5))
def test_force_and_tangent_of_the_paper(seed):
    """The force of a green beam with spatial curvature is the paper's eq. 17, term by term, and
    the tangent its eq. 44, with its one unsymmetric term, -6 Gamma q q' S'S', made symmetric: as
    printed it is not the derivative of eq. 17."""
    model = CubicElements(NODES, Beam(mu=SOFT), Problem().theory)
    noise = np.random.default_rng(seed).standard_normal((len(NODES), 4)) * [0.05, 0.05, 0.25, 0.4]
    q_e = element_coordinates(model.unstressed + noise.ravel(), 4)  # tens of degrees and percent
    paper = [paper_element(e, q, SOFT) for e, q in enumerate(q_e)]
    Q_f, K = map(np.array, zip(*paper, strict=True))
    assert model.force(q_e) == pytest.approx(-Q_f, abs=1e-12 * np.abs(Q_f).max())
    K_e, scale = model.stiffness(q_e), np.abs(K).max()
    assert K_e == pytest.approx((K + K.swapaxes(1, 2)) / 2, abs=1e-12 * scale)
    assert np.abs(K_e - K).max() > 1e-4 * scale


def paper_element(e, q, mu):
    """Q_fe (eq. 17) and K_e (eq. 44) of one element with the paper's own symbols, as printed."""
    length, EA, EI = np.diff(NODES)[e], mu**2, 1.0
    Q_f, K = np.zeros(8), np.zeros((8, 8))
    for xi, weight in zip(*gauss(9), strict=True):
        dx = weight * length
        dS, ddS = (np.kron(s, np.eye(2)) for s in hermite(xi, length)[1:])
        SS = dS.T @ dS
        Gamma = dS.T @ TURN.T @ ddS + ddS.T @ TURN @ dS
        f = np.linalg.norm(dS @ q)
        kappa = q @ Gamma @ q / 2 / f**3
        strain = (q @ SS @ q - 1) / 2
        bend = Gamma / f**3 - 3 * kappa / f**2 * SS
        Q_f -= dx * (EA * strain * SS @ q + EI * kappa * bend @ q)
        K += dx * (EA * np.outer(SS @ q, SS @ q) + EA * strain * SS)
        K += dx * EI * (np.outer(bend @ q, bend @ q) + kappa * bend)
        K += dx * EI * kappa * -6 / f**5 * np.outer(Gamma @ q, SS @ q)
        K += dx * EI * kappa * 15 * kappa / f**4 * np.outer(SS @ q, SS @ q)
    return Q_f, K
