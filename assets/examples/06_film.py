"""How do I get a film of a mode into my slides?

One call writes a GIF, WebP or MP4 that repeats without a seam. The second bending mode of a beam
with a mass in its middle, at gamma = 10, vibrates with 22.0955 / T*.

Source: computed independently of this project (assets/validation.md).
"""

import sys

from beamviz import Beam, Scene, animate, solve

PICTURE = "film.webp"  # in the current folder, unless the command line names a file


def main(picture=PICTURE):
    beam = Beam(alpha=1, beta=0.5, gamma=10)
    loop = animate(picture, Scene.of(beam, mode=2), width=320, height=180, fps=12)
    print(f"{picture}: {loop.seconds:.2f} s, repeated without a seam")

    return {"B2 [1/T*]": solve(beam).frequencies[1]}


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
