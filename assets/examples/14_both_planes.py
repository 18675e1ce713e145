"""When do flap and lag of a flat beam veer?

Its stiffness out of the plane of rotation is a quarter of that in it. Without pitch the first flap
and lag loci cross at gamma = 3.0755. With a pitch of 5 degrees they veer with a gap of 0.2196, and
with 30 degrees they are never nearer than 1.21: each mode changes from one motion to the other. At
gamma = 5 and 30 degrees the mode that is flap by then is 17.97 % above the 1x line, and its
Southwell coefficient, from rest, is 0.897.

Source: an independent solution of the differential equations (tests/oracle).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, loci

PICTURE = "both_planes.png"  # in the current folder, unless the command line names a file
FLAT = Beam(flap=0.25, gamma=5)  # gamma: the speed of the margins
SPEEDS = np.linspace(0, 8, 161)  # 5 is number 100
LOOK = {"s": 6, "cmap": "coolwarm_r", "vmin": 0, "vmax": 1}


def main(picture=PICTURE):
    figure, panels = plt.subplots(1, 3, figsize=(9, 3.6), sharey=True, layout="constrained")
    events, margins, distance = {}, {}, {}
    for pitch, axes in zip((0, 5, 30), panels, strict=True):
        beam = FLAT.replace(pitch=pitch)
        chart = loci(beam, "gamma", SPEEDS, modes=2, per_rev=2, plane="both")
        events[pitch] = [event for event in chart.events if event.kind != "resonance"]
        margins[pitch] = chart.margins  # by frequency
        distance[pitch] = abs(chart["F1"].frequency - chart["L1"].frequency).min()
        for mode in chart.margins:
            branch = chart[mode.label]
            flap = 1 - branch.in_plane_fraction  # of the kinetic energy
            dots = axes.scatter(SPEEDS, branch.frequency, c=flap, **LOOK)
            print(f"{pitch} degrees, {mode.label} at gamma = 5: {flap[100]:.2f} of it flap,")
            print(f"    {mode.percent[0]:.1f} % above 1x, Southwell {mode.southwell:.3f}")
        for k in (1, 2):
            axes.axline((0, 0), slope=k, color="0.6", lw=0.8, zorder=0)
            axes.text(6.5 / k, 6.5, f"  {k}×", va="top", color="0.4")
        axes.set(title=f"pitch {pitch}°", xlabel="rotation speed γ", ylim=(0, 9))
    panels[0].set_ylabel("frequency ω [1/T*]")
    figure.colorbar(dots, label="share of flap")
    figure.savefig(picture, dpi=100)
    plt.close(figure)
    return {
        "crossing at gamma": events[0][0].at,
        "gap at 5 degrees [1/T*]": events[5][0].gap,
        "least distance at 30 degrees [1/T*]": distance[30],
        "flap above 1x [%]": margins[30][1].percent[0],
        "its Southwell coefficient": margins[30][1].southwell,
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
