"""Run the notebook in a Jupyter kernel and store its outputs: python scripts/notebook.py

A live page is stored as a picture, as its server ends with the kernel. Run it after a change of the
notebook (assets/notebook.ipynb), of its results or of the look of the page.
"""

import base64
import io
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import _script
import nbformat
from live.browser import READY, page  # type: ignore[import-not-found]
from live.notebook import frame_address, kernel  # type: ignore[import-not-found]
from PIL import Image

WIDTH, HEIGHT = 1000, 560
SETTLING = 4.0  # [s] until charts are there and the picture is sharp
COLOURS = 128


def main() -> None:
    """Run all cells, and write the notebook."""
    file = _script.ROOT / "assets" / "notebook.ipynb"
    notebook = nbformat.read(file, 4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    with TemporaryDirectory() as folder, kernel(Path(folder)) as running:
        for count, cell in enumerate(cells, 1):
            cell.execution_count = count
            cell.outputs = [stored(output) for output in running.run(cell.source)]
    nbformat.write(notebook, file)
    print(f"{file}: {len(cells)} cells, {file.stat().st_size / 1e3:.0f} kB")


def stored(output: Any) -> Any:
    """An output as it is stored."""
    data = output.get("data", {})
    if address := frame_address(data.get("text/html", "")):
        del data["text/html"]
        data["image/png"] = picture(address)
    output.get("metadata", {}).clear()
    return output


def picture(address: str) -> str:
    """A live page as a PNG file, base64."""
    with page(address, WIDTH, HEIGHT, is_drawn=True) as live:
        live.wait(READY)
        time.sleep(SETTLING)
        png = base64.b64decode(live.call("Page.captureScreenshot")["data"])
    file = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").quantize(COLOURS).save(file, "png", optimize=True)
    return base64.b64encode(file.getvalue()).decode()


if __name__ == "__main__":
    _script.Parser(__doc__).parse_args()
    main()
