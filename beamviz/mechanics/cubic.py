"""A beam on the paper's cubic elements that bends and stretches in one plane (eqs. 2-44).

The unknowns are the coordinates of `cubic_elements` that the clamp leaves free. Positions are
linear in them, r = N q, so that mass, Coriolis and centrifugal matrices are constant:

    M q" + 2 gamma G q' + (gamma' G - gamma^2 M)(q + delta t) + dU/dq = N(x)' F.

The classes have the attributes and methods of `planar` that a motion needs.
"""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.mechanics.cubic_elements import (
    CubicElements,
    assemble,
    assemble_band,
    dense,
    distributed_mass,
    interpolate,
)
from beamviz.mechanics.inertia import Loading
from beamviz.mechanics.planar import Derivatives, Tangents
from beamviz.solver.constitutive import Theory

LARGEST_STEP = 1.0  # of a coordinate at once
HELD = (0, 1, 3)  # coordinates of the first node: r(0), and the direction of r'(0)


class CubicBeam:
    """A clamped beam on elements between `nodes` (n + 1,); its bodies are points."""

    def __init__(self, nodes: NDArray, beam: Beam, theory: Theory, force_at: float = 1.0):
        self.beam, self.theory, self.force_at = beam, theory, force_at
        self.model = CubicElements(nodes, beam, theory)
        self.free = np.setdiff1d(np.arange(4 * len(nodes)), HELD)
        self.size = len(self.free)
        _, points, mass = distributed_mass(nodes, beam)
        self.points = points.ravel()
        bodies = [(body.alpha, body.beta) for body in beam.bodies]
        alpha, beta = np.array(bodies).reshape(-1, 2).T
        self.mass = np.append(mass, alpha)  # (m,) of the points that have mass
        self.N = self.rows(np.append(points, beta))  # (m, size) r by the unknowns
        self.rotary = np.zeros(0)  # of bodies that turn: there are none
        self.rotary_inertia = np.zeros((0, self.size))
        self.loading = Loading(beam.gamma, beam.spin_up, theory.in_plane)

    @property
    def lengths(self) -> NDArray:
        """The size [L] (size,) of the displacement by a unit of each unknown."""
        return np.ones(self.size)

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the elements."""
        return (3,) * (len(self.model.nodes) - 1)

    def rows(self, x: ArrayLike, derivative: int = 0) -> NDArray:
        """r, or its derivative 1 or 2 by x, at points x by the unknowns: complex (len(x), size)."""
        nodes = self.model.nodes
        S = interpolate(nodes, np.eye(2 * len(nodes)), np.atleast_1d(x), derivative)
        return np.kron(S, [1, 1j])[:, self.free]  # coordinates r1, r2, r1', r2' of each node

    def element_coordinates(self, q: NDArray) -> NDArray:
        """Coordinates (..., elements, 8) of unknowns (..., size)."""
        full = np.zeros((*q.shape[:-1], len(self.model.nodes), 4))
        full.reshape(*q.shape[:-1], -1)[..., self.free] = q
        return np.concatenate((full[..., :-1, :], full[..., 1:, :]), axis=-1)

    def nearest(self, f: NDArray, theta: NDArray) -> NDArray:
        """q (size,) of a stretch and an angle at `points`, in least squares."""
        return self._nearest_slope(f * np.exp(1j * theta))

    def nearest_rates(
        self, f: NDArray, theta: NDArray, f_rate: NDArray, theta_rate: NDArray
    ) -> NDArray:
        """v (size,) of the rates of a stretch and an angle at `points`, in least squares."""
        return self._nearest_slope((f_rate + 1j * f * theta_rate) * np.exp(1j * theta))

    def _nearest_slope(self, slope: NDArray) -> NDArray:
        """q whose r' is nearest to a complex one at `points`, in proportion to the mass."""
        root = np.sqrt(self.mass[: len(self.points)])
        rows, slope = root[:, None] * self.rows(self.points, 1), root * slope
        parts = np.concatenate((rows.real, rows.imag))
        return np.linalg.lstsq(parts, np.concatenate((slope.real, slope.imag)))[0]

    def state(self, q: NDArray, loading: Loading | None = None) -> "CubicState":
        """The beam at rest in the rotating frame, under its own loading where none is given."""
        none = np.zeros_like(q)
        return CubicState(self, q, none, none, loading or self.loading)

    def moving(self, q: NDArray, v: NDArray, a: NDArray, loading: Loading) -> "CubicState":
        """The beam in motion; q, v and a are (..., size)."""
        return CubicState(self, q, v, a, loading)


