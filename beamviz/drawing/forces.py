"""The forces on a rotating beam in the frame of its hub, on pieces of it and on its bodies.

A piece of the mass m at R from the axis of rotation, which moves with v relative to the hub, has
the centrifugal, the Coriolis and the Euler force

    gamma^2 m R,    -2 gamma m e_z x v,    -gamma' m e_z x R.

Of the centrifugal force the part along the undeformed beam makes the tension, which stiffens the
beam; the part across it, in the plane of rotation alone, grows with the displacement and softens
it. In complex numbers, along the undeformed beam and across it in the plane of rotation, they are
terms of the force of inertia (`mechanics.inertia`). Forces are in units of E I / L^2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.sizes import drawn_bodies
from beamviz.dynamics import Motion
from beamviz.mechanics.inertia import Loading, Number

PIECES = 8  # of the beam
BAND = 80  # pieces of the band of the tension, besides those that end at bodies
PULL, SOFTENING, CORIOLIS, EULER = "pull", "softening", "Coriolis", "Euler"
KINDS = PULL, SOFTENING, CORIOLIS, EULER
NONE = 1e-9  # of the largest force: what rounding leaves of none
SAMPLED = 200  # times of a motion at which its largest forces are looked for


class Forces(NamedTuple):
    """The forces at one moment."""

    on_pieces: Mapping[str, NDArray]  # of each kind, complex (k,): see `ForcePieces`
    tension: NDArray  # (b,) at the stations of the band; compression is negative


@dataclass(frozen=True, eq=False)
class ForcePieces:
    """The pieces of equal lengths of a beam, and then its bodies, but for those at the clamp, which
    the hub carries: k in all.

    x: (k,) their middle; bodies: how many of them are bodies; mass: (k,); integrals: (k, n) of the
    mass times a field that is given at n stations.
    """

    x: NDArray
    bodies: int
    mass: NDArray
    integrals: NDArray

    @classmethod
    def of(cls, beam: Beam, stations: NDArray) -> "ForcePieces":
        """Those of a beam whose fields are given at stations (n,)."""
        edges = np.linspace(0.0, 1.0, PIECES + 1)
        bodies = [body for body in drawn_bodies(beam) if body.beta > 0]
        ends = np.union1d(stations, edges)
        middle, length = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
        rho = np.ones(len(middle)) if beam.blade is None else beam.blade.at("mass", middle)
        weights = rho * length * interpolation(stations, middle).T  # (n, parts)
        piece = np.searchsorted(edges, middle) - 1
        rows = [weights[:, piece == k].sum(axis=1) for k in range(PIECES)]
        rows += [body.alpha * interpolation(stations, np.array([body.beta]))[0] for body in bodies]
        integrals = np.array(rows)
        x = np.append([(a + b) / 2 for a, b in pairwise(edges)], [body.beta for body in bodies])
        return cls(x, len(bodies), integrals.sum(axis=1), integrals)

    def sums(self, fields: NDArray, *, in_plane: bool) -> NDArray:
        """The integrals (..., k, 2) of fields (..., n, c) times the mass: along the beam, and
        across it in the plane of rotation."""
        sums = self.integrals @ fields[..., :2]
        if not in_plane:
            sums[..., 1] = 0.0
        return sums

    def greatest(self, forces: NDArray) -> tuple[float, float]:
        """The greatest size of forces (..., k) on a piece of the beam, and on a body."""
        sizes = np.abs(forces).reshape(-1, len(self.x)).max(axis=0)
        return float(sizes[:PIECES].max()), float(sizes[PIECES:].max(initial=0.0))


def interpolation(x: NDArray, at: NDArray) -> NDArray:
    """The matrix (j, n) of linear interpolation between x (n,) at points (j,)."""
    k = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    part = (at - x[k]) / (x[k + 1] - x[k])
    matrix, row = np.zeros((len(at), len(x))), np.arange(len(at))
    matrix[row, k], matrix[row, k + 1] = 1 - part, part
    return matrix


def band_stations(beam: Beam) -> NDArray:
    """Stations (b,) of the band: two at each body, where the tension has a step."""
    places = np.array([body.beta for body in drawn_bodies(beam) if 0 < body.beta < 1])
    return np.union1d(np.linspace(0.0, 1.0, BAND + 1), [*places, *np.nextafter(places, 1)])


def inertial_forces(
    R: NDArray, v: NDArray, gamma: Number, rate: Number, *, in_plane: bool
) -> dict[str, NDArray]:
    """The forces of each kind, complex (..., k), on pieces of masses m: from m R and m v (..., k),
    complex, the speed of the hub, and its rate."""
    centrifugal = -Loading(gamma, in_plane=in_plane).inertia(R)
    none = np.zeros_like(R)
    return {
        PULL: centrifugal.real + 0j,
        SOFTENING: 1j * centrifugal.imag,
        CORIOLIS: -Loading(gamma).inertia(none, v) if in_plane else none,
        EULER: -Loading(0.0, rate).inertia(R),
    }


def as_complex(sums: NDArray) -> NDArray:
    """Vectors (..., 2) in the plane of rotation as complex numbers."""
    return sums[..., 0] + 1j * sums[..., 1]


def present(largest: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """The kinds of forces that are more than rounding leaves of none."""
    least = NONE * max(max(sizes) for sizes in largest.values())
    return {kind: sizes for kind, sizes in largest.items() if max(sizes) > least}


class ForceSource:
    """What is known of the forces on a beam besides the moment.

    pieces: those that forces are on; band: stations (b,) of the tension; largest: of each kind that
    there is, at any time, on a piece of the beam and on a body; tensions: the least and the
    greatest, below 0 for compression; at_root: the tension at the root, None where it varies.
    """

    pieces: "ForcePieces"
    band: NDArray
    largest: Mapping[str, tuple[float, float]]
    tensions: tuple[float, float]
    at_root: float | None

    @property
    def greatest_tension(self) -> float:
        """The greatest tension or compression; 0 for none."""
        return max(map(abs, self.tensions))

    def at(self, moment: Any) -> Forces:
        """The forces at the phases (m,) [rad] of modes, or at a time [T*] of a motion."""
        raise NotImplementedError


class ModeForces(ForceSource):
    """The forces on a beam that vibrates in its modes about its equilibrium. A term that its model
    leaves out has no forces: with the stiffening the pull and the tension, with the softening the
    part across, and the Coriolis forces by their factor."""

    def __init__(self, shapes: SampledModes, amplitudes: NDArray):
        solution, beam = shapes.solution, shapes.beam
        assert solution
        problem = solution.problem
        self.beam, self.amplitudes = beam, amplitudes
        self.in_plane = problem.chordwise or problem.in_space
        self.factors = {
            PULL: float(problem.stiffens),
            SOFTENING: float(problem.softening),
            CORIOLIS: problem.coriolis_factor,
            EULER: 1.0,
        }
        self.pieces = ForcePieces.of(beam, shapes.x)
        self.rest = self.pieces.sums(shapes.centreline, in_plane=self.in_plane)
        self.rest[:, 0] += beam.delta * self.pieces.mass
        self.modes = self.pieces.sums(shapes.modes, in_plane=self.in_plane)
        frequencies = np.nan_to_num(shapes.frequencies[: len(shapes.modes)])
        self.rates = amplitudes * frequencies
        self.band = band_stations(beam)
        self.tension = self.factors[PULL] * solution.equilibrium.loads.at(self.band).axial
        self.tensions = float(self.tension.min()), float(self.tension.max())
        self.at_root = float(self.tension[0])
        self.largest = present(self.bounds())

    def bounds(self) -> dict[str, tuple[float, float]]:
        """The largest of each kind at any time, as if all modes were at their largest together."""
        swing = np.tensordot(self.amplitudes, np.abs(self.modes), 1)  # (k, 2)
        speed = np.tensordot(self.rates, np.abs(self.modes), 1)
        farthest = as_complex(np.abs(self.rest) + swing)
        kinds = self.forces(farthest, as_complex(speed))
        return {kind: self.pieces.greatest(values) for kind, values in kinds.items()}

    def forces(self, R: NDArray, v: NDArray) -> dict[str, NDArray]:
        """The forces of each kind, complex (k,), that the model has."""
        beam = self.beam
        forces = inertial_forces(R, v, beam.gamma, beam.spin_up, in_plane=self.in_plane)
        return {kind: self.factors[kind] * values for kind, values in forces.items()}

    def at(self, phases: NDArray) -> Forces:
        """The forces at phases (m,) [rad] of the modes."""
        turned = np.exp(1j * phases)
        moved = np.tensordot(self.amplitudes * turned, self.modes, 1).imag
        velocity = np.tensordot(self.rates * turned, self.modes, 1).real
        return Forces(
            self.forces(as_complex(self.rest + moved), as_complex(velocity)), self.tension
        )


class MotionForces(ForceSource):
    """The forces on a beam in a motion in time, from its positions and velocities and the speed of
    the hub."""

    def __init__(self, motion: Motion, stations: NDArray):
        self.motion, self.stations, beam = motion, stations, motion.beam
        self.pieces, self.band = ForcePieces.of(beam, stations), band_stations(beam)
        self.at_root = None
        some = np.linspace(0.0, float(motion.t[-1]), SAMPLED)
        R, v, gamma, rate = self.state(some)
        kinds = inertial_forces(R, v, gamma, rate, in_plane=True)
        greatest = {kind: self.pieces.greatest(values) for kind, values in kinds.items()}
        self.largest = present(greatest)
        tension = motion.tension(some, self.band)
        self.tensions = float(tension.min()), float(tension.max())

    def state(self, t: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """m R and m v (len(t), k), complex, and the speed and its rate (len(t), 1)."""
        motion, sums = self.motion, self.pieces.sums
        position = as_complex(sums(motion.position(t, self.stations), in_plane=True))
        velocity = as_complex(sums(motion.velocity(t, self.stations), in_plane=True))
        position += motion.beam.delta * self.pieces.mass
        on_beam = np.ones((len(t), len(self.pieces.x)))
        if motion.beam.alpha and motion.beam.beta > 0:  # the first body; one at the clamp is none
            on_beam[:, PIECES] = [motion.has_mass(float(moment)) for moment in t]
        gamma, rate = motion.speed(t)
        return on_beam * position, on_beam * velocity, gamma[:, None], rate[:, None]

    def at(self, t: float) -> Forces:
        """The forces at a time."""
        moment = np.array([min(max(t, 0.0), float(self.motion.t[-1]))])
        R, v, gamma, rate = self.state(moment)
        kinds = inertial_forces(R, v, gamma, rate, in_plane=True)
        on_pieces = {kind: values[0] for kind, values in kinds.items()}
        return Forces(on_pieces, self.motion.tension(moment, self.band)[0])
