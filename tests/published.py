"""The published and independent values of the validation page, as numbers.

Lengths in L, frequencies in 1/T*; slenderness 70 where nothing else is said.
"""

import numpy as np
from helpers import load_script
from scipy.optimize import brentq

validation = load_script("validation")


def numbers(text: str) -> list[float]:
    """Numbers separated by spaces."""
    return [float(word) for word in text.split()]


def cantilever_at_rest(alpha: float) -> np.ndarray:
    """omega (4,) of bending with a tip mass, b^2 with 1 + cos b cosh b = alpha b (sin b cosh b -
    cos b sinh b) (Blevins)."""

    def characteristic(b):  # divided by cosh b
        tip = alpha * b * (np.sin(b) - np.cos(b) * np.tanh(b))
        return 1 / np.cosh(b) + np.cos(b) - tip

    b = np.linspace(0.05, 14, 4000)
    found = np.flatnonzero(np.diff(np.sign(characteristic(b))))[:4]
    return np.array([brentq(characteristic, b[i], b[i + 1], xtol=1e-14) for i in found]) ** 2


def bar_at_rest(alpha: float) -> float:
    """The least z with z tan z = 1 / alpha, omega = mu z of stretching with a tip mass."""
    return brentq(lambda z: alpha * z * np.sin(z) - np.cos(z), 1e-6, np.pi / 2 + 1e-9)


# beam, bending 1..4 and stretching 1; the same with Coriolis, omega 1 ..
INDEPENDENT, INDEPENDENT_CORIOLIS = (
    [(beam, numbers(text)) for beam, text in table.items()]
    for table in (validation.STRETCHED, validation.STRETCHED_CORIOLIS)
)
