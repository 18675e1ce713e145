"""OpenSees: corotational beam elements of a structural program, mass and centrifugal force lumped
at the nodes.

Each node carries a dead load gamma^2 m (x + delta) and springs of stiffness -gamma^2 m along and
across the beam. In its limit: engineering strain, material curvature.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.benchmark.external import Peer
from beamviz.errors import NotConverged

STEPS = 10  # of the load
TOLERANCE, ITERATIONS = 1e-10, 50


def solve(beam: Beam, elements: int, modes: int) -> np.ndarray:
    """omega^2 of the lowest modes (modes,). Raises NotConverged."""
    ops: Any = import_module("openseespy.opensees")
    ops.wipe()
    model(ops, beam, elements)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormUnbalance", TOLERANCE * beam.mu**2, ITERATIONS, 0)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1 / STEPS)
    ops.analysis("Static")
    if beam.gamma and ops.analyze(STEPS):
        raise NotConverged("OpenSees: Newton's method did not converge")
    x = [node / elements + ops.nodeDisp(node, 1) for node in range(elements + 1)]
    if not np.all(np.diff(x) > 0):
        raise NotConverged(f"OpenSees landed on an inverted beam, its tip at {x[-1]:.3g}")
    return np.array(ops.eigen("-genBandArpack", modes))


def model(ops: Any, beam: Beam, elements: int) -> None:
    """Nodes, elements, lumped masses, springs and loads; a node's ground is numbered beyond."""
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.geomTransf("Corotational", 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ground = elements + 1
    for node, m in enumerate(lumped(beam, elements)):
        x = node / elements
        ops.node(node, x, 0.0)
        if node == 0:
            ops.fix(node, 1, 1, 1)
            continue
        ops.mass(node, m, m, 0.0)
        ops.element("elasticBeamColumn", node, node - 1, node, beam.mu**2, 1.0, 1.0, 1)
        if beam.gamma:
            ops.node(ground + node, x, 0.0)
            ops.fix(ground + node, 1, 1, 1)
            ops.uniaxialMaterial("Elastic", node, -(beam.gamma**2) * m)
            spring = (ground + node, ground + node, node)
            ops.element("zeroLength", *spring, "-mat", node, node, "-dir", 1, 2)
            ops.load(node, beam.gamma**2 * m * (x + beam.delta), 0.0, 0.0)


def lumped(beam: Beam, elements: int) -> np.ndarray:
    """Mass of each node; the concentrated one is shared by its neighbours."""
    m = np.full(elements + 1, 1 / elements)
    m[[0, -1]] /= 2
    e = min(int(beam.beta * elements), elements - 1)
    share = beam.beta * elements - e
    m[e] += beam.alpha * (1 - share)
    m[e + 1] += beam.alpha * share
    return m


OPENSEES = Peer(
    "OpenSees",
    "biot",
    (10, 20, 40, 80, 160, 320, 640),
    solve,
    lambda: version("openseespy"),
    "pip install openseespy",
    "corotational beams, lumped mass",
)
