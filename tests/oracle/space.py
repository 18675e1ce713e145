"""The oracle of a beam that bends in both planes at once.

As in `oracle`, with displacements v in the plane of rotation and w out of it, their rotations t_v
and t_w, moments and shear forces, u along the beam:

    v' = f t_v    w' = f t_w    (t_v, t_w)' = f^(2c) D^-1 (m_v, m_w)    u' = p / (mu^2 EA n'(f))
    m' = f (N t - V)    V_v' = -(omega^2 + gamma^2) rho v    V_w' = -omega^2 rho w
    p' = -(omega^2 + gamma^2) rho u

D is the stiffness of the section, EI and that out of the plane, turned by phi = pitch + twist x and
the twist of the blade. With Coriolis the motion is (u, i v, i w) exp(i omega t), and p' and V_v'
have the terms of `oracle`. At a body m_i jumps by (gamma^2 H_ij - omega^2 J_ij) t_j with the
inertia J, Jz and Jy, turned with the section, and H_ww = J_vv - Jx alone.
"""

import numpy as np

from beamviz import Beam
from oracle import CURVATURE, Spectrum, eigen, embedded, properties
from oracle.collocation import Coefficients, Mesh
from oracle.eigen import Pencil
from oracle.equilibrium import LAWS, Resolution, equilibrium, resolving_mesh, shoot, stretch

U, V, TV, W, TW, P, VV, MV, VW, MW = range(10)
PLANES = ((V, TV, VV, MV), (W, TW, VW, MW))


class SpaceSpectrum(Spectrum):
    """Equilibrium and modes in space of one beam at one resolution."""

    def __init__(self, beam: Beam, strain: str, curvature: str, level: Resolution):
        self.gamma, self.delta, self.c = beam.gamma, beam.delta, CURVATURE[curvature]
        self.beam, self.plane = beam, "both"
        start = shoot(beam, strain)
        meshes = [
            resolving_mesh(beam, strain, self.c, level, start, bend) for bend in ("bending", "flap")
        ]
        self.mesh = union(*meshes, beam)
        state = equilibrium(self.mesh, beam, strain, start)
        self.X, self.tip = state[::2], float(state[-2] - beam.delta)
        self.N = self.mesh.at_points(state, 2)[..., 1]
        EI, flap, axial = (
            properties.at(beam, name, self.mesh.x) for name in ("bending", "flap", "axial")
        )
        self.EI = np.minimum(EI, flap)
        c, s = turn(beam, self.mesh.x)
        self.compliance = {
            (0, 0): c**2 / EI + s**2 / flap,
            (0, 1): c * s * (1 / EI - 1 / flap),
            (1, 1): s**2 / EI + c**2 / flap,
        }
        self.compliance[1, 0] = self.compliance[0, 1]
        axial = beam.mu**2 * axial
        self.f = stretch(strain, self.N / axial)
        self.stiffness = axial * LAWS[strain].stiffness(self.f)
        self.force = np.max(self.stiffness), np.max(np.abs(self.N)) + 1
        self.moment = np.sqrt(self.force[1])

    def static(self) -> Coefficients:
        """The coefficients without inertia; moments and forces in their units."""
        f, unit = self.f, self.moment
        found = embedded(self._stretching(), (U, P))
        for i, (displacement, angle, force, moment) in enumerate(PLANES):
            found[displacement, angle] = f
            found[moment, angle] = f * self.N / unit
            found[moment, force] = -f * self.force[1] / unit
            for j, (_, _, _, other) in enumerate(PLANES):
                found[angle, other] = f ** (2 * self.c) * unit * self.compliance[i, j]
        return found

    def pencil(self, coriolis: bool) -> Pencil:
        """A y = omega B y + omega^2 C y; without Coriolis C is empty, and omega stands for its
        square."""
        mesh, gamma = self.mesh, self.gamma
        p, V_ = 1 / self.force[0], 1 / self.force[1]
        C = mesh.mass(10, {(P, U): -p, (VV, V): -V_, (VW, W): -V_})
        softened = mesh.mass(10, {(P, U): -p, (VV, V): -V_})
        A = mesh.differences(10) - mesh.integral(10, self.static()) - gamma**2 * softened
        for (i, j), sizes in self.body_matrices(static=True).items():
            A = A - mesh.jumps(10, (PLANES[i][3], PLANES[j][1]), sizes)
        for (i, j), sizes in self.body_matrices(static=False).items():
            C = C + mesh.jumps(10, (PLANES[i][3], PLANES[j][1]), sizes)
        if self.beam.root < np.inf:
            share = 1 / (1 + self.beam.root)
            for _, angle, _, moment in PLANES:
                A = A + mesh.matrix(10, angle, angle, self.beam.root * share - 1)
                A = A + mesh.matrix(10, angle, moment, -share * self.moment)
        if not coriolis:
            return Pencil(A, C, 0 * C)
        B = 2 * gamma * mesh.mass(10, {(P, V): p, (VV, U): V_})
        return Pencil(A, B, C)

    def body_matrices(self, static: bool) -> dict[tuple[int, int], list[float]]:
        """Jumps of the moments by the angles at each body: gamma^2 H, or -J."""
        rows = []
        for _, body in self.mesh.bodies:
            Jx, Jy, Jz = body.inertia
            c, s = turn(self.beam, np.array(body.beta))
            R = np.array([[c, -s], [s, c]])
            J = R @ np.diag([Jz, Jy]) @ R.T
            H = np.diag([0.0, J[0, 0] - Jx])
            rows.append((self.gamma**2 * H if static else -J) / self.moment)
        return {(i, j): [float(row[i, j]) for row in rows] for i in (0, 1) for j in (0, 1)}

    def squares(self, modes: int, coriolis: bool) -> np.ndarray:
        """omega^2 of the lowest modes."""
        definite = self.delta >= 0
        if not coriolis:
            if definite:
                values, _ = eigen.lowest(self.pencil(coriolis=False), modes)
                return values
            return eigen.lowest_indefinite(self.pencil(coriolis=False), modes, self.least)
        pencil = self.pencil(coriolis=True)
        if not definite and self.squares(1, coriolis=False)[0] < 0:
            return eigen.lowest_gyroscopic_indefinite(pencil, modes, self.least)
        return eigen.squares(eigen.lowest_gyroscopic(pencil, modes))


def turn(beam: Beam, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine of the angle of the section at x."""
    own = 0.0 if beam.blade is None else properties.at(beam, "twist", x)
    angle = np.radians(beam.pitch + beam.twist * np.asarray(x) + own)
    return np.cos(angle), np.sin(angle)


def union(first: Mesh, second: Mesh, beam: Beam) -> Mesh:
    """The elements between the ends of those of both."""
    lefts = np.union1d(first.lefts, second.lefts)
    lengths = np.diff(np.append(lefts, 1.0))
    mesh = Mesh(lefts, lengths, first.points, np.zeros(0), ())
    rights = lefts + lengths
    bodies = tuple(
        (int(np.argmin(abs(rights - body.beta))), body) for body in beam.bodies if body.beta
    )
    return Mesh(lefts, lengths, first.points, properties.at(beam, "mass", mesh.x), bodies)
