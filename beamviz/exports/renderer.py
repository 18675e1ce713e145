"""Pictures of a solved scene: rendered by a headless browser, or by matplotlib without one."""

import atexit
import contextlib
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import trimesh
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from viser import ClientHandle
from viser.transforms import SO3

from beamviz.drawing import beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import subdivide, to_hub_frame
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import mass_size, section_size
from beamviz.drawing.surroundings import HUB_HEIGHT, annulus, ground_height, hub_radius
from beamviz.errors import Unavailable
from beamviz.exports.solved_scene import DrawnScene, Moment, SolvedScene
from beamviz.scene import ViewOptions
from beamviz.server import run_server
from beamviz.signals import defer_signals

BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
FLAGS = (
    "--headless",
    "--no-sandbox",  # it needs rights that containers lack; only our own page is opened
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--hide-scrollbars", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--disable-quic"),
    *("--disable-dev-shm-usage", "--remote-debugging-port=0"),
)
TIMEOUT = 90.0  # [s] for one picture; a software renderer takes about 5 for the first
WARM_UP = 2  # small pictures until labels and instanced meshes are up to date
FIRST_WARM_UP = 8  # before the first picture, while the page loads the letters of labels
LIGHT, DARK = (255, 255, 255), (20, 20, 20)  # backgrounds of the page
# Height of letters: [pixels], and of the width of a narrow picture, for a title and for a line of
# one letter (a line then fits in any font: the mean letter of a wide one is 0.7 as wide as high).
MAX_LETTERS, RELATIVE_LETTERS, RELATIVE_LINE = 22, 0.032, 0.85 / 0.7

Render = Callable[[Moment], np.ndarray]


@contextlib.contextmanager
def open_renderer(
    solved: SolvedScene, width: int, height: int, supersampling: int = 1
) -> Iterator[Render]:
    """A function that renders a solved scene at any moment: (height, width, 4), bytes, on a
    transparent background. supersampling: factor by which a browser's picture is larger before it
    is averaged, for smooth edges.

    Raises Unavailable where the browser fails.
    """
    browser = find_browser()
    if browser is None and solved.all_modes:
        raise Unavailable("all modes at once need a browser: install one, or set BEAMVIZ_BROWSER")
    if browser is None:
        note = "no browser found (set BEAMVIZ_BROWSER), drawn by matplotlib"
        print(f"beamviz: {note}", file=sys.stderr)
        yield lambda moment: draw_with_matplotlib(solved, moment, width, height)
        return
    size = supersampling * width, supersampling * height
    connected: Future[ClientHandle] = Future()
    with run_server(pictures=True) as server:
        scale = solved.scale(*size)
        longest = max(map(len, solved.warning.split("\n"))) or 1
        letters = min(MAX_LETTERS, width * min(RELATIVE_LETTERS, RELATIVE_LINE / longest))
        drawn = DrawnScene(server.scene, solved, scale, supersampling * letters / scale)

        @server.on_client_connect
        def _(client: ClientHandle) -> None:
            if not connected.done():
                connected.set_result(client)

        dark = "&darkMode" if solved.scene.view.dark else ""
        url = f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1{dark}"
        with open_browser(browser, url, 320, 240):
            warm_up = iter((FIRST_WARM_UP,))

            def render(moment: Moment) -> np.ndarray:
                try:
                    client = connected.result(TIMEOUT)
                    drawn.move(moment)
                    picture = render_in_browser(client, solved, *size, next(warm_up, WARM_UP))
                except (TimeoutError, RuntimeError):
                    raise Unavailable(
                        f"{browser} drew no picture within {TIMEOUT:g} s: name another browser in"
                        " BEAMVIZ_BROWSER, or none (BEAMVIZ_BROWSER=none) for matplotlib"
                    ) from None
                return downsample(picture, supersampling)

            yield render


def render_in_browser(
    client: ClientHandle, solved: SolvedScene, width: int, height: int, warm_up: int
) -> np.ndarray:
    """The client's picture (height, width, 4), after small ones that are not used."""
    deadline, view = monotonic() + TIMEOUT, solved.camera(width / height)
    position = np.array(view.position)
    render = partial(
        client.get_render,
        position=position,
        wxyz=SO3.from_matrix(camera.axes(position - view.look_at)).wxyz,
        fov=camera.FIELD_OF_VIEW,
        transport_format="png",
    )
    for _ in range(warm_up):
        render(64, 64, timeout=max(deadline - monotonic(), 0.1))
    return render(height, width, timeout=max(deadline - monotonic(), 0.1))


def downsample(picture: np.ndarray, factor: int) -> np.ndarray:
    """A picture (factor h, factor w, 4) averaged to (h, w, 4)."""
    height, width = picture.shape[0] // factor, picture.shape[1] // factor
    blocks = picture.reshape(height, factor, width, factor, 4).astype(float)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.rint(np.concatenate([colour, alpha], -1)).astype(np.uint8)


