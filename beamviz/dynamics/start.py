"""States that a motion starts from: an equilibrium, one under a force at the tip, or the amplitudes
of modes about one."""

import math

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics.equation import Equation
from beamviz.errors import NotConverged
from beamviz.solver import Solution

NEWTON_STEPS = 12
CONVERGED = 1e-11  # Newton step [L]; rounding errors are a hundredth of it
SMALLEST = 1e-4  # of the force in one step, at which following an equilibrium is given up


def equilibrium(equation: Equation, solution: Solution) -> NDArray:
    """q (n,) of the equilibrium of a solution without a force, by Newton's method from its
    positions."""
    x, curve = equation.unknowns.elements.points, solution.equilibrium
    q = equation.unknowns.fitted(curve.angle(x), curve.stretch(x))
    found = newton(equation, q, solution.beam.gamma, 0.0)
    if found is None:
        raise NotConverged(
            "Newton's method leaves the equilibrium on the elements of the motion; ask for a"
            " smaller tolerance"
        )
    return found


def held(equation: Equation, q: NDArray, gamma: float, force: float) -> NDArray:
    """q (n,) of the equilibrium under a force [E I / L^2] across the beam at its tip, followed from
    the equilibrium q without it."""
    reached, step, last = 0.0, 1.0, q
    while reached < 1:
        step = min(step, 1 - reached)
        found = newton(equation, q, gamma, (reached + step) * force)
        if found is None:
            step /= 2
            if step < SMALLEST:
                raise NotConverged(
                    f"release = {force:g}: the equilibrium under this force was followed to"
                    f" {reached * force:.4g} only; ask for a smaller one"
                )
            q = last
            continue
        reached += step
        q, last, step = 2 * found - last if reached < 1 else found, found, 1.5 * step
    return q


def newton(equation: Equation, q: NDArray, gamma: float, force: float) -> NDArray | None:
    """The equilibrium near q at a speed under a force across the unloaded beam; None where Newton's
    method does not converge."""
    equation.force = 1j * force
    try:
        return balanced(equation, q, gamma)
    finally:
        equation.force = 0.0


def balanced(equation: Equation, q: NDArray, gamma: float) -> NDArray | None:
    """The equilibrium near q at a speed; None where Newton's method does not converge."""
    last = math.inf
    for _ in range(NEWTON_STEPS):
        R, K, _ = equation.balance(gamma, q)
        step = np.linalg.solve(K, R)
        q, size = q - step, float(np.abs(step).max())
        if not math.isfinite(size) or size > 1:
            return None
        if size < CONVERGED or (size < 1e-7 and size > last / 2):
            f = equation.unknowns.gauss_stretch(q)
            law = equation.model.law
            inside = law.min_stretch < f.min() and f.max() < law.max_stretch
            return q if inside else None
        last = size
    return None


def with_modes(
    equation: Equation, solution: Solution, amplitudes: dict[int, float]
) -> tuple[NDArray, NDArray]:
    """q and v (n,) about an equilibrium at the phase in which each mode has its amplitude.

    The shapes, scaled to a largest displacement of 1, are taken as changes of stretch and angle,
    which bend the beam without stretching it however large they are.
    """
    elements = equation.unknowns.elements
    x = elements.points
    f, theta = solution.equilibrium.stretch(x), solution.equilibrium.angle(x)
    e = np.exp(1j * theta)
    moved, rates = np.zeros((2, len(x)), complex)  # in the axes of the hub
    everywhere = np.linspace(0, 1, 201)
    for k, amplitude in amplitudes.items():
        size = np.linalg.norm(solution.shape(k, everywhere), axis=1).max()
        along, across = amplitude / size * solution.shape(k, x).T  # complex in time
        omega = np.nan_to_num(solution.frequencies[k])
        moved += (along.real + 1j * across.real) * e
        rates += (1j * omega * along).real * e + 1j * (1j * omega * across).real * e
    integration = elements.integration(x)
    slope, slope_rate = (np.linalg.solve(integration, field) / e for field in (moved, rates))
    theta, f = theta + slope.imag / f, f + slope.real
    return (
        equation.unknowns.fitted(theta, f),
        equation.unknowns.fitted_rates(theta, f, slope_rate.imag / f, slope_rate.real),
    )


def damping_matrix(equation: Equation, q: NDArray, gamma: float, ratio: float) -> NDArray:
    """D (n, n) that gives every mode without Coriolis forces about the equilibrium q the same
    damping ratio: the sum of 2 ratio omega (M phi)(M phi)', phi of unit modal mass."""
    from scipy.linalg import eigh

    _, K, M = equation.balance(gamma, q)
    squares, shapes = eigh((K + K.T) / 2, (M + M.T) / 2)
    scaled = M @ shapes
    return (scaled * (2 * ratio * np.sqrt(np.maximum(squares, 0.0)))) @ scaled.T
