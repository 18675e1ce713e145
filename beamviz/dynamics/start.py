"""States that a motion starts from: an equilibrium, one under a force at the tip, or the amplitudes
of modes about one."""

import math

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics.elements import PositionElements
from beamviz.dynamics.equation import Equation
from beamviz.errors import NotConverged
from beamviz.solver import Solution
from beamviz.solver.fem.elements import gauss

NEWTON_STEPS = 12
CONVERGED = 1e-11  # Newton step [L]; rounding errors are a hundredth of it
SMALLEST = 1e-4  # of the force in one step, at which following an equilibrium is given up
QUADRATURE = 24  # Gauss points of each element that a solution is sampled at


def equilibrium(equation: Equation, solution: Solution) -> NDArray:
    """q (n,) of the equilibrium of a solution without a force, by Newton's method from its
    positions."""
    x, _ = samples(equation.elements)
    curve = solution.equilibrium
    q = from_gradients(equation.elements, curve.stretch(x), curve.angle(x))
    found = newton(equation, q, solution.beam.gamma, 0.0)
    if found is None:
        raise NotConverged(
            "Newton's method leaves the equilibrium on the elements of the motion; ask for a"
            " smaller tolerance"
        )
    return found


def across(equation: Equation, x: float) -> NDArray:
    """The load (n,) of a unit force across the unloaded beam at the point x."""
    functions = equation.elements.at(np.array([x]))
    return np.kron([[0.0, 1.0]], functions)[0, equation.elements.free]


def held(equation: Equation, q: NDArray, gamma: float, force: float, x: float = 1.0) -> NDArray:
    """q (n,) of the equilibrium under a force [E I / L^2] across the beam at a point x, followed
    from the equilibrium q without it."""
    reached, step, last, unit = 0.0, 1.0, q, across(equation, x)
    while reached < 1:
        step = min(step, 1 - reached)
        found = newton(equation, q, gamma, (reached + step) * force * unit)
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


def newton(equation: Equation, q: NDArray, gamma: float, load: NDArray | float) -> NDArray | None:
    """The equilibrium near q at a speed under a load (n,); None where Newton's method does not
    converge."""
    speed, still, last = np.array([gamma]), np.zeros((1, equation.size)), math.inf
    for _ in range(NEWTON_STEPS):
        R = equation.forces(speed, 0 * speed, q[None], still)[0] - load
        K = equation.stiffness(speed, 0 * speed, q[None])[0]
        step = np.linalg.solve(K, R)
        q, size = q - step, float(np.abs(step).max())
        if not math.isfinite(size) or size > 1:
            return None
        if size < CONVERGED or (size < 1e-7 and size > last / 2):
            f = equation.stretch(q[None])
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
    elements = equation.elements
    x, _ = samples(elements)
    f, theta = solution.equilibrium.stretch(x), solution.equilibrium.angle(x)
    along = np.array([np.cos(theta), np.sin(theta)])
    across = np.array([-along[1], along[0]])
    moved = np.zeros((2, len(x)), complex)  # in the axes of the hub
    rates = np.zeros((2, len(x)), complex)
    everywhere = np.linspace(0, 1, 201)
    for k, amplitude in amplitudes.items():
        size = np.linalg.norm(solution.shape(k, everywhere), axis=1).max()
        shape = amplitude / size * solution.shape(k, x).T
        shape = shape[0] * along + shape[1] * across
        moved = moved + shape
        rates = rates + 1j * np.nan_to_num(solution.frequencies[k]) * shape
    slope, slope_rate = (gradient(elements, field.real) for field in (moved, rates))
    f = f + (slope * along).sum(axis=0)
    theta = theta + (slope * across).sum(axis=0) / solution.equilibrium.stretch(x)
    along_now = np.array([np.cos(theta), np.sin(theta)])
    across_now = np.array([-along_now[1], along_now[0]])
    turn_rate = (slope_rate * across).sum(axis=0) / solution.equilibrium.stretch(x)
    v = (slope_rate * along).sum(axis=0) * along_now + f * turn_rate * across_now
    return project(elements, f * along_now, 1), project(elements, v, 1)


def gradient(elements: PositionElements, field: NDArray) -> NDArray:
    """The derivative by x of a field (2, j) at the samples that is 0 at the clamp, as polynomials
    on the elements."""
    x, _ = samples(elements)
    full = np.zeros(2 * elements.count)
    full[elements.free] = project(elements, field, 0)
    return full.reshape(2, -1) @ elements.at(x, 1).T


def samples(elements: PositionElements) -> tuple[NDArray, NDArray]:
    """Gauss points on all elements and their weights (j,)."""
    points, weights = gauss(2 * QUADRATURE - 1)
    lengths = np.diff(elements.ends)[:, None]
    return (elements.ends[:-1, None] + lengths * points).ravel(), (lengths * weights).ravel()


def from_gradients(elements: PositionElements, f: NDArray, theta: NDArray) -> NDArray:
    """q (n,) of positions with a stretch and an angle (j,) at the samples."""
    return project(elements, f * np.array([np.cos(theta), np.sin(theta)]), 1)


def project(elements: PositionElements, field: NDArray, derivative: int) -> NDArray:
    """q (n,) whose field, or its derivative by x, is nearest to one (2, j) at the samples, in least
    squares."""
    x, weights = samples(elements)
    root = np.sqrt(weights)
    functions = root[:, None] * elements.at(x, derivative)
    q = np.zeros((2, elements.count))
    for component, fixed in ((0, [0]), (1, [0, 1])):
        free = np.setdiff1d(np.arange(elements.count), fixed)
        q[component, free] = np.linalg.lstsq(functions[:, free], root * field[component])[0]
    return q.ravel()[elements.free]


def damping_matrix(equation: Equation, q: NDArray, gamma: float, ratio: float) -> NDArray:
    """D (n, n) that gives every mode without Coriolis forces about the equilibrium q the same
    damping ratio: the sum of 2 ratio omega (M phi)(M phi)', phi of unit modal mass."""
    from scipy.linalg import eigh

    speed = np.array([gamma])
    K = equation.stiffness(speed, 0 * speed, q[None])[0]
    squares, shapes = eigh((K + K.T) / 2, equation.M)
    scaled = equation.M @ shapes
    return (scaled * (2 * ratio * np.sqrt(np.maximum(squares, 0.0)))) @ scaled.T