class CubicState:
    """A state of the elements: unknowns q, their velocities v and accelerations a (..., size)."""

    def __init__(self, beam: CubicBeam, q: NDArray, v: NDArray, a: NDArray, loading: Loading):
        self.beam, self.q, self.v, self.loading = beam, q, v, loading
        N = beam.N.T
        self.R, self.velocities = q @ N + beam.beam.delta, v @ N  # (..., m) of the masses
        self.p = beam.mass * loading.inertia(self.R, self.velocities, a @ N)
        self.of_elements = beam.element_coordinates(q)

    @cached_property
    def f(self) -> NDArray:
        """The stretch (..., n) at the Gauss points of the elements."""
        return self.beam.model.strain_state(self.of_elements)[1].reshape(*self.q.shape[:-1], -1)

    def positions(self, x: ArrayLike) -> NDArray:
        """r (..., len(x)) from the clamp at points of the beam."""
        return self.q @ self.beam.rows(x).T

    def velocities_at(self, x: ArrayLike) -> NDArray:
        """The rate of the position (..., len(x)) at points of the beam."""
        return self.v @ self.beam.rows(x).T

    def stretch(self, x: ArrayLike) -> NDArray:
        """f (..., len(x)) at points of the beam."""
        return abs(self.q @ self.beam.rows(x, 1).T)

    def curvature(self, x: ArrayLike) -> NDArray:
        """theta' = (r' x r'') / f^2 (..., len(x)) [1/L] at points of the beam."""
        slope, bend = (self.q @ self.beam.rows(x, k).T for k in (1, 2))
        return (slope.conj() * bend).imag / abs(slope) ** 2

    def displacement_at(self, x: float) -> NDArray:
        """The derivative (size,) of the position of a point by the unknowns."""
        return self.beam.rows(x)[0]

    def step_size(self, step: NDArray) -> float:
        """The size of a step of q in units of the largest that should be taken at once."""
        return float(abs(step).max() / LARGEST_STEP)

    @property
    def body_moments(self) -> NDArray:
        """No moments: bodies are points."""
        return np.zeros((*self.q.shape[:-1], 0))

    @property
    def stored(self) -> Any:
        """Strain energy (...)."""
        return self.beam.model.energy(self.of_elements)

    @property
    def kinetic(self) -> Any:
        """int rho |r'|^2 / 2 (...)."""
        return abs(self.velocities) ** 2 @ self.beam.mass / 2

    @property
    def centrifugal(self) -> Any:
        """gamma^2 / 2 int rho |P R|^2 (...)."""
        axial = self.R if self.loading.in_plane else self.R.real
        return np.squeeze(self.loading.gamma) ** 2 / 2 * (abs(axial) ** 2 @ self.beam.mass)

    @property
    def residual(self) -> NDArray:
        """The left-hand side of the equation of motion (..., size)."""
        beam = self.beam
        inertia = self.p.real @ beam.N.real + self.p.imag @ beam.N.imag
        elastic = assemble(beam.model.force(self.of_elements))[..., beam.free]
        if self.loading.force:
            at = self.displacement_at(beam.force_at)
            inertia = inertia - (np.conj(self.loading.force) * at).real
        return inertia + elastic

    @property
    def stiffness(self) -> NDArray:
        """K (size, size) of a state at rest."""
        return self.tangents()[0].K

    @property
    def inertia(self) -> NDArray:
        """M (size, size)."""
        N = self.beam.N
        return (N.conj().T @ (self.beam.mass[:, None] * N)).real

    def tangents(self) -> tuple[Tangents, Derivatives]:
        """K, C and M of a single state, and what they are made of."""
        beam, loading, N = self.beam, self.loading, self.beam.N
        by_q, by_v = loading.inertia(N), loading.inertia(np.zeros_like(N), N)
        virtual = N.conj().T * beam.mass
        K, C, M = ((virtual @ part).real for part in (by_q, by_v, N))
        elastic = dense(assemble_band(beam.model.stiffness(self.of_elements)))
        K += elastic[np.ix_(beam.free, beam.free)]
        return Tangents(K, C, M), Derivatives(N, by_q, by_v)
