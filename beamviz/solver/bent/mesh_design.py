"""Meshes of bent beams: a first one, graded towards bending layers, and its refinement."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.solver.bent.beam import BentBeam, BentModes, State
from beamviz.solver.hp.mesh import Mesh, make_mesh, reference
from beamviz.solver.hp.mesh_design import distances, subdivided
from beamviz.solver.problem import Problem

FIRST_ORDER, HIGHEST_ORDER, LONGEST_ELEMENT = 10, 16, 0.5
LAYER, GRADING = 3.0, 4.0  # first element in widths of a bending layer; ratio of neighbours
CELLS = 40  # of the beam, for an estimate of its tension
MOST_STRETCH = 30.0  # of that estimate
SETTLED = 0.05  # relative change of its stretch after which it is good enough


class FoldedBeam(NamedTuple):
    """An estimate of the beam pulled straight outward from its clamp, at the middles of cells."""

    x: np.ndarray  # (CELLS,)
    stretch: np.ndarray  # (CELLS,)
    carries_load: bool  # whether its strain law has the force for it
    width: np.ndarray  # (CELLS,) of a bending layer: sqrt of bending stiffness over tension


def folded_beam(beam: Beam, problem: Problem) -> FoldedBeam:
    """The beam folded over at its clamp, where the load pulls it."""
    law, power = problem.strain_law, 4 - 2 * problem.curvature_power
    x = (np.arange(CELLS) + 0.5) / CELLS
    load = max(beam.gamma**2, abs(beam.spin_up))
    f = np.ones(CELLS)
    most = min(law.max_stretch, MOST_STRETCH)
    for _ in range(CELLS):
        arm = abs(beam.delta) + np.cumsum(f) / CELLS
        at_mass = beam.alpha * np.interp(beam.beta, x, arm) * (x <= beam.beta)
        tension = load * (np.cumsum(arm[::-1])[::-1] / CELLS + at_mass)
        with np.errstate(invalid="ignore"):
            found = np.clip(law.stretch(tension / beam.mu**2), 1.0, most)
        change, f = abs(found / f - 1).max(), found
        if change < SETTLED:
            break
    return FoldedBeam(
        x, f, bool(f.max() < most), f ** ((power - 1) / 2) / np.sqrt(np.maximum(tension, 1.0))
    )


def first_mesh(beam: Beam, problem: Problem) -> Mesh:
    """Elements graded towards the layers of bending at the clamp and at the concentrated mass."""
    folded = folded_beam(beam, problem)
    ends = [0.0, beam.beta, 1.0] if beam.alpha and 0 < beam.beta < 1 else [0.0, 1.0]
    breaks = set(ends)
    for a, b in pairwise(ends):
        inside = folded.width[(folded.x > a) & (folded.x < b)]
        first, last = (inside[0], inside[-1]) if len(inside) else (1.0, 1.0)
        half = (b - a) / 2
        breaks |= {a + distance for distance in distances(LAYER * first, GRADING, half)}
        if b < 1:
            breaks |= {b - distance for distance in distances(LAYER * last, GRADING, half)}
    spread = subdivided(sorted(breaks), 1 / LONGEST_ELEMENT)
    return make_mesh(tuple(spread), (FIRST_ORDER,) * (len(spread) - 1))


def tails(bent: BentBeam, Q: np.ndarray, parity: int) -> np.ndarray:
    """The part of values Q (2 n, ...) in the two highest polynomials of every second element."""
    found = np.zeros_like(Q)
    for half in (0, len(bent.w)):
        end = half
        for k, order in enumerate(bent.mesh.orders):
            block = slice(end, end + order)
            if k % 2 == parity:
                found[block] = reference(order).last_two @ Q[block]
            end += order
    return found


def refined_mesh(state: State, modes: BentModes, tolerance: float) -> Mesh:
    """A mesh with a higher order, or halves, where the tails of the state or of a shape are."""
    bent, n = state.beam, len(state.f)
    q = tails(bent, state.q, 0) + tails(bent, state.q, 1)
    V = abs(tails(bent, modes.V, 0)) ** 2 + abs(tails(bent, modes.V, 1)) ** 2
    stiffness = 1 / bent.scale**2
    breaks, orders, start = [0.0], [], 0
    lengths = np.diff(bent.mesh.breaks)
    for order, length, end in zip(bent.mesh.orders, lengths, bent.mesh.breaks[1:], strict=True):
        block = slice(start, start + order)
        angle = math.sqrt(length * (bent.w[block] @ q[n:][block] ** 2))
        stretch = math.sqrt(length * (bent.w[block] @ q[:n][block] ** 2))
        strain = stiffness[block] @ V[block] + stiffness[n:][block] @ V[n:][block]
        shapes = strain / (modes.frequencies**2 + modes.growth_rates**2)
        needed = max(max(angle, stretch) * 10, math.sqrt(shapes.max())) / math.sqrt(tolerance)
        start += order
        if needed > 1 and order >= HIGHEST_ORDER:
            breaks += [end - length / 2, end]
            orders += [order, order]
        else:
            breaks.append(end)
            orders.append(order + (6 if needed > 10 else 4 if needed > 1 else 2))
    return make_mesh(tuple(breaks), tuple(orders))