def over_background(picture: np.ndarray, view: ViewOptions) -> np.ndarray:
    """A picture (h, w, 4) on the background of the page, (h, w, 3)."""
    alpha, background = picture[..., 3:] / 255, np.array(DARK if view.dark else LIGHT)
    return np.rint(picture[..., :3] * alpha + background * (1 - alpha)).astype(np.uint8)


def find_browser() -> str | None:
    """The browser named by BEAMVIZ_BROWSER (a name or a path), else the first of BROWSERS found."""
    named = os.environ.get("BEAMVIZ_BROWSER")
    return next(filter(None, map(shutil.which, [named] if named else BROWSERS)), None)


@contextlib.contextmanager
def open_browser(browser: str, url: str, width: int = 1280, height: int = 720) -> Iterator[Path]:
    """`browser` showing `url` without a window, ended at last; yields its profile folder."""
    with tempfile.TemporaryDirectory(prefix="beamviz-", ignore_cleanup_errors=True) as profile:
        end = None
        try:
            with defer_signals():  # one could arrive before the process is known
                options = [f"--window-size={width},{height}", f"--user-data-dir={profile}"]
                process = subprocess.Popen(
                    [browser, *FLAGS, *options, url],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,  # a process group of its own
                )
                end = partial(end_browser, process, Path(profile))
                atexit.register(end)  # in case a signal arrives as `finally` begins
            yield Path(profile)
        finally:
            if end is not None:
                end()
                atexit.unregister(end)


def end_browser(process: subprocess.Popen, profile: Path) -> None:
    """End a browser and its child processes, and remove the folder that Chromium, killed, leaves
    outside its profile (for a short socket path), empty where its profile has no link to it yet;
    may be called twice."""
    if process.returncode is None:
        if os.name == "posix":
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()
    socket = profile / "SingletonSocket"
    if socket.is_symlink() and socket.readlink().parent.name.startswith("org.chromium."):
        shutil.rmtree(socket.readlink().parent, ignore_errors=True)
    for folder in Path(tempfile.gettempdir()).glob("org.chromium.Chromium.*"):
        with contextlib.suppress(OSError):
            folder.rmdir()


# Without a browser.

DPI = 100
NEAR = 0.3  # distance from the camera from which on everything is drawn
REACH, CELL = 2.0, 0.5  # of the ground: how far it is drawn, distance of its lines
VISIBLE = 3.0  # largest distance from the clamp at which the hub is drawn
SUN = np.array([-0.5, -1.0, 2.2]) / math.sqrt(0.25 + 1.0 + 4.84)
SHADOW = (0.86, 0.865, 0.875)


class Projection:
    """Perspective projection of a scene in a picture with width / height = `aspect`."""

    def __init__(self, solved: SolvedScene, aspect: float):
        view = solved.camera(aspect)
        target = camera.target(solved.shapes, solved.scene.view.rotating_frame)
        self.position = np.array(view.position) + target
        self.axes = camera.axes(np.subtract(view.position, view.look_at))

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Distance (...) in front of the camera of points (..., 3)."""
        return (points - self.position) @ self.axes[:, 2]

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture, (..., 2)."""
        seen = (points - self.position) @ self.axes[:, :2] * [1, -1]
        return seen / self.depth(points)[..., None]

    def in_front(self, points: np.ndarray) -> np.ndarray:
        """Whether shapes (n, k, 3) are in front of the camera, (n,)."""
        front: np.ndarray = self.depth(points).min(axis=1) > NEAR
        return front


