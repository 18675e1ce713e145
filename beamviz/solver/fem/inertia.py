"""Inertia of the beam and its concentrated mass: M, G and the centrifugal terms.

Everything inertial is one scalar matrix m per element (paper, eq. 8, one component) times a
2 x 2 matrix that says which components meet: M = m I, G = m J, and the centrifugal matrix
C = m P, with P the projection away from the axis of rotation.
"""

import numpy as np
from numpy.typing import NDArray

from beamviz.solver.fem.hermite import gauss, hermite, locate

MASS_DEGREE = 6  # S' S of cubics

IDENTITY = np.eye(2)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # e3 x r, the rotation axis out of the plane
PROJECTIONS = {
    "chordwise": np.diag([1.0, 1.0]),  # the axis is normal to the plane of motion
    "flapwise": np.diag([1.0, 0.0]),  # the axis lies in it, across the beam
}


def line_mass(nodes: NDArray) -> NDArray:
    """m_e = int S' S dx of each element for rho A = 1 (paper, eq. 8): (elements, 4, 4)."""
    points, weights = gauss(MASS_DEGREE)
    lengths = np.diff(nodes)[:, None]
    S, _, _ = hermite(points, lengths)
    return np.einsum("ep,epi,epj->eij", weights * lengths, S, S)


def point_mass(nodes: NDArray, alpha: float, beta: float) -> NDArray:
    """alpha S'(beta) S(beta) in the element that holds beta (paper, eqs. 29-32), zero in all
    others: (elements, 4, 4)."""
    lengths = np.diff(nodes)
    element, xi = locate(nodes, beta)
    S, _, _ = hermite(xi, lengths[element])
    m = np.zeros((len(lengths), 4, 4))
    m[element] = alpha * np.outer(S, S)
    return m


def scalar_mass(nodes: NDArray, alpha: float, beta: float) -> NDArray:
    """m_e of the beam with its concentrated mass, one component: (elements, 4, 4)."""
    return line_mass(nodes) + point_mass(nodes, alpha, beta)


def planar(m: NDArray, components: NDArray) -> NDArray:
    """Element matrices m_e (x) components in the order of planar coordinates: (elements, 8, 8).

    With IDENTITY this is M, with TURN the gyroscopic G of M q" + 2 gamma G q' + K q = 0, with a
    row of PROJECTIONS the centrifugal matrix C.
    """
    return np.einsum("eij,cd->eicjd", m, components).reshape(-1, 8, 8)


def lever_arm(q_e: NDArray, delta: float) -> NDArray:
    """Element coordinates of r + delta e1, the position seen from the axis of rotation.

    The centrifugal force is then gamma^2 C (q + delta t), t the unit translation along the
    beam: cubics hold it exactly, so delta C t is the load of the hub radius (eqs. 24-25, 33-34).
    """
    arm = q_e.copy()
    arm[:, [0, 4]] += delta
    return arm
