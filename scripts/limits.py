"""The converged frequencies that methods are measured against: python scripts/limits.py

Nothing here is shared with the solver but `Beam` and the start of each root: the differential
equations of the straight beam, in the numbers of mpmath, by Taylor series from clamp to tip in
steps far below their radius of convergence.

    equilibrium  u' = f          N' = -gamma^2 rho (u + delta)    mu^2 n(f) = N
    bending      w' = f theta    theta' = f^power m               m' = f (N theta - V)
                 V' = -Lambda rho w                               power = 2 spatial, 0 material
    stretching   v' = p / (mu^2 n'(f))                            p' = -Lambda rho v

rho holds the mass: N, V and p step there. At the clamp u = w = theta = v = 0, at the tip N = V =
m = p = 0. Lambda is omega^2 + gamma^2 (in the plane of rotation). The tip's conditions are driven
to zero by the secant rule; a root is the k-th of its family because its shape has k - 1 nodes.
The two bending solutions that leave the clamp are made orthonormal after each step, so that their
growth costs no digits. Scenes may be named; the results are beamviz/evidence/benchmark/limits.json.
"""

import json
import time
from collections import namedtuple
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import _script
import numpy as np
from mpmath import fdot, mp, mpf

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.evidence.benchmark.external import PEERS
from beamviz.evidence.benchmark.work_precision import MODES, SCENES
from beamviz.solver import solve

FILE = _script.ROOT / "beamviz" / "evidence" / "benchmark" / "limits.json"
TERMS = 40  # of a Taylor series
DIGITS, GUARD = 20, 16  # stored, and worked with beyond them
SHARE = 0.15  # of the radius of convergence in one step: 0.15^40 = 1e-33
PHASE = 2.0  # of the fastest solution in one step: 2^40 / 40! = 1e-36
LONGEST = 0.05
CALCULIX, SOLID_ELEMENTS = PEERS[-1], 160
MADE = (
    "omega^2 of the lowest modes by scripts/limits.py: Taylor series of the differential equations"
    " in extended precision; solid: CalculiX on a fine mesh"
)

Series = list[Any]  # coefficients by power
ONE: Series = [mpf(1)] + [mpf(0)] * (TERMS - 1)


class Theory(NamedTuple):
    """A model: its strain law, or a tension of its own; its curvature; and the keywords with
    which `solve` starts each root."""

    strain: str  # green, biot, rigid (the tension of the reference length) or none
    power: int
    start: dict[str, Any]


THEORIES = {
    "green": Theory("green", 2, {}),
    "biot": Theory("biot", 0, {"strain": "biot", "curvature": "material"}),
    "rigid": Theory("rigid", 0, {"method": "foac"}),
    "none": Theory("none", 0, {"method": "zoac"}),
}


Column = namedtuple("Column", "w theta m V")  # a bending solution at a point


class Step(NamedTuple):
    """Taylor series about its start of what does not depend on the frequency."""

    h: Any
    f: Series
    bending_factor: Series  # f^power
    tension: Series  # f N
    compliance: Series  # 1 / (mu^2 n'(f))
    mass: Any  # at the end of the step


def product(a: Series, b: Series, k: int) -> Any:
    """Coefficient k of a b."""
    return fdot(a[: k + 1], b[k::-1])


def inverse(a: Series) -> Series:
    """1 / a."""
    b = [1 / a[0]]
    for k in range(1, TERMS):
        b.append(-fdot(a[1 : k + 1], b[::-1]) / a[0])
    return b


def at(a: Series, h: Any) -> Any:
    """The series at h."""
    value = mpf(0)
    for coefficient in reversed(a):
        value = value * h + coefficient
    return value


def root(function: Callable[[Any], Any], start: Any) -> Any:
    """The root of a function next to a start that is right to six digits or more, by the secant
    rule: where a step is below the tolerance, the error after the next is about its square."""
    near = start * (1 - mpf(10) ** -8)
    return mp.findroot(function, (near, start), tol=mpf(10) ** -(DIGITS - 4), verify=False)


