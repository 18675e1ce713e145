"""Frequencies published elsewhere or computed independently of this project, with their sources.

Lengths in L, frequencies in 1/T*; slenderness 70 where nothing else is said.
"""

from math import pi

from beamviz.beam import Beam

# gamma, omega 1..3: flapwise, delta 0, alpha 0, rigid in tension. Wright, Smith, Thresher & Wang,
# J. Appl. Mech. 49 (1982), as quoted by Bir 2009 / 2010.
UNIFORM_FLAPWISE = [
    (0, 3.516, 22.035, 61.697),
    (1, 3.682, 22.181, 61.842),
    (2, 4.137, 22.615, 62.273),
    (3, 4.797, 23.320, 62.985),
    (4, 5.585, 24.273, 63.967),
    (5, 6.450, 25.446, 65.205),
    (6, 7.360, 26.809, 66.684),
    (7, 8.300, 28.334, 68.386),
    (8, 9.257, 29.995, 70.293),
    (9, 10.226, 31.771, 72.387),
    (10, 11.202, 33.640, 74.649),
    (11, 12.184, 35.589, 77.064),
    (12, 13.170, 37.603, 79.615),
]

# gamma, omega 1, 2: the same with alpha = beta = 1.
TIP_MASS_FLAPWISE = [
    (0, 1.557, 16.25),
    (1, 1.902, 16.76),
    (2, 2.670, 18.19),
    (3, 3.582, 20.35),
    (4, 4.543, 23.03),
    (5, 5.522, 26.04),
    (6, 6.509, 29.29),
    (7, 7.501, 32.70),
    (8, 8.495, 36.21),
    (9, 9.490, 39.80),
    (10, 10.49, 43.45),
    (11, 11.48, 47.14),
    (12, 12.48, 50.86),
]

# gamma, omega 1: chordwise with Coriolis, alpha 0, delta 0, linear axial model.
# Hamza Cherif & Houmat, 24th ICAS, table 2.
LINEAR_AXIAL_CORIOLIS = [
    (2, 3.6195),
    (4, 3.888),
    (6, 4.2393),
    (8, 4.6105),
    (10, 4.97),
    (50, 7.3362),
]

# omega 1..5, alpha = beta = 1 at rest. Math. Probl. Eng. 2017/1568019, table 1.
TIP_MASS_AT_REST = [1.557298, 16.25009, 50.89584, 105.1983, 179.2320]

# Frequencies [Hz] of a steel tube with a mass at its tip: VPCS, test SDLL15, as recomputed.
TUBE = {
    "length": 10.0,
    "density": 7800.0,
    "area": pi / 4 * (0.35**2 - 0.32**2),
    "second_moment": pi / 64 * (0.35**4 - 0.32**4),
    "youngs_modulus": 2.1e11,
    "mass": 1000.0,
}
TUBE_HERTZ = [1.6554, 16.0711, 50.0235, 76.4706, 103.1995]

# alpha, beta, gamma, delta, bending 1..4, stretching 1: green, spatial, chordwise.
INDEPENDENT = [
    (0, 1, 0, 0, (3.5160153, 22.0344916, 61.6972144, 120.9019161), 109.9557429),
    (1, 0.5, 10, 0, (4.3905981, 22.0954901, 78.3525694, 111.1520304), 76.8632663),
    (1, 0.3, 50, 1, (55.7060158, 124.7611423, 234.4764718, 380.8273268), 154.1656016),
    (0, 1, 50, 1, (52.942507, 172.905287, 286.071455, 408.016404), 161.527165),
]

# alpha, beta, gamma, delta, omega 1..: the same with Coriolis.
INDEPENDENT_CORIOLIS = [
    (1, 0.5, 10, 0, (4.2560380, 21.9918226, 78.2173207, 79.5184410, 111.0672016)),
    (1, 0.3, 50, 1, (46.205059, 117.208910, 186.820598)),
]

# strain, delta, largest gamma with an equilibrium (alpha 0), a unit of its last digit.
LIMITS = [
    ("biot", 0.0, 70 * pi / 2, 1e-6),
    ("biot", 5.0, 70 * pi / 2, 1e-6),
    ("hencky", 0.0, 45.420, 1e-3),
    ("hencky", 1.0, 31.4887, 1e-4),
]

# parameter, beam, bending mode that meets the first stretching one, curvature, place, last digit.
_TIP, _HALF, _FAR = Beam(alpha=1), Beam(alpha=1, beta=0.5), Beam(alpha=1, beta=0.8)
_GAMMA_5, _GAMMA_10, _OVER_BETA = Beam(gamma=5), Beam(gamma=10), Beam(alpha=0.5, gamma=5)
MEETINGS = [
    (over, beam, bending, curvature, at, digit)
    for over, beam, bending, digit, material, spatial in [
        ("gamma", _HALF, 3, 1e-3, 9.206, 9.373),
        ("gamma", _FAR, 3, 1e-3, 6.662, 6.824),
        ("gamma", _FAR, 2, 1e-3, 17.343, 17.589),
        ("gamma", _TIP, 3, 1e-3, 4.406, 4.464),
        ("gamma", _TIP, 2, 1e-3, 16.215, 16.319),
        ("alpha", _TIP, 3, 1e-3, 1.570, 1.570),
        ("alpha", _GAMMA_5, 3, 1e-3, 0.921, 0.929),
        ("alpha", _GAMMA_10, 3, 1e-3, 0.477, 0.485),
        ("alpha", _GAMMA_10, 2, 1e-3, 1.747, 1.758),
        ("beta", _OVER_BETA, 4, 1e-4, 0.0877, 0.0872),
        ("beta", _OVER_BETA, 4, 1e-4, 0.2234, 0.2242),
    ]
    for curvature, at in (("material", material), ("spatial", spatial))
]
