"""Files of blades: the formats of the field, and CSV.

A format is a record in FORMATS: how a file is recognised by its text, and how it is read. General
readers of such files exist (weio, openfast-io); those that read blades of BModes, HAWC2 or FLEX
bring a hundred megabytes of other libraries, so the few tables needed here are read here.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PureWindowsPath
from typing import Any, NamedTuple

from beamviz.blade_files import bmodes, delimited, elastodyn, flex, hawc2
from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import Text
from beamviz.checks import check_positive
from beamviz.conversions import in_si
from beamviz.errors import InvalidInput, LeftOut
from beamviz.input_files import decoded, read_small

__all__ = [
    "CSV",
    "FORMATS",
    "BladeData",
    "Format",
    "Text",
    "delimited",
    "format_of",
    "parse_blade",
    "parse_together",
    "read_blade_file",
]


MAX_BYTES = 2_000_000


class Format(NamedTuple):
    """A format of files."""

    name: str
    what: str  # it is recognised by
    is_this: Callable[[Text], bool]
    read: Callable[[Text], BladeData]
    read_set: Callable[[Text, str], BladeData] | None = None  # by its name, where it has several


CSV = Format("CSV", "a line of names of columns", delimited.is_table, delimited.read_stations)
FORMATS = (
    Format(
        *("ElastoDyn blade", "columns BlFract, BMassDen"),
        *(elastodyn.is_blade, elastodyn.read_blade),
    ),
    Format(
        *("BModes sections", "columns sec_loc, mass_den"),
        *(bmodes.is_sections, bmodes.read_sections),
    ),
    Format("BModes", "entries romg, sec_props_file", bmodes.is_main, bmodes.read_main),
    Format(
        *("ElastoDyn", "entries TipRad, HubRad, BldFile(1)"),
        *(elastodyn.is_main, elastodyn.read_main),
    ),
    Format(
        name="HAWC2 structure",
        what="sets #1, $1",
        is_this=hawc2.is_structure,
        read=hawc2.read_structure,
        read_set=hawc2.read_structure,
    ),
    Format("FLEX blade", "a count and rows of numbers", flex.is_blade, flex.read_blade),
    CSV,
)


def format_of(file: Text) -> Format:
    """The format of a file. Raises InvalidInput for none, with what was looked for."""
    form = next((form for form in FORMATS if form.is_this(file)), None)
    if form is None:
        looked_for = "; ".join(f"{form.what} ({form.name})" for form in FORMATS)
        raise InvalidInput(f"{file.name}: no file of a known format; looked for {looked_for}")
    return form


def parse_blade(file: Text, chosen: str = "") -> BladeData:
    """What the text of a file says. chosen: the name of a set, of a file that has several. Raises
    InvalidInput."""
    form = format_of(file)
    if not chosen:
        return form.read(file)
    if form.read_set is None:
        raise InvalidInput(f"{file.name}#{chosen}: this file has no sets ({form.name})")
    return form.read_set(file, chosen)


def read_blade_file(path: str | Path, given: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of `Beam.from_si` in a file of a blade, and in those that it names.

    path: of the file; after # the name of a set, as in "blade_st.dat#1.2". given: keywords known
    beside it, of which the length is needed where stations are fractions of it. Warns with LeftOut
    of what the file has and the model leaves out. Raises InvalidInput with file, line and column.
    """
    path, chosen = Path(path), ""
    if "#" in path.name and not path.exists():
        name, _, chosen = path.name.rpartition("#")
        path = path.with_name(name)
    data = parse_blade(text_of(path), chosen)
    if data.blade_file is not None:
        data = with_sections(data, parse_blade(text_of(path.parent / data.blade_file)))
    values = dict(data.values)
    if data.has_fractions:
        values["stations"] = from_fractions(path, values, given)
    if data.left_out:
        left_out = ", ".join(data.left_out)
        warnings.warn(f"{path}: the model leaves out {left_out}", LeftOut, stacklevel=4)
    return values


def with_sections(main: BladeData, sections: BladeData) -> BladeData:
    """What a main file and the file of sections that it names say together."""
    rows = {
        key: tuple(main.factors.get(key, 1.0) * value for value in row)
        for key, row in sections.values.items()
    }
    left_out = (*main.left_out, *sections.left_out)
    return BladeData({**main.values, **rows}, sections.has_fractions, left_out)


def parse_together(files: Sequence[Text]) -> BladeData:
    """What the texts of files say that are given at once: one with stations, perhaps with the main
    file that names it, or more of which the main file names one. Raises InvalidInput."""
    read = {Path(file.name).name: parse_blade(file) for file in files}
    main_files = [data for data in read.values() if data.blade_file is not None]
    sections = {name: data for name, data in read.items() if data.blade_file is None}
    if len(main_files) > 1 or (len(sections) > 1 and not main_files):
        raise InvalidInput(
            f"{', '.join(read)}: give one file of stations, and at most one main file with it"
        )
    if not main_files:
        return next(iter(sections.values()))
    named = main_files[0].blade_file
    assert named is not None
    name = PureWindowsPath(named).name  # a path of any system
    if name in sections or len(sections) == 1:
        return with_sections(main_files[0], sections.get(name) or next(iter(sections.values())))
    raise InvalidInput(f"the stations are in {name}: give both files at once")


def text_of(path: Path) -> Text:
    """The text of a file, in UTF-8 or, as older programs write it, in Latin-1. Raises
    InvalidInput."""
    content = read_small(path, MAX_BYTES)
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        content = content.decode("latin-1").encode("utf-8")
    return Text(str(path), decoded(content, str(path), "CSV", MAX_BYTES))


def from_fractions(
    path: Path, values: Mapping[str, Any], given: Mapping[str, Any]
) -> tuple[float, ...]:
    """Stations [m] of those that are fractions of the length."""
    length = values.get("length", given.get("length"))
    if length is None:
        raise InvalidInput(
            f"{path}: its stations are fractions of the length: give length [m] beside it, as with"
            f' a TOML file of stations_file = "{path.name}", length, hub_radius and rotation_rpm'
        )
    length = check_positive("length", in_si("length", length, "m"))
    return tuple(length * fraction for fraction in values["stations"])
