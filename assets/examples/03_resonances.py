"""At which speeds does the rotation excite a resonance?

A disturbance that is fixed in space excites the beam once per revolution, and by its harmonics
twice, three times and so on: where a frequency is k times the speed. In a Campbell diagram these
are the crossings with the lines omega = k gamma. With a mass at the tip, B1 meets 2 per revolution
at gamma = 0.79791 and 1 per revolution at gamma = 1.71737.

Source: an independent solution of the differential equations has these frequencies at these speeds
(tests/oracle).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, loci

PICTURE = "resonances.png"  # in the current folder, unless the command line names a file


def main(picture=PICTURE):
    chart = loci(Beam(alpha=1), "gamma", np.linspace(0, 3, 61), modes=1, per_rev=4)
    found = [event for event in chart.events if event.kind == "resonance"]
    for event in found:
        print(f"{event.branches[0]} is excited {event.per_rev} per revolution at {event.at:.5f}")

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    chart.plot(axes)
    for k in range(1, 5):
        axes.axline((0, 0), slope=k, color="0.6", lw=0.8, zorder=0)
        label_at = min(2.8, 3.6 / k)
        axes.annotate(f"{k}x", (label_at, k * label_at), color="0.4")
    axes.plot([e.at for e in found], [e.frequency for e in found], "ko", mfc="w", ms=5)
    axes.set(ylim=(0, 4), title="resonances with multiples of the speed")
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    by_multiple = {event.per_rev: event.at for event in found if event.branches == ("B1",)}
    return {"B1, 2 per revolution": by_multiple[2], "B1, 1 per revolution": by_multiple[1]}


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
