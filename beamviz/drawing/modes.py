"""Mode shapes sampled along the beam, and the rate at which they are played."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Self

import numpy as np
from scipy.integrate import cumulative_trapezoid, trapezoid

from beamviz.beam import Beam
from beamviz.drawing.sizes import drawn_bodies, jumps
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver.solution import Solution

STATIONS = 601
CLOSE = 1e-6  # distance from an end of the beam within which a mass is drawn at the end
SAMPLES = np.linspace(0.0, 1.0, 401)
CACHED_POSITIONS = 100  # of the mass, whose stations are cached
LAYER = 0.05  # [beam lengths] typical width of a boundary layer
SIGN_STRIDE = 8  # every 8th station determines the sign of a mode
MAX_STRAIN = 0.6  # of the displacement drawn; at 1 the beam would be folded


@dataclass(frozen=True)
class SampledModes:
    """Equilibrium and mode shapes of a solution at some stations [beam lengths from the clamp].

    Vectors have c = 2 components, along the beam and across it in its plane; where it bends in both
    planes c = 3: along it, in the plane of rotation, out of it.
    """

    beam: Beam
    plane: str
    x: np.ndarray  # (n,) stations
    centreline: np.ndarray  # (n, c) the equilibrium
    strain: np.ndarray  # (n - 1,) axial strain of the equilibrium
    labels: tuple[str, ...] = ()
    frequencies: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (m,)
    # (m, n, c) mode shapes with largest displacement 1
    modes: np.ndarray = field(default_factory=lambda: np.zeros((0, STATIONS, 2)))
    limits: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (m,) largest amplitudes
    nodes: Sequence[np.ndarray] = ()  # positions x (j,) of the nodes of each mode
    solution: Solution | None = None
    # The largest displacement where the modes are parts of the same motion, None where each moves
    # for itself.
    largest: float | None = None
    tip_path: np.ndarray | None = None  # (t, c) from the clamp, of modes that are such parts

    @classmethod
    def sampled(
        cls, solution: Solution, previous: Self | None = None, x: np.ndarray | None = None
    ) -> Self:
        """The modes of a solution, with the signs of `previous`; x: other stations than usual."""
        x = stations(*fixed_places(solution.beam)) if x is None else x
        labels = identify_modes(solution).labels
        equilibrium = solution.equilibrium
        local = np.moveaxis(solution.displacement(x), 2, 0)  # along and across the beam's axis
        local = local / np.linalg.norm(local, axis=2).max(axis=1)[:, None, None]
        centreline, _, angle = equilibrium.curve(x)
        if solution.problem.in_space:
            centreline = np.column_stack((centreline, np.zeros(len(x))))
        modes = rotated(local, angle)
        along = local[:, :, 0]
        larger = local[range(len(modes)), :, solution.larger_component]
        stretching = np.abs(np.diff(along) / np.diff(x)).max(axis=1)
        return cls(
            beam=solution.beam,
            plane=solution.problem.plane,
            x=x,
            centreline=centreline,
            strain=equilibrium.stretch((x[:-1] + x[1:]) / 2) - 1.0,
            labels=labels,
            frequencies=solution.frequencies,
            modes=modes if previous is None else align_signs(modes, labels, x, previous),
            limits=MAX_STRAIN / np.maximum(stretching, 1e-12),
            nodes=node_positions(x, larger),
            solution=solution,
        )

    @classmethod
    def at_rest(cls, beam: Beam, plane: str) -> Self:
        """The undeformed beam without modes, for a beam without a solution."""
        x = stations(*fixed_places(beam))
        line = np.zeros((len(x), 3 if plane == "both" else 2))
        line[:, 0] = x
        return cls(beam, plane, x, line, np.zeros(len(x) - 1), modes=np.zeros((0, *line.shape)))

    @cached_property
    def strains(self) -> np.ndarray:
        """A bound (m, n - 1) of |axial strain| of each mode over time."""
        strains = axial_strain(self, self.modes) - self.strain
        return np.abs(strains.real) + np.abs(strains.imag)

    @cached_property
    def mass(self) -> int:
        """The index of the station of the concentrated mass."""
        return self.station(self.beam.beta)

    @cached_property
    def bodies(self) -> list[int]:
        """The indices of the stations of `drawn_bodies`."""
        return [self.station(body.beta) for body in drawn_bodies(self.beam)]

    @cached_property
    def breaks(self) -> list[int]:
        """The ascending indices of the stations where the stretch may jump: at the mass, at all
        bodies and where the section jumps."""
        return sorted({self.station(place) for place in fixed_places(self.beam)})

    def station(self, place: float) -> int:
        """The index of the station that is nearest to a place."""
        return int(np.argmin(np.abs(self.x - place)))


def fixed_places(beam: Beam) -> tuple[float, ...]:
    """Where a station has to be: at the mass, at all bodies and where the section jumps."""
    return (beam.beta, *(body.beta for body in beam.masses), *jumps(beam))


@lru_cache(CACHED_POSITIONS)
def stations(mass: float, *others: float) -> np.ndarray:
    """Stations (n,) in 0 .. 1 for a mass at `mass` and other places where the stretch may be
    discontinuous, read-only: half of them equally spaced, half in possible boundary layers, at the
    clamp and on both sides of these places. One is at each place. All beams with the same places
    share the array."""
    layers = np.exp(-SAMPLES / LAYER)
    for place in (mass, *others):
        layers += np.exp(-np.abs(SAMPLES - place) / LAYER)
    density = 1.0 + layers / trapezoid(layers, SAMPLES)
    share = cumulative_trapezoid(density, SAMPLES, initial=0.0)
    x = np.interp(np.linspace(0.0, share[-1], STATIONS), share, SAMPLES)
    x[0], x[-1] = 0.0, 1.0
    if CLOSE < mass < 1.0 - CLOSE:
        x[1 + np.argmin(np.abs(x[1:-1] - mass))] = mass
    for place in others:
        if np.abs(x - place).min() > CLOSE:
            x = np.insert(x, np.searchsorted(x, place), place)
    x.flags.writeable = False
    return x


def rotated(local: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Fields (m, n, c) along and across an axis at angles (n,) in the plane of motion, in the axes
    of the hub."""
    if not angle.any():
        return local
    c, s = np.cos(angle), np.sin(angle)
    u, w = local[..., 0], local[..., 1]
    return np.stack((c * u - s * w, s * u + c * w), axis=-1)