def draw_with_matplotlib(
    solved: SolvedScene, moment: Moment, width: int, height: int
) -> np.ndarray:
    """The scene (height, width, 4) on a transparent background: ground, shadow, hub, beam and mass
    with far triangles first, and the outline of the undeformed beam."""
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="none")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    tall = math.tan(camera.FIELD_OF_VIEW / 2)
    axes.set(xlim=(-tall * width / height, tall * width / height), ylim=(-tall, tall))
    axes.set_axis_off()
    beam, view = solved.scene.beam, solved.scene.view
    rotor, ground = (0.0, -moment.angle) if view.rotating_frame else (moment.angle, 0.0)
    rotation = SO3.from_z_radians(rotor).as_matrix().T
    projection = Projection(solved, width / height)
    low = ground_height(beam)
    middle = camera.target(solved.shapes, view.rotating_frame)[:2]
    lines = ground_lines(middle, low, ground)
    lines = projection.project(lines[projection.in_front(lines)])
    thin: dict[str, Any] = {"linewidths": 0.6, "colors": [np.array(colours.GRID) / 255]}
    axes.add_collection(LineCollection(list(lines), alpha=0.4, zorder=0, **thin))
    triangles, colour = scene_triangles(solved, moment, solved.scale(width, height))
    triangles = triangles @ rotation
    ahead = projection.in_front(triangles)
    triangles, colour = triangles[ahead], colour[ahead]
    shadow = triangles - (triangles[..., 2:] - low) / SUN[2] * SUN
    shadow = projection.project(shadow[projection.in_front(shadow)])
    axes.add_collection(PolyCollection(list(shadow), facecolors=[SHADOW], edgecolors=[SHADOW]))
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    lit = np.clip(colour * (0.78 + 0.25 * normals @ SUN)[:, None], 0, 1)
    order = np.argsort(-projection.depth(triangles.mean(axis=1)))
    towards = projection.position - triangles[order, 0]
    order = order[(towards * normals[order]).sum(axis=1) > 0]
    axes.add_collection(
        PolyCollection(
            list(projection.project(triangles[order])),
            facecolors=lit[order],
            edgecolors=lit[order],
            linewidths=1.0,  # less leaves seams between triangles that one can see through
        )
    )
    if view.ghosts:
        edges = beam_mesh.straight_edges(solved.shapes, section_size(beam, view.thicken))
        outline = projection.project(edges @ rotation)
        axes.add_collection(LineCollection(list(outline), alpha=0.7, zorder=2, **thin))
    if solved.warning:
        letters = 14 * min(1.0, width / 640)  # the longest line takes four fifths of the picture
        figure.text(0.5, 0.8, solved.warning, ha="center", fontsize=letters)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).copy()


def ground_lines(middle: np.ndarray, low: float, angle: float) -> np.ndarray:
    """Pieces (n, 2, 3) of the lines of the ground around `middle` (2,), at height `low`: a lattice
    around the axis, rotated by angle [rad]."""
    lines = []
    for start in (angle, angle + math.pi / 2):
        along, across = (np.array([math.cos(a), math.sin(a)]) for a in (start, start + math.pi / 2))
        first, last = (math.ceil((middle @ across + side * REACH) / CELL) for side in (-1, 1))
        for k in range(first, last):
            reach = math.sqrt(REACH**2 - (k * CELL - middle @ across) ** 2)
            at = middle @ along + reach * np.linspace(-1, 1, 17)[:, None]
            points = np.insert(at * along + k * CELL * across, 2, low, axis=1)
            lines.append(np.stack([points[:-1], points[1:]], 1))
    return np.concatenate(lines)


def scene_triangles(
    solved: SolvedScene, moment: Moment, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (n, 3, 3) of hub, beam and mass, and their colours (n, 3); a length of the beam
    takes `scale` pixels."""
    shapes, view = subdivide(solved.shapes, solved.motion(scale)), solved.scene.view
    moved = displacement(shapes, moment.phases, solved.amplitudes)
    points, normal = to_hub_frame(shapes, shapes.centreline + moved)
    section = section_size(shapes.beam, view.thicken)
    vertices, triangles = beam_mesh.swept(points, normal, section)
    largest = colours.colour_range(shapes, view.colouring, solved.amplitudes)
    places = colours.scaled(shapes, view.colouring, moved, largest)
    along = colours.mapped(places, colours.MAPS[view.colouring])
    if solved.warning:
        along = np.tile(np.array(colours.GREYED) / 255, (len(along), 1))
    painted = np.concatenate([np.repeat(along, 8, axis=0), np.repeat(along[[0, -1]], 2, axis=0)])
    radius = hub_radius(shapes.beam)
    hoop = annulus(radius)
    solids = [(hoop.triangles if shapes.beam.delta < 0 else drum(radius), colours.HUB)]
    if shapes.beam.alpha > 0:
        radius = max(mass_size(shapes.beam, view.thicken))
        ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
        solids.append((ball.triangles + points[shapes.mass], colours.MASS))
    return (
        np.concatenate([vertices[triangles], *(solid for solid, _ in solids)]),
        np.concatenate([painted, *(np.tile(rgb, (len(solid), 1)) / 255 for solid, rgb in solids)]),
    )


def drum(radius: float) -> np.ndarray:
    """Triangles (n, 3, 3) of the part of a drum around the clamp that a picture can hold: small
    ones, since one that reaches behind the camera cannot be projected."""
    r = np.append(np.linspace(max(radius - VISIBLE, 0.0), radius, 15), radius)
    z = np.append(np.full(15, HUB_HEIGHT / 2), -HUB_HEIGHT / 2)
    angle = min(math.pi, VISIBLE / radius) * np.linspace(-1, 1, 121)[:, None]
    grid = np.stack([r * np.cos(angle), r * np.sin(angle), np.broadcast_to(z, (121, 16))], -1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(part, 2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))])
