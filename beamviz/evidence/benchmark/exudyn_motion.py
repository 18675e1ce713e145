"""Exudyn's motion in time of the same beam: its planar cubic elements (ANCFCable2D) with their own
energy, engineering strain and material curvature, in the rotating frame.

Coriolis, Euler and centrifugal forces are an object beside each element: its damping 2 gamma G, its
stiffness gamma' G - gamma^2 M and the load of the reference positions. With a speed that varies
they are set anew before each step. Generalised-alpha with full Newton steps.
"""

from collections.abc import Callable
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.evidence.benchmark.external import clamp, element_masses

SPECTRAL_RADIUS = 0.9
LOAD_STEPS = 5
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # e3 x
NEWTON_TOLERANCE = 1e-6  # its own, 1e-10 and 1e-8, is below rounding at mu = 450

Drive = Callable[[NDArray], tuple[NDArray, NDArray]]


def missing() -> str:
    """Why Exudyn cannot run; empty where it can."""
    try:
        version("exudyn")
    except PackageNotFoundError:
        return "not installed: pip install exudyn"
    return ""


def exudyn_tip(
    beam: Beam, times: NDArray, drive: Drive | None, release: float, elements: int, steps: int
) -> NDArray:
    """Position of the tip (len(times), 2) at equidistant times; steps: in all, a multiple of the
    intervals. Raises NotConverged."""
    if missing():
        raise NotConverged(f"Exudyn is {missing()}")
    module: Any = import_module("exudyn")
    items: Any = import_module("exudyn.utilities")
    module.config.printToConsole = False
    system = module.SystemContainer().AddSystem()
    h = 1 / elements
    places = [[n * h, 0, 1, 0] for n in range(elements + 1)]
    nodes = [system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=at)) for at in places]
    section = {"massPerLength": 1, "bendingStiffness": 1, "axialStiffness": beam.mu**2}
    bodies = []
    for e, (distributed, point) in enumerate(element_masses(beam, elements)):
        ends = [nodes[e], nodes[e + 1]]
        system.AddObject(items.Cable2D(nodeNumbers=ends, length=h, **section))
        q = np.array([e * h + beam.delta, 0, 1, 0, (e + 1) * h + beam.delta, 0, 1, 0])
        number = system.AddObject(items.ObjectGenericODE2(nodeNumbers=ends, massMatrix=point))
        M = distributed + point
        bodies.append((number, M, M @ np.kron(np.eye(4), TURN), q))
    clamp(system, items, nodes[0])
    tip = system.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1]))
    load = system.AddLoad(items.Force(markerNumber=tip, loadVector=[0, release, 0]))
    position = module.OutputVariableType.Position
    sensor = system.AddSensor(
        items.SensorNode(nodeNumber=nodes[-1], outputVariableType=position, storeInternal=True)
    )

    def set_speed(gamma: float, rate: float) -> None:
        for number, M, G, q in bodies:
            K = rate * G - gamma**2 * M
            system.SetObjectParameter(number, "stiffnessMatrix", K)
            system.SetObjectParameter(number, "dampingMatrix", 2 * gamma * G)
            system.SetObjectParameter(number, "forceVector", -K @ q)

    def before_step(system: Any, t: float) -> bool:
        assert drive is not None
        (gamma,), (rate,) = drive(np.array([t]))
        set_speed(gamma, rate)
        return True

    if drive is None:
        set_speed(beam.gamma, 0.0)
    else:
        before_step(system, 0.0)
        system.SetPreStepUserFunction(before_step)
    system.Assemble()
    try:
        if drive is None:
            settings = common_settings(module)
            settings.staticSolver.numberOfLoadSteps = LOAD_STEPS
            system.SolveStatic(settings, updateInitialValues=True)
            system.SetLoadParameter(load, "loadVector", [0, 0, 0])
        system.SolveDynamic(dynamic_settings(module, float(times[-1]), steps, len(times) - 1))
    except Exception as failure:  # its own class, and plain ones from C++
        raise NotConverged(f"Exudyn: {str(failure).splitlines()[0]}") from None
    stored = np.array(system.GetSensorStoredData(sensor))
    stored = stored[np.append(np.diff(stored[:, 0]) > 1e-9, True)]  # the last at each time
    if len(stored) != len(times):
        raise NotConverged(f"Exudyn: {len(stored)} of {len(times)} times")
    return stored[:, 1:3]


def common_settings(module: Any) -> Any:
    settings = module.SimulationSettings()
    settings.staticSolver.verboseMode = 0
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.linearSolver.solverType = module.LinearSolverType.EigenSparse
    return settings


def dynamic_settings(module: Any, until: float, steps: int, intervals: int) -> Any:
    settings = common_settings(module)
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps = until, steps
    time.adaptiveStep = False
    time.newton.useModifiedNewton = False
    time.newton.absoluteTolerance = time.newton.relativeTolerance = NEWTON_TOLERANCE
    time.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    settings.solution.sensors.writePeriod = until / intervals
    return settings
