"""Converged answers of some 380 beams, charts and motions, and how they are compared.

The values were computed at the finest tolerance that converges and confirmed by another mesh: the
same section at more stations. Beside them stands their spread: the greatest change by another
tolerance, another mesh or, where the resolution is given, numbers changed in the last digit. A
later program is allowed

    frequencies       1e-9, relative, and the estimated errors of both
    at the default tolerance: the estimated error alone, which has to be within the tolerance
    motions           the sum of their error bars
    all other values  ten times their spread, and a share of their size (FLOORS)
"""