class Straight:
    """A beam in one theory: its equilibrium as a chain of Taylor series, and its modes."""

    def __init__(self, beam: Beam, theory: Theory, modes: int = MODES):
        self.theory = theory
        self.approximate = solve(beam, modes, tolerance=1e-8, **theory.start)
        mp.dps = DIGITS + GUARD
        self.alpha, self.beta, self.gamma, self.delta, self.mu = map(mpf, beam.numbers.values())
        self.steps, _ = self.march(self.tension_at_clamp())

    def tension_at_clamp(self) -> Any:
        """N at the clamp: that of the reference length, or such that none is left at the tip, from
        that of the approximate solution on."""
        if self.theory.strain == "none" or not self.gamma:
            return mpf(0)
        if self.theory.strain == "rigid":
            outboard = self.alpha * (self.beta + self.delta) if self.beta else 0
            return self.gamma**2 * (mpf(1) / 2 + self.delta + outboard)
        f = mpf(float(self.approximate.equilibrium.stretch(np.zeros(1))[0]))
        start = self.mu**2 * ((f**3 - f) / 2 if self.theory.strain == "green" else f - 1)
        return root(lambda N: self.march(N)[1], start)

    def march(self, N: Any) -> tuple[list[Step], Any]:
        """The steps from a tension at the clamp, and what is left of it at the tip."""
        x, u, steps = mpf(0), mpf(0), []
        ends = sorted({self.beta, mpf(1)} - {mpf(0)})
        while x < 1:
            end = next(e for e in ends if e > x)
            f, tension, position = self.expand(u, N)
            rate = float(abs(f[0] ** (self.theory.power + 1) * N)) ** 0.5
            h = min(mpf(LONGEST), PHASE / mpf(rate + 1), SHARE * radius(f), end - x)
            mass = self.alpha if x + h >= end == self.beta else mpf(0)
            square, force = ([product(f, b, k) for k in range(TERMS)] for b in (f, tension))
            factor = square if self.theory.power else ONE
            steps.append(Step(h, f, factor, force, self.compliance(square), mass))
            u, N = at(position, h), at(tension, h)
            if self.theory.strain != "none":
                N -= self.gamma**2 * mass * (u + self.delta)
            x = end if x + h >= end else x + h
        return steps, N

    def expand(self, u: Any, N: Any) -> tuple[Series, Series, Series]:
        """f, N and u about a point, power by power."""
        strain, load = self.theory.strain, self.gamma**2 * (self.theory.strain != "none")
        f, tension, position = [self.stretch(N)], [N], [u]
        square: Series = [f[0] ** 2]  # of f, for green
        for k in range(1, TERMS):
            arm = position[k - 1] + (self.delta if k == 1 else 0)
            tension.append(-load * arm / k)
            position.append(f[k - 1] / k)
            if strain == "green":  # 2 n = f^3 - f, solved for its highest coefficient
                square.append(fdot(f[1:], f[:0:-1]))
                rest = fdot(f, square[k:0:-1])
                f.append((2 * tension[k] / self.mu**2 - rest) / (3 * f[0] ** 2 - 1))
                square[k] += 2 * f[0] * f[k]
            else:
                f.append(tension[k] / self.mu**2 if strain == "biot" else mpf(0))
        return f, tension, position

    def stretch(self, N: Any) -> Any:
        """f at tension N, on the branch that starts from 1."""
        n = N / self.mu**2
        if self.theory.strain == "biot":
            return 1 + n
        if self.theory.strain != "green":
            return mpf(1)
        guess = mp.cbrt(2 * n) if n > 1 else 1 + n / (1 + n)
        return mp.findroot(lambda f: f**3 - f - 2 * n, guess)

    def compliance(self, square: Series) -> Series:
        """1 / (mu^2 n'(f)), from f^2."""
        slope = ONE
        if self.theory.strain == "green":
            slope = [(3 * c - o) / 2 for c, o in zip(square, ONE, strict=True)]
        return [c / self.mu**2 for c in inverse(slope)]

    def bending(self, Lambda: Any) -> tuple[list[Any], list[Any]]:
        """The two solutions that leave the clamp: at the end of each step as orthonormal columns of
        w, theta, m, V, and the triangle that made them so."""
        Q, R = [(Column(0, 0, 1, 0), Column(0, 0, 0, 1))], []
        for step in self.steps:
            first, second = (self.advanced(step, Lambda, column) for column in Q[-1])
            a = mp.norm(first)
            first = Column(*(value / a for value in first))
            b = fdot(first, second)
            second = Column(*(y - b * x for x, y in zip(first, second, strict=True)))
            c = mp.norm(second)
            Q.append((first, Column(*(value / c for value in second))))
            R.append((a, b, c))
        return Q, R

    def advanced(self, step: Step, Lambda: Any, start: Column) -> Column:
        """A bending solution at the end of a step, from its start."""
        w, theta, m, V = ([value] for value in start)
        for k in range(TERMS - 1):
            w.append(product(step.f, theta, k) / (k + 1))
            theta.append(product(step.bending_factor, m, k) / (k + 1))
            m.append((product(step.tension, theta[: k + 1], k) - product(step.f, V, k)) / (k + 1))
            V.append(-Lambda * w[k] / (k + 1))
        end = Column(*(at(series, step.h) for series in (w, theta, m, V)))
        return end._replace(V=end.V - Lambda * step.mass * end.w)

    def stretching(self, Lambda: Any) -> list[tuple[Any, Any]]:
        """v, p at the end of each step, from a force at the clamp."""
        states = [(mpf(0), mpf(1))]
        for step in self.steps:
            v, p = ([c] for c in states[-1])
            for k in range(TERMS - 1):
                v.append(product(step.compliance, p, k) / (k + 1))
                p.append(-Lambda * v[k] / (k + 1))
            end = at(v, step.h)
            states.append((end, at(p, step.h) - Lambda * step.mass * end))
        return states

    def determinant(self, Lambda: Any) -> Any:
        """Of moment and shear at the tip."""
        first, second = self.bending(Lambda)[0][-1]
        return first.m * second.V - second.m * first.V

    def deflection(self, Lambda: Any) -> list[Any]:
        """w at the end of each step, of the solution without a moment at the tip."""
        Q, R = self.bending(Lambda)
        shares = (Q[-1][1].m, -Q[-1][0].m)
        w = [shares[0] * Q[-1][0].w + shares[1] * Q[-1][1].w]
        for (first, second), (a, b, c) in zip(Q[-2::-1], R[::-1], strict=True):
            y = shares[1] / c
            shares = ((shares[0] - b * y) / a, y)
            w.append(shares[0] * first.w + shares[1] * second.w)
        return w[::-1]

    def squares(self) -> list[Any]:
        """omega^2 of the lowest modes of both families, ascending."""
        found = []
        near = self.approximate
        for label, rough in zip(near.labels, near.omega_squared, strict=True):
            start = mpf(float(rough)) + self.gamma**2
            if label[0] == "B":
                Lambda = root(self.determinant, start)
                shape = self.deflection(Lambda)
            else:
                Lambda = root(lambda L: self.stretching(L)[-1][1], start)
                shape = [state[0] for state in self.stretching(Lambda)]
            if nodes(shape) != int(label[1:]) - 1:
                raise ArithmeticError(f"{label} has {nodes(shape)} nodes")
            found.append(Lambda - self.gamma**2)
        return found


