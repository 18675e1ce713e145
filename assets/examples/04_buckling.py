"""How fast may an inward beam turn before it buckles?

Clamped to a rim and pointing at the axis, a beam is compressed by its own centrifugal force. With
its tip at the axis (delta = -1) it is straight up to gamma = 2.996. Beyond, the straight state is
unstable and a bent one takes its place: at gamma = 4 its tip is 0.858 L off.

Source: a Ritz computation of the buckling speed, independent of this project; the differential
equations of the bent beam (tests/oracle/bent.py).
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from beamviz import Beam, loci, solve

PICTURE = "buckling.png"  # in the current folder, unless the command line names a file
INWARD = Beam(delta=-1)


def main(picture=PICTURE):
    straight = loci(INWARD, "gamma", np.linspace(0, 5, 51), modes=2)
    (limit,) = straight.limits
    print(limit.message)

    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
    straight.plot(left)
    x = np.linspace(0, 1, 101)
    for gamma in (3.0, 3.2, 3.6, 4.0):
        bent = solve(INWARD.replace(gamma=gamma), state="stable").equilibrium
        right.plot(*bent.position(x).T, label=f"γ = {gamma:g}")
    right.set(title="the stable state", xlabel="along the beam [L]", ylabel="across [L]")
    right.axis("equal")
    right.legend()
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    return {"buckling at gamma": limit.start, "tip at gamma = 4 [L]": abs(bent.tip[1])}


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
