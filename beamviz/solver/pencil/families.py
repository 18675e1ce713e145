"""Two families of motions of a stack of beams: along the beam (a) and across it (b).

Uncoupled they are two symmetric problems. Coriolis forces make the problem M q" + 2 gamma G q' +
K q = 0 of q = (a, b), with K = diag(Ka, Kb), softening included, M = diag(Fa' Fa, Fb' Fb) and G =
[[0, -Fa' Fb], [Fb' Fa, 0]]. The rows of Fa and Fb are displacements at common points times the root
of the mass there.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import blas

from beamviz.errors import NotConverged
from beamviz.solver.pencil.inverse import COMPRESSED, eigh_largest, inverse_modes_with_shift
from beamviz.solver.pencil.matrices import EPS, TINY, Families, Family, Modes, exponents

# Safety factor of rounding errors: twice the least for which the errors of 5000 random beams over
# the accepted domain were within their estimates (scripts/measure_error_bars.py).
ROUNDING_FACTOR = 30.0
FAR_APART = 1e10  # ratio of eigenvalues from which the eigenvectors of Z Z' are too inaccurate
HIGHEST = 1e10  # ratio to the lowest eigenvalue above which modes are rounding error
MAX_INDEFINITE = 400  # most unknowns of an unstable gyroscopic problem: 0.05 s
INDEFINITE_ROUNDING = 2e4  # of omega^2 in such a problem, in units of EPS, on random beams


def uncoupled_modes(pencil: Families, count: int) -> Modes:
    """The `count` lowest modes of each family; fewer where neither has as many.

    Softening shifts every omega^2 and does not change the modes: it is subtracted at the end. Where
    K across the beam is semidefinite, its lowest omega^2 is the Rayleigh quotient of its shape, and
    the others, which beside it would be rounding errors, are computed with a shift.
    """
    (K, M, _), A, Ka = pencil.across, pencil.along.mass, pencil.along.K
    assert K is not None
    assert M is not None
    stack, n, r = len(K), K.shape[-1], A.shape[-1]
    count = min(count, max(n, r))
    across, along = min(count, n), min(count, r)  # numbers of modes
    shift = 0.0 if pencil.definiteness == "definite" else COMPRESSED
    nu, shifts = np.empty((stack, 2, count)), []
    b, a = np.empty((stack, count, n)), np.empty((stack, count, r))
    for k in range(stack):
        nu[k, 0, :across], b[k, :across], added = inverse_modes_with_shift(M[k], K[k], count, shift)
        if Ka is None:
            nu[k, 1, :along], a[k, :along] = eigh_largest(A[k], count)
            added_along = 0.0
        else:
            modes = inverse_modes_with_shift(A[k], Ka[k], count, 0.0)
            nu[k, 1, :along], a[k, :along], added_along = modes
        shifts.append((added, added_along))
    if across < count:
        nu[:, 0, across:], b[:, across:] = np.nan, np.nan
    if along < count:
        nu[:, 1, along:], a[:, along:] = np.nan, np.nan
    # An element beside a mass near the clamp is short, and has hardly any mass: 1 / nu is only
    # rounding error there, of either sign, and would pass for an instability.
    nu[nu <= EPS * nu[..., :1]] = np.nan
    shifted = 1 / nu
    root = np.sqrt(abs(shifted))[..., None]
    b *= root[:, 0]
    a *= root[:, 1]
    omega_squared, size = shifted - pencil.softening, shifted
    is_shifted = any(map(any, shifts))
    if is_shifted:
        # K and the shift cancel, and in the motion of a heavy mass the rotation about the root and
        # bending: sum of absolute terms.
        by = np.array(shifts)[..., None]
        diagonal = np.linalg.diagonal(K)
        terms = np.vecdot((diagonal + by[:, 0] * np.linalg.diagonal(M))[:, None], b**2)
        omega_squared, size = shifted - by - pencil.softening, shifted.copy()
        size[:, 0] = terms
        if pencil.definiteness == "semidefinite":
            lowest = b[:, 0]
            stored = np.vecdot(lowest, np.matvec(K, lowest))
            omega_squared[:, 0, 0] = stored - pencil.softening[:, 0, 0]
            size[:, 0, 0] = np.vecdot(diagonal, lowest**2)
    if pencil.cancelled is not None:
        size = size + pencil.cancelled
    relative = shifted / shifted[..., :1]  # largest in the high modes
    rigid = None
    if pencil.rigid is not None and pencil.rigid.any():
        rigid = np.zeros(omega_squared.shape, bool)
        rigid[:, 0] = np.arange(count) < pencil.rigid[:, None]
        omega_squared[rigid] = 0.0
    return Modes(
        omega_squared,
        V=(b.mT, a.mT),
        rounding=ROUNDING_FACTOR * EPS * size * (1 + relative),
        definite=not is_shifted,
        pairing=2 * np.sqrt(abs(omega_squared)),
        rigid=rigid,
    )


class Coupled(NamedTuple):
    """Modes of a stack of coupled problems before they are scaled."""

    omega_squared: np.ndarray  # (beams, count) ascending
    a: np.ndarray  # (beams, na, count) complex, unit modal mass
    b: np.ndarray  # (beams, nb, count)
    fraction: np.ndarray  # (beams, count) share of b in the kinetic energy
    stored: np.ndarray  # (beams, count) a* Ka a + b* Kb b
    relative: np.ndarray  # (beams, count) rounding error of omega^2, in units of EPS


Stacks = tuple[np.ndarray, np.ndarray]  # matrices of each beam, of family a and of family b


def coupled_modes(pencil: Families, count: int) -> Modes:
    """The `count` lowest modes with Coriolis forces.

    Frequencies are real by construction where K is positive definite; LinAlgError is raised where
    it is not for one of several beams. A shape is real along the beam and imaginary across it, or
    the other way round. |y* T'(s) v| is omega + v* K v / omega.
    """
    gamma, Fa, Fb = pencil.gamma, pencil.along.F, pencil.across.F
    assert gamma is not None
    assert Fa is not None
    assert Fb is not None
    stiffness = _stiffness(pencil.along), _stiffness(pencil.across)
    soft = pencil.softening[..., None]
    K = (
        stiffness[0] - soft[:, 1] * pencil.along.mass,
        stiffness[1] - soft[:, 0] * pencil.across.mass,
    )
    singular = pencil.rigid is not None and bool(pencil.rigid.any())
    L = None if singular else _factors(K, alone=len(gamma) == 1)
    if L is None:
        modes = _indefinite_gyroscopic(K, (Fa, Fb), gamma.item(), count)
    else:
        max_rounding = pencil.tolerance / (10 * ROUNDING_FACTOR * EPS)
        modes = _definite_gyroscopic(L, (Fa, Fb), gamma, count, max_rounding)
    omega_squared, squares = modes.omega_squared, abs(modes.omega_squared)
    size = squares + np.maximum(gamma[..., 0] ** 2, pencil.softening.max(axis=1))
    if pencil.cancelled is not None:
        size = size + pencil.cancelled[:, 0]
    if L is None:  # compression and a shift cancel: sum of absolute terms
        size = size + COMPRESSED
        for k, shape in zip(stiffness, (modes.a, modes.b), strict=True):
            size = size + np.vecmat(abs(np.linalg.diagonal(k)), abs(shape) ** 2)
    pairing = (squares + abs(modes.stored)) / np.maximum(np.sqrt(squares), TINY)
    rigid = None
    if pencil.rigid is not None and singular:
        order = squares.argsort(axis=-1).argsort(axis=-1)
        rigid = order < pencil.rigid[:, None]
        omega_squared[rigid] = 0.0
    return Modes(
        omega_squared,
        V=(modes.b, modes.a),
        rounding=ROUNDING_FACTOR * EPS * size * (1 + modes.relative),
        definite=L is not None,
        pairing=pairing,
        fraction=modes.fraction,
        rigid=rigid,
    )


def _stiffness(family: Family) -> np.ndarray:
    """K (1 or beams, n, n), the identity where there is none."""
    if family.K is not None:
        return family.K
    assert family.F is not None
    return np.eye(family.F.shape[-1])[None]


def _factors(K: Stacks, alone: bool) -> Stacks | None:
    """The Cholesky factors; of a single beam None where either is not positive definite."""
    try:
        return np.linalg.cholesky(K[0]), np.linalg.cholesky(K[1])
    except np.linalg.LinAlgError:
        if alone:
            return None
        raise


class InverseRoot(NamedTuple):
    """Z of `_definite_gyroscopic`, whose singular values are 1 / omega, of a stack of problems.

    A column of Z' X is (Lb' b, omega Fa a) / omega for a column (La' a, omega Fb b) of X.
    """

    Ya: np.ndarray  # (beams, na, m) La^-1 Fa'
    Yb: np.ndarray  # (beams, m, nb) Fb Lb^-T
    gamma: np.ndarray  # (beams, 1, 1)

    def squared(self) -> np.ndarray:
        """Z Z' (beams, na + m, na + m), of which only the upper triangle is set."""
        Ya, Yb, gamma = self
        na, P = Ya.shape[-2], Yb @ Yb.mT
        n = na + P.shape[-1]
        H = np.empty((len(P), n, n))
        coupling = -2 * gamma * (Ya @ P)
        H[:, :na, :na] = (Ya - 2 * gamma * coupling) @ Ya.mT
        H[:, :na, na:] = coupling
        H[:, na:, na:] = P
        return H

    def transposed_times(self, X: np.ndarray) -> np.ndarray:
        """Z' X (beams, nb + m, k) of X (beams, na + m, k)."""
        na = self.Ya.shape[-2]
        velocity = self.Ya.mT @ X[:, :na]
        across = self.Yb.mT @ (X[:, na:] - 2 * self.gamma * velocity)
        return np.concatenate((across, velocity), axis=1)


def _definite_gyroscopic(
    L: Stacks, F: Stacks, gamma: np.ndarray, count: int, max_rounding: float
) -> Coupled:
    """The modes for K = diag(La La', Lb Lb').

    With q = (a, i b) e^(i omega t) the problem is real; with the velocities omega Fb b and
    omega Fa a as further unknowns it is linear in 1/omega:

        [-2 gamma Fa' Fb  Fa'] [   b      ]             [Ka  ] [   a      ]
        [      Fb         0  ] [omega Fa a]  = 1/omega  [   1] [omega Fb b],

    so 1/omega are the singular values of the left matrix between the Cholesky factors, Z, and
    1/omega^2 the eigenvalues of Z Z', with Ya = La^-1 Fa', Yb = Fb Lb^-T and P = Yb Yb':

        [Ya (1 + 4 gamma^2 P) Ya'  -2 gamma Ya P] [ La' a    ]               [ La' a    ]
        [      -2 gamma P Ya'            P      ] [omega Fb b]  = 1/omega^2  [omega Fb b].

    These have half the digits where modes are far apart: then `_by_singular_values`.
    """
    (La, Lb), (Fa, Fb) = L, F
    na, nb = La.shape[-1], Lb.shape[-1]
    Ya = _divide_by_factor(La, Fa, transposed=True).mT
    Yb = _divide_by_factor(Lb, Fb, transposed=True)
    Z = InverseRoot(Ya, Yb, gamma)
    # One by one: numpy's stacked call computes all vectors, not a few.
    pairs = (eigh_largest(H, count) for H in Z.squared())
    nu, rows = map(np.array, zip(*pairs, strict=True))
    X = rows.mT  # columns (La' a, omega Fb b)
    with np.errstate(divide="ignore", over="ignore"):  # near zero, by rounding: infinite
        omega_squared = 1 / nu
    rounding = abs(omega_squared / omega_squared[:, :1])
    if rounding.max() > max_rounding:
        omega_squared, X, rounding = _by_singular_values(Z, X, rounding)
    Y = Z.transposed_times(X) * np.sqrt(omega_squared)[:, None]  # columns (Lb' b, omega Fa a)
    along, across = np.square(Y[:, nb:]).sum(axis=1), np.square(X[:, na:]).sum(axis=1)
    mass = (along + across) / omega_squared
    stored = np.square(X[:, :na]).sum(axis=1) + np.square(Y[:, :nb]).sum(axis=1)
    root = np.sqrt(mass)[:, None]
    a, b = (
        _divide_by_factor(l, (q / root).mT, transposed=False).mT
        for l, q in ((La, X[:, :na]), (Lb, Y[:, :nb]))
    )
    return Coupled(
        omega_squared=omega_squared,
        a=a.astype(complex),
        b=1j * b,
        fraction=across / (along + across),
        stored=stored / mass,
        relative=rounding,
    )


def _by_singular_values(
    Z: InverseRoot, X: np.ndarray, rounding: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """omega^2 (beams, count), vectors (beams, na + m, count) and rounding errors (beams, count) in
    units of EPS, by singular values of Z', from vectors X of Z Z' and the rounding errors of their
    omega^2. Z' is restricted to X, or where that is too inaccurate is taken whole."""
    stack, n, count = X.shape
    restricted = rounding.max() < FAR_APART
    basis = X if restricted else np.broadcast_to(np.eye(n), (stack, n, n))
    _, singular, rotation = np.linalg.svd(Z.transposed_times(basis), full_matrices=False)
    omega_squared = 1 / singular[:, :count] ** 2
    ratio = omega_squared / omega_squared[:, :1]
    errors = np.sqrt(ratio)  # of the singular values
    if restricted:
        errors = errors + EPS * ratio**2  # of the vectors that they are restricted to
    return omega_squared, basis @ rotation[:, :count].mT, errors


def _divide_by_factor(L: np.ndarray, B: np.ndarray, transposed: bool) -> np.ndarray:
    """B L^-T if `transposed`, else B L^-1, of stacks of lower triangles L (beams, n, n) and
    matrices B (beams, m, n)."""
    # l.T and b.T are in column order, as BLAS requires: to BLAS l.T is an upper triangle.
    pairs = zip(L, B, strict=True)
    return np.array([blas.dtrsm(1, l.T, b.T, trans_a=transposed).T for l, b in pairs])


def _indefinite_gyroscopic(K: Stacks, F: Stacks, gamma: float, count: int) -> Coupled:
    """The modes of a single problem where either Ka or Kb is indefinite."""
    (Ka, Kb), (Fa, Fb) = K, F
    omega_squared, a, b = _indefinite(Ka[0], Fa[0], Kb[0], Fb[0], gamma, count)
    a, b = a[None], b[None]
    along, across = (abs(Fa @ a) ** 2).sum(axis=1), (abs(Fb @ b) ** 2).sum(axis=1)
    stored = sum((q.conj() * (k @ q)).real.sum(axis=1) for k, q in ((Ka, a), (Kb, b)))
    mass = along + across
    root = np.sqrt(mass)[:, None]
    return Coupled(
        omega_squared=omega_squared[None],
        a=a / root,
        b=b / root,
        fraction=across / mass,
        stored=stored / mass,
        relative=np.full((1, len(omega_squared)), INDEFINITE_ROUNDING),
    )


def _indefinite(
    Ka: np.ndarray, Fa: np.ndarray, Kb: np.ndarray, Fb: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lowest modes (omega^2, a, b) of one problem where either Ka or Kb is indefinite.

    Let it be Kb. In the modal coordinates of the other family, Ka = diag(l), Fa' Fa = 1 and
    C = Fa' Fb; with y = sqrt(l) a and z = b' (q = (a, b) e^(s t)) the problem is symmetric:

        [         l             -2 gamma sqrt(l) C  ] [y]        [1         ] [y]
        [-2 gamma C' sqrt(l)   Kb + 4 gamma^2 C' C ] [z] = -s^2 [   Fb' Fb ] [z].

    Every s^2 is real: such a beam may buckle but does not flutter.
    """
    unknowns = len(Ka) + len(Kb)
    if unknowns > MAX_INDEFINITE:
        raise NotConverged(
            f"the straight beam is unstable; with Coriolis forces its {unknowns} unknowns are too"
            f" many (at most {MAX_INDEFINITE}): leave out Coriolis forces, lower gamma, or ask for"
            " fewer elements or modes"
        )
    l, A = _symmetric(Ka, Fa.T @ Fa, len(Ka))
    if l[0] <= 0:
        if np.linalg.eigvalsh(Kb)[0] <= 0:
            raise NotConverged(
                "both families are unstable; such a beam is not solved with Coriolis forces: leave"
                " them out, or lower gamma"
            )
        omega_squared, b, a = _indefinite(Kb, Fb, Ka, Fa, -gamma, count)
        return omega_squared, a, b
    kept = (l >= l[0]) & (l < HIGHEST * (1 + l[0]))
    l, A = l[kept], A[:, kept]
    na, n = len(l), len(l) + len(Kb)
    C = (Fa @ A).T @ Fb
    K, M = np.zeros((n, n)), np.eye(n)
    K[:na, :na] = np.diag(l)
    K[:na, na:] = -2 * gamma * np.sqrt(l)[:, None] * C
    K[na:, :na] = K[:na, na:].T
    K[na:, na:] = Kb + 4 * gamma**2 * C.T @ C
    M[na:, na:] = Fb.T @ Fb
    omega_squared, V = _symmetric(K, M, count)
    s = exponents(omega_squared)
    a = A @ (s * V[:na] / np.sqrt(l)[:, None])
    return omega_squared, a, V[na:].astype(complex)


def _symmetric(K: np.ndarray, M: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues of K v = lambda M v, ascending, and their vectors (n, count),
    V' M V = 1. K may be indefinite."""
    nu, rows, added = inverse_modes_with_shift(M, K, count, COMPRESSED)
    return 1 / nu - added, rows.T / np.sqrt(abs(nu))  # from V' (K + added M) V = 1
