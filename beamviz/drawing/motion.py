"""A computed motion, drawn with the shapes that the scene draws.

The displacements from the unloaded beam are a sum of some principal shapes (by singular values).
Each moves like a mode whose phase has its present size as its sine.
"""

import math
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.forces import ForceSource, MotionForces
from beamviz.drawing.modes import SampledModes, stations
from beamviz.dynamics import Motion
from beamviz.dynamics.linear import LinearMotion
from beamviz.scene import ViewOptions

UNSTIFFENED = "without stiffening"  # title of the linear theory beside a motion
MAX_SHAPES = 12  # principal shapes that a motion is drawn with
DRAWN = 2e-4  # [L] deviation of the drawn beam that is not seen
SAMPLED = 200  # times that the shapes are computed from


class MotionShapes:
    """The principal shapes of a motion. t: (n,) equal intervals, or those of the motion; sampled:
    the shapes as modes; amplitudes: of each (k,) [L]; parts: their sizes over time (n, k) [L]."""

    def __init__(self, motion: Motion | LinearMotion, t: NDArray | None = None):
        self.motion, beam = motion, motion.beam
        self.t = motion.t if t is None else t
        self.x = x = stations(beam.beta if beam.alpha else 1.0)
        unloaded = np.stack([x, np.zeros_like(x)], axis=1)

        def moved(t: NDArray) -> NDArray:
            """The displacements (len(t), 2 stations) at times; at all of them they take 30 MB."""
            return (motion.position(t, x) - unloaded).reshape(len(t), -1)

        some = moved(self.t[:: math.ceil(len(self.t) / SAMPLED)])
        _, sizes, shapes = np.linalg.svd(some, full_matrices=False)
        left = np.sqrt(np.append(np.cumsum(sizes[::-1] ** 2)[::-1], 0.0))
        count = min(MAX_SHAPES, max(1, int((left > DRAWN * math.sqrt(some.size)).sum())))
        largest = np.linalg.norm(shapes[:count].reshape(count, len(x), 2), axis=2).max(axis=1)
        largest = np.where(largest > 0, largest, 1.0)
        parts, far = [], 0.0
        for times in np.split(self.t, np.arange(SAMPLED, len(self.t), SAMPLED)):
            rows = moved(times)
            parts.append(rows @ shapes[:count].T)
            far = max(far, float(np.linalg.norm(rows.reshape(-1, 2), axis=1).max()))
        self.parts = np.concatenate(parts) * largest
        self.amplitudes = np.maximum(abs(self.parts).max(axis=0), 1e-12)
        modes = shapes[:count].reshape(count, len(x), 2) / largest[:, None, None]
        self.sampled = SampledModes(
            beam.replace(gamma=0.0),
            plane="chordwise",
            x=x,
            centreline=unloaded,
            strain=np.zeros(len(x) - 1),
            labels=tuple(f"{k + 1}" for k in range(count)),
            frequencies=np.zeros(count),
            modes=modes,
            limits=np.full(count, np.inf),
            largest=far,
            tip_path=unloaded[-1] + self.parts @ modes[:, -1],
        )

    @cached_property
    def forces(self) -> MotionForces | None:
        """The forces in it; None in the linear theory, which has none of the second order."""
        return MotionForces(self.motion, self.x) if isinstance(self.motion, Motion) else None

    def phases(self, t: float) -> NDArray:
        """The phases (k,) [rad] at a time, at most at the end of the motion."""
        sizes = np.array([np.interp(t, self.t, column) for column in self.parts.T])
        return np.arcsin(np.clip(sizes / self.amplitudes, -1, 1))

    @property
    def until(self) -> float:
        """The time at which it ends."""
        return float(self.motion.t[-1])

    def angle(self, t: float) -> float:
        """The angle of the hub [rad] at a time."""
        return float(np.interp(t, self.motion.t, self.motion.angle))

    def gamma(self, t: float) -> float:
        """The speed at a time."""
        return float(np.interp(t, self.motion.t, self.motion.gamma))


def drawn(
    sampled: SampledModes,
    amplitudes: NDArray,
    beam: Beam,
    view: ViewOptions,
    scale: float,
    title: str = "",
    forces: ForceSource | None = None,
) -> DrawnBeam:
    """A motion as a beam to draw: displacements as they are, without nodes of modes."""
    view = view.changed("colouring", "displacement").changed("all_modes", False)
    view = view.changed("nodes", False)
    shapes = replace(sampled, beam=beam)
    return DrawnBeam(shapes, view, scale, amplitudes, title=title, forces_of_motion=forces)


def drawn_beam(motion: Motion) -> Beam:
    """The beam of a motion, to draw: at whatever speed above 0 the rotation has an arrow."""
    beam, fastest = motion.beam, float(abs(motion.gamma).max())
    return beam.replace(gamma=min(fastest, beam.mu))


def dominant_frequency(motion: Motion) -> NDArray:
    """The frequency [1/T*] of the largest vibration of the tip (1,)."""
    frequency, amplitude = motion.spectrum()
    return frequency[[amplitude[1:].argmax() + 1]]
