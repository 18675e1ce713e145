"""The data of exported pages, which their scripts play.

What a page is given is checked against these types before it is written. `offline.d.ts` has the
same types for the scripts, which TypeScript checks; `scripts/message_types.py` writes it.
"""

from collections.abc import Sequence

from msgspec import Struct

Vec3 = tuple[float, float, float]
Steps = list[list[int]]  # columns of numbers over speeds or moments: see `html_page.steps`


class Record(Struct, forbid_unknown_fields=True):
    """A part of the data: what is not declared is refused, not left out."""


class SceneCaption(Record):
    """A text at a node of the scene; anchor: the side of the text that is there."""

    name: str
    text: str
    anchor: str


class BodyLabel(Record):
    """The label of a body, by the name of its node: its station, and its place from there."""

    name: str
    station: int
    above: Vec3


class Surface(Record):
    """The surface of a beam that is drawn in a single piece."""

    rings: list[tuple[int, float, float]]  # of each section its station, thickness and breadth
    normals: list[Vec3]  # of the breadth of each section of the undeformed beam
    faces: list[int]  # three vertices of each triangle; a section has four vertices


class OfflineBeam(Record):
    """A beam in n pieces, of which the last begins at station n - 1."""

    root: str  # name of its node
    largest: float  # the end of the colour map
    sections: list[tuple[float, float]]  # of each piece
    turns: list[float]  # angle [rad] of each piece about the axis of the beam
    capped: list[int]  # the pieces whose ends are seen
    bodies: dict[str, list[int]]  # by the names of their nodes, the stations of their instances
    labels_of_bodies: list[BodyLabel]
    # Of a beam that is drawn over another, in the frame of its hub, in place of the pieces.
    surface: Surface | None


class VibratingBeam(OfflineBeam):
    """A beam that moves in modes."""

    modes: list[str]  # their names
    equilibrium: int  # the number of its body at rest, -1 without
    states: Steps  # see `html_page.beam_data`
    # The length of the mark of a node along the beam, and its size over that of the section.
    ring: tuple[float, float]
    ring_colour: list[int]
    component: int  # of the displacement whose zeros are nodes
    # PERIODS, MOST and SAMPLES of drawing/tip_path.py, where the path of the tip is drawn.
    path: tuple[int, int, int] | None


class MovedBeam(OfflineBeam):
    """A beam in a motion in time: see `motion_page.motion_data`."""

    fields: Steps
    parts: Steps


class OfflineScene(Record):
    """The data that all pages have."""

    rate: float  # time [T*] per second on the screen
    resolution: float  # the unit of `Steps`
    turning: tuple[str, int]  # the node that turns with the hub, and its sense
    palette: list[int]  # red, green and blue of each colour
    strain: bool  # whether the colours are of strain, else of displacement
    beams: Sequence[OfflineBeam]


class OfflineEquilibrium(Record):
    """A body at rest: vertices (3 v, speeds) and the triangles of these."""

    vertices: Steps
    faces: list[int]


class OfflineSpeeds(OfflineScene):
    """Modes of vibration at several speeds: see `html_page.speed_data`."""

    beams: Sequence[VibratingBeam]
    gammas: list[float]
    start: int
    speeds: list[str]
    factor: float
    numbers: list[str]
    frequencies: dict[str, list[float]]
    equilibria: list[OfflineEquilibrium]
    arrow: str
    captions: list[list[SceneCaption]]


class Reading(Record):
    """A number over time, shown with some decimals."""

    label: str
    unit: str
    values: list[float]
    decimals: int


class OfflineMotion(OfflineScene):
    """A motion in time: see `motion_page.motion_data`."""

    beams: Sequence[MovedBeam]
    until: float
    angle: list[float]
    with_mass: list[bool]
    readings: list[Reading]
    captions: list[SceneCaption]
    speed: str
    speeds: list[str]
    of_mass: list[str]
