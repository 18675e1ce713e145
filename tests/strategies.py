"""Random beams for hypothesis."""

from typing import Any

from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.blade import Blade

EVERYDAY = {
    "alpha": (0.0, 5.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 60.0),
    "delta": (0.0, 3.0),
    "mu": (20.0, 500.0),
}


def beams(**ranges: tuple[float, float]) -> st.SearchStrategy[Beam]:
    """Beams within an everyday range of each number, or another one."""
    return st.builds(Beam, **{name: st.floats(*ends) for name, ends in (EVERYDAY | ranges).items()})


@st.composite
def stations(draw: st.DrawFn) -> list[float]:
    """2 to 12 stations from 0 to 1, ascending; some are named twice, a jump."""
    x, steps = [0.0], draw(st.lists(st.floats(0.01, 1.0), min_size=1, max_size=8))
    for step in steps:
        x.append(x[-1] + step)
        if len(x) < len(steps) and draw(st.booleans()):
            x.append(x[-1])
    return [place / x[-1] for place in x[:-1]] + [1.0]


def rows(count: int) -> st.SearchStrategy[list[float]]:
    """A property at stations, relative to that at the root."""
    others = st.lists(st.floats(0.2, 1.0), min_size=count - 1, max_size=count - 1)
    return others.map(lambda values: [1.0, *values])


@st.composite
def blades(draw: st.DrawFn) -> Blade:
    """Dimensionless blades, linear between stations."""
    x = draw(stations())
    mass, bending, axial = (draw(rows(len(x))) for _ in range(3))
    return Blade(x, mass, bending, axial, draw(st.none() | rows(len(x))))


@st.composite
def physical_beams(draw: st.DrawFn, by_stations: bool = False) -> dict[str, Any]:
    """Keywords of `Beam.from_si` for blades and uniform beams of plausible sizes, by their mass and
    stiffnesses; by_stations: always at stations."""
    L, m = draw(st.floats(0.1, 100.0)), draw(st.floats(0.01, 100.0))
    EA = m * draw(st.floats(1000.0, 6000.0)) ** 2
    EI = EA * (draw(st.floats(0.005, 0.1)) * L) ** 2 / 12
    values: dict[str, Any] = {
        "length": L,
        "mass_per_length": m,
        "bending_stiffness": EI,
        "axial_stiffness": EA,
    }
    if draw(st.booleans()):
        values["flap_stiffness"] = EI * draw(st.floats(0.1, 10.0))
    if by_stations or draw(st.booleans()):
        x = draw(stations())
        values["stations"] = [L * place for place in x[:-1]] + [L]
        for name in values.keys() - {"length", "stations"}:
            if draw(st.booleans()):
                values[name] = [values[name] * share for share in draw(rows(len(x)))]
    a = values["hub_radius"] = L * draw(st.floats(0.0, 2.0))
    values["rotation_speed"] = draw(st.floats(0.0, 100.0)) / (L + a)
    values["mass"] = m * L * draw(st.floats(0.0, 5.0))
    values["mass_position"] = L * draw(st.floats(0.0, 1.0))
    bodies = st.tuples(st.floats(0.01, 5.0), st.floats(0.0, 1.0), *[st.floats(0.0, 0.5)] * 3)
    values["masses"] = [
        {
            "mass": share * m * L,
            "position": place * L,
            "inertia": [share * m * L * (radius * L) ** 2 for radius in radii],
        }
        for share, place, *radii in draw(st.lists(bodies, max_size=3))
    ]
    if draw(st.booleans()):
        values["root_stiffness"] = draw(st.floats(0.0, 100.0)) * EI / L
    return values
