"""An independent oracle: a straight rotating beam from its differential equations.

Nothing here is shared with the package but `Beam` and, of a law without formulas here, the function
e(f). The package makes an energy stationary over trial functions; the oracle takes the differential
equations that follow from that energy, as a first-order system, and makes them hold at Chebyshev
points.

Strong form. Lengths in L, times in T*, forces in EI / L^2, x the reference coordinate in 0 .. 1.
X is the distance from the axis of rotation, f = X' the stretch, N = mu^2 n(f) the axial force,
n = e(f) e'(f): (f^2 - 1) f / 2 (green), f - 1 (biot), ln f / f (hencky). Varying

    E = int mu^2 e(f)^2 / 2 + k^2 / 2 - gamma^2 rho r^2 / 2 dx,   rho = 1 + alpha Dirac(x - beta)

about the straight state gives

    equilibrium   X' = f(N)               N' = -gamma^2 rho X
    stretching    v' = p / (mu^2 n'(f))   p' = -Lambda rho v
    bending       w' = f theta            theta' = f^(2c) m
                  m' = f (N theta - V)    V' = -Lambda rho w

theta is the rotation, m the moment, V the shear force; k = theta' / f^c with c = 1 for the spatial
curvature, c = 0 for the material one. Clamp: X = delta, v = w = theta = 0. Tip: N = p = m = V = 0.
N, p and V jump at the mass, nothing else does; a mass at the tip makes them jump to zero there.
Lambda is omega^2 + gamma^2 for motions in the plane of rotation and omega^2 out of it. With
Coriolis the motion is (v, i w) exp(i omega t) and

    p' = -rho (Lambda v - 2 gamma omega w),   V' = -rho (Lambda w - 2 gamma omega v).

Of a blade rho, EI and EA vary with x: N = mu^2 EA n(f), theta' = f^(2c) m / EI. A body adds alpha
to rho, and its rotary inertia a jump of m by -omega^2 Jz theta in the plane of rotation, and out of
it by (gamma^2 (Jz - Jx) - omega^2 Jy) theta. With a root spring K theta(0) = m(0).

Numerics. Collocation on elements that halve toward the clamp, the mass and the tip until they
resolve the local lengths; eigenvalues by an Arnoldi process about zero frequency and inverse
iteration about each. Everything is computed at two resolutions that share no points; the
difference is returned, and too large a one raises `UnresolvedError`. A missed mode would show
too: where N >= 0, mode k has k - 1 nodes (Gantmacher & Krein, Oscillation Matrices and Kernels),
and they are counted. A beam in compression (delta < 0) may buckle, omega^2 < 0: then all
eigenvalues of the full matrix are found, and the lowest refined.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from beamviz.beam import Beam
from oracle import eigen, properties
from oracle.collocation import Coefficients
from oracle.eigen import Pencil, UnresolvedError, sign_changes
from oracle.equilibrium import LAWS, Resolution, equilibrium, resolving_mesh, shoot, stretch

AT_REST = 12.0  # omega^2 of a beam at rest, its lowest
CURVATURE = {"spatial": 1, "material": 0}  # c

FINE = (Resolution(18, 1.0, 1.5), Resolution(23, 0.8, 1.1))
QUICK = (Resolution(12, 1.0, 1.5), Resolution(16, 0.8, 1.3))


@dataclass(frozen=True)
class Truth:
    """omega^2 [1/T*^2] ascending (k,), by how much the two resolutions differ (k,), families,
    and the equilibrium: reference points x, stretch there, place of the tip."""

    squares: np.ndarray
    square_differences: np.ndarray
    families: tuple[str, ...]
    x: np.ndarray
    stretch: np.ndarray
    tip: float  # from the clamp

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies [1/T*]; nan where unstable."""
        return np.sqrt(np.where(self.squares >= 0, self.squares, np.nan))

    @property
    def differences(self) -> np.ndarray:
        """By how much the two resolutions differ in frequency or rate of growth."""
        return self.square_differences / (2 * np.sqrt(np.abs(self.squares)))


