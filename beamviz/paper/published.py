"""Published and independent values as tables of text, and the claims made of them."""

from collections.abc import Callable, Sequence
from functools import partial

from beamviz.beam import PARAMETERS, Beam
from beamviz.paper.claims import RIGID, Claim, labelled, lowest, met
from beamviz.paper.data import FIGURES, LociFigure
from beamviz.plotting.style import OMEGAS

# gamma, omega 1..3 (alpha 0); gamma, omega 1, 2 (alpha = beta = 1): flapwise, delta 0.
UNIFORM = """
0 3.516 22.035 61.697
1 3.682 22.181 61.842
2 4.137 22.615 62.273
3 4.797 23.320 62.985
4 5.585 24.273 63.967
5 6.450 25.446 65.205
6 7.360 26.809 66.684
7 8.300 28.334 68.386
8 9.257 29.995 70.293
9 10.226 31.771 72.387
10 11.202 33.640 74.649
11 12.184 35.589 77.064
12 13.170 37.603 79.615
"""
TIP_MASS = """
0 1.557 16.25
1 1.902 16.76
2 2.670 18.19
3 3.582 20.35
4 4.543 23.03
5 5.522 26.04
6 6.509 29.29
7 7.501 32.70
8 8.495 36.21
9 9.490 39.80
10 10.49 43.45
11 11.48 47.14
12 12.48 50.86
"""
# gamma, omega 1: chordwise with Coriolis, no stretch.
LINEAR_CORIOLIS = """
2 3.6195
4 3.888
6 4.2393
8 4.6105
10 4.97
50 7.3362
"""
# figure, place of the meeting among its meetings, material, spatial.
MEETINGS = """
fig5 0 9.206 9.373
fig6 0 6.662 6.824
fig6 1 17.343 17.589
fig7 0 4.406 4.464
fig7 1 16.215 16.319
fig8 0 1.570 1.570
fig9 0 0.921 0.929
fig10 0 0.477 0.485
fig10 1 1.747 1.758
fig11 0 0.0877 0.0872
fig11 1 0.2234 0.2242
"""
# alpha, beta, gamma, delta, B1 B2 B3 B4 S1: green, spatial, chordwise, mu 70.
INDEPENDENT = """
0 1 0 0 3.5160153 22.0344916 61.6972144 120.9019161 109.9557429
1 0.5 10 0 4.3905981 22.0954901 78.3525694 111.1520304 76.8632663
1 0.3 50 1 55.7060158 124.7611423 234.4764718 380.8273268 154.1656016
0 1 50 1 52.942507 172.905287 286.071455 408.016404 161.527165
"""
INDEPENDENT_CORIOLIS = """
1 0.5 10 0 4.2560380 21.9918226 78.2173207 79.5184410 111.0672016
1 0.3 50 1 46.205059 117.208910 186.820598
"""
# elements, S1: alpha 1, beta 0.5, gamma 10.
SHARED_GRADIENT = """
10 77.005312
20 76.934327
40 76.898804
80 76.881037
"""


def rows(text: str) -> list[list[str]]:
    """The words of each line."""
    return [line.split() for line in text.strip().splitlines()]


def omegas(count: int) -> str:
    """ω₁, ω₂, ω₃."""
    return ", ".join(OMEGAS[:count])


def flapwise(name: str, text: str, alpha: float) -> tuple[Claim, ...]:
    """Rows of a table over speed, without stretch."""
    return tuple(
        Claim(
            f"{name}-{gamma}",
            f"γ = {gamma}",
            omegas(len(values)),
            tuple(values),
            partial(
                lowest,
                len(values),
                Beam(alpha=alpha, gamma=float(gamma), mu=RIGID),
                plane="flapwise",
            ),
        )
        for gamma, *values in rows(text)
    )


def meetings() -> tuple[Claim, ...]:
    """Where bending and stretching loci cross, by both curvature measures."""
    claims = []
    for name, place, *values in rows(MEETINGS):
        figure = FIGURES[name]
        assert isinstance(figure, LociFigure)
        meeting = figure.meetings[int(place)]
        claims.append(
            Claim(
                f"meeting-{name}-{meeting.at}",
                f"figure {name[3:]}, loci {meeting.loci[0]}/{meeting.loci[1]}",
                f"{PARAMETERS[figure.over].symbol} (material, spatial)",
                tuple(values),
                partial(met, figure, meeting, "material", "spatial"),
            )
        )
    return tuple(claims)


def printed_meetings() -> tuple[Claim, ...]:
    """The meetings the paper prints, by the material measure, which fits them best."""
    reasons = {
        "1.59": (2, "likely a root that holds the length of r' too, which gives 1.584"),
        "0.225": (2, "read off a curve; eq. 16 gives 0.2242"),
    }
    return tuple(
        Claim(
            f"paper-{figure.name}-{meeting.at}",
            f"figure {figure.name[3:]}, loci {meeting.loci[0]}/{meeting.loci[1]}",
            PARAMETERS[figure.over].symbol,
            (meeting.at,),
            partial(met, figure, meeting, "material"),
            *reasons.get(meeting.at, ()),
        )
        for figure in FIGURES.values()
        if isinstance(figure, LociFigure)
        for meeting in figure.meetings
    )


def independent(
    name: str,
    text: str,
    quantity: str,
    find: Callable[[int, Beam], Sequence[float]],
    digits: float = 1,
    reason: str = "",
) -> tuple[Claim, ...]:
    """Frequencies of some beams."""
    return tuple(
        Claim(
            f"{name}-{k}",
            f"α = {alpha}, β = {beta}, γ = {gamma}, δ = {delta}",
            quantity,
            tuple(values),
            partial(find, len(values), Beam(float(alpha), float(beta), float(gamma), float(delta))),
            digits,
            reason,
        )
        for k, (alpha, beta, gamma, delta, *values) in enumerate(rows(text))
    )


def in_families(count: int, beam: Beam) -> list[float]:
    """B1, B2, B3, B4 and S1."""
    return labelled("B1 B2 B3 B4 S1", beam)[:count]


def shared_gradient() -> tuple[Claim, ...]:
    """The stretching frequency of the paper's elements beside an inner mass."""
    beam = Beam(alpha=1, beta=0.5, gamma=10)
    return tuple(
        Claim(
            f"shared-gradient-{count}",
            f"{count} elements beside a mass",
            "S1",
            (value,),
            partial(labelled, "S1", beam, method="ancf", elements=int(count)),
        )
        for count, value in rows(SHARED_GRADIENT)
    )


def linear_coriolis() -> tuple[Claim, ...]:
    """The first frequency over speed, with Coriolis and without stretch."""
    return tuple(
        Claim(
            f"linear-coriolis-{gamma}",
            f"foac, γ = {gamma}",
            "ω₁",
            (value,),
            partial(lowest, 1, Beam(gamma=float(gamma)), method="foac", coriolis=True),
            *((30, "slightly unconverged in the source") if gamma == "50" else ()),
        )
        for gamma, value in rows(LINEAR_CORIOLIS)
    )
