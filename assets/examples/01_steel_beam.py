"""Which frequencies has my steel beam, in Hz?

A tube of steel, 10 m long, with a mass of 1 t at its tip, at rest: 1.6554 Hz and 16.0711 Hz in
bending. At 60 rpm the centrifugal force stiffens it: B1 rises to 1.71 Hz.

Source: VPCS (validation of structural software), test SDLL15, at rest; an independent solution of
the differential equations at 60 rpm (tests/oracle).
"""

import sys
from math import pi

import matplotlib.pyplot as plt

from beamviz import Beam, solve

PICTURE = "steel_beam.png"  # in the current folder, unless the command line names a file
TUBE = {
    "length": 10.0,  # [m]
    "density": 7800.0,  # [kg/m^3]
    "area": pi / 4 * (0.35**2 - 0.32**2),  # [m^2]
    "second_moment": pi / 64 * (0.35**4 - 0.32**4),  # [m^4]
    "youngs_modulus": 2.1e11,  # [Pa]
    "mass": 1000.0,  # [kg]
}


def main(picture=PICTURE):
    still = Beam.from_si(**TUBE)
    turning = Beam.from_si(**TUBE, rotation_speed=60 * 2 * pi / 60)  # [rad/s]
    at_rest, rotating = solve(still), solve(turning)

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    rotating.plot(axes)
    axes.set_title(f"mode shapes at {turning.units.rpm(turning.gamma):.0f} rpm")
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    B1, B2 = still.units.hertz(at_rest.frequencies[:2])
    return {
        "B1 at rest [Hz]": B1,
        "B2 at rest [Hz]": B2,
        "B1 at 60 rpm [Hz]": turning.units.hertz(rotating.frequencies[0]),
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
