"""Other programs that solve the same beam: Exudyn, OpenSees and CalculiX.

Exudyn has the paper's planar cubic elements (ANCFCable2D). Its own energy has the engineering
strain f - 1 and the material curvature; user functions for axial force and bending moment (the
first is ignored without the second) replace it by the paper's. The centrifugal force is an object
beside each element: K = -gamma^2 M, and its load.

OpenSees has corotational beam elements; masses and the centrifugal force are lumped at the nodes.
Each node carries the load gamma^2 m (x + delta) and springs of stiffness -gamma^2 m along and
across the beam. In its limit: engineering strain, material curvature.

CalculiX has quadratic plane-stress elements of a solid and runs as a process of its own. The beam
is a strip with a square section of height sqrt(12) / mu and Poisson's ratio 0; the mass is a thin,
denser slice of it. A nonlinear static step under the centrifugal force, then frequencies about its
end. A solid has shear and rotary inertia, so it converges to a limit of its own.
"""

import math
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from functools import partial
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from itertools import pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.evidence.benchmark.work_precision import ELEMENTS, Solver


def check_not_inverted(program: str, x: list[float]) -> None:
    """Raise NotConverged for a beam folded back on itself, whose frequencies look plausible."""
    if not np.all(np.diff(x) > 0):
        raise NotConverged(f"{program} converged to an inverted beam, its tip at {x[-1]:.3g}")


# Exudyn

CLAMPED = (0, 1, 3)  # r1, r2 and r2' of the first node
LOAD_STEPS = (1, 20)  # tried in turn
SPARSE = 80  # elements from which its sparse eigensolver is the faster one
HERMITE = np.array(  # mass of a cubic element, value and slope of each end, times 420 / length
    [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
)


def exudyn(energy: str, beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 (modes,) of Exudyn with its "own" energy or the "paper"'s. Raises NotConverged."""
    module = exudyn_module()
    settings = quiet_settings(module)
    laws = paper_laws(beam.mu) if energy == "paper" else {}
    for steps in LOAD_STEPS:
        settings.staticSolver.numberOfLoadSteps = steps
        system, nodes, _ = exudyn_model(beam, elements, beam.gamma, **laws)
        system.Assemble()
        try:
            system.SolveStatic(settings, updateInitialValues=True)
            break
        except Exception:  # its own class, and plain ones from C++
            continue
    else:
        raise NotConverged(f"Exudyn's static solver failed with {LOAD_STEPS[-1]} load steps")
    position = module.OutputVariableType.Position
    check_not_inverted("Exudyn", [system.GetNodeOutput(node, position)[0] for node in nodes])
    options: Any = {"useSparseSolver": elements >= SPARSE, "numberOfEigenvalues": modes}
    options |= {"constrainedCoordinates": list(CLAMPED), "ignoreAlgebraicEquations": True}
    eigenvalues = import_module("exudyn.solver").ComputeODE2Eigenvalues
    return np.sort(eigenvalues(system, settings, **options)[0])[:modes]


def exudyn_module() -> Any:
    module: Any = import_module("exudyn")
    module.config.printToConsole = False  # else it prints errors on stdout
    return module


def quiet_settings(module: Any) -> Any:
    """Settings with which Exudyn neither prints nor writes files."""
    settings = module.SimulationSettings()
    settings.staticSolver.verboseMode = 0
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.linearSolver.solverType = module.LinearSolverType.EigenSparse
    return settings


class ExudynModel(NamedTuple):
    """A clamped beam in Exudyn, not assembled."""

    system: Any
    nodes: list[Any]  # (elements + 1,)
    # For each element the number of an object with its concentrated mass, which takes the forces of
    # the rotating frame, its mass matrix M (8, 8), and its position q (8,) at rest, from the axis.
    bodies: list[tuple[Any, np.ndarray, np.ndarray]]


def exudyn_model(beam: Beam, elements: int, gamma: float = 0.0, **laws: Any) -> ExudynModel:
    """gamma: of the centrifugal force; laws: user functions of a section, see `paper_laws`, by
    default those of Exudyn's energy."""
    items: Any = import_module("exudyn.utilities")
    system = exudyn_module().SystemContainer().AddSystem()
    section = {"massPerLength": 1, "bendingStiffness": 1, "axialStiffness": beam.mu**2}
    h = 1 / elements
    places = [[n * h, 0, 1, 0] for n in range(elements + 1)]
    nodes = [system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=at)) for at in places]
    bodies = []
    for e, (distributed, point) in enumerate(element_masses(beam, elements)):
        ends = [nodes[e], nodes[e + 1]]
        system.AddObject(items.Cable2D(nodeNumbers=ends, length=h, **section, **laws))
        M = distributed + point
        q = np.array([e * h + beam.delta, 0, 1, 0, (e + 1) * h + beam.delta, 0, 1, 0])
        K = gamma**2 * M
        terms = {"massMatrix": point, "stiffnessMatrix": -K, "forceVector": K @ q}
        number = system.AddObject(items.ObjectGenericODE2(nodeNumbers=ends, **terms))
        bodies.append((number, M, q))
    clamp(system, items, nodes[0])
    return ExudynModel(system, nodes, bodies)


