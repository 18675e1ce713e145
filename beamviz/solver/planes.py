"""The section of a beam in the plane, or the planes, that it bends in.

The section at x is turned about the axis of the beam by phi(x) = pitch + twist x, and the twist of
a blade, from the plane of rotation towards its axis. Where it is not, or where it bends as easily
in every direction, bending in the plane of rotation and out of it do not couple: they are solved
for one by one, and joined. A single plane has no turned section.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.blade import Blade
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, Stats, read_only

Answer = Solution | BeamvizError


def check_in_space(beam: Beam) -> None:
    """InvalidInput for what bends in the plane of rotation only."""
    if beam.spin_up:
        raise InvalidInput(
            f"spin_up = {beam.spin_up:g}: bends the beam in the plane of rotation only",
            use={"plane": ("chordwise",)},
        )


def check_not_turned(beam: Beam) -> None:
    """InvalidInput for a turned section in a single plane."""
    if beam.is_turned:
        numbers = {name: getattr(beam, name) for name in ("pitch", "twist")}
        given = ", ".join(f"{name} = {value:g}" for name, value in numbers.items() if value)
        raise InvalidInput(
            f"{given or 'the twist of the blade'}: a turned section couples bending in the plane of"
            " rotation and out of it",
            use={"plane": ("both",)},
        )


def beam_in_plane(beam: Beam, plane: str) -> Beam:
    """The beam of the mechanics, which know flap, pitch and twist as properties of a blade: with
    the blade that has those of them that count in a plane. Raises InvalidInput for a turned section
    in a single plane."""
    if plane == "both":
        blade = section(beam.blade, beam.flap, beam.pitch, beam.twist)
        return beam.replace(blade=blade, flap=1.0, pitch=0.0, twist=0.0)
    check_not_turned(beam)
    if plane == "flapwise" and beam.flap != 1:
        return beam.replace(blade=section(None, beam.flap, 0.0, 0.0), flap=1.0)
    return beam


@lru_cache(maxsize=64)
def problems_of_planes(problem: Problem) -> tuple[Problem, Problem]:
    """The problems in the plane of rotation and out of it of one in both."""
    chordwise = replace(problem, plane="chordwise")
    return chordwise, replace(problem, plane="flapwise", coriolis=False)


@lru_cache(maxsize=256)
def section(blade: Blade | None, flap: float, pitch: float, twist: float) -> Blade:
    """The blade with pitch and twist in its own twist; of a uniform beam that of its flap."""
    if blade is None:
        ones = (1.0, 1.0)
        blade = Blade((0.0, 1.0), ones, ones, ones, (flap, flap))
    twists = blade.twist or (0.0,) * len(blade.x)
    turns = tuple(pitch + twist * x + own for x, own in zip(blade.x, twists, strict=True))
    return replace(blade, twist=turns)


def solve_both(
    beams: Sequence[Beam],
    problem: Problem,
    solve: Callable[[list[Beam], Problem], list[Answer]],
) -> list[Answer]:
    """The solutions of beams that bend in both planes, or their errors. solve: solves for beams of
    the mechanics; those whose planes do not couple, in each plane. Raises InvalidInput."""
    for beam in beams:
        check_in_space(beam)
    answers: dict[int, Answer] = {}
    coupled = [k for k, beam in enumerate(beams) if beam.is_turned]
    others = [k for k in range(len(beams)) if k not in set(coupled)]
    if coupled:
        in_space = [beam_in_plane(beams[k], "both") for k in coupled]
        answers |= dict(zip(coupled, solve(in_space, problem), strict=True))
    if others:
        rows: list[list[Answer]] = []
        for of_plane in problems_of_planes(problem):
            sections = [beam_in_plane(beams[k], of_plane.plane) for k in others]
            rows.append(solve(sections, of_plane))
        for k, chordwise, flapwise in zip(others, *rows, strict=True):
            answers[k] = joined(chordwise, flapwise, problem)
    return [answers[k] for k in range(len(beams))]


def joined(chordwise: Answer, flapwise: Answer, problem: Problem) -> Answer:
    """The solution in both planes of those in each; or the error of one of them."""
    if isinstance(chordwise, BeamvizError) or isinstance(flapwise, BeamvizError):
        return chordwise if isinstance(chordwise, BeamvizError) else flapwise
    out_of_plane = np.flatnonzero(flapwise.bending_energy_fraction >= 0.5)
    squares = np.concatenate((chordwise.omega_squared, flapwise.omega_squared[out_of_plane]))
    count = max(len(chordwise.s), len(flapwise.s))
    order = squares.argsort(kind="stable")[:count]
    modes = JoinedModes(chordwise, flapwise, out_of_plane, order)
    stats = chordwise.stats
    dof, order_of_elements = stats.dof + flapwise.stats.dof, max(stats.order, flapwise.stats.order)
    status = chordwise.equilibrium.status
    return replace(
        chordwise,
        problem=problem,
        equilibrium=replace(
            chordwise.equilibrium,
            status=flapwise.equilibrium.status if status == "stable" else status,
        ),
        stats=Stats(dof, stats.method, stats.elements, order_of_elements),
        s=read_only(modes.listed(lambda solution: solution.s)),
        estimate_errors=partial(modes.listed, _errors),
        bending_energy_fraction=read_only(modes.listed(lambda each: each.bending_energy_fraction)),
        fields=modes,
        in_plane_fraction=read_only((order < len(chordwise.s)).astype(float)),
    )


def _errors(solution: Solution) -> NDArray:
    """Estimated errors (modes,) of omega^2."""
    return solution.omega_squared_errors


@dataclass(frozen=True, eq=False)
class JoinedModes:
    """The modes of a beam in each of its planes, in one list: the `fields` of a Solution."""

    chordwise: Solution
    flapwise: Solution
    out_of_plane: NDArray  # indices of the modes of the second that bend
    order: NDArray  # (modes,) indices in those of the first, followed by these

    def listed(self, of_modes: Callable[[Solution], NDArray]) -> NDArray:
        """A quantity (modes,) of all modes."""
        parts = of_modes(self.chordwise), of_modes(self.flapwise)[self.out_of_plane]
        return np.concatenate(parts)[self.order]

    def arranged(self, chordwise: NDArray, flapwise: NDArray) -> NDArray:
        """Displacements (points, 3, modes) of those (points, 2, modes) in each plane."""
        flapwise = flapwise[..., self.out_of_plane]
        count = chordwise.shape[-1]
        dtype = np.result_type(chordwise, flapwise)
        fields = np.zeros((len(chordwise), 3, count + flapwise.shape[-1]), dtype)
        fields[:, :2, :count] = chordwise
        fields[:, 2, count:] = flapwise[:, 1]
        return fields[..., self.order]

    def __call__(self, x: NDArray) -> NDArray:
        """Displacements (len(x), 3, modes) along the beam, in the plane of rotation, out of it."""
        return self.arranged(self.chordwise.fields(x), self.flapwise.fields(x))
