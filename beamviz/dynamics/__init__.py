"""Motion in time: the nonlinear equation of motion in the rotating frame, integrated.

problem          what is asked for: beam, drive, start, theory, scheme
initial_value    its equations on a mesh, and the state at t = 0
controllers      how long the steps are
integration      steps one after the other, each by Newton's method (newton_step)
refinement       finer meshes and shorter steps, until two motions agree to the tolerance
result           the motion, a plain record
"""

import time
from collections.abc import Mapping
from typing import Any

from beamviz.beam import Beam
from beamviz.dynamics.initial_value import start_solution
from beamviz.dynamics.problem import MotionProblem
from beamviz.dynamics.refinement import at_resolution, to_tolerance
from beamviz.dynamics.result import Motion, motion_of


def motion(
    beam: Beam,
    until: float,
    *,
    speed: Any = None,
    release: float = 0.0,
    start: Mapping[str, float] | None = None,
    damping: float = 0.0,
    tolerance: float = 1e-4,
    points: int = 401,
    method: str = "auto",
    **options: Any,
) -> Motion:
    """The motion of a beam from t = 0 until a time [T*], in the plane of rotation.

    speed: None, constantly beam.gamma; a Ramp; a pair of arrays (t, gamma), linear between samples
    and constant after the last; or a Hub, which turns under a torque. It starts at rest in the
    equilibrium at the first speed; release: held out of it by a transverse force [E I / L^2] until
    t = 0, at the point release_at of the beam, the tip by default; start: amplitudes of modes [L],
    as {"B1": 0.1}. damping: ratio of all modes about that equilibrium. tolerance: of the tip at all
    times [L], 1e-9 to 1e-2. points: of the results in time. method: "auto", or "ancf" for the
    paper's cubic elements.

    options: strain, curvature and state of the equilibrium as in `solve`. catch, drop: times at
    which the concentrated mass docks and is released; body_velocity: its velocity when it docks,
    relative to the frame of the hub. elements: of ancf. integrator: a name in INTEGRATORS; step: a
    constant step in time. progress: called with the time that has been reached.

    Raises InvalidInput; NoEquilibrium where there is none to start from (with .limit) or a stretch
    leaves the range of its strain law; NotConverged.
    """
    problem = MotionProblem.of(
        beam=beam,
        until=until,
        speed=speed,
        release=release,
        start=start,
        damping=damping,
        tolerance=tolerance,
        points=points,
        method=method,
        **options,
    )
    begun = time.perf_counter()
    refine = at_resolution if problem.studied else to_tolerance
    refined = refine(problem, start_solution(problem))
    return motion_of(problem, refined, time.perf_counter() - begun)
