"""What does a beam do when it is let go?

A force of 3 E I / L^2 holds the tip of a rotating beam, with a mass as heavy as the beam, 0.4919 L
off; at t = 0 it is released. The motion is large, so `motion` integrates the nonlinear equation in
time. At t = 2 T* the tip is 0.3780 L off on the other side.

Source: an independent integration, with polynomials and DOP853 (tests/oracle/motion.py).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, motion

PICTURE = "release.png"  # in the current folder, unless the command line names a file


def main(picture=PICTURE):
    moved = motion(Beam(alpha=1, gamma=3), until=4, release=3)
    print(moved)

    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
    moved.plot(left)
    x, times = np.linspace(0, 1, 51), np.linspace(0, 0.75, 7)
    for t, position in zip(times, moved.position(times, x), strict=True):
        right.plot(*position.T, color=plt.cm.viridis(t), label=f"t = {t:.3g}")
    right.set(title="the beam", xlabel="along the beam [L]", ylabel="across [L]")
    right.axis("equal")
    right.legend(fontsize=7)
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    return {"tip at t = 0 [L]": moved.tip[0, 1], "tip at t = 2 [L]": moved.tip[200, 1]}


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
