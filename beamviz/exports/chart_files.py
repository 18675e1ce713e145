"""The frequency chart of a scene as a file: a picture, or its numbers."""

import csv
import io
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from beamviz.chart_ranges import CHART_POINTS, chart_range
from beamviz.errors import BeamvizError
from beamviz.files import check_suffix, csv_text, replaced
from beamviz.frequency_loci import Loci, loci
from beamviz.frequency_loci.identity import names_of_branches
from beamviz.output.loci import heading, loci_csv, loci_notes, si_values
from beamviz.plotting import SUFFIXES, figure_bytes
from beamviz.plotting.loci import Names, draw_chart, has_points
from beamviz.scene import Scene
from beamviz.version import __version__


class SceneLoci(NamedTuple):
    """The loci of the chart of a scene; second: those of the second beam over the same values, None
    without one and where it has none; title: of that."""

    first: Loci
    second: Loci | None
    title: str

    @property
    def names(self) -> Names:
        """The names of the modes at a value, as the page has them: those of their shapes."""
        return partial(names_of_branches, self.first)

    @classmethod
    def of(cls, scene: Scene) -> "SceneLoci":
        """Raises the errors of `loci`, for the first beam."""
        over = scene.over
        values = np.linspace(*chart_range(scene.beam, over), CHART_POINTS)
        most = max(scene.per_rev, default=0) if over == "gamma" else 0
        first = loci(scene.beam, over, values, per_rev=most, **scene.solver_options)
        if scene.second is None:
            return cls(first, None, "")
        other = scene.second_scene
        try:
            second = loci(other.beam, over, values, **other.solver_options)
        except BeamvizError:
            return cls(first, None, scene.second.title)
        return cls(first, second, scene.second.title)


def export_chart(path: str | Path, scene: Scene) -> None:
    """Write the frequency chart of a scene, over its parameter `over` and with its per-rev lines:
    .png, .svg or .pdf, a picture with a line at the beam and its measured frequencies; .csv, its
    numbers, below lines that begin with # and state beam, model, events and limits.

    Raises InvalidInput, Unavailable, and the errors of `loci`; the file is complete or untouched.
    """
    suffix = check_suffix(path, (".csv", *SUFFIXES))
    with replaced(path) as file:
        computed = SceneLoci.of(scene)
        if suffix == ".csv":
            file.write_text(chart_csv(computed), encoding="utf-8")
            return
        per_rev = scene.per_rev if scene.over == "gamma" else ()
        marker = getattr(scene.beam, scene.over)
        second = computed.second, computed.title
        measured = scene.measured if has_points(computed.first, scene.measured) else None
        figure = draw_chart(
            computed.first, per_rev, marker, *second, names=computed.names, measured=measured
        )
        file.write_bytes(figure_bytes(figure, suffix[1:]))


def chart_csv(computed: SceneLoci) -> str:
    """The numbers of a chart: a line for each value, as `beamviz loci --format csv` writes them,
    with those of the second beam in further columns."""
    lines = [f"beamviz {__version__}", *heading(computed.first), *loci_notes(computed.first)]
    lines.append(
        "Branches     keep their label through a veering, where modes exchange their shapes"
    )
    lines.append("Columns      frequencies [1/T*]; _hertz [Hz]; _bending: share of kinetic energy")
    comments = "".join(f"# {line}".rstrip() + "\n" for line in lines)
    if computed.second is None:
        return comments + loci_csv(computed.first)
    first, second = rows_of(computed.first), rows_of(computed.second)
    leading = 1 + len(si_values(computed.first))
    heads = [*first[0], *(f"{computed.title}: {head}" for head in second[0][leading:])]
    rows = (a + b[leading:] for a, b in zip(first[1:], second[1:], strict=True))
    return comments + csv_text(heads, rows)


def rows_of(loci: Loci) -> list[list[str]]:
    """The cells of the table of loci, the heads first."""
    return [*csv.reader(io.StringIO(loci_csv(loci)))]
