"""At which speeds does my tapered blade resonate?

A blade of steel, 600 mm long and 40 mm wide, whose thickness falls from 12 mm at the root to 6 mm
at the tip, on a hub of 100 mm: mass, stiffness and place of five stations, as a table of a blade
has them. Out of the plane of rotation it vibrates with 30.288 Hz at rest; the speed meets B2 four
times per revolution at 2904.36 rpm.

Source: Ozdemir & Kaya, J. Sound Vib. 289 (2006), have omega_1 = 3.8238 for this taper at rest,
where T* = 20.09 ms; an independent solution of the differential equations has the resonance
(tests/oracle).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, loci, solve

PICTURE = "tapered_blade.png"  # in the current folder, unless the command line names a file
E, RHO, WIDTH = 210e9, 7850.0, 0.04  # [Pa], [kg/m^3], [m]
STATIONS = np.linspace(0, 0.6, 5)  # [m]
THICKNESS = np.linspace(0.012, 0.006, 5)  # [m]
BLADE = {
    "stations": STATIONS,
    "mass_per_length": RHO * WIDTH * THICKNESS,  # [kg/m]
    "bending_stiffness": E * WIDTH * THICKNESS**3 / 12,  # [N m^2], out of the plane of rotation
    "axial_stiffness": E * WIDTH * THICKNESS,  # [N]
    "degree": 4,  # a polynomial through the stations; by default straight lines between them
    "hub_radius": 0.1,  # [m]
}


def main(picture=PICTURE):
    still = Beam.from_si(**BLADE)
    B1 = still.units.hertz(solve(still, plane="flapwise").frequencies[0])
    speeds = np.linspace(0, 6000, 61)
    chart = loci(still, "rpm", speeds, modes=3, per_rev=4, plane="flapwise")
    (resonance,) = (e for e in chart.events if e.branches == ("B2",) and e.per_rev == 4)

    size = {"figsize": (6, 5.6), "height_ratios": (1, 2.4)}
    figure, (above, below) = plt.subplots(2, 1, **size, layout="constrained")
    x = np.linspace(0, 1, 101)
    for name, label in (("bending", "EI"), ("mass", "mass of a unit of length")):
        above.plot(600 * x, still.blade.at(name, x), label=label)
    above.plot(1e3 * STATIONS, BLADE["bending_stiffness"] / BLADE["bending_stiffness"][0], "k.")
    above.set(xlabel="place [mm]", ylabel="over the root", xlim=(0, 600), ylim=(0, 1.05))
    above.legend(frameon=False)
    chart.plot(below)
    for k in range(1, 5):
        below.axline((0, 0), slope=k / 60, color="0.6", lw=0.8, zorder=0)
    below.set_title("frequencies, and 1 .. 4 times the speed")
    figure.savefig(picture, dpi=100)
    plt.close(figure)
    return {"B1 at rest [Hz]": B1, "B2, 4 per revolution [rpm]": still.units.rpm(resonance.at)}


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