def node_positions(x: np.ndarray, components: np.ndarray) -> list[np.ndarray]:
    """Nodes (j,) of each mode: the zeros of its larger component (m, n), given at x (n,). Linear
    interpolation, accurate to 1e-4; `Solution.nodes` is converged, but slower."""
    far = components[np.arange(len(components)), np.abs(components).argmax(axis=1)]
    v = ((np.conj(far) / np.abs(far))[:, None] * components).real  # complex with Coriolis forces
    k, i = np.nonzero(v[:, 1:-1] * v[:, 2:] < 0)
    before, after = v[k, i + 1], v[k, i + 2]
    nodes = x[i + 1] + (x[i + 2] - x[i + 1]) * before / (before - after)
    return np.split(nodes, np.searchsorted(k, np.arange(1, len(v))))


def align_signs(
    modes: np.ndarray, labels: Sequence[str], x: np.ndarray, previous: SampledModes
) -> np.ndarray:
    """`modes` (m, n, c), each with the sign (the phase, if complex) of the mode of the same label
    in `previous`: a sign is arbitrary, and would change at random while a slider moves."""
    aligned, some = modes.copy(), slice(None, None, SIGN_STRIDE)
    known = dict(zip(previous.labels, previous.modes, strict=True))
    for label, new in zip(labels, aligned, strict=True):
        if label not in known:
            continue
        old = known[label]
        common = old[some]
        if x is not previous.x:
            common = np.stack([np.interp(x[some], previous.x, column) for column in old.T], 1)
        overlap = np.vdot(common, new[some])
        overlap = overlap if np.iscomplexobj(new) else overlap.real
        if abs(overlap) > 1e-6:
            new *= np.conj(overlap) / abs(overlap)
    return aligned


def displacement(shapes: SampledModes, phases: np.ndarray, amplitudes: np.ndarray) -> np.ndarray:
    """Displacement (n, c) of the centreline at phases (m,) [rad] for amplitudes (m,)."""
    rows = shapes.modes.reshape(len(amplitudes), shapes.centreline.size)
    if np.iscomplexobj(rows):
        moved = ((amplitudes * np.exp(1j * phases)) @ rows).imag
    else:
        moved = (amplitudes * np.sin(phases)) @ rows
    return moved.reshape(shapes.centreline.shape)


def axial_strain(shapes: SampledModes, moved: np.ndarray) -> np.ndarray:
    """Axial strain (..., n - 1): of the equilibrium and, to first order, of `moved` (..., n, c)."""
    step = np.diff(shapes.centreline, axis=0)
    tangent = step / np.linalg.norm(step, axis=1, keepdims=True)
    return shapes.strain + (np.diff(moved, axis=-2) * tangent).sum(axis=-1) / np.diff(shapes.x)


# [s] on screen: longest period of the slowest mode, shortest of the fastest and of a rotation.
SLOWEST, FASTEST, TURN = 2.5, 0.6, 1.5
AT_REST = 1e-5  # [1/T*] a smaller speed or frequency is as good as none: the rate would be infinite


def playback_rate(frequencies: np.ndarray, gamma: float) -> float:
    """The time [T*] per second on screen at which the slowest motion is visible and the fastest can
    be followed; frequencies: of the modes shown [1/T*], gamma: rotation speed [1/T*]; those below
    AT_REST are no motion."""
    seen = frequencies[np.isfinite(frequencies) & (frequencies > AT_REST)]
    longest = [2 * math.pi / gamma / TURN] if gamma > AT_REST else []
    if len(seen):
        longest += [2 * math.pi / seen.min() / SLOWEST, 2 * math.pi / seen.max() / FASTEST]
    return min(longest, default=0.1)
