"""Pictures of a solved scene: rendered by a headless browser, or by matplotlib without one."""

import atexit
import contextlib
import math
import os
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import monotonic

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation
from viser import ClientHandle
from viser.transforms import SO3

from beamviz.drawing import beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import subdivide
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import (
    EDGES,
    HUB_HEIGHT,
    annulus,
    ground_height,
    hub_radius,
    mass_radius,
    section_size,
    to_hub_frame,
)
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
LIGHT, DARK = (255, 255, 255), (20, 20, 20)  # backgrounds of the page
LETTER_HEIGHT, RELATIVE_LETTER_HEIGHT = 22, 0.032  # [pixels], of the width of a narrow picture

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
    clients: queue.Queue[ClientHandle] = queue.Queue()
    with run_server(pictures=True) as server:
        scale = solved.scale(*size)
        letters = supersampling * min(LETTER_HEIGHT, RELATIVE_LETTER_HEIGHT * width) / scale
        drawn = DrawnScene(server.scene, solved, scale, letters)
        server.on_client_connect(clients.put)
        dark = "&darkMode" if solved.scene.view.dark else ""
        url = f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1{dark}"
        with open_browser(browser, url, 320, 240):

            def render(moment: Moment) -> np.ndarray:
                drawn.move(moment)
                with browser_errors(browser):
                    return downsample(render_in_browser(client, solved, *size), supersampling)

            with browser_errors(browser):
                client = clients.get(timeout=TIMEOUT)
            yield render


def render_in_browser(
    client: ClientHandle, solved: SolvedScene, width: int, height: int
) -> np.ndarray:
    """The client's picture (height, width, 4)."""
    deadline, view = monotonic() + TIMEOUT, solved.camera(width / height)
    position = np.array(view.position)
    render = partial(
        client.get_render,
        position=position,
        wxyz=SO3.from_matrix(camera.axes(position - view.look_at)).wxyz,
        fov=camera.FIELD_OF_VIEW,
        transport_format="png",
    )
    for _ in range(WARM_UP):
        render(64, 64, timeout=max(deadline - monotonic(), 0.1))
    return render(height, width, timeout=max(deadline - monotonic(), 0.1))


@contextlib.contextmanager
def browser_errors(browser: str) -> Iterator[None]:
    """Turns the failures of a browser into Unavailable, with the remedy."""
    try:
        yield
    except (queue.Empty, TimeoutError, RuntimeError):
        raise Unavailable(
            f"{browser} drew no picture within {TIMEOUT:g} s: name another browser in"
            " BEAMVIZ_BROWSER, or none (BEAMVIZ_BROWSER=none) for matplotlib"
        ) from None


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
    """`browser` showing `url` without a window; yields its profile folder, and ends it at last."""
    with tempfile.TemporaryDirectory(prefix="beamviz-", ignore_cleanup_errors=True) as profile:
        end = None
        try:
            with defer_signals():  # one could arrive before the process is known
                process = start_browser(browser, url, profile, width, height)
                end = partial(end_browser, process, Path(profile))
                atexit.register(end)  # in case a signal arrives as `finally` begins
            yield Path(profile)
        finally:
            if end is not None:
                end()
                atexit.unregister(end)


def start_browser(
    browser: str, url: str, profile: str, width: int, height: int
) -> subprocess.Popen:
    """A browser in a process group of its own."""
    return subprocess.Popen(
        [browser, *FLAGS, f"--window-size={width},{height}", f"--user-data-dir={profile}", url],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def end_browser(process: subprocess.Popen, profile: Path) -> None:
    """End a browser and its child processes, and remove the folder that Chromium, killed, leaves
    outside its profile (for a short socket path); may be called twice."""
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


# Without a browser.

DPI = 100
NEAR = 0.3  # nothing nearer to the camera is drawn
REACH, CELL = 2.0, 0.5  # of the ground: how far it is drawn, distance of its lines
VISIBLE = 3.0  # nor what is so far from the clamp
SUN = np.array([-0.5, -1.0, 2.2]) / math.sqrt(0.25 + 1.0 + 4.84)
SHADOW = (0.86, 0.865, 0.875)


def draw_with_matplotlib(
    solved: SolvedScene, moment: Moment, width: int, height: int
) -> np.ndarray:
    """The scene (height, width, 4) on a transparent ground."""
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="none")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    tall = math.tan(camera.FIELD_OF_VIEW / 2)
    axes.set(xlim=(-tall * width / height, tall * width / height), ylim=(-tall, tall))
    axes.set_axis_off()
    solid = scene_triangles(solved, moment, solved.scale(width, height))
    draw(axes, Projection(solved, moment, width / height), moment, *solid)
    if solved.warning:
        letters = 14 * min(1.0, width / 640)  # the longest line takes four fifths of the picture
        figure.text(0.5, 0.8, solved.warning, ha="center", fontsize=letters)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).copy()


