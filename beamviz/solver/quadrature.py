"""Integrals over the mass of a beam, distributed and concentrated, by Gauss quadrature between its
discontinuities.
"""

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from beamviz.beam import Beam
from beamviz.space.spans import ends_of_spans

MOMENT_POINTS = 12  # Gauss points between two discontinuities, of a static moment
# Gauss points between two discontinuities, however close: 6 are exact to rounding on the 48 spans
# of a wind turbine blade.
MORE_IN_SPAN = 8

gauss = lru_cache(maxsize=64)(legendre.leggauss)  # points and weights on [-1, 1]


def quadrature(beam: Beam, points: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Points (n,) and weights (n,) of an integral over the mass of a beam: `points` Gauss points on
    either side of the concentrated mass and, as the last point, the concentrated mass. Of a beam
    that is not uniform, about as many in all, in proportion to the distances between its
    discontinuities and MORE_IN_SPAN more between each two, and at the end the bodies."""
    if not beam.is_prismatic:
        bodies = beam.bodies
        ends = ends_of_spans(beam)
        along, mass = distributed_mass(beam, ends, points, MORE_IN_SPAN)
        at = [body.beta for body in bodies]
        return np.append(along, at), np.append(mass, [body.alpha for body in bodies])
    xi, weights = gauss(points)
    parts = list(pairwise(ends_of_spans(beam)))
    x = [a + (b - a) * (xi + 1) / 2 for a, b in parts]
    w = [(b - a) / 2 * weights for a, b in parts]
    return np.append(np.concatenate(x), beam.beta), np.append(np.concatenate(w), beam.alpha)


def distributed_mass(
    beam: Beam, ends: tuple[float, ...], points: int, more: int
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n,) and weights (n,) of an integral over the mass of the beam itself: `points` Gauss
    points in proportion to the distances between the ends, and `more` between each two."""
    parts = []
    for start, stop in pairwise(ends):
        count = more + math.ceil(points * (stop - start))
        xi, weights = gauss(count)
        half = (stop - start) / 2
        parts.append((start + half * (xi + 1), half * weights))
    x, w = np.concatenate(parts, axis=1)
    return x, w if beam.blade is None else w * beam.blade.at("mass", x)


def moment_of_weight(beam: Beam) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n,), weights (n,) of an integral over x, and the bending moment (n,) at the points of
    the static force on the mass of the beam, across it and 1 for a unit of mass."""
    at, mass = quadrature(beam)
    xi, weights = gauss(MOMENT_POINTS)
    x, w, moments = [], [], []
    for start, stop in pairwise(ends_of_spans(beam)):
        here = start + (stop - start) * (xi + 1) / 2
        # The rest of the span, and all beyond it.
        rest = here[:, None] + (stop - here)[:, None] * (xi + 1) / 2
        rho = 1.0 if beam.blade is None else beam.blade.at("mass", rest)
        beyond = at >= stop
        moment = ((rest - here[:, None]) * rho) @ weights * (stop - here) / 2
        moments.append(moment + (at[beyond] - here[:, None]) @ mass[beyond])
        x.append(here)
        w.append((stop - start) / 2 * weights)
    return np.concatenate(x), np.concatenate(w), np.concatenate(moments)
