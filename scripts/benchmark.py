"""How fast a solve is, as ratios measured in one run: python scripts/benchmark.py

1. A default solve (equilibrium, 5 modes, error estimates, relative 1e-6) against the time its
   eigenproblems alone take, repeated while caches are warm: by scipy.linalg.eigh, and by LAPACK's
   bare routines.
2. The paper's elements: equilibrium and assembly per element, which should not grow with their
   number.
3. A sweep of 201 points with 6 modes against 201 separate solves.
4. A bent solve, without a start and from a neighbour's state, against a straight one that has at
   least as many unknowns.

Times are the least of many repeats, in one thread.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from functools import partial
from typing import Any

import numpy as np
from _arguments import Parser

from beamviz.beam import Beam
from beamviz.benchmark.work_precision import lapack_ratios, least_time
from beamviz.solver import Solution, solve, solve_many
from beamviz.solver.fem import straight_equilibrium
from beamviz.solver.fem.elements import PlanarBeam
from beamviz.solver.problem import Problem

PAPER = Problem()

SCENES = {
    "at rest": Beam(),
    "gamma 10": Beam(gamma=10),
    "gamma 10, mass at the tip": Beam(alpha=1, gamma=10),
    "gamma 10, mass at 0.5": Beam(alpha=1, beta=0.5, gamma=10),
    "gamma 50, delta 1": Beam(gamma=50, delta=1),
    "gamma 50, delta 1, mass at 0.3": Beam(alpha=1, beta=0.3, gamma=50, delta=1),
}

BENT_SCENES = {
    "delta -1, gamma 4": Beam(delta=-1, gamma=4),
    "delta -1, gamma 20, mass at 0.5": Beam(alpha=1, beta=0.5, delta=-1, gamma=20),
    "gamma 5, spin-up 10": Beam(gamma=5, spin_up=10),
}


def default_solves() -> None:
    head = f"{'default solve':32}{'us':>8}{'unknowns':>10}"
    print(f"{head}{'/ eigh':>8}{'/ LAPACK':>10}")
    for name, beam in SCENES.items():
        found, seconds = lapack_ratios(beam), least_time(partial(solve, beam))
        print(
            f"{name:32}{1e6 * seconds:8.0f}{solve(beam).stats.dof:10}"
            f"{found['eigh']:8.1f}{found['bare_lapack']:10.1f}"
        )


def ancf_equilibrium(beam: Beam, elements: int) -> None:
    straight_equilibrium(PlanarBeam(np.linspace(0, 1, elements + 1), beam, PAPER))


def paper_elements() -> None:
    beam = Beam(alpha=1, beta=0.5, gamma=10)
    print(f"\n{'ancf, equilibrium and assembly':32}{'ms':>8}{'us / element':>14}{'/ 20':>8}")
    first = 0.0
    for n in (20, 40, 80, 160, 320):
        seconds = least_time(partial(ancf_equilibrium, beam, n), 20)
        per_element = 1e6 * seconds / n
        first = first or per_element
        print(f"{n:4} elements{1e3 * seconds:28.2f}{per_element:14.1f}{per_element / first:8.2f}")


def one_by_one(beams: list[Beam]) -> None:
    for beam in beams:
        solve(beam, modes=6)


def sweeps() -> None:
    print(f"\n{'201 points, 6 modes':32}{'ms':>8}{'one by one':>14}{'ratio':>8}")
    for name, alpha, beta in (("no mass", 0, 1), ("mass at the tip", 1, 1), ("at 0.5", 1, 0.5)):
        beams = [Beam(alpha, beta, gamma) for gamma in np.linspace(0, 15, 201)]
        together = least_time(partial(solve_many, beams, modes=6), 10)
        apart = least_time(partial(one_by_one, beams), 3)
        print(f"{name:32}{1e3 * together:8.1f}{1e3 * apart:14.1f}{apart / together:8.1f}")


def straight_with(unknowns: int, coriolis: bool) -> partial[Solution]:
    """A solve of a straight beam with as many unknowns, by the number of modes asked for."""
    beam = Beam(alpha=1, beta=0.5, gamma=30, delta=1)
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        for modes in (5, 10, 20):
            one = partial(solve, beam, modes=modes, tolerance=tolerance, coriolis=coriolis)
            if one().stats.dof >= unknowns:
                return one
    return one


def bent_solves() -> None:
    print(f"\n{'bent solve':40}{'unknowns':>10}{'ms':>8}{'/ straight':>12}{'neighbour':>12}")
    for name, beam in BENT_SCENES.items():
        for coriolis in (False, True):
            options: dict[str, Any] = {"state": "bent", "coriolis": coriolis}
            unknowns = solve(beam, **options).stats.dof
            straight = least_time(straight_with(unknowns, coriolis), 20)
            cold = least_time(partial(solve, beam, **options), 10)
            beams = [beam.replace(gamma=beam.gamma * (1 + 1e-3 * k)) for k in range(21)]
            row = least_time(partial(solve_many, beams, **options), 3)
            near = (row - cold) / (len(beams) - 1)
            print(
                f"{name + ', Coriolis' * coriolis:40}{unknowns:10}{1e3 * cold:8.1f}"
                f"{cold / straight:12.1f}{near / straight:12.1f}"
            )


if __name__ == "__main__":
    Parser(__doc__).parse_args()
    default_solves()
    paper_elements()
    sweeps()
    bent_solves()
