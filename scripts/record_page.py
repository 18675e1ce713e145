"""Record the moving picture of the README from the live page: python scripts/record_page.py

Starts the explorer, opens its page in headless Chromium, turns the wheel on the hub, and writes the
screenshots as an animated WebP (assets/page.webp). Run it after a change of the page's look. The
scene moves as much more slowly as a screenshot takes longer than a frame of the film.
"""

import base64
import io
import time

import _script
import numpy as np
from live.browser import Page, page  # type: ignore[import-not-found]
from PIL import Image

from beamviz import Beam, Scene
from beamviz.explorer import explorer
from beamviz.explorer.features.hub_turn import knob_place

WIDTH, HEIGHT, SHOWN = 1280, 720, (960, 540)
FRAMES, DURATION = 40, 0.12  # [s] of a frame
REACH = 120  # [px] that the wheel is dragged, and back
QUALITY = 55


def screenshot(live: Page) -> bytes:
    """The page as PNG."""
    return base64.b64decode(live.call("Page.captureScreenshot")["data"])


def place_of(point: np.ndarray) -> str:
    """The script of the place on the page of a point (3,) of the hub."""
    x, y, z = point.tolist()
    return f"""(() => {{
      const {{ camera, canvas, nodeRefFromName }} = window.__viserMutable;
      const hub = nodeRefFromName["/scene/rotor"], r = canvas.getBoundingClientRect();
      const at = hub.localToWorld(hub.position.clone().set({x}, {y}, {z})).project(camera);
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2]; }})()"""


def main() -> None:
    """Record the film and print its size."""
    scene = Scene.of(Beam(alpha=1, beta=0.5, gamma=5), mode=2)
    with explorer(scene) as url, page(url, WIDTH, HEIGHT, is_drawn=True) as live:
        live.wait("document.body?.innerText.includes('B1')")
        time.sleep(8)
        live.send("used", "pull turn")  # without hints
        x, y = live.evaluate(place_of(knob_place(scene.beam)))
        begin, frames = time.monotonic(), []
        for _ in range(3):
            screenshot(live)
        live.send("pace", min(3 * DURATION / (time.monotonic() - begin), 1.0))
        live.mouse("mousePressed", x, y, 1)
        for k in range(FRAMES):
            live.mouse("mouseMoved", x + REACH * (1 - abs(1 - 2 * k / FRAMES)), y, 1)
            frames.append(screenshot(live))
        live.mouse("mouseReleased", x, y)
    pictures = [Image.open(io.BytesIO(png)).convert("RGB").resize(SHOWN) for png in frames]
    path = _script.ROOT / "assets" / "page.webp"
    pictures[0].save(
        path,
        save_all=True,
        append_images=pictures[1:],
        duration=int(1000 * DURATION),
        loop=0,
        quality=QUALITY,
    )
    print(f"{path}: {len(frames)} frames, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    _script.Parser(__doc__).parse_args()
    main()
