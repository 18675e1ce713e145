"""The lowest eigenvalues of the collocated equations, for the oracle."""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, splu

from oracle.collocation import Displacements

LARGEST_DENSE = 900


class UnresolvedError(Exception):
    """The oracle could not reach its own accuracy: it returns nothing rather than junk."""


def lowest(
    A: csc_array, B: csc_array, moving: Displacements, modes: int
) -> tuple[np.ndarray, np.ndarray]:
    """The smallest eigenvalues of A y = lambda B y, all positive, and their y (n, modes).

    B sees the displacements alone, so the iteration runs on them, weighted by the root of their
    inertia: Green's function is symmetric, and in these variables nearly so is its matrix.
    """
    load, solve = B @ moving.lift(A.shape[0]), factorised(A)

    def response(shift: float, s: np.ndarray) -> np.ndarray:
        return factorised(A - shift * B)(load @ s)

    start = np.sqrt(moving.inertia)
    nu, shapes = largest(lambda s: moving.weighted(solve(load @ s)), modes, start)
    if np.any(nu <= 0):
        raise UnresolvedError(f"eigenvalues {1 / nu} are not positive")
    pairs = [inverse_iteration(response, moving, 1 / nu[k], shapes[:, k]) for k in np.argsort(-nu)]
    values, Y = zip(*pairs, strict=True)
    return np.array(values), np.column_stack(Y)


def lowest_indefinite(
    A: csc_array, B: csc_array, moving: Displacements, modes: int, least: float
) -> np.ndarray:
    """The smallest lambda with A y = lambda B y, negative ones first; none is below `least`."""
    load = B @ moving.lift(A.shape[0])
    with np.errstate(divide="ignore"):
        nu, shapes = np.linalg.eig(dense(factorised(A), load, moving))
        values = 1 / nu

    def response(shift: complex, s: np.ndarray) -> np.ndarray:
        return factorised(A - shift.real * B)(load @ s.real)

    picks = smallest(values.real, np.abs(nu.imag) <= 1e-6 * np.abs(nu), least, modes)
    pairs = [inverse_iteration(response, moving, values[k].real, shapes[:, k].real) for k in picks]
    return np.array([value for value, _ in pairs])


def lowest_gyroscopic_indefinite(
    A: csc_array, B: csc_array, C: csc_array, moving: Displacements, modes: int, least: float
) -> np.ndarray:
    """The smallest omega^2 with A y = omega C y + omega^2 B y; where omega is complex (the
    motion grows while it swings) minus the square of its rate of growth.

    omega comes with -omega and with its conjugate, so of all squares every other one is kept.
    """
    lift, solve = moving.lift(A.shape[0]), factorised(A)
    RB, RC = dense(solve, B @ lift, moving), dense(solve, C @ lift, moving)
    n, unit = len(RB), np.sqrt(np.linalg.norm(RB, 2))
    Z = np.block([[np.zeros((n, n)), unit * np.eye(n)], [RB / unit, RC]])
    nu, shapes = np.linalg.eig(Z)
    picks = smallest(growing(1 / nu), np.ones(2 * n, bool), least, 2 * modes)[::2]

    def response(shift: complex, s: np.ndarray) -> np.ndarray:
        load = C @ lift @ s + 2 * shift * (B @ lift @ s)
        return factorised((A - shift * C - shift**2 * B).astype(complex))(load)

    pairs = [inverse_iteration(response, moving, 1 / nu[k], shapes[:n, k]) for k in picks]
    return growing(np.array([value for value, _ in pairs]))


def growing(omega: np.ndarray) -> np.ndarray:
    """omega^2 where it is real, otherwise minus the square of the rate of growth."""
    square = omega**2
    swings = np.abs(square.imag) > 1e-7 * np.abs(square)
    return np.where(swings, -(omega.imag**2), square.real)


def smallest(values: np.ndarray, kept: np.ndarray, least: float, count: int) -> np.ndarray:
    """Where the `count` smallest of the values kept are, none below `least`: those are noise."""
    places = np.flatnonzero(kept & (values >= least))
    return places[np.argsort(values[places], kind="stable")][:count]


