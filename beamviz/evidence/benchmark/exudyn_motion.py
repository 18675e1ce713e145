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
from beamviz.evidence.benchmark.external import exudyn_model, exudyn_module, quiet_settings

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
    module, items = exudyn_module(), import_module("exudyn.utilities")
    system, nodes, bodies = exudyn_model(beam, elements)
    turn = np.kron(np.eye(4), TURN)
    terms = [(number, M, M @ turn, q) for number, M, q in bodies]
    tip = system.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1]))
    load = system.AddLoad(items.Force(markerNumber=tip, loadVector=[0, release, 0]))
    position = module.OutputVariableType.Position
    sensor = system.AddSensor(
        items.SensorNode(nodeNumber=nodes[-1], outputVariableType=position, storeInternal=True)
    )

    def set_speed(gamma: float, rate: float) -> None:
        for number, M, G, q in terms:
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
            settings = quiet_settings(module)
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


def dynamic_settings(module: Any, until: float, steps: int, intervals: int) -> Any:
    settings = quiet_settings(module)
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps = until, steps
    time.adaptiveStep = False
    time.newton.useModifiedNewton = False
    time.newton.absoluteTolerance = time.newton.relativeTolerance = NEWTON_TOLERANCE
    time.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    settings.solution.sensors.writePeriod = until / intervals
    return settings
