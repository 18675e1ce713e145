"""The interior penalty that keeps the beam's direction continuous where its stretch jumps.

With the gradients a = r'(left) and b = r'(right), the sine of the angle between them and the
bending moment m = dU / d theta' on each side,

    sigma = (a x b) / (|a| |b|),    m = kappa f^(2 - c) = (r' x r'') / f^(2c - 2),

the strain energy is completed by (m left + m right) / 2 sigma + eta sigma^2 / 2. Its variation
vanishes at the solution, whose moment is continuous and whose sigma is 0, so that nothing is lost
in accuracy and eta need not be large (Engel et al. 2002, for thin beams). As sigma is as small as
the error, its products with second derivatives are left out of the tangent.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics.elements import PositionElements
from beamviz.solver.fem.elements import CROSS, bending

PENALTY = 4.0  # eta over (order of the element)^2 / its length, the greater of both sides


class Joint:
    """The interior penalty at one element end. states: q -> (r1', r2', r1'', r2'') on the left,
    then on the right (8, n). slopes: q -> (a, b) (4, n)."""

    def __init__(self, elements: PositionElements, jump: int, curvature_power: int):
        self.power = 2 * curvature_power - 2
        place, free = elements.ends[jump : jump + 1], elements.free
        states = []
        for side in ("left", "right"):
            first, second = (elements.at(place, k, side)[0] for k in (1, 2))
            states += [np.kron(np.eye(2), row)[:, free] for row in (first, second)]
        self.states = np.concatenate(states)
        self.slopes = self.states[[0, 1, 4, 5]]
        self.half = self.states / 2
        lengths = np.diff(elements.ends)
        sizes = [elements.orders[e] ** 2 / lengths[e] for e in (jump - 1, jump)]
        self.eta = PENALTY * max(sizes)

    def angle_and_moment(self, q: NDArray) -> "AngleAndMoment":
        """sigma and the mean moment, and their derivatives."""
        s = (q @ self.states.T).reshape(-1, 2, 4)
        f = np.hypot(s[..., 0], s[..., 1])
        m, dm = bending(s, f, self.power)
        scale = 1 / (f[:, :1] * f[:, 1:])
        ab = s[..., :2].reshape(-1, 4)
        inverse = (s[..., :2] / (f * f)[..., None]).reshape(-1, 4)
        crossed = scale * (ab @ CROSS)
        sigma = (crossed * ab).sum(axis=1) / 2
        d_sigma = crossed - sigma[:, None] * inverse
        moment = (m[:, 0] + m[:, 1]) / 2
        return AngleAndMoment(sigma, d_sigma, scale, inverse, moment, dm.reshape(-1, 8) @ self.half)

    def energy(self, q: NDArray) -> NDArray:
        sigma, *_, m, _ = self.angle_and_moment(q)
        return sigma * (m + self.eta / 2 * sigma)

    def force(self, q: NDArray) -> NDArray:
        """The derivative of the energy by q (k, n)."""
        sigma, d_sigma, _, _, m, dm = self.angle_and_moment(q)
        by_slopes = (m + self.eta * sigma)[:, None] * d_sigma
        return by_slopes @ self.slopes + sigma[:, None] * dm

    def tangent(self, q: NDArray) -> NDArray:
        """The second derivative (k, n, n), but for terms with sigma."""
        sigma, d_sigma, scale, inverse, m, dm = self.angle_and_moment(q)
        outer = d_sigma[:, :, None] * inverse[:, None, :]
        second = scale[:, :, None] * CROSS - outer - outer.swapaxes(1, 2)
        H = self.eta * d_sigma[:, :, None] * d_sigma[:, None, :]
        H += (m + self.eta * sigma)[:, None, None] * second
        d = d_sigma @ self.slopes
        mixed = dm[:, :, None] * d[:, None, :]
        return self.slopes.T @ H @ self.slopes + mixed + mixed.swapaxes(1, 2)


class AngleAndMoment(NamedTuple):
    sigma: NDArray  # (k,)
    d_sigma: NDArray  # by (a, b): (k, 4)
    scale: NDArray  # 1 / (|a| |b|) (k, 1)
    inverse: NDArray  # (a / |a|^2, b / |b|^2) (k, 4)
    m: NDArray  # mean moment (k,)
    dm: NDArray  # by q (k, n)
