"""Bent states and their modes by shooting along the beam, sharing only `Beam` with the program.

State, from the clamp: x' = f cos a, y' = f sin a, a' = m / b(f), m' = -f (P . n), P' = -q, with the
force P and the moment m that the part further out exerts, n = (-sin a, cos a), the stretch f from
mu^2 e e' + b' m^2 / (2 b^2) = P . t, and the load q = gamma^2 R + lambda (R_y, -R_x),
R = r + delta e1. At the concentrated mass P has a step alpha q. At the
clamp m and P are unknown, at the tip both vanish.

Modes: the same equations linearised, with omega^2 (and 2 i gamma omega for Coriolis forces) in the
load; a frequency is a zero of the determinant of the tip's conditions on the three solutions that
leave the clamp.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, newton, root

from beamviz import Beam

STRAIN = {
    "green": (lambda f: (f * f - 1) / 2, lambda f: f),
    "biot": (lambda f: f - 1, lambda f: 1.0),
    "hencky": (np.log, lambda f: 1 / f),
}
POWER = {"spatial": -2, "material": 0}  # of b(f)
TOLERANCE = {"rtol": 1e-11, "atol": 1e-12, "method": "DOP853"}
STEP = 1e-30  # of a complex derivative


class BentOracle(NamedTuple):
    """A beam's bent state: values at the clamp that meet the tip's conditions."""

    beam: Beam
    strain: str
    curvature: str
    clamp: np.ndarray  # m, P_x, P_y

    def frequency(self, near: complex, coriolis: bool = False) -> complex:
        """The root omega of the determinant next to a guess."""
        scale = abs(self.determinant(near * 1.001, coriolis))
        return newton(
            lambda omega: self.determinant(omega, coriolis) / scale,
            complex(near),
            x1=near * (1 + 1e-4 + 1e-5j),
            tol=1e-12 * abs(near),
            maxiter=50,
        )

    def determinant(self, omega: complex, coriolis: bool) -> complex:
        """Of the tip's conditions on the three solutions that leave the clamp."""
        end = _integrate(self, np.eye(3), omega, coriolis)
        return np.linalg.det(end)

    @property
    def tip(self) -> np.ndarray:
        """Position of the tip from the clamp."""
        return _integrate(self)[:2]


def bent_state(beam: Beam, strain: str, curvature: str, guess: np.ndarray) -> BentOracle:
    """The state next to a guess of m, P_x and P_y at the clamp."""
    oracle = BentOracle(beam, strain, curvature, np.asarray(guess, float))
    scale = np.maximum(abs(oracle.clamp), 1.0)

    def tip(values: np.ndarray) -> np.ndarray:
        return _integrate(oracle._replace(clamp=values * scale))[3:6] / scale

    found = root(tip, oracle.clamp / scale, tol=1e-13)
    assert abs(found.fun).max() < 1e-7, found.message
    return oracle._replace(clamp=found.x * scale)


def _slope(oracle: BentOracle, z: np.ndarray) -> np.ndarray:
    """The derivative (6, ...) of z = (x, y, a, m, P_x, P_y) by x; z may be complex."""
    beam, (_, _, a, m, Px, Py) = oracle.beam, z
    c, s = np.cos(a), np.sin(a)
    f = _stretch(oracle, m, Px * c + Py * s)
    q = _load(beam, z[:2])
    return np.array(
        [f * c, f * s, m / f ** POWER[oracle.curvature], -f * (Py * c - Px * s), -q[0], -q[1]]
    )


def _load(beam: Beam, r: np.ndarray) -> np.ndarray:
    x, y = r[0] + beam.delta, r[1]
    turn = beam.gamma**2
    return np.array([turn * x + beam.spin_up * y, turn * y - beam.spin_up * x])


def _stretch(oracle: BentOracle, m: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """f by bracketing, then by Newton's method, through which small imaginary parts pass: m and
    pull (k,) have equal real parts."""
    (e, de), p, mu2 = STRAIN[oracle.strain], POWER[oracle.curvature], oracle.beam.mu**2

    def excess(f, m, pull):
        return mu2 * e(f) * de(f) + p * f ** (-p - 1) * m**2 / 2 - pull

    real = float(np.real(m).flat[0]), float(np.real(pull).flat[0])
    low = high = 1.0
    while excess(high, *real) < 0:
        high *= 1.3
    while excess(low, *real) > 0:
        low /= 1.1
    f = brentq(excess, low, high, args=real, xtol=1e-15) if high > low else 1.0
    h = 1e-6
    for _ in range(2):
        slope = (excess(f + h, m, pull) - excess(f - h, m, pull)) / (2 * h)
        f = f - excess(f, m, pull) / slope
    return f


def _integrate(
    oracle: BentOracle,
    columns: np.ndarray | None = None,
    omega: complex = 0.0,
    coriolis: bool = False,
) -> np.ndarray:
    """The state at the tip, (6,); with columns (3, k), tip conditions (3, k) of the linearised
    solutions that leave the clamp with these m and P."""
    beam = oracle.beam
    swirl = 2j * beam.gamma * omega if coriolis else 0.0
    count = 0 if columns is None else columns.shape[1]
    z0 = np.concatenate((np.zeros(3), oracle.clamp))
    start = np.zeros((6, count), complex if count else float)
    if count:
        start[3:] = columns * np.maximum(abs(oracle.clamp), 1.0)[:, None]

    def jacobian(z: np.ndarray) -> np.ndarray:
        return _slope(oracle, z[:, None] + 1j * STEP * np.eye(6)).imag / STEP

    def inertia(d: np.ndarray) -> np.ndarray:
        dx, dy = d
        return np.array([omega**2 * dx + swirl * dy, omega**2 * dy - swirl * dx])

    def slope(_: float, packed: np.ndarray) -> np.ndarray:
        z, d = packed[:6].real, packed[6:].reshape(6, count)
        dz = _slope(oracle, z)
        dd = jacobian(z) @ d if count else d
        if count:
            dd[4:] -= inertia(d[:2])
        return np.concatenate((dz, dd.ravel()))

    def step(packed: np.ndarray) -> np.ndarray:
        z, d = packed[:6].real, packed[6:].reshape(6, count).copy()
        new = z.copy()
        new[4:] -= beam.alpha * _load(beam, z[:2])
        if count:
            turn, spin = beam.gamma**2, beam.spin_up
            d[4:] -= beam.alpha * (np.array([[turn, spin], [-spin, turn]]) @ d[:2] + inertia(d[:2]))
        return np.concatenate((new, d.ravel()))

    packed = np.concatenate((z0, start.ravel()))
    has_mass = beam.alpha > 0 and beam.beta > 0
    ends = [0.0, *([beam.beta] if has_mass and beam.beta < 1 else []), 1.0]
    for a, b in pairwise(ends):
        packed = solve_ivp(slope, (a, b), packed, **TOLERANCE).y[:, -1]
        if has_mass and b == beam.beta:
            packed = step(packed)
    return packed[6:].reshape(6, count)[3:] if count else packed
