"""A lesson: texts, a scene to begin with, a computed fact, and a challenge with its check; and the
quantities in the lessons, computed when they are needed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from beamviz.adjusting import adjust
from beamviz.beam import NUMBERS, Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.frequency_loci import Event, loci
from beamviz.scene import Scene
from beamviz.solver import Solution, solve

BARE = Beam()  # at rest, without mass
TIP = Beam(alpha=1, beta=1)
MIDDLE = Beam(alpha=1, beta=0.5)
ACCURACY = ("elements", "tolerance")  # options that may be changed in all challenges
ON_OFF = {True: "on", False: "off"}
LABELS = {"coriolis": "Coriolis", "softening": "spin softening"}
UNDEFINED = "not defined for this beam"
PLUCK, HEARD = 0.1, 20.0  # force [E I / L^2] and time [T*] of a plucked beam
MIN_MASS = 0.5  # alpha, in a challenge that leaves the mass free


class Verdict(NamedTuple):
    """Whether a challenge is met, and the reason."""

    met: bool
    reason: str


@dataclass(frozen=True, kw_only=True)
class Lesson:
    """A question about the beam that experiments answer, and a challenge: to find the value of one
    of its numbers, or the point at which the beam is pulled before it is let go, with all
    other numbers as in the lesson's scene.

    In the texts, *single stars* mark technical terms and **double stars** controls of the page.
    """

    name: str
    title: str
    scene: Scene  # that it begins with
    motion: Mapping[str, Any] = field(default_factory=dict)  # in time, as the page has it, or {}

    question: str
    guesses: tuple[str, ...]  # answers to choose from before the experiment
    right: int  # index of the right guess
    do: str
    see: str
    meaning: str
    fact: str  # a sentence with placeholders for the numbers of compute_fact
    compute_fact: Callable[[], tuple[float, ...]]

    # The challenge

    task: str
    number: str = "gamma"  # to be found: a number of a beam or "pull_at"
    within: float = 0.1  # accepted distance from the answer
    # The quantity to observe, one number or several, of a solution (and for "pull_at" that point).
    gauge: Callable[..., Any]
    reading: str  # a phrase with placeholders for the numbers of the gauge
    level: float | None = None  # the gauge's first number at the answer, which is then solved for
    answer_in_fact: int = 0  # without a level: the index of the answer in the numbers of the fact
    # The largest value of the gauge's first number that is accepted, where other numbers are free
    # that it depends on.
    at_most: float | None = None
    free: tuple[str, ...] = ()  # other numbers and options that may differ from the scene's

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """The numbers of the fact, computed once."""
        return self.compute_fact()

    @property
    def proof(self) -> str:
        return self.fact.format(*self.numbers)

    @cached_property
    def answer(self) -> float:
        """The value that meets the challenge, computed once."""
        if self.level is None:
            return self.numbers[self.answer_in_fact]

        def excess(value: float) -> float:
            beam = self.scene.beam.replace(**{self.number: value})
            return np.ravel(self.gauge(solve(beam, **self.scene.options)))[0] - self.level

        low, high, _ = NUMBERS[self.number].slider
        return brentq(excess, low, high, xtol=1e-9)

    @property
    def record(self) -> dict[str, Any]:
        """The texts, without marks of emphasis, the numbers and the scene, for JSON."""
        return {
            **{key: getattr(self, key) for key in ("name", "title", "question")},
            "guesses": {"answers": self.guesses, "right": self.right},
            **{key: getattr(self, key).replace("*", "") for key in ("do", "see", "meaning")},
            "proof": {"words": self.proof, "numbers": self.numbers},
            "challenge": {
                **{key: getattr(self, key) for key in ("task", "number", "within")},
                "answers": [self.answer],
            },
            "scene": self.scene.tables,
            "motion": dict(self.motion),
        }

    def check(self, beam: Beam, options: Mapping[str, Any], pull_at: float = 1.0) -> Verdict:
        """Whether `beam`, solved with the keywords `options` of `solve`, meets the challenge.
        pull_at: the point at which it is pulled before it is let go."""
        if obstacle := self._obstacle(beam, options):
            return Verdict(False, obstacle)
        value = pull_at if self.of_pull else getattr(beam, self.number)
        if abs(self.answer - value) > self.within or self._exceeds(beam, options):
            return Verdict(False, "")
        near = f"is within {self.within:g} of {self.answer:.5g}"
        symbol = "x" if self.of_pull else NUMBERS[self.number].symbol
        return Verdict(True, f"{symbol} = {value:.5g} {near}.")

    @property
    def of_pull(self) -> bool:
        """Whether the challenge is to find the point at which the beam is pulled."""
        return self.number == "pull_at"

    def measured(self, solution: Solution, pull_at: float = 1.0) -> str:
        """The gauge of a solution in words."""
        try:
            given = (solution, pull_at) if self.of_pull else (solution,)
            values = np.ravel(self.gauge(*given))
        except BeamvizError:
            return UNDEFINED
        return self.reading.format(*values) if np.isfinite(values).all() else UNDEFINED

    def _exceeds(self, beam: Beam, options: Mapping[str, Any]) -> bool:
        """Whether the first number of the gauge is above `at_most`, or is not known."""
        if self.at_most is None:
            return False
        try:
            first = float(np.ravel(self.gauge(solve(beam, **options)))[0])
        except BeamvizError:
            return True
        return not first <= self.at_most

    def _obstacle(self, beam: Beam, options: Mapping[str, Any]) -> str:
        """The change to undo before the challenge can be met, or ""."""
        free = (*self.free, self.number, *ACCURACY)
        if "alpha" in free and beam.alpha < MIN_MASS:
            return f"Make the mass α at least {MIN_MASS:g}: a lighter one has little effect."
        for name, parameter in NUMBERS.items():
            start = getattr(self.scene.beam, name)
            if name not in free and getattr(beam, name) != start:
                return f"Put the {parameter.label} {parameter.symbol} back to {start:g} first."
        for name, choice in self.scene.options.items():
            if name not in free and options.get(name, choice) != choice:
                return f"Put {LABELS.get(name, name)} back to {ON_OFF.get(choice, choice)} first."
        return ""


# Quantities in the lessons


def frequency(beam: Beam, label: str = "B1", **options: Any) -> float:
    """Frequency of the mode `label` of a beam."""
    return labelled(solve(beam, **options), label)


def labelled(solution: Solution, label: str) -> float:
    """Frequency of the mode `label`; nan where it is unstable or not among the modes solved."""
    frequencies = dict(zip(solution.labels, solution.frequencies, strict=True))
    return float(frequencies.get(label, np.nan))


def difference(solution: Solution) -> float:
    """|S1 - B3|."""
    return abs(labelled(solution, "S1") - labelled(solution, "B3"))


def crossing(over: str, stop: float, **options: Any) -> Event:
    """Crossing or veering of S1 and B3 with a mass as heavy as the beam at its tip."""
    computed = loci(TIP, over, np.linspace(0, stop, 21), **options)
    return next(event for event in computed.events if set(event.branches) == {"B3", "S1"})


FLAT = Beam(flap=0.25)
VERY_FLAT = Beam(flap=1 / 16)


def flap_and_lag() -> tuple[float, float, float, float]:
    """Of a flat beam: the speed at which F1 and L1 cross; their least gap with a pitch of 5 deg
    and its speed; the pitch [deg] at which they are 0.5 apart at gamma = 3."""

    def gap(gamma: float, pitch: float) -> float:
        solution = solve(FLAT.replace(gamma=gamma, pitch=pitch), modes=2, plane="both")
        return float(solution.frequencies[1] - solution.frequencies[0])

    events = loci(FLAT, "gamma", np.linspace(0, 6, 25), modes=3, plane="both").events
    meeting = next(event for event in events if set(event.branches) == {"F1", "L1"})
    least = minimize_scalar(
        gap, bounds=(2, 5), args=(5,), method="bounded", options={"xatol": 1e-7}
    )
    pitch = brentq(lambda pitch: gap(3, pitch) - 0.5, 1, 45, xtol=1e-9)
    return meeting.at, float(least.fun), float(least.x), pitch


def twisted_shares() -> tuple[float, float, float, float]:
    """Of a flat beam at rest: the share of kinetic energy in the plane of rotation of modes 1 to 3
    at a twist of 60 deg, and the twist [deg] at which mode 3 has a quarter."""

    def shares(twist: float) -> list[float]:
        solution = solve(VERY_FLAT.replace(twist=twist), modes=3, plane="both")
        assert solution.in_plane_fraction is not None
        return [float(share) for share in solution.in_plane_fraction]

    first, second, third = shares(60)
    twist = brentq(lambda twist: shares(twist)[2] - 0.25, 1, 89, xtol=1e-9)
    return first, second, third, twist


MEASURED = {"B1": 2.197, "B2": 21.74, "B3": 49.86, "S1": 67.97, "B4": 104.7}  # of a hidden mass
HIDDEN = Beam(alpha=0.9, beta=0.75)  # which has these frequencies


def misfit(solution: Solution) -> float:
    """Root mean square of the relative differences [%] of five frequencies from those measured."""
    differences = [labelled(solution, label) / omega - 1 for label, omega in MEASURED.items()]
    return 100 * float(np.sqrt(np.mean(np.square(differences))))


def hidden_mass() -> tuple[float, float, float, float]:
    """The mass and its position that fit the five frequencies measured; and of the masses that fit
    the first two the one that is farthest from it."""
    free = {"alpha": (0.0, 5.0), "beta": (0.05, 1.0)}
    five, two = (
        adjust(
            MIDDLE,
            free,
            measured={
                "mode": [*MEASURED][:count],
                "frequency": [*MEASURED.values()][:count],
                "error": [0.001 * omega for omega in MEASURED.values()][:count],
            },
        )
        for count in (5, 2)
    )
    mass, place = five.free["alpha"], five.free["beta"]
    others = (two.free, *two.alternatives)
    other = max(others, key=lambda values: abs(values["beta"] - place))
    return mass, place, other["alpha"], other["beta"]


def resonance(per_rev: int, label: str) -> float:
    """Speed at which omega = per_rev gamma for a mode of the bare beam."""
    events = loci(BARE, "gamma", np.linspace(0, 15, 31), per_rev=per_rev).events
    wanted = per_rev, (label,)
    return next(event.at for event in events if (event.per_rev, event.branches) == wanted)


def first_unstable(beam: Beam, stop: float, **options: Any) -> float:
    """Speed at which the straight beam becomes unstable."""
    computed = loci(beam, "gamma", np.linspace(0, stop, 21), modes=1, **options)
    return next(limit.start for limit in computed.limits if limit.kind == "unstable")


def last_equilibrium(beam: Beam, **options: Any) -> float:
    """Highest speed with an equilibrium."""
    try:
        solve(beam.replace(gamma=2 * beam.mu), **options)
    except NoEquilibrium as error:
        return error.limit
    raise ValueError(f"{beam} has an equilibrium at every speed tried")


def strain_at_mass(solution: Solution) -> tuple[float, float]:
    """Strain [%] at the inner and at the outer side of the mass."""
    sides = np.clip([solution.beam.beta - 1e-9, solution.beam.beta + 1e-9], 0, 1)
    inside, outside = 100 * (solution.equilibrium.stretch(sides) - 1)
    return float(inside), float(outside)


def tip(beam: Beam) -> np.ndarray:
    """Position (2,) of the tip from the clamp in the stable state."""
    return solve(beam, state="stable").equilibrium.tip


KANE = Beam(mu=447.2136, gamma=5.554921)  # the robot arm of Kane, Ryan & Banerjee, 6 rad/s
SPIN_UP_TIME = 16.20185  # [T*], 15 s


def spin_up() -> tuple[float, float, float]:
    """The largest lag of the tip of the robot arm, its time, and the time at which the theory
    without stiffening has left the picture."""
    from beamviz.dynamics import motion
    from beamviz.dynamics.drives import Ramp
    from beamviz.dynamics.linear import motion_without_stiffening

    speed = Ramp(KANE.gamma, SPIN_UP_TIME)
    stiffened = motion(KANE, SPIN_UP_TIME, speed=speed, points=4001)
    k = int(np.argmin(stiffened.tip[:, 1]))
    end = motion_without_stiffening(KANE, SPIN_UP_TIME, speed=speed).t[-1]
    return float(-stiffened.tip[k, 1]), float(stiffened.t[k]), float(end)


def strength(solution: Solution, label: str, pull_at: float) -> float:
    """Amplitude of a mode at the tip over that of B1, by the linear theory, after a beam without a
    mass was pulled at a point x and let go: mode k has phi_k(x) / (phi_k(1) omega_k^2), as its
    modal mass is phi_k(1)^2 / 4 of that of the beam."""
    shares = []
    for name in (label, "B1"):
        k = solution.labels.index(name)
        at, tip = solution.shape(k, np.array([pull_at, 1.0]))[:, 1].real
        shares.append(at / tip / solution.frequencies[k] ** 2)
    return abs(shares[0] / shares[1])


def heard(label: str, pull_at: float) -> float:
    """The ratio of `strength` in a computed motion of the bare beam."""
    from beamviz.dynamics import motion

    plucked = motion(BARE, HEARD, release=PLUCK, release_at=pull_at)
    t = np.linspace(0.0, HEARD, 4001)
    deflection = np.hanning(len(t)) * plucked.position(t, [1.0])[:, 0, 1]
    omegas = [frequency(BARE, name) for name in (label, "B1")]
    first, other = (abs(deflection @ np.exp(1j * omega * t)) for omega in omegas)
    return float(first / other)
