"""The paper's tables and figures as data: their scenes, and every number its text prints.

"Modal characteristics of a rotating flexible beam with a concentrated mass based on the absolute
nodal coordinate formulation", Nonlinear Dynamics (2017). The bodies of its tables and the curves
of its figures are not available to this project: nothing here stands in for them.
"""

from typing import Literal, NamedTuple

from beamviz.beam import PARAMETERS, Beam

TITLE = (
    "Modal characteristics of a rotating flexible beam with a concentrated mass based on the"
    " absolute nodal coordinate formulation"
)
SOURCE = f'"{TITLE}", Nonlinear Dynamics (2017)'
ELEMENTS = 20  # of its beam: they give its omega_3 = 61.6982


class Statement(NamedTuple):
    """What the text says about a table, shortened, and how to check it."""

    text: str
    check: Literal["agree", "part", "rise", "end"]
    pairs: tuple[tuple[str, str], ...] = (("ancf", "foac"),)  # of columns to compare


class Table(NamedTuple):
    """The lowest two chordwise bending frequencies of a beam at some speeds and hub radii."""

    name: str
    beam: Beam
    deltas: tuple[float, ...]
    gammas: tuple[float, ...]
    columns: tuple[str, ...]
    compared: str  # with what the paper compares its own model
    statements: tuple[Statement, ...]
    notes: tuple[str, ...]

    @property
    def caption(self) -> str:
        """What the table holds."""
        fixed, radii = described(self.beam, ("alpha", "beta", "mu")), map(str, self.deltas)
        return f"First and second chordwise bending frequencies ({fixed}, δ = {', '.join(radii)})"


class Meeting(NamedTuple):
    """Two loci, counted from the lowest, that meet at a printed value of what is swept."""

    loci: tuple[int, int]
    at: str
    why: str = ""  # what explains a printed value that no curvature measure gives


class Node(NamedTuple):
    """A place where a mode of the beam at rest without a mass stands still."""

    mode: int
    at: str


class Constant(NamedTuple):
    """A frequency at rest that a mass at a node of its mode does not change."""

    mode: int
    frequency: str


