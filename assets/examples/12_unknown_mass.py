"""How heavy is the mass on my beam, and where is it?

A clamped strip of steel, 600 mm x 30 mm x 4 mm, carries a body that cannot be weighed. Five
frequencies were measured at rest, each to 0.3 %: the mass is 0.248 kg at 390.4 mm. The first two
alone fit another mass as well, of 0.074 kg near the tip: each frequency is a curve of masses over
places, and two curves meet more than once.

Source: an independent solution of the differential equations (tests/oracle) has 7.600, 51.507,
139.692, 318.965 and 462.384 Hz for 0.25 kg at 390 mm; a sample of errors of 0.2 % was added.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, adjust, solve_many

PICTURE = "unknown_mass.png"  # in the current folder, unless the command line names a file
LENGTH, WIDTH, THICKNESS = 0.6, 0.03, 0.004  # [m]
STRIP = {
    "length": LENGTH,
    "density": 7850,
    "area": WIDTH * THICKNESS,
    "second_moment": WIDTH * THICKNESS**3 / 12,
    "youngs_modulus": 2.1e11,
}
MEASURED = {"mode": ["B1", "B2", "B3", "B4", "B5"], "hertz": [7.605, 51.59, 139.8, 318.1, 463.2]}
MEASURED["error"] = [0.003 * hertz for hertz in MEASURED["hertz"]]
FREE = {"kg": (0.0, 0.6), "beta:mm": (60, 600)}


def main(picture=PICTURE):
    strip = Beam.from_si(**STRIP)
    answer = adjust(strip, FREE, measured=MEASURED)
    two = adjust(strip, FREE, measured={name: column[:2] for name, column in MEASURED.items()})
    values = [two.free, *two.alternatives]
    other = max(values, key=lambda each: abs(each["kg"] - answer.free["kg"]))

    axes, place = plt.subplots(figsize=(6, 4), layout="constrained")[1], np.linspace(60, 600, 109)
    mass = np.linspace(0, 0.6, 61)
    size = 1e3 * LENGTH, strip.units.mass
    beams = [strip.replace(alpha=m / size[1], beta=x / size[0]) for m in mass for x in place]
    frequencies = np.array([each.frequencies for each in solve_many(beams, modes=5)])
    hertz = strip.units.hertz(frequencies).reshape(len(mass), len(place), 5)
    for k, label in enumerate(MEASURED["mode"]):
        axes.contour(place, mass, hertz[..., k], [MEASURED["hertz"][k]], colors=f"C{k}")
        axes.plot([], [], color=f"C{k}", label=label)
    axes.plot(answer.free["beta:mm"], answer.free["kg"], "ko", label="all five")
    axes.plot(other["beta:mm"], other["kg"], "kx", label="the first two, too")
    axes.set(xlabel="place [mm]", ylabel="mass [kg]", title="each frequency leaves a curve")
    axes.legend(loc="upper right", framealpha=1)
    axes.figure.savefig(picture, dpi=100)
    plt.close(axes.figure)
    return {
        "mass [kg]": answer.free["kg"],
        "place [mm]": answer.free["beta:mm"],
        "another mass, by two frequencies [kg]": other["kg"],
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
