"""Loci in forms that tests compare."""

import numpy as np

from beamviz.frequency_loci import Loci


def sorted_frequencies(found: Loci) -> np.ndarray:
    """The frequencies (values, branches) of loci in order, nan last."""
    return np.sort(np.column_stack([branch.frequency for branch in found.branches]), axis=1)
