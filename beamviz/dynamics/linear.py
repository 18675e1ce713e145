"""The motion by the classical linear theory, without stiffening, for comparison:

    M q" + 2 gamma G q' + D q' + (gamma' G - gamma^2 M)(q + delta) + K (q - q0) = F

K is the stiffness of the straight, unstretched beam q0: bending does not draw the tip inward, so
that the centrifugal force only softens. From the frequency of the first bending mode at rest on,
such a beam diverges (Kane, Ryan & Banerjee 1987).
"""

import time
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics import Motion, difference, estimate, record
from beamviz.dynamics.case import Case
from beamviz.dynamics.drives import Hub
from beamviz.dynamics.elements import PositionElements
from beamviz.dynamics.equation import Equation, Model
from beamviz.dynamics.integration import Control, Recorder, integrate
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.run import Run
from beamviz.dynamics.schemes import scheme
from beamviz.dynamics.start import across, damping_matrix
from beamviz.errors import InvalidInput, NotConverged
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS

DIVERGED = 1.0  # [L] displacement of the tip at which a theory of small ones has failed
FIRST_STEP = 0.1  # [T*], and half of it in each refinement
REFINEMENTS = 6
CROSSING = 4001  # times at which the displacement is compared with DIVERGED


class Diverged(Exception):
    """The tip has left the range of small displacements."""


class LinearEquation(Equation):
    """The equation of motion with the stiffness of the straight, unstretched beam."""

    @cached_property
    def linear_stiffness(self) -> NDArray:
        return super().elastic_tangent(self.unstressed[None])[0]

    def elastic(self, q: NDArray) -> NDArray:
        return (q - self.unstressed) @ self.linear_stiffness

    def elastic_tangent(self, q: NDArray) -> NDArray:
        return np.broadcast_to(self.linear_stiffness, (len(q), *self.linear_stiffness.shape))

    def strain_energy(self, q: NDArray) -> NDArray:
        moved = q - self.unstressed
        return ((moved @ self.linear_stiffness) * moved).sum(axis=1) / 2

    def equilibrium(self, gamma: float, load: NDArray) -> NDArray:
        """q (n,) at a constant speed under a load (n,); InvalidInput at a speed without one."""
        q0 = self.unstressed
        centrifugal = gamma**2 * (q0 @ self.M + self.delta * self.m[0])
        try:
            return q0 + np.linalg.solve(
                self.linear_stiffness - gamma**2 * self.M, centrifugal + load
            )
        except np.linalg.LinAlgError:
            raise InvalidInput(
                f"gamma = {gamma:g}: the linear theory has no equilibrium at this speed"
            ) from None

    def displaced(self, q: NDArray) -> NDArray:
        """Displacement of the tip (k,) from that of the unstretched beam."""
        return np.linalg.norm((q - self.unstressed) @ self.at_tip.T, axis=1)

    def check(self, t: float, gamma: float, q: NDArray) -> None:
        """Raises Diverged."""
        if self.displaced(q[None])[0] > DIVERGED:
            raise Diverged


def motion_without_stiffening(beam: Beam, until: float, **options: Any) -> Motion:
    """The motion of a beam by the classical linear theory; arguments as in `motion`, without a
    start in modes, a hub of inertia, and choices of methods. It ends early, at the time at which
    the tip is displaced by DIVERGED, where it diverges. Raises InvalidInput and NotConverged."""
    case = Case.of(beam=beam, until=until, **options)
    if case.start or isinstance(case.drive, Hub) or case.studied:
        raise InvalidInput("the linear theory takes a prescribed speed, and no start in modes")
    begun = time.perf_counter()
    mesh, step = refined(first_mesh(case.beam, 0.0)), FIRST_STEP
    last = run(case, mesh, step)
    for runs in range(2, REFINEMENTS + 2):
        mesh, step = refined(mesh), step / 2
        before, last = last, run(case, mesh, step)
        common = shortened(case, min(before.path.t[-1], last.path.t[-1]))
        error = estimate(common, difference(common, last, before))
        if error <= case.tolerance:
            return record(
                shortened(case, end_of(last)), last, error, runs, time.perf_counter() - begun
            )
    raise NotConverged(
        f"the linear theory: the position of the tip is uncertain by {error:.1e} L; ask for a"
        " larger tolerance or a shorter time"
    )


def run(case: Case, elements: PositionElements, step: float) -> Run:
    """One integration with steps of one length, until the end or a divergence."""
    collected = Recorder(elements, 0.0)
    control = Control(case.tolerance, step, progress=case.report)
    parts: list[tuple[float, Equation]] = []
    equation = equation_of(case, elements, case.parts[0].with_mass, None)
    q = equation.equilibrium(case.first_speed, case.release * across(equation, case.release_at))
    v, t, length = np.zeros_like(q), 0.0, step
    damping = None
    if case.damping:
        still = equation.equilibrium(case.first_speed, np.zeros_like(q))
        damping = damping_matrix(equation, still, case.first_speed, case.damping)
    try:
        for part in case.parts:
            equation = equation_of(case, elements, part.with_mass, damping)
            if parts and part.with_mass:
                v = equation.after_docking(q, v, parts[-1][1], np.array(case.body_velocity))
            parts.append((part.end, equation))
            if part.end > t:
                q, v, length = integrate(
                    *(equation, scheme(case.integrator), (q, v), t, part.end),
                    *(case.drive.breaks, control, collected, length),
                )
            t = part.end
    except Diverged:
        parts[-1] = collected.t[-1], equation
    return Run(collected.path, tuple(parts))


def equation_of(
    case: Case, elements: PositionElements, with_mass: bool, damping: NDArray | None
) -> LinearEquation:
    """The equation of motion with or without the concentrated mass."""
    beam = case.beam if with_mass else replace(case.beam, alpha=0.0)
    model = Model(beam, STRAIN_LAWS[case.strain], CURVATURES[case.curvature])
    assert not isinstance(case.drive, Hub)
    return LinearEquation(elements, model, case.drive, damping)


def shortened(case: Case, until: float) -> Case:
    """A case that ends earlier; what happens later stays in it."""
    shorter = copy(case)
    shorter.__dict__["until"] = until
    return shorter


def end_of(run: Run) -> float:
    """The time at which the tip is displaced by DIVERGED, or at which the motion ends."""
    t = np.linspace(0.0, run.path.t[-1], CROSSING)
    displaced = np.linalg.norm(run.tip(t) - [1.0, 0.0], axis=1)
    k = int(np.argmax(displaced >= DIVERGED))
    if displaced[k] < DIVERGED:
        return float(t[-1])
    return float(np.interp(DIVERGED, displaced[k - 1 : k + 1], t[k - 1 : k + 1])) if k else 1e-6