class Projection:
    """Perspective projection from where a solved is seen at a moment."""

    def __init__(self, solved: SolvedScene, moment: Moment, aspect: float):
        self.solved, seen = solved, solved.camera(aspect)
        target = camera.target(solved.shapes, solved.scene.view.rotating_frame)
        self.position = np.array(seen.position) + target
        self.axes = camera.axes(np.subtract(seen.position, seen.look_at))
        self.rotor = Rotation.from_euler(
            "z", 0.0 if solved.scene.view.rotating_frame else moment.angle
        ).as_matrix()

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Distance (...) in front of the camera of points (..., 3)."""
        return (points - self.position) @ self.axes[:, 2]

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture, (..., 2)."""
        return ((points - self.position) @ self.axes[:, :2] * [1, -1]) / self.depth(points)[
            ..., None
        ]


def draw(
    axes: Axes, view: Projection, moment: Moment, triangles: np.ndarray, colour: np.ndarray
) -> None:
    """Ground, shadow and outline, then triangles (n, 3, 3) in colours (n, 3), far ones first."""
    solved, beam = view.solved, view.solved.scene.beam
    triangles = triangles @ view.rotor.T
    ahead = (view.depth(triangles) > NEAR).all(axis=1)
    triangles, colour = triangles[ahead], colour[ahead]
    low = ground_height(beam)
    middle = camera.target(solved.shapes, solved.scene.view.rotating_frame)[:2]
    ground = ground_lines(middle, low, -moment.angle if solved.scene.view.rotating_frame else 0.0)
    ground = ground[(view.depth(ground) > NEAR).all(axis=1)]
    axes.add_collection(thin_lines(view.project(ground), 0.4, zorder=0))
    fallen = triangles - (triangles[..., 2:] - low) / SUN[2] * SUN
    fallen = fallen[(view.depth(fallen) > NEAR).all(axis=1)]
    axes.add_collection(
        PolyCollection(list(view.project(fallen)), facecolors=[SHADOW], edgecolors=[SHADOW])
    )
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    lit = np.clip(colour * (0.78 + 0.25 * normals @ SUN)[:, None], 0, 1)
    order = np.argsort(-view.depth(triangles.mean(axis=1)))
    order = order[((view.position - triangles[order, 0]) * normals[order]).sum(axis=1) > 0]
    axes.add_collection(
        PolyCollection(
            list(view.project(triangles[order])),
            facecolors=lit[order],
            edgecolors=lit[order],
            linewidths=1.0,  # less leaves seams between triangles that one can see through
        )
    )
    if solved.scene.view.ghosts:
        section = np.array([1.0, *section_size(beam, solved.scene.view.thicken)])
        if solved.shapes.plane == "flapwise":
            section = section[[0, 2, 1]]
        outline = (EDGES * section + [beam.delta + 0.5, 0.0, 0.0]) @ view.rotor.T
        axes.add_collection(thin_lines(view.project(outline), 0.7, zorder=2))


def thin_lines(lines: np.ndarray, alpha: float, zorder: float) -> LineCollection:
    """Thin grey lines (n, 2, 2)."""
    return LineCollection(
        list(lines),
        linewidths=0.6,
        colors=[np.array(colours.GRID) / 255],
        alpha=alpha,
        zorder=zorder,
    )


def ground_lines(middle: np.ndarray, low: float, angle: float) -> np.ndarray:
    """Pieces (n, 2, 3) of the lines of the ground around `middle` (2,), at height `low`: a lattice
    around the axis, turned by angle [rad]."""
    lines = []
    for turned in (angle, angle + math.pi / 2):
        along, across = (
            np.array([math.cos(a), math.sin(a)]) for a in (turned, turned + math.pi / 2)
        )
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
    vertices, triangles = beam_mesh.swept(points, normal, *section_size(shapes.beam, view.thicken))
    along = colours.along(shapes, view.colouring, moved, solved.amplitudes)
    if solved.warning:
        along = np.tile(np.array(colours.GREYED) / 255, (len(along), 1))
    painted = np.concatenate([np.repeat(along, 8, axis=0), np.repeat(along[[0, -1]], 2, axis=0)])
    parts = [(vertices[triangles], painted)]
    radius = hub_radius(shapes.beam)
    hoop = annulus(radius)
    hub = hoop.vertices[hoop.faces] if shapes.beam.delta < 0 else drum(radius)
    parts.append((hub, np.tile(np.array(colours.HUB) / 255, (len(hub), 1))))
    if shapes.beam.alpha > 0:
        ball = trimesh.creation.icosphere(
            subdivisions=3, radius=mass_radius(shapes.beam, view.thicken)
        )
        mass = (ball.vertices + points[shapes.mass])[ball.faces]
        parts.append((mass, np.tile(np.array(colours.MASS) / 255, (len(mass), 1))))
    return np.concatenate([a for a, _ in parts]), np.concatenate([b for _, b in parts])


def drum(radius: float) -> np.ndarray:
    """Triangles (n, 3, 3) of the part of a drum around the clamp that a picture can hold: small
    ones, since one that reaches behind the camera cannot be projected."""
    r = np.append(np.linspace(max(radius - VISIBLE, 0.0), radius, 15), radius)
    z = np.append(np.full(15, HUB_HEIGHT / 2), -HUB_HEIGHT / 2)
    turn = min(math.pi, VISIBLE / radius) * np.linspace(-1, 1, 121)[:, None]
    grid = np.stack([r * np.cos(turn), r * np.sin(turn), np.broadcast_to(z, (121, 16))], -1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(part, 2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))])
