"""Which mode is which, where two frequencies meet?

Without Coriolis forces the third bending mode and the first stretching mode cross at gamma = 4.464:
neither notices the other. With Coriolis forces they veer apart at gamma = 4.650, with a gap of
0.241: the upper frequency stays the upper one, and its vibration changes from bending to
stretching. `branch.family` names it point by point.

Source: crossing, veering and gap were computed independently of this project.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, loci

PICTURE = "veering.png"  # in the current folder, unless the command line names a file
TIP_MASS = Beam(alpha=1)  # as heavy as the beam
SPEEDS = np.linspace(3.5, 6, 101)


def main(picture=PICTURE):
    figure, panels = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True, layout="constrained")
    events = []
    for coriolis, axes in zip((False, True), panels, strict=True):
        chart = loci(TIP_MASS, "gamma", SPEEDS, modes=4, coriolis=coriolis)
        (event,) = chart.events
        events.append(event)
        for branch in (chart[label] for label in event.branches):
            share = branch.bending_fraction  # 1: bending, 0: stretching
            dots = axes.scatter(
                SPEEDS, branch.frequency, 8, share, cmap="coolwarm_r", vmin=0, vmax=1
            )
            print(event.kind, branch.label, "from", branch.family[0], "to", branch.family[-1])
        title = "with Coriolis forces" if coriolis else "without Coriolis forces"
        axes.set(title=title, xlabel="rotation speed γ", ylabel="frequency ω [1/T*]")
    figure.colorbar(dots, label="share of bending")
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    crossing, veering = events
    return {
        "crossing at gamma": crossing.at,
        "veering at gamma": veering.at,
        "gap [1/T*]": veering.gap,
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
