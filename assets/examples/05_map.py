"""How does a frequency depend on two numbers at once?

A sweep solves every combination, and a map shows one frequency over both. Here the third one, over
the speed and the place of a mass as heavy as the beam. Lines separate the regions where it is a
bending and a stretching mode. With the mass in the middle, at gamma = 10, it is 76.86327: S1.

Source: computed independently of this project (assets/validation.md).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, sweep
from beamviz.plotting.maps import draw_map

PICTURE = "map.png"  # in the current folder, unless the command line names a file
SPEEDS = np.linspace(0, 20, 61)
PLACES = np.linspace(0, 1, 61)


def main(picture=PICTURE):
    # None: no store is kept. A name, "map.zarr", keeps one, and an interrupted sweep goes on there.
    data = sweep({"gamma": SPEEDS, "beta": PLACES}, None, modes=3, beam=Beam(alpha=1))

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    draw_map(data, ("gamma", "beta"), mode=3, ax=axes)
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    return {"third frequency [1/T*]": float(data.frequency.sel(gamma=10, beta=0.5, mode=3))}


if __name__ == "__main__":  # processes are started, each of which imports this file
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