def clamp(system: Any, items: Any, node: Any) -> None:
    """Clamp a node of an Exudyn system. items: the module exudyn.utilities."""
    ground = system.AddNode(items.NodePointGround())
    fixed = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in CLAMPED:
        held = items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        markers = [fixed, system.AddMarker(held)]
        system.AddObject(items.CoordinateConstraint(markerNumbers=markers))


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
    """Mass matrices (8, 8) of each element and the mass in it, for r1, r2, r1', r2' of its ends."""
    h = 1 / elements
    scale = np.array([1, h, 1, h])
    distributed = np.kron(h / 420 * HERMITE * np.outer(scale, scale), np.eye(2))
    for e in range(elements):
        s = beam.beta * elements - e
        S = np.zeros(4)
        if 0 < s <= 1:
            value, slope = s * s * (3 - 2 * s), s * s * (s - 1)
            S = scale * [1 - value, s * (1 - s) ** 2, value, slope]
        yield distributed, beam.alpha * np.kron(np.outer(S, S), np.eye(2))


# OpenSees

OPENSEES_STEPS = 10  # of the load
TOLERANCE, ITERATIONS = 1e-10, 50


def opensees(beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 (modes,) of OpenSees. Raises NotConverged."""
    ops: Any = import_module("openseespy.opensees")
    ops.wipe()
    opensees_model(ops, beam, elements)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormUnbalance", TOLERANCE * beam.mu**2, ITERATIONS, 0)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1 / OPENSEES_STEPS)
    ops.analysis("Static")
    if beam.gamma and ops.analyze(OPENSEES_STEPS):
        raise NotConverged("OpenSees: Newton's method did not converge")
    check_not_inverted("OpenSees", [n / elements + ops.nodeDisp(n, 1) for n in range(elements + 1)])
    return np.array(ops.eigen("-genBandArpack", modes))


def opensees_model(ops: Any, beam: Beam, elements: int) -> None:
    """Nodes, elements, lumped masses, springs and loads; the fixed end of a node's springs is
    node `elements + 1` higher."""
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.geomTransf("Corotational", 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for node, m in enumerate(lumped_masses(beam, elements)):
        x, ground = node / elements, node + elements + 1
        ops.node(node, x, 0.0)
        if node == 0:
            ops.fix(node, 1, 1, 1)
            continue
        ops.mass(node, m, m, 0.0)
        ops.element("elasticBeamColumn", node, node - 1, node, beam.mu**2, 1.0, 1.0, 1)
        if beam.gamma:
            ops.node(ground, x, 0.0)
            ops.fix(ground, 1, 1, 1)
            ops.uniaxialMaterial("Elastic", node, -(beam.gamma**2) * m)
            ops.element("zeroLength", ground, ground, node, "-mat", node, node, "-dir", 1, 2)
            ops.load(node, beam.gamma**2 * m * (x + beam.delta), 0.0, 0.0)


def lumped_masses(beam: Beam, elements: int) -> np.ndarray:
    """Mass of each node; the concentrated one is shared by its neighbours."""
    m = np.full(elements + 1, 1 / elements)
    m[[0, -1]] /= 2
    e = min(int(beam.beta * elements), elements - 1)
    share = beam.beta * elements - e
    m[e] += beam.alpha * (1 - share)
    m[e + 1] += beam.alpha * share
    return m


# CalculiX

CCX = "ccx"
ROWS = 5  # of nodes over the height: two elements
SLICE = 0.002  # length of the slice that is the mass, in L
TIMEOUT = 60.0  # [s]
EIGENVALUE = re.compile(r"^ +\d+ +(\S+) +\S+ +\S+ +\S+ *$", re.MULTILINE)
THREADS = {"OMP_NUM_THREADS": "1", "CCX_NPROC_STIFFNESS": "1", "CCX_NPROC_EQUATION_SOLVER": "1"}
CORNERS_AND_MIDSIDES = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))


def calculix(beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 (modes,) of CalculiX. Raises NotConverged."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "beam.inp").write_text("\n".join(calculix_input(beam, elements, modes)))
        options: dict[str, Any] = {"cwd": folder, "env": {**os.environ, **THREADS}}
        try:
            done = run_program("beam", **options, timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            raise NotConverged(f"CalculiX took more than {TIMEOUT:g} s") from None
        values = EIGENVALUE.findall((Path(folder) / "beam.dat").read_text())
    if len(values) < modes:
        errors = re.findall(r"\*ERROR[^\n]*", done.stdout) or ["no frequencies"]
        raise NotConverged(f"CalculiX: {errors[0].strip()}")
    return np.sort(np.array([float(value) for value in values]))[:modes]


def calculix_input(beam: Beam, elements: int, modes: int) -> Iterator[str]:
    """The lines of its input file."""
    height = math.sqrt(12) / beam.mu
    x, dense = node_columns(beam, elements)
    yield "*NODE"
    for i, at in enumerate(x):
        for j in range(ROWS):
            if i % 2 == 0 or j % 2 == 0:
                yield f"{i * ROWS + j + 1}, {at!r}, {height * (j / (ROWS - 1) - 0.5)!r}, 0."
    names = [name for name, kind in (("PLAIN", False), ("DENSE", True)) if kind in dense]
    for name in names:
        yield f"*ELEMENT, TYPE=CPS8R, ELSET={name}"
        for e, k in product(range(len(dense)), range(ROWS // 2)):
            if dense[e] is (name == "DENSE"):
                nodes = [(2 * e + a) * ROWS + 2 * k + b + 1 for a, b in CORNERS_AND_MIDSIDES]
                yield ", ".join(map(str, [e * (ROWS // 2) + k + 1, *nodes]))
        yield f"*SOLID SECTION, ELSET={name}, MATERIAL={name}\n{height!r}"
        rho = 1 / height**2 * (1 + (beam.alpha / SLICE if name == "DENSE" else 0.0))
        yield f"*MATERIAL, NAME={name}\n*ELASTIC\n{12 / height**4!r}, 0."
        yield f"*DENSITY\n{rho!r}"
    yield "*BOUNDARY"
    yield from (f"{node + 1}, 1, 2" for node in range(ROWS))
    if beam.gamma:
        yield "*STEP, NLGEOM, INC=200\n*STATIC\n0.25, 1."
        yield "*CONTROLS, PARAMETERS=FIELD\n1e-8, 1e-8"
        yield "*DLOAD"
        for name in names:
            yield f"{name}, CENTRIF, {beam.gamma**2!r}, {-beam.delta!r}, 0., 0., 0., 0., 1."
        yield "*END STEP"
    yield f"*STEP, PERTURBATION\n*FREQUENCY\n{modes}\n*END STEP\n"


def node_columns(beam: Beam, elements: int) -> tuple[list[float], list[bool]]:
    """The x of every column of nodes, corners and midsides, and which elements are dense."""
    ends = {0.0, 1.0}
    if beam.alpha and beam.beta:
        end = min(beam.beta + SLICE / 2, 1.0)
        ends |= {end - SLICE, end}
    corners, dense = [0.0], []
    for a, b in pairwise(sorted(ends)):
        heavy = bool(beam.alpha) and b - a < 1.5 * SLICE
        count = 1 if heavy else max(1, round(elements * (b - a)))
        corners += [a + (b - a) * (i + 1) / count for i in range(count)]
        dense += [heavy] * count
    x = np.interp(np.arange(2 * len(dense) + 1) / 2, np.arange(len(corners)), corners)
    return x.tolist(), dense


def calculix_version() -> str:
    """The version of CalculiX. Raises PackageNotFoundError where it is not on the path."""
    try:
        return run_program("-v").stdout.split()[-1]
    except OSError:
        raise PackageNotFoundError(CCX) from None


def run_program(argument: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """CalculiX run to its end, whatever its exit code."""
    return subprocess.run([CCX, argument], capture_output=True, text=True, check=False, **options)


EXUDYN = (partial(version, "exudyn"), "pip install exudyn")
OPENSEES = (partial(version, "openseespy"), "pip install openseespy")
CALCULIX = (calculix_version, "apt-get install calculix-ccx")
EXUDYN_ENERGY, PAPER_ENERGY = partial(exudyn, "own"), partial(exudyn, "paper")
PEERS = (
    Solver("Exudyn", "biot", "elements", ELEMENTS, EXUDYN_ENERGY, *EXUDYN),
    Solver("Exudyn, paper's energy", "green", "elements", ELEMENTS, PAPER_ENERGY, *EXUDYN),
    Solver("OpenSees", "biot", "elements", (*ELEMENTS[1:], 320, 640), opensees, *OPENSEES),
    Solver("CalculiX", "solid", "elements", ELEMENTS[1:5], calculix, *CALCULIX),
)
