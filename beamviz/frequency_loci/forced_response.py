"""The steady response of a beam to a force that rotates, and its run-up through resonances.

The force is proportional to the mass of each particle, as weight on a beam that rotates in a
vertical plane: in the frame of the beam it rotates once per revolution, with components along and
across the beam (flapwise: across it only). A force of higher order rotates 2, 3 ... times per
revolution. The response is linear and steady (transients have decayed at each speed), and all modes
have the same damping ratio. Amplitudes are in units of the static deflection of the tip under the
same force at rest.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.checks import check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.frequency_loci import loci
from beamviz.frequency_loci.events.record import Event
from beamviz.solver import solve_many
from beamviz.solver.quadrature import moment_of_weight, quadrature
from beamviz.solver.solution import Solution, read_only

LOADS = {"chordwise": (1j, -1.0), "flapwise": (0.0, -1.0)}  # along, across; times exp(i omega t)
DAMPING = (0.001, 0.2)  # least and greatest damping ratio
MAX_PER_REV = 20
SPEEDS = 81  # evenly spaced
# Speeds near a resonance, in its half-widths: dense at the peak, and as far as 8 of them, where the
# response is an eighth of it.
NEAR = np.sinh(np.linspace(-3.5, 3.5, 33)) / 2
TIP = np.ones(1)


def response(solution: Solution, frequency: float, damping: float, x: np.ndarray) -> np.ndarray:
    """Complex amplitudes (len(x), 2) along and across the beam at x under the force at `frequency`:
    the displacement over the static deflection is the real part of amplitude exp(i frequency t).
    nan where a mode is unstable."""
    check_one_plane(solution.problem.plane)
    static = static_deflection(solution.beam, solution.problem.plane)
    return displacement(solution, frequency, damping, x) / static


def check_one_plane(plane: str) -> None:
    """InvalidInput where the force would have no direction."""
    if plane == "both":
        raise InvalidInput(
            "plane = 'both': the forced response is that to a force in one plane",
            use={"plane": tuple(LOADS)},
        )


def displacement(solution: Solution, frequency: float, damping: float, x: np.ndarray) -> np.ndarray:
    """The amplitudes of `response`, in units of length under the force 1 for a unit of mass.

    Modal superposition: with shapes phi of unit modal mass, norms n and poles p, the inverse of
    K + 2 i omega gamma G - omega^2 M is the sum of phi phi^H / (n (p - omega)) and of the same for
    the conjugate modes, with poles -conj(p).
    """
    if solution.omega_squared[0] < 0:
        return np.full((len(x), 2), np.nan + 0j)
    beam, omega = solution.beam, solution.frequencies
    nodes, weight = quadrature(beam)  # the mass at each point
    u, w = np.moveaxis(solution.displacement(nodes), 1, 0)  # (len(nodes), modes) each
    coriolis = weight @ (w.conj() * u - u.conj() * w)  # phi^H G phi, 0 for real shapes
    along, across = LOADS[solution.problem.plane]
    force = weight @ (along * u.conj() + across * w.conj())  # its work on each shape
    force_conjugate = weight @ (along * u + across * w)  # and on its conjugate
    ratio = np.sqrt(1 - damping**2)
    pole = omega * (ratio + 1j * damping)
    norm = ratio * (2 * omega - 2j * beam.gamma * coriolis).real
    shapes = solution.displacement(x)  # (len(x), 2, modes)
    direct = shapes @ (force / (norm * (pole - frequency)))
    conjugate = shapes.conj() @ (force_conjugate / (norm * (pole.conj() + frequency)))
    return direct + conjugate


def semi_major_axis(a: np.ndarray) -> float:
    """That of the ellipse Re (a exp(i p)), p = 0 .. 2 pi, of a complex vector a (2,)."""
    u, v = a.real, a.imag
    return float(np.sqrt((u @ u + v @ v) / 2 + np.hypot((u @ u - v @ v) / 2, u @ v)))


def static_deflection(beam: Beam, plane: str = "chordwise") -> float:
    """Deflection of the tip at rest under the force, constant and across the beam: of a hinged one
    infinite."""
    stiffness = 1.0 if plane == "chordwise" else beam.flap  # of a beam without a blade
    if beam.is_uniform:
        return (1 / 8 + beam.alpha * beam.beta**2 * (3 - beam.beta) / 6) / stiffness
    if beam.root == 0:
        return math.inf
    bending = "bending" if plane == "chordwise" else "flap"
    x, w, moment = moment_of_weight(beam)
    EI = stiffness if beam.blade is None else beam.blade.at(bending, x)
    at, mass = quadrature(beam)
    return float(w @ (moment / EI * (1 - x)) + (mass @ at) / beam.root)


@dataclass(frozen=True, eq=False)
class RunUp:
    """Steady responses at ascending speeds (n,), dense near the resonances.

    amplitudes: of the tip (n,), the major semi-axis of its ellipse over the static deflection; nan
    without an equilibrium, or where it is unstable.
    """

    beam: Beam
    per_rev: int
    damping: float
    speeds: np.ndarray
    amplitudes: np.ndarray
    resonances: tuple[Event, ...]

    def peak(self, resonance: Event) -> float:
        """The amplitude of the tip at a resonance."""
        return float(self.amplitudes[np.argmin(abs(self.speeds - resonance.at))])


def run_up(
    beam: Beam, per_rev: int, damping: float, stop: float, modes: int = 5, **options: Any
) -> RunUp:
    """Steady responses of a beam at speeds from 0 to `stop`; its own gamma is not used.

    per_rev: periods of the force per revolution, 1 to 20. damping: damping ratio, 0.001 to 0.2.
    modes, options: as for solve(). Raises InvalidInput; and NoEquilibrium or NotConverged where
    there is no solution at any speed.
    """
    per_rev = check_int("per_rev", per_rev, 1, MAX_PER_REV)
    damping = check_float("damping", damping, *DAMPING)
    check_one_plane(str(options.get("plane", "chordwise")))
    if beam.root == 0:
        raise InvalidInput(
            "root = 0: a hinged beam has no static deflection to relate amplitudes to"
        )
    even = np.linspace(0.0, stop, SPEEDS)
    tracked = loci(beam, "gamma", even, modes=modes, per_rev=per_rev, **options)
    excited = tuple(event for event in tracked.events if event.per_rev == per_rev)
    near = [event.at * (1 + damping * NEAR) for event in excited]
    speeds = np.unique(np.concatenate([even, *near]))
    speeds = speeds[(speeds >= 0) & (speeds <= stop)]
    outcomes = solve_many([beam.replace(gamma=speed) for speed in speeds], modes=modes, **options)
    amplitudes = np.full(len(speeds), np.nan)
    for k, outcome in enumerate(outcomes):
        if isinstance(outcome, Solution):
            (tip,) = displacement(outcome, per_rev * outcome.beam.gamma, damping, TIP)
            amplitudes[k] = semi_major_axis(tip)
    amplitudes /= static_deflection(beam, tracked.problem.plane)
    return RunUp(beam, per_rev, damping, speeds, read_only(amplitudes), excited)
