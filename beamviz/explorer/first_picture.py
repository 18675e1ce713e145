"""What a page shows until its scene has come, which takes seconds on a slow machine.

A page that opens without a link gets a picture of its scene. One with a link gets rings without a
beam: of which scene the link is, the page does not know yet.
"""

import base64
import io

from beamviz.errors import BeamvizError
from beamviz.explorer.camera import viewpoint
from beamviz.exports.renderer import Renderer
from beamviz.exports.solved_scene import SolvedScene
from beamviz.scene import Camera, Scene

SIZE = (1092, 595)  # [pixels] of the scene in a window of 1440 x 900
QUALITY = 70  # of 100: 15 kB each
LOADING = '<p role="status">Loading the scene …</p>'
NEUTRAL = (
    '<svg viewBox="0 0 400 220" aria-hidden="true">'
    '<ellipse cx="200" cy="120" rx="180" ry="62"/>'
    '<ellipse cx="200" cy="120" rx="90" ry="31"/></svg>'
)


class OpeningScene(SolvedScene):
    """A solved scene, seen as on a page."""

    def camera(self, aspect: float) -> Camera:
        """The camera of a page on which the scene has this aspect ratio."""
        frame = self.scene.view.rotating_frame
        return self.scene.camera or viewpoint(self.shapes, frame, aspect, self.heights)


def first_picture(scene: Scene | None) -> str:
    """The HTML of a first picture: of a scene, light and dark, or of no scene in particular."""
    pictures = {}
    if scene:
        try:
            for theme, dark in (("light", False), ("dark", True)):
                pictures[theme] = data_url(OpeningScene(scene.changed(dark=dark)))
        except BeamvizError:  # which the page explains
            pictures.clear()
    images = "".join(f'<img class="{theme}" alt="" src="{url}">' for theme, url in pictures.items())
    return f'<div id="first-picture">{images}{NEUTRAL}{LOADING}</div>'


def data_url(solved: SolvedScene) -> str:
    """A picture of a solved scene, as an address that contains it."""
    file = io.BytesIO()
    Renderer(solved, *SIZE).picture(solved.moment()).save(file, "WEBP", quality=QUALITY)
    return f"data:image/webp;base64,{base64.b64encode(file.getvalue()).decode()}"
