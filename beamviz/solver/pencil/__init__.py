"""The lowest modes of M q" + C q' + K q = 0: q(t) = Re (v e^(s t)), T(s) v = 0 with
T(s) = s^2 M + s C + K.

The algorithm is chosen from the properties of the matrices:

    two families of a stack of beams
        uncoupled                      K v = -s^2 M v of each family, beam by beam
        coupled, K definite            eigenvalues of Z Z', or singular values of Z: s is imaginary
        coupled, K not definite        a symmetric problem in s^2 with the modes of one family
    a single pencil
        K symmetric, no C              K v = -s^2 M v
        K symmetric, definite, C skew  a Hermitian problem in 1 / s, by Arnoldi's method if large
        otherwise                      the inverse of the first-order system, and of its transpose
    K and M by collocation             their real modes alone (`inverse.real_modes`)

With thin elements or high order the eigenvalues span a factor of 1e17, and a reduction by M would
lose the low ones. Every algorithm solves the inverse problem: the low modes are its largest
eigenvalues, and the rounding errors are in the high modes, which are not returned.
"""

from beamviz.solver.pencil.families import coupled_modes, uncoupled_modes
from beamviz.solver.pencil.matrices import Families, Modes, Pencil
from beamviz.solver.pencil.single import general_modes, steady_gyroscopic_modes, symmetric_modes


def lowest_modes(pencil: Families | Pencil, count: int) -> Modes:
    """The `count` lowest modes.

    Raises NotConverged; LinAlgError where families are coupled and K of one of several beams is not
    positive definite.
    """
    if isinstance(pencil, Families):
        coupled = pencil.gamma is not None
        return coupled_modes(pencil, count) if coupled else uncoupled_modes(pencil, count)
    if pencil.symmetric and pencil.C is None:
        return symmetric_modes(pencil, count)
    if pencil.symmetric and pencil.F is not None and pencil.factor is not None:
        return steady_gyroscopic_modes(pencil, count)
    return general_modes(pencil, count)
