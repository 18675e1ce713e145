"""Modes of beams that may be bent, as vectors in the product they are orthogonal in.

With Coriolis forces (u, i w) of a straight beam is real; modes of a bent one are complex in both
components.
"""

from collections.abc import Sequence

import numpy as np

from beamviz.solver.solution import Solution


def orthogonal_vectors(
    fields: np.ndarray, solutions: Sequence[Solution]
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals (n, m, d) of modes (n, m, 2, points), u and w times the root of the mass,
    in the real part of (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j, with
    i phi_i* G phi_j = i sum (w_i* u_j - u_i* w_j).

    The phase of a mode is that which makes sum (u^2 - w^2) real: of a straight beam (u, i w).
    """
    omega = np.sqrt(abs(np.array([one.omega_squared for one in solutions])))[:, :, None]
    coriolis = [one.beam.gamma if one.problem.gyroscopic else 0.0 for one in solutions]
    root = np.sqrt(coriolis)[:, None, None]
    fields = fields.astype(complex)
    square = (fields[:, :, 0] ** 2 - fields[:, :, 1] ** 2).sum(axis=2)
    fields = fields * np.exp(-0.5j * np.angle(square))[:, :, None, None]
    u, w = fields[:, :, 0], fields[:, :, 1]
    both = np.concatenate((u.real, u.imag, w.real, w.imag), axis=2)
    swirl = np.concatenate((w.real, -w.imag, -u.real, u.imag), axis=2)
    others = np.concatenate((u.imag, u.real, w.imag, w.real), axis=2)
    shapes = np.concatenate((omega * both, both, root * swirl), axis=2)
    duals = np.concatenate((both, omega * both, 2 * root * others), axis=2)
    norms = (shapes * duals).sum(axis=2, keepdims=True)
    size = np.sqrt(np.maximum(abs(norms), np.finfo(float).tiny))
    return shapes / size, duals / size * np.sign(norms)
