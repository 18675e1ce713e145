"""Exudyn: the same planar cubic elements (ANCFCable2D), in a general multibody program.

Its own energy has the engineering strain f - 1 and the material curvature; user functions for the
axial force and the bending moment (the first is ignored without the second) give it the paper's.
The centrifugal force is an object of its own beside the beam: K = -gamma^2 M, and its load.
"""

from collections.abc import Iterator
from functools import partial
from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.benchmark.external import Peer
from beamviz.errors import NotConverged

HELD = (0, 1, 3)  # r1, r2 and r2' of the first node
LOAD_STEPS = (1, 20)  # tried in turn
SPARSE = 80  # elements from which its sparse eigensolver is the faster one
HERMITE = np.array(  # mass of a cubic element, value and slope of each end, times 420 / length
    [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
)


def solve(energy: str, beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 of the lowest modes (modes,). Raises NotConverged."""
    exudyn: Any = import_module("exudyn")
    exudyn.config.printToConsole = False  # its failures would go to stdout
    settings = exudyn.SimulationSettings()
    settings.staticSolver.verboseMode = 0
    settings.solution.file.write = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    for steps in LOAD_STEPS:
        settings.staticSolver.numberOfLoadSteps = steps
        system, nodes = model(energy, beam, elements)
        if loaded(system, settings):
            break
    else:
        raise NotConverged(f"Exudyn's static solver failed with {LOAD_STEPS[-1]} load steps")
    check_upright(exudyn, system, nodes)
    squares = import_module("exudyn.solver").ComputeODE2Eigenvalues(
        system,
        settings,
        useSparseSolver=elements >= SPARSE,
        numberOfEigenvalues=modes,
        constrainedCoordinates=list(HELD),
        ignoreAlgebraicEquations=True,
    )[0]
    return np.sort(squares)[:modes]


def loaded(system: Any, settings: Any) -> bool:
    """Whether the static solver found an equilibrium."""
    try:
        system.SolveStatic(settings, updateInitialValues=True)
    except Exception:  # its own class, and plain ones from C++
        return False
    return True


def check_upright(exudyn: Any, system: Any, nodes: list[Any]) -> None:
    """NotConverged for a beam that came out folded: its frequencies look plausible."""
    kind = exudyn.OutputVariableType.Position
    x = [system.GetNodeOutput(node, kind)[0] for node in nodes]
    if not np.all(np.diff(x) > 0):
        raise NotConverged(f"Exudyn landed on an inverted beam, its tip at {x[-1]:.3g}")


def model(energy: str, beam: Beam, elements: int) -> tuple[Any, list[Any]]:
    """The beam as an assembled Exudyn system, and its nodes."""
    exudyn: Any = import_module("exudyn")
    utilities: Any = import_module("exudyn.utilities")
    system = exudyn.SystemContainer().AddSystem()
    laws = paper_laws(beam.mu) if energy == "paper" else {}
    h = 1 / elements
    nodes = [
        system.AddNode(utilities.NodePoint2DSlope1(referenceCoordinates=[n * h, 0, 1, 0]))
        for n in range(elements + 1)
    ]
    for e, (distributed, point) in enumerate(element_masses(beam, elements)):
        ends = [nodes[e], nodes[e + 1]]
        system.AddObject(
            utilities.Cable2D(
                nodeNumbers=ends,
                length=h,
                massPerLength=1,
                bendingStiffness=1,
                axialStiffness=beam.mu**2,
                **laws,
            )
        )
        load = beam.gamma**2 * (distributed + point)
        q = np.array([e * h + beam.delta, 0, 1, 0, (e + 1) * h + beam.delta, 0, 1, 0])
        system.AddObject(
            utilities.ObjectGenericODE2(
                nodeNumbers=ends, massMatrix=point, stiffnessMatrix=-load, forceVector=load @ q
            )
        )
    ground = system.AddNode(utilities.NodePointGround())
    fixed = system.AddMarker(utilities.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in HELD:
        held = utilities.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate)
        markers = [fixed, system.AddMarker(held)]
        system.AddObject(utilities.CoordinateConstraint(markerNumbers=markers))
    system.Assemble()
    return system, nodes


def paper_laws(mu: float) -> dict[str, Any]:
    """Axial force and bending moment of mu^2 (f^2 - 1)^2 / 8 + (kappa / f)^2 / 2, kappa the
    material curvature and f = 1 + strain."""

    def force(system, t, item, x, strain, rate, strain0, EA, damping, kappa, kappa_t, kappa0):
        f = 1 + strain
        return mu**2 * (f * f - 1) * f / 2 - kappa**2 / f**3

    def moment(system, t, item, x, kappa, kappa_t, kappa0, EI, damping, strain, rate, strain0):
        return kappa / (1 + strain) ** 2

    return {"axialForceUserFunction": force, "bendingMomentUserFunction": moment}


def element_masses(beam: Beam, elements: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Mass matrices (8, 8) of each element and of the concentrated mass in it, for r1, r2, r1',
    r2' of both its nodes."""
    h = 1 / elements
    scale = np.array([1, h, 1, h])
    distributed = np.kron(h / 420 * HERMITE * np.outer(scale, scale), np.eye(2))
    for e in range(elements):
        s = beam.beta * elements - e
        S = np.zeros(4)
        if 0 < s <= 1:
            S = scale * [
                1 - s * s * (3 - 2 * s),
                s * (1 - s) ** 2,
                s * s * (3 - 2 * s),
                s * s * (s - 1),
            ]
        yield distributed, beam.alpha * np.kron(np.outer(S, S), np.eye(2))


RESOLUTIONS = (5, 10, 20, 40, 80, 160)
HOW = "pip install exudyn"
EXUDYN = (
    Peer(
        "Exudyn",
        "biot",
        RESOLUTIONS,
        partial(solve, "own"),
        partial(version, "exudyn"),
        HOW,
        "its own energy: engineering strain, material curvature",
    ),
    Peer(
        "Exudyn, paper's energy",
        "green",
        RESOLUTIONS,
        partial(solve, "paper"),
        partial(version, "exudyn"),
        HOW,
        "the paper's energy by user functions in Python",
    ),
)