def truth(
    beam: Beam,
    modes: int = 5,
    strain: str = "green",
    curvature: str = "spatial",
    plane: str = "chordwise",
    coriolis: bool = False,
    resolutions: tuple[Resolution, Resolution] = FINE,
    accuracy: float = 1e-9,
) -> Truth:
    """The lowest frequencies of a straight beam.

    Raises NoStateError without an equilibrium, UnresolvedError where the two resolutions differ
    by more than `accuracy` (relative; of a beam that may buckle, relative to one at rest at least).
    """
    if coriolis and plane == "flapwise":
        raise ValueError("Coriolis couples stretching with bending in the plane of rotation only")
    if plane == "both":
        from oracle.space import SpaceSpectrum

        spectra = [SpaceSpectrum(beam, strain, curvature, level) for level in resolutions]
        coarse, fine = (spectrum.squares(modes, coriolis) for spectrum in spectra)
        families = ["mixed"] * modes
        return compared(beam, curvature, spectra[1], coarse, fine, families, accuracy)
    spectra = [Spectrum(beam, strain, curvature, level, plane) for level in resolutions]
    if coriolis:
        coarse, fine = (spectrum.coupled(modes) for spectrum in spectra)
        families = ["mixed"] * modes
    else:
        coarse, fine = (
            np.concatenate([spectrum.bending(modes, plane), spectrum.stretching(modes)])
            for spectrum in spectra
        )
        families = ["bending"] * modes + ["stretching"] * modes
    return compared(beam, curvature, spectra[1], coarse, fine, families, accuracy, modes)


def compared(
    beam: Beam,
    curvature: str,
    found: "Spectrum",
    coarse: np.ndarray,
    fine: np.ndarray,
    families: list[str],
    accuracy: float,
    modes: int | None = None,
) -> Truth:
    """The lowest modes of both resolutions, of the finer `found`; UnresolvedError where they
    differ."""
    lowest = np.argsort(fine)[:modes]
    fine, differences = fine[lowest], np.abs(fine - coarse)[lowest]
    size = np.abs(fine) + (0.0 if beam.delta >= 0 else AT_REST)
    if not np.all(differences <= 2 * accuracy * size):
        raise UnresolvedError(
            f"{beam.numbers}, {curvature}: differs by {np.max(differences / size) / 2:.1e}"
        )
    kinds = tuple(families[k] for k in lowest)
    return Truth(fine, differences, kinds, found.mesh.x.ravel(), found.f.ravel(), found.tip)


