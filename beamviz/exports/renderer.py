"""A scene set up to be photographed at any moment: by a browser, or by matplotlib without one."""

import contextlib
import queue
import sys
from collections.abc import Callable, Iterator
from functools import partial
from time import monotonic

import numpy as np
from viser import ClientHandle, SceneApi
from viser.transforms import SO3

from beamviz.drawing import camera
from beamviz.drawing.all_modes import Multiples
from beamviz.drawing.beam_view import BeamView
from beamviz.drawing.subdivision import SCALE
from beamviz.errors import Unavailable
from beamviz.exports.browser import found_browser, opened
from beamviz.exports.matplotlib_renderer import drawn
from beamviz.exports.solved_scene import Moment, Shot
from beamviz.scene import ViewOptions
from beamviz.server import run_server

DEADLINE = 90.0  # [s] for one picture; a software renderer needs about 5 for the first
LAG = 2  # pictures until labels and instanced bodies are where they were put
LIGHT, DARK = (255, 255, 255), (20, 20, 20)  # as the page has them

LETTERS, WIDE = 22, 0.032  # [pixels] high are letters, less where a picture is narrow
TITLE = 0.065  # [lengths of the beam] at most: there is no more room between two of all modes
Photographer = Callable[[Moment], np.ndarray]


@contextlib.contextmanager
def studio(shot: Shot, width: int, height: int, scale: int = 1) -> Iterator[Photographer]:
    """Takes pictures (height, width, 4) of a shot at any moment, on a transparent ground.

    scale: how many times larger a browser takes them, to smooth their edges further.

    Raises Unavailable where the browser fails.
    """
    browser = found_browser()
    if browser is None and shot.all_modes:
        raise Unavailable("all modes at once need a browser: install one, or set BEAMVIZ_BROWSER")
    if browser is None:
        words = "no browser found (set BEAMVIZ_BROWSER), drawn by matplotlib"
        print(f"beamviz: {words}", file=sys.stderr)
        yield lambda moment: drawn(shot, moment, width, height)
        return
    clients: queue.Queue[ClientHandle] = queue.Queue()
    with run_server(pictures=True) as server:
        length = shot.scale(scale * width, scale * height)
        set_up = Set(server.scene, shot, length)
        set_up.letter(scale * min(LETTERS, WIDE * width) / length)
        server.on_client_connect(clients.put)
        dark = "&darkMode" if shot.scene.view.dark else ""
        url = f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1{dark}"
        with opened(browser, url, 320, 240):

            def picture(moment: Moment) -> np.ndarray:
                set_up.move(moment)
                with explained(browser):
                    return averaged(rendered(client, shot, scale * width, scale * height), scale)

            with explained(browser):
                client = clients.get(timeout=DEADLINE)
            yield picture


class Set:
    """What stands before the camera; a length of the beam takes `scale` pixels."""

    def __init__(self, api: SceneApi, shot: Shot, scale: float = SCALE):
        self.shot, self.scene = shot, BeamView(api)
        self.multiples = Multiples(api) if shot.all_modes else None
        seen = shot.seen(scale)
        self.scene.show(shot.shapes, shot.scene.view, shot.shown, words=shot.words, seen=seen)
        self.scene.stage.visible = not self.multiples
        if self.multiples:
            self.multiples.show(shot.shapes, shot.scene.view, scale)

    def letter(self, height: float) -> None:
        """Words and titles in letters of a height in the scene: on the screen they would have the
        size that fits the window of the browser, and not the picture."""
        titles = [one.title for one in self.multiples.scenes] if self.multiples else []
        for label in (self.scene.words, *titles):
            label.font_size_mode = "scene"
            label.font_scene_height = min(height, TITLE) if titles else height

    def move(self, moment: Moment) -> None:
        """Put everything where it is at a moment."""
        self.scene.move(moment.phases, self.shot.amplitudes, moment.angle)
        if self.multiples:
            amplitude = self.shot.scene.view.amplitude
            self.multiples.move(moment.phases, amplitude, moment.angle)


@contextlib.contextmanager
def explained(browser: str) -> Iterator[None]:
    """Unavailable, with the remedy, for a browser that does not do its work."""
    try:
        yield
    except (queue.Empty, TimeoutError, RuntimeError):
        raise Unavailable(
            f"{browser} drew no picture within {DEADLINE:g} s: name another browser in"
            " BEAMVIZ_BROWSER, or none (BEAMVIZ_BROWSER=none) for matplotlib"
        ) from None


def rendered(client: ClientHandle, shot: Shot, width: int, height: int) -> np.ndarray:
    """The client's picture (height, width, 4)."""
    deadline, view = monotonic() + DEADLINE, shot.camera(width / height)
    position = np.array(view.position)
    render = partial(
        client.get_render,
        position=position,
        wxyz=SO3.from_matrix(camera.axes(position - view.look_at)).wxyz,
        fov=camera.FIELD_OF_VIEW,
        transport_format="png",
    )
    for _ in range(LAG):
        render(64, 64, timeout=max(deadline - monotonic(), 0.1))
    return render(height, width, timeout=max(deadline - monotonic(), 0.1))


def averaged(picture: np.ndarray, scale: int) -> np.ndarray:
    """A picture (scale h, scale w, 4) made smaller, (h, w, 4)."""
    height, width = picture.shape[0] // scale, picture.shape[1] // scale
    blocks = picture.reshape(height, scale, width, scale, 4).astype(float)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.rint(np.concatenate([colour, alpha], -1)).astype(np.uint8)


def opaque(picture: np.ndarray, view: ViewOptions) -> np.ndarray:
    """A picture (h, w, 4) on the background, (h, w, 3)."""
    alpha, ground = picture[..., 3:] / 255, np.array(DARK if view.dark else LIGHT)
    return np.rint(picture[..., :3] * alpha + ground * (1 - alpha)).astype(np.uint8)
