"""How do I run a sweep on a cluster?

Give `sweep` a Dask client. Here its cluster is this machine; one of dask-jobqueue for SLURM, PBS or
LSF is used alike (assets/sweeps.md). The sweep is over the speeds and the masses of a published
table: flapwise at gamma = 12 a bare beam has omega_1 = 13.170, one with a tip mass 12.48.

Source: Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982), as quoted by Bir (2009).
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from distributed import Client, LocalCluster

from beamviz import Beam, sweep

PICTURE = "cluster.png"  # in the current folder, unless the command line names a file
AXES = {"gamma": np.arange(13.0), "alpha": [0.0, 1.0]}
SLENDER = Beam(mu=10000)  # the source leaves the stretch out


def main(picture=PICTURE):
    # Workers compute in one thread each, and must all see the folder of the store.
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        out = Path(folder) / "wright.zarr"
        data = sweep(AXES, out, 3, client, beam=SLENDER, plane="flapwise").load()

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    for alpha, style in ((0, "o-"), (1, "s--")):
        axes.plot(data.gamma, data.frequency.sel(alpha=alpha), style, color=f"C{alpha}", ms=3)
    axes.set(xlabel="rotation speed γ", ylabel="frequency ω [1/T*]")
    axes.set_title("flapwise, without (circles) and with a tip mass")
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    bare, loaded = data.frequency.sel(gamma=12, mode=1).values
    return {"omega_1 without a mass": bare, "omega_1 with a tip mass": loaded}


if __name__ == "__main__":  # processes are started, each of which imports this file
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
