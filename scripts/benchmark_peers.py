"""A sweep of 201 speeds against the closest peer, in one run: python scripts/benchmark_peers.py

Exudyn (`pip install exudyn`, not needed for anything else) has the same planar cubic elements,
with the engineering strain and the material curvature (ANCFCable2D). The centrifugal force comes
in as an object of its own: K = -gamma^2 M, and its load. Both solve the same beams for 6 modes in
one thread, warm, assembly included. The peer's error is against its own continuum limit, which is
this program's `auto` with strain biot and curvature material. Nothing but equilibrium and
frequencies is timed: this program's error bars and the tracking of its chart come on top.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from beamviz import Beam, loci, solve
from beamviz.mechanics import assembly, inertia
from beamviz.mechanics.basis import uniform
from beamviz.mechanics.solve import solve_many

POINTS, MODES = 201, 6
MODEL: dict[str, Any] = {"strain": "biot", "curvature": "material"}
HELD = (0, 1, 3)  # r1, r2 and r2' of the first node


def peer_model(exudyn: Any, beam: Beam, elements: int) -> Any:
    """The beam as an assembled Exudyn system."""
    from exudyn import beams, utilities

    system = exudyn.SystemContainer().AddSystem()
    cable = utilities.Cable2D(
        physicsMassPerLength=1, physicsBendingStiffness=1, physicsAxialStiffness=beam.mu**2
    )
    nodes = beams.GenerateStraightLineANCFCable2D(
        system,
        positionOfNode0=[0, 0, 0],
        positionOfNode1=[1, 0, 0],
        numberOfElements=elements,
        cableTemplate=cable,
    )[0]
    at = uniform(elements)
    m = planar(inertia.scalar_mass(at, beam.alpha, beam.beta))
    q = np.zeros(4 * len(at))
    q[0::4], q[2::4] = at + beam.delta, 1
    load = beam.gamma**2
    system.AddObject(
        utilities.ObjectGenericODE2(
            nodeNumbers=list(nodes),
            massMatrix=planar(inertia.point_mass(at, beam.alpha, beam.beta)),
            stiffnessMatrix=-load * m,
            forceVector=load * (m @ q),
        )
    )
    ground = system.AddNode(utilities.NodePointGround())
    fixed = system.AddMarker(utilities.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in HELD:
        held = utilities.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate)
        markers = [fixed, system.AddMarker(held)]
        system.AddObject(utilities.CoordinateConstraint(markerNumbers=markers))
    system.Assemble()
    return system


def planar(m: np.ndarray) -> np.ndarray:
    """Element masses of one component as the full matrix for r1, r2, r1', r2' of each node."""
    mass = assembly.dense(assembly.band(m))
    full = np.zeros((2 * len(mass), 2 * len(mass)))
    along = np.arange(len(mass)) // 2 * 4 + np.arange(len(mass)) % 2 * 2
    for rows in (along, along + 1):
        full[np.ix_(rows, rows)] = mass
    return full


def peer_solve(exudyn: Any, beam: Beam, elements: int) -> np.ndarray:
    """The lowest frequencies (MODES,) by the peer."""
    from exudyn.solver import ComputeODE2Eigenvalues

    system = peer_model(exudyn, beam, elements)
    settings = exudyn.SimulationSettings()
    settings.staticSolver.verboseMode = 0
    settings.solution.file.write = False
    system.SolveStatic(settings, updateInitialValues=True)
    squares = ComputeODE2Eigenvalues(
        system,
        settings,
        useSparseSolver=False,
        numberOfEigenvalues=MODES,
        constrainedCoordinates=list(HELD),
        ignoreAlgebraicEquations=True,
    )[0]
    return np.sqrt(squares)


def peer_sweep(exudyn: Any, beams: list[Beam], elements: int) -> None:
    for beam in beams:
        peer_solve(exudyn, beam, elements)


def one_by_one(beams: list[Beam]) -> None:
    for beam in beams:
        solve(beam, MODES, **MODEL)


def least(work: Callable[[], object], repeats: int) -> float:
    """The least time [ms] of several calls; the first call warms up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times)


def main() -> int:
    """Print one line for each way to sweep."""
    try:
        import exudyn
    except ImportError:
        print("Exudyn is not installed: pip install exudyn", file=sys.stderr)
        return 1
    beam, speeds = Beam(alpha=1), np.linspace(0, 15, POINTS)
    beams = [beam.replace(gamma=gamma) for gamma in speeds]
    exact = solve(beams[-1], MODES, tolerance=1e-9, **MODEL).frequencies
    chart = least(partial(loci, beam, "gamma", speeds, MODES, **MODEL), 10)
    ours = least(partial(solve_many, beams, modes=MODES, **MODEL), 10)
    error = abs(solve(beams[-1], MODES, **MODEL).frequencies / exact - 1).max()
    print(f"{'201 speeds, 6 modes':34}{'ms':>9}{'error':>10}{'/ auto':>9}")
    print(f"{'auto':34}{ours:9.1f}{error:10.0e}{1:9.1f}")
    apart = least(partial(one_by_one, beams), 2)
    print(f"{'auto, 201 separate solves':34}{apart:9.1f}{error:10.0e}{apart / ours:9.1f}")
    print(f"{'auto, tracked with meetings':34}{chart:9.1f}{error:10.0e}{chart / ours:9.1f}")
    for elements in (5, 10, 20):
        name = f"Exudyn {exudyn.__version__}, {elements} elements"
        try:
            theirs = least(partial(peer_sweep, exudyn, beams, elements), 1)
        except exudyn.SolverError as failure:
            print(f"{name:34}failed: {failure}")
            continue
        error = abs(peer_solve(exudyn, beams[-1], elements) / exact - 1).max()
        print(f"{name:34}{theirs:9.1f}{error:10.0e}{theirs / ours:9.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