def dense(
    solve: Callable[[np.ndarray], np.ndarray], load: csc_array, moving: Displacements
) -> np.ndarray:
    """Weighted displacements under weighted loads, as a full matrix."""
    if load.shape[1] > LARGEST_DENSE:
        raise UnresolvedError(f"{load.shape[1]} points: too many for all eigenvalues at once")
    y = solve(load.toarray())
    return np.sqrt(moving.inertia)[:, None] * y[moving.places]


def lowest_gyroscopic(
    A: csc_array, B: csc_array, C: csc_array, moving: Displacements, modes: int
) -> np.ndarray:
    """The smallest omega > 0 with A y = omega C y + omega^2 B y; they come in pairs +-omega.

    With nu = 1 / omega, s the displacements and t = nu s it reads nu t = A^-1 (C t + B s).
    """
    lift, solve = moving.lift(A.shape[0]), factorised(A)
    B_load, C_load = B @ lift, C @ lift
    start = np.sqrt(moving.inertia)
    n = len(start)
    unit = np.sqrt(np.linalg.norm(moving.weighted(solve(B_load @ start))) / np.linalg.norm(start))

    def inverse(st: np.ndarray) -> np.ndarray:
        s, t = st[:n], st[n:]
        return np.append(unit * t, moving.weighted(solve(C_load @ t + B_load @ s / unit)))

    def response(shift: float, s: np.ndarray) -> np.ndarray:
        load = C_load @ s + 2 * shift * (B_load @ s)
        return factorised(A - shift * C - shift**2 * B)(load)

    nu, shapes = largest(inverse, 2 * modes, np.append(start, start))
    forward = [k for k in np.argsort(-nu) if nu[k] > 0]
    if len(forward) != modes:
        raise UnresolvedError(f"frequencies {1 / nu} do not come in pairs")
    return np.array(
        [inverse_iteration(response, moving, 1 / nu[k], shapes[:n, k])[0] for k in forward]
    )


def factorised(matrix: csc_array) -> Callable[[np.ndarray], np.ndarray]:
    """b -> the solution of matrix y = b."""
    return splu(matrix.tocsc(), permc_spec="NATURAL").solve  # a band already


def largest(
    apply: Callable[[np.ndarray], np.ndarray], modes: int, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The largest eigenvalues, all real, and vectors of a linear function of vectors."""
    operator = LinearOperator((len(start),) * 2, apply, dtype=float)
    try:
        nu, shapes = eigs(operator, modes, which="LM", v0=start, ncv=4 * modes + 4, tol=1e-12)
    except ArpackNoConvergence as error:
        raise UnresolvedError(f"Arnoldi process: {error}") from None
    if np.any(np.abs(nu.imag) > 1e-9 * np.abs(nu)):
        raise UnresolvedError(f"eigenvalues {1 / nu} are not real")
    return nu.real, shapes.real


def inverse_iteration(
    response: Callable[[complex, np.ndarray], np.ndarray],
    moving: Displacements,
    value: complex,
    s: np.ndarray,
) -> tuple[complex, np.ndarray]:
    """An eigenvalue to rounding, with its unknowns; the shift stays clear of the eigenvalue."""
    for _ in range(6):
        shift = value * (1 - 1e-8)
        y = response(shift, s)
        moved = moving.weighted(y)
        previous, value = value, shift + np.vdot(s, s) / np.vdot(s, moved)
        s = moved / np.linalg.norm(moved)
        if abs(value - previous) < 1e-6 * abs(value):  # and each step gains eight digits
            return value, y
    raise UnresolvedError(f"inverse iteration about {value:g} does not settle")


def sign_changes(w: np.ndarray) -> int:
    """How often w changes its sign, but for noise."""
    w = w[np.abs(w) > 1e-9 * np.max(np.abs(w))]
    return int(np.sum(w[1:] * w[:-1] < 0))