class Spectrum:
    """Equilibrium and modes of one beam at one resolution."""

    def __init__(
        self, beam: Beam, strain: str, curvature: str, level: Resolution, plane: str = "chordwise"
    ):
        self.gamma, self.delta, self.c = beam.gamma, beam.delta, CURVATURE[curvature]
        self.beam, self.plane = beam, plane
        self.bend = "bending" if plane == "chordwise" else "flap"
        start = shoot(beam, strain)
        self.mesh = resolving_mesh(beam, strain, self.c, level, start, self.bend)
        state = equilibrium(self.mesh, beam, strain, start)
        self.X = state[::2]
        self.tip = float(state[-2] - beam.delta)
        self.N = self.mesh.at_points(state, 2)[..., 1]  # (elements, p)
        self.EI, axial = (properties.at(beam, name, self.mesh.x) for name in (self.bend, "axial"))
        axial = beam.mu**2 * axial
        self.f = stretch(strain, self.N / axial)
        self.stiffness = axial * LAWS[strain].stiffness(self.f)
        # units of p, V and of m that keep all unknowns of one size
        self.force = np.max(self.stiffness), np.max(np.abs(self.N)) + 1
        self.moment = np.sqrt(self.force[1])

    @property
    def least(self) -> float:
        """A lower bound of omega^2: a wave in a compressed beam has -N^2 / 4 or more, stretched."""
        most = float(np.max(self.f)) ** (2 + 4 * self.c)
        most = max(1.0, most) / float(np.min(self.EI) * np.min(self.mesh.rho))
        return -(self.gamma**2) - 4 * AT_REST - float(np.min(self.N)) ** 2 * most

    def bending(self, modes: int, plane: str = "chordwise") -> np.ndarray:
        """omega^2 of the lowest bending modes; an inward beam may buckle, and hide nodes."""
        spin = self.gamma**2 if plane == "chordwise" else 0.0
        if self.delta < 0:
            B = self.mesh.mass(4, {(2, 0): -1 / self.force[1]})
            A = self.mesh.differences(4) - self.mesh.integral(4, self._bending()) - spin * B
            A, B = A + self._static_turning(4), B + self._turning(4)
            return eigen.lowest_indefinite(Pencil(A, B, 0 * B), modes, self.least)
        squares, Y = self._family(self._bending(), 1 / self.force[1], modes, spin)
        for k in np.flatnonzero(squares < spin / 100):
            squares[k] = self._balance(Y[:, k])
        return squares

    def _balance(self, y: np.ndarray) -> float:
        """omega^2 in the plane of rotation, from the moments about the axis of rotation.

        The clamp's moment and shear turn the beam: m(0) + delta V(0) = omega^2 int rho X w. It
        follows from the equations above, and keeps the digits that Lambda - gamma^2 loses.
        """
        moment, shear = self.moment * y[3], self.force[1] * y[2]
        momentum = np.sum(self.mesh.inertia * self.X * y[::4])
        for element, body in self.mesh.bodies:
            momentum += body.inertia[2] * y[self.mesh.unknown(4, element + 1, -1, 1)]
        return (moment + self.delta * shear) / momentum

    def _turning(self, d: int) -> Any:
        """Jumps of the moment at bodies, by their rotary inertia, times omega^2."""
        axis = 2 if self.plane == "chordwise" else 1
        pair = (3, 1) if d == 4 else (5, 2)
        sizes = [-body.inertia[axis] / self.moment for _, body in self.mesh.bodies]
        return self.mesh.jumps(d, pair, sizes)

    def _static_turning(self, d: int) -> Any:
        """What a root spring and the centrifugal force on turned bodies change in A."""
        mesh, root = self.mesh, self.beam.root
        theta, m = (1, 3) if d == 4 else (2, 5)
        sizes = [0.0 for _ in mesh.bodies]
        if self.plane == "flapwise":
            sizes = [
                self.gamma**2 * (body.inertia[2] - body.inertia[0]) / self.moment
                for _, body in mesh.bodies
            ]
        change = -mesh.jumps(d, (m, theta), sizes)
        if root < np.inf:  # instead of theta = 0 at the clamp: root theta = m
            share = 1 / (1 + root)
            change = change + mesh.matrix(d, theta, theta, root * share - 1)
            change = change + mesh.matrix(d, theta, m, -share * self.moment)
        return change

    def stretching(self, modes: int) -> np.ndarray:
        """omega^2 of the lowest stretching modes: positive, as the equilibrium is stable."""
        squares, _ = self._family(self._stretching(), 1 / self.force[0], modes, self.gamma**2)
        return squares

    def _stretching(self) -> Coefficients:
        """(v, p)' in (v, p), without Lambda."""
        return {(0, 1): self.force[0] / self.stiffness}

    def _bending(self) -> Coefficients:
        """(w, theta, V, m)' in (w, theta, V, m), without Lambda; m and V in their units."""
        f, N, unit = self.f, self.N, self.moment
        return {
            (0, 1): f,
            (1, 3): f ** (2 * self.c) * unit / self.EI,
            (3, 1): f * N / unit,
            (3, 2): -f * self.force[1] / unit,
        }

    def _family(
        self, static: Coefficients, unit: float, modes: int, spin: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """omega^2 and unknowns of one family, Lambda = omega^2 + spin: A y = omega^2 B y."""
        mesh, d = self.mesh, 2 if len(static) == 1 else 4
        B = mesh.mass(d, {(d // 2, 0): -unit})
        A = mesh.differences(d) - mesh.integral(d, static) - spin * B
        if d == 4:
            A, B = A + self._static_turning(4), B + self._turning(4)
        squares, Y = eigen.lowest(Pencil(A, B, 0 * B), modes)
        if any(any(body.inertia) for _, body in mesh.bodies):
            return squares, Y  # nodes are not counted
        for k in range(modes):
            if (found := sign_changes(Y[::d, k])) != k:
                raise UnresolvedError(f"mode {k + 1} has {found} nodes")
        return squares, Y

    def _coupled(self) -> Pencil:
        """A y = omega B y + omega^2 C y in (v, w, theta, p, V, m)."""
        mesh, p, V = self.mesh, 1 / self.force[0], 1 / self.force[1]
        C = mesh.mass(6, {(3, 0): -p, (4, 1): -V})
        B = 2 * self.gamma * mesh.mass(6, {(3, 1): p, (4, 0): V})
        static = embedded(self._stretching(), (0, 3)) | embedded(self._bending(), (1, 2, 4, 5))
        A = mesh.differences(6) - mesh.integral(6, static) - self.gamma**2 * C
        return Pencil(A + self._static_turning(6), B, C + self._turning(6))

    def response(self, omega: float, coriolis: bool) -> np.ndarray:
        """Displacements (points, 2) under the force (i, -1) exp(i omega t) on each mass: they are
        (i v, -w), where (1, 1) adds to the accelerations of (v, w)."""
        A, B, C = self._coupled()
        each = np.tile([1.0, 1.0, 0.0, 0.0, 0.0, 0.0], A.shape[0] // 6)
        y = eigen.factorised(A - omega**2 * C - omega * coriolis * B)(C @ each)
        return self.mesh.at_points(y, 6)[..., :2].reshape(-1, 2) * [1j, -1]

    def coupled(self, modes: int) -> np.ndarray:
        """omega^2 with Coriolis."""
        pencil = self._coupled()
        if self.delta < 0 and self.bending(1)[0] < 0:
            return eigen.lowest_gyroscopic_indefinite(pencil, modes, self.least)
        return eigen.squares(eigen.lowest_gyroscopic(pencil, modes))


def embedded(coefficients: Coefficients, unknowns: tuple[int, ...]) -> Coefficients:
    """The coefficients with their unknowns renumbered."""
    return {(unknowns[a], unknowns[b]): c for (a, b), c in coefficients.items()}