class LociFigure(NamedTuple):
    """Frequencies along one number of a beam, from 0."""

    name: str
    beam: Beam
    over: str
    stop: float
    modes: int = 5
    meetings: tuple[Meeting, ...] = ()
    nodes: tuple[Node, ...] = ()
    constants: tuple[Constant, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def caption(self) -> str:
        """What the figure shows."""
        first = f"First {COUNTS[self.modes]} frequencies over the {PARAMETERS[self.over].label}"
        return f"{first} ({parameters(self)})"


class ShapeFigure(NamedTuple):
    """Mode shapes, counted from the lowest, of a beam with some mass ratios at its tip."""

    name: str
    beam: Beam
    modes: tuple[int, ...]
    alphas: tuple[float, ...]
    stretching: tuple[int, ...] = ()  # the modes of which the text says so
    nodes: tuple[Node, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def caption(self) -> str:
        """What the figure shows."""
        one = f"{ORDINALS[self.modes[0]]} mode shape"
        shapes = one if len(self.modes) == 1 else f"First {COUNTS[len(self.modes)]} mode shapes"
        return f"{shapes} ({parameters(self)})"


Figure = LociFigure | ShapeFigure

COUNTS = {3: "three", 5: "five"}
ORDINALS = {1: "First", 2: "Second", 3: "Third"}


def parameters(figure: Figure) -> str:
    """The numbers held fixed in a figure: α = 1, β = 0.5, δ = 0, μ = 70."""
    if isinstance(figure, LociFigure):
        return described(figure.beam, tuple(name for name in PARAMETERS if name != figure.over))
    beam = figure.beam.replace(alpha=figure.alphas[0])
    return described(beam, tuple(PARAMETERS)[len(figure.alphas) > 1 :])


def described(beam: Beam, names: tuple[str, ...]) -> str:
    """α = 1, β = 0.5."""
    return ", ".join(f"{PARAMETERS[name].symbol} = {getattr(beam, name):g}" for name in names)


NODES = (Node(2, "0.78344"), Node(3, "0.50355"), Node(3, "0.86768"))
CONSTANTS = (Constant(2, "22.0345"), Constant(3, "61.6982"))

COMPARED = ("ancf", "exact", "material", "foac", "linear")
RISING = Statement("The frequencies rise with the speed.", "rise")
PARTING = Statement("The deviation grows with the speed.", "part")
NO_SLENDERNESS = "The caption leaves the slenderness out; it is taken to be 70, as elsewhere."
LONGER_ARM = (
    "At δ = 0 the longer arm of the load makes up for much of what the stretch takes from the"
    " stiffness: ω₂ of FOAC deviates little, and not steadily."
)
OWN_RANGE = "The text does not give the range of the axis; it is ours."
OWN_MASSES = "The text does not give the mass ratios drawn; they are ours."
NO_MASS = "The nodes in the text are those of the beam without a mass, which is drawn."
HELD_ROOT = "likely from a root that holds the length of r' too: 1.584 with 20 elements"

TABLES = {
    row.name: row
    for row in (
        Table(
            "table1",
            Beam(alpha=1),
            (0,),
            tuple(range(11)),
            COMPARED,
            "references [30] and [13], which FOAC stands in for",
            (
                Statement(
                    "The discrepancy is trivial for γ from 0 to 10.",
                    "agree",
                    (("foac", "ancf"), ("foac", "material")),
                ),
                RISING,
            ),
            ("The text gives the speeds as 0 to 10; the steps of 1 are ours.",),
        ),
        Table(
            "table2",
            Beam(alpha=1),
            (0, 1),
            (0, 1, 2, 3, 4, 5, 10, 20, 50),
            COMPARED,
            "reference [13], which FOAC stands in for",
            (PARTING,),
            ("The text lists the speeds as values of μ; γ is meant, μ is 70.", LONGER_ARM),
        ),
        Table(
            "table3",
            Beam(beta=0),
            (0, 1, 5),
            (2, 10, 20, 30, 40, 50),
            COMPARED,
            "references [29] and [31], which linear finite elements stand in for, and FOAC",
            (
                RISING,
                PARTING,
                Statement(
                    "References [29], [31] and FOAC are nearly the same.",
                    "agree",
                    (("linear", "foac"),),
                ),
            ),
            (NO_SLENDERNESS, LONGER_ARM),
        ),
        Table(
            "table4",
            Beam(beta=0),
            (1,),
            (2, 10, 20, 30, 40, 50),
            (*COMPARED, "hencky"),
            "FOAC and the nonlinear and linear models of ANSYS, which hencky strain and linear"
            " finite elements stand in for",
            (
                Statement(
                    "FOAC and the linear model of ANSYS are nearly the same.",
                    "agree",
                    (("linear", "foac"),),
                ),
                Statement(
                    "The nonlinear model of ANSYS diverges at γ = 40 and 50, so the paper's"
                    " is more stable.",
                    "end",
                    (("hencky", "ancf"),),
                ),
            ),
            (NO_SLENDERNESS,),
        ),
    )
}

FIGURES: dict[str, Figure] = {
    row.name: row
    for row in (
        LociFigure("fig4", Beam(alpha=1, beta=0.3), "gamma", 20, notes=(OWN_RANGE,)),
        LociFigure(
            "fig5",
            Beam(alpha=1, beta=0.5),
            "gamma",
            20,
            meetings=(Meeting((3, 4), "9.2"),),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig6",
            Beam(alpha=1, beta=0.8),
            "gamma",
            20,
            meetings=(Meeting((3, 4), "6.6"), Meeting((2, 3), "17.3")),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig7",
            Beam(alpha=1),
            "gamma",
            20,
            meetings=(Meeting((3, 4), "4.4"), Meeting((2, 3), "16.2")),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig8",
            Beam(),
            "alpha",
            2,
            meetings=(Meeting((3, 4), "1.59", HELD_ROOT),),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig9",
            Beam(gamma=5),
            "alpha",
            2,
            meetings=(Meeting((3, 4), "0.92"),),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig10",
            Beam(gamma=10),
            "alpha",
            2,
            meetings=(Meeting((3, 4), "0.48"), Meeting((2, 3), "1.74")),
            notes=(OWN_RANGE,),
        ),
        LociFigure(
            "fig11",
            Beam(alpha=0.5, gamma=5),
            "beta",
            1,
            meetings=(Meeting((4, 5), "0.09"), Meeting((4, 5), "0.225")),
        ),
        ShapeFigure("fig12", Beam(), (1,), (0, 0.5, 1, 2), notes=(OWN_MASSES,)),
        ShapeFigure("fig13", Beam(), (2,), (0, 0.5, 1, 2), notes=(OWN_MASSES,)),
        ShapeFigure("fig14", Beam(), (1, 2, 3, 4, 5), (1,), stretching=(4,)),
        ShapeFigure("fig15", Beam(), (1, 2, 3, 4, 5), (2,), stretching=(3,)),
        LociFigure("fig16", Beam(alpha=0.5), "beta", 1, modes=3, nodes=NODES, constants=CONSTANTS),
        ShapeFigure("fig17", Beam(), (2,), (0,), nodes=NODES[:1], notes=(NO_MASS,)),
        LociFigure(
            "fig18",
            Beam(beta=0.78344),
            "alpha",
            2,
            constants=CONSTANTS[:1],
            notes=(OWN_RANGE,),
        ),
        ShapeFigure("fig19", Beam(), (3,), (0,), nodes=NODES[1:], notes=(NO_MASS,)),
    )
}