def radius(f: Series) -> Any:
    """A low estimate of the radius of convergence of a series."""
    last = range(TERMS - 4, TERMS)
    return min((abs(f[k]) ** (mpf(-1) / k) for k in last if f[k]), default=mpf(1))


def nodes(shape: list[Any]) -> int:
    """Changes of sign, the clamp left out."""
    signs = [mp.sign(value) for value in shape[1:]]
    return sum(a * b < 0 for a, b in pairwise(signs))


def limits(scene: str) -> dict[str, list[str] | str]:
    """omega^2 of a scene in every theory, or why there are none."""
    found: dict[str, list[str] | str] = {}
    for name, theory in THEORIES.items():
        began = time.perf_counter()
        try:
            squares = Straight(SCENES[scene], theory).squares()
            found[name] = [mp.nstr(value, DIGITS) for value in squares]
        except NoEquilibrium as error:
            found[name] = str(error)
        _script.print_row(f"{scene}, {name}", time.perf_counter() - began, "s")
    return found


def solid(beam: Beam) -> list[str] | str:
    """omega^2 of CalculiX on its finest mesh: about five digits of the limit of a solid."""
    try:
        return [f"{x:.7g}" for x in CALCULIX.omega_squared(beam, SOLID_ELEMENTS, MODES)]
    except NotConverged as error:
        return str(error)


def main(scenes: list[str]) -> None:
    """Compute the limits of the named scenes, or of all, and write the file; those of a solid stay
    as they are where CalculiX is not installed."""
    known = json.loads(FILE.read_text())["limits"]
    for scene in scenes or SCENES:
        known[scene] = known.get(scene, {}) | limits(scene)
        if not CALCULIX.missing:
            known[scene]["solid"] = solid(SCENES[scene])
        ordered = {name: known[name] for name in SCENES if name in known}
        FILE.write_text(json.dumps({"made": MADE, "limits": ordered}, indent=1) + "\n")


if __name__ == "__main__":
    parser = _script.Parser(__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", type=_script.one_of(SCENES))
    main(parser.parse_args().scenes)
