"""Bent states and their modes from the differential equations, sharing only `Beam`.

State z = (x, y, a, m, P_x, P_y): position and angle, and the moment and force that the part
further out exerts; n = (-sin a, cos a), t = (cos a, sin a), b = f^p the bending stiffness:

    x' = f cos a,  y' = f sin a,  a' = m / b(f),  m' = -f P . n,  P' = -rho q,
    mu^2 e e' + b'(f) (m / b)^2 / 2 = P . t,
    q = gamma^2 R + lambda (R_y, -R_x),  R = r + delta e1.

x, y and a vanish at the clamp (with a root spring, K a = m), m and P at the tip; at a body P has a
step -alpha q and m a step lambda Jz. Of a blade rho, b and mu^2 vary with x. Modes: the
same equations linearised, with omega^2 d (and 2 i gamma omega (d_y, -d_x) for Coriolis forces) in
q. Chebyshev collocation and eigenvalues as for straight beams, on elements that halve towards the
clamp, the mass and the tip, at two resolutions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import splu

from beamviz import Beam
from oracle import eigen, properties
from oracle.collocation import Mesh, refined_mesh
from oracle.eigen import Pencil, UnresolvedError
from oracle.equilibrium import LAWS

POWER = {"spatial": -2, "material": 0}  # of b(f)
STEP = 1e-30  # of a complex derivative
D = 6  # unknowns
RESOLUTIONS = ((14, 1.5), (18, 1.0))  # points of an element; its length in layers at the ends
LONGEST = 0.1
NEWTON_STEPS, NEWTON_TOLERANCE = 25, 1e-10


@dataclass(frozen=True)
class BentTruth:
    """omega (k,) complex [1/T*], ascending by real part, the differences (k,) between the two
    resolutions, and the tip (2,) from the clamp."""

    omega: np.ndarray
    differences: np.ndarray
    tip: np.ndarray


def bent_truth(
    beam: Beam,
    strain: str,
    curvature: str,
    coriolis: bool,
    count: int,
    guess: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]],
) -> BentTruth:
    """The state next to a guess, and its lowest modes.

    guess: position (k, 2), angle (k,) and stretch (k,) at points (k,). Raises UnresolvedError.
    """
    found = []
    for points, layers in RESOLUTIONS:
        problem = _Problem(beam, strain, curvature, _mesh(beam, points, layers, guess))
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                z, f = problem.state(guess)
        except FloatingPointError as error:  # Newton's method diverges
            raise UnresolvedError(f"{beam}: no bent state next to the guess: {error}") from error
        found.append((problem.modes(z, f, coriolis, count), z[-D:][:2]))
    (coarse, _), (omega, tip) = found
    return BentTruth(omega, abs(omega - coarse), tip)


def _mesh(beam: Beam, points: int, layers: float, guess: Callable) -> Mesh:
    """Elements that halve towards the ends of what is smooth, down to the width of a layer."""
    x = np.linspace(0, 1, 401)
    r, _, f = guess(x)
    arm = np.hypot(r[:, 0] + beam.delta, r[:, 1])
    load = beam.gamma**2 + abs(beam.spin_up)
    carried = sum(body.alpha * np.interp(body.beta, x, arm) for body in beam.bodies)
    tension = load * ((arm * properties.at(beam, "mass", x)).mean() + carried)
    softest = properties.at(beam, "bending", x).min()
    narrowest = layers / np.sqrt(1 + tension * f.max() ** 3 / softest)

    def longest(x: float, h: float, distance: float) -> float:
        inside = x + h * np.linspace(1e-9, 1 - 1e-9, 9)
        waves, change = properties.reduced(beam, inside, "bending")
        return min(LONGEST * min(1.0, waves), layers * change, max(distance, narrowest))

    return refined_mesh(properties.ends(beam), beam, points, longest)


class _Problem:
    def __init__(self, beam: Beam, strain: str, curvature: str, mesh: Mesh):
        self.beam, self.strain, self.curvature, self.mesh = beam, strain, curvature, mesh
        self.clamped = self.skeleton = mesh.differences(D)
        if beam.root < np.inf:  # instead of a = 0 at the clamp: root a = m
            share = 1 / (1 + beam.root)
            spring = mesh.matrix(D, 2, 2, beam.root * share - 1) + mesh.matrix(D, 2, 3, -share)
            self.skeleton = self.clamped + spring
        self.EI, self.EA = (properties.at(beam, name, mesh.x) for name in ("bending", "axial"))
        self.turning = [body.inertia[2] for _, body in mesh.bodies]
        self.integral = mesh.integral(D, {(a, a): np.ones_like(mesh.x) for a in range(D)})
        turn, spin = beam.gamma**2, beam.spin_up
        load = {(4, 0): -turn, (5, 1): -turn, (4, 1): -spin, (5, 0): spin}
        self.load = mesh.mass(D, load)  # of P by r, spread and at the mass
        self.hub_load = self.load @ np.tile([beam.delta, 0, 0, 0, 0, 0], mesh.size(1))
        for (element, _), inertia in zip(mesh.bodies, self.turning, strict=True):
            self.hub_load[mesh.equation(D, element, mesh.points, 3)] += spin * inertia

    def state(self, guess: Callable) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns z and the stretch (elements, p) of the state, by Newton's method."""
        mesh = self.mesh
        x = np.append(np.column_stack([mesh.lefts, mesh.x]), 1.0)
        r, a, f = guess(x)
        z = np.column_stack((r, a, np.zeros((len(x), 3)))).ravel()
        f = f[:-1].reshape(len(mesh.lefts), -1)[:, 1:]
        for _ in range(5):  # P_x and P_y, then m, that balance the load of the guess
            slope = np.zeros_like(z)
            mesh.at_points(slope, D)[:] = self._slope(mesh.at_points(z, D), f)[0]
            load = self.integral @ slope + self.load @ z + self.hub_load
            z.reshape(-1, D)[:, 3:] = splu(self.clamped).solve(load).reshape(-1, D)[:, 3:]
        last = np.inf
        scale = np.tile(np.maximum(abs(z.reshape(-1, D)).max(axis=0), 1.0), len(x))
        for _ in range(NEWTON_STEPS):
            F, C, f = self.slopes(z, f)
            slope = np.zeros_like(z)
            mesh.at_points(slope, D)[:] = F
            residual = self.skeleton @ z - self.integral @ slope - self.load @ z - self.hub_load
            A = self.skeleton - mesh.integral(D, C) - self.load
            step = splu(A.tocsc()).solve(-residual)
            z, size = z + step, abs(step / scale).max()
            if not np.isfinite(size) or size > 1e3:
                break
            if size < NEWTON_TOLERANCE or (size < 1e-7 and size > last / 2):
                return z, f
            last = size
        raise UnresolvedError(f"{self.beam}: no bent state next to the guess")

    def slopes(self, z: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, dict, np.ndarray]:
        """z' without the load (elements, p, 6), its derivatives by z, and the stretch."""
        at = self.mesh.at_points(z, D)
        F, f = self._slope(at, f)
        C = {}
        for b in range(D):
            moved = at.astype(complex)
            moved[..., b] += 1j * STEP
            column = self._slope(moved, f)[0].imag / STEP
            C |= {(a, b): column[..., a] for a in range(D) if column[..., a].any()}
        return F, C, f

    def _slope(self, z: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, m, Px, Py = np.moveaxis(z[..., 2:], -1, 0)
        c, s = np.cos(a), np.sin(a)
        f = self._stretch(m, Px * c + Py * s, f)
        zero = np.zeros_like(f)
        bending = self.EI * f ** POWER[self.curvature]
        slope = (f * c, f * s, m / bending, -f * (Py * c - Px * s), zero, zero)
        return np.stack(slope, axis=-1), f

    def _stretch(self, m: np.ndarray, pull: np.ndarray, f: np.ndarray) -> np.ndarray:
        """f from the force along the beam, on the branch where it grows with the force; by Newton's
        method, through which small imaginary parts pass."""
        n, dn = LAWS[self.strain].force, LAWS[self.strain].stiffness
        p, mu2, EI = POWER[self.curvature], self.beam.mu**2 * self.EA, self.EI
        f = f.astype(m.dtype)
        for _ in range(60):
            excess = mu2 * n(f) + p * f ** (-p - 1) * m**2 / (2 * EI) - pull
            slope = mu2 * dn(f) + p * (-p - 1) * f ** (-p - 2) * m**2 / (2 * EI)
            step = np.clip((excess / slope).real, -0.3 * f.real, 0.3 * f.real) + (
                1j * (excess / slope).imag if np.iscomplexobj(f) else 0
            )
            f = f - step
            if abs(step / f).max() < 1e-14:
                break
        return f

    def modes(self, z: np.ndarray, f: np.ndarray, coriolis: bool, count: int) -> np.ndarray:
        """The lowest omega (count,), complex."""
        mesh, (_, C, _) = self.mesh, self.slopes(z, f)
        A = (self.skeleton - mesh.integral(D, C) - self.load).tocsc()
        swirl = 2 * self.beam.gamma * coriolis * mesh.mass(D, {(4, 1): -1.0, (5, 0): 1.0})
        inertia = mesh.mass(D, {(4, 0): 1.0, (5, 1): 1.0})
        inertia = inertia + mesh.jumps(D, (3, 2), self.turning)
        return eigen.lowest_gyroscopic(Pencil(A, swirl, inertia), count, -1j)
