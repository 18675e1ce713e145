"""How do I get from a blade file of ElastoDyn to its Campbell chart?

The NREL 5 MW blade has its first flap frequency at 0.6777 Hz at rest and 0.7294 Hz at 12.1 rpm, its
first edge frequency at 1.0864 Hz at rest. Its mode shapes are printed as the polynomials of such a
file. Their coefficients depend on small changes of the shapes; the first flap and edge shapes are
within 0.005 of those of the published file, in parts of the tip's displacement.

Source: J. Jonkman et al., NREL/TP-500-38060, 2009, table 2-1; pyBModes 1.19.1 has these frequencies
(assets/validation.md).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

from beamviz import Beam, loci, solve
from beamviz.output.shape_polynomials import elastodyn_lines, shape_polynomials

PICTURE = "blade_file.png"  # in the current folder, unless the command line names a file
FILE = Path(__file__).with_name("nrel_5mw_blade.dat")


def main(picture=PICTURE):
    beam = Beam.from_file(FILE, length=61.5, hub_radius=1.5, rotation_rpm=12.1)
    chart = loci(beam, over="rpm", values=range(21), modes=5, plane="both")
    axes = chart.plot(plt.subplots(figsize=(6, 4), layout="constrained")[1])
    for k in (1, 3, 6):
        axes.plot([0, 20], [0, k * 20 / 60], "k:", lw=0.8)
    axes.figure.savefig(picture, dpi=100)
    plt.close(axes.figure)
    solution = solve(beam, plane="both")
    print("\n".join(elastodyn_lines(shape_polynomials(solution))))
    still = solve(beam.replace(gamma=0.0), modes=2, plane="both")
    flap, edge = beam.units.hertz(still.frequencies)
    return {
        "F1 at 12.1 rpm [Hz]": beam.units.hertz(solution.frequencies[0]),
        "F1 at rest [Hz]": flap,
        "L1 at rest [Hz]": edge,
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
