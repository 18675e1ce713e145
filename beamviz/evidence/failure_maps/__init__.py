"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text. A picture is a sheet for each map with a panel for each method."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from beamviz.evidence.failure_maps.maps import compute_maps
from beamviz.evidence.failure_maps.pictures import sheet
from beamviz.evidence.failure_maps.report import as_data, page
from beamviz.files import json_text, make_folder, write_files


def stability(out: Path, quick: bool) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        maps = compute_maps(quick, pool)
        text, data = page(maps), json_text([as_data(plane_map) for plane_map in maps], indent=None)
        files = {"stability.md": text.encode(), "stability.json": f"{data}\n".encode()}
        for pictures in pool.map(sheet, maps):
            files |= pictures
    write_files(out, files)
    return text
