"""Charts: their style, labels, the frequency loci, and figures as files."""

import io
from typing import TYPE_CHECKING

from beamviz.plotting.style import DPI, STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture_files(figure: "Figure") -> dict[str, bytes]:
    """The contents of a PNG and an SVG file of a figure, by extension; the same every time."""
    from matplotlib import rc_context

    files = {}
    for extension in ("png", "svg"):
        buffer = io.BytesIO()
        undated = {"Date": None} if extension == "svg" else None
        with rc_context(STYLE):
            figure.savefig(buffer, format=extension, dpi=DPI, metadata=undated)
        files[extension] = buffer.getvalue()
    return files
