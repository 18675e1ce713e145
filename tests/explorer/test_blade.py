"""The panel of a blade: its tables by typing, paste and file; presets; a blade in links."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import blade_texts
import pytest
from helpers import slow
from live.axe import load_axe, violations
from live.browser import READY, Page, by_id, page, says
from live.offline import Desk, local, offline
from live.visitor import Visitor, catch_up, visitor

from beamviz.beam import Beam
from beamviz.blade_files import Text
from beamviz.errors import InvalidInput
from beamviz.explorer.blade_table import (
    STATIONS,
    Draft,
    beam_of,
    draft_of,
    draft_of_text,
    parse_stations,
    parse_table,
    text_of_draft,
    wrong_entries,
)
from beamviz.explorer.features import real_beam
from beamviz.explorer.features.blade import uniform as made_uniform
from beamviz.presets import PRESETS
from beamviz.scene import MAX_LINK, Scene

FIRST = Scene(real_beam.STEEL_BEAM.beam).changed(playing=False)
NREL, STEEL = PRESETS["nrel-5mw-blade"].beam, PRESETS["tapered-steel-blade"].beam
SI: dict[str, Any] = {
    "stations": [0.0, 0.4, 1.0],
    "mass_per_length": [1.2, 1.0, 0.5],
    "bending_stiffness": [300.0, 200.0, 50.0],
    "axial_stiffness": [3e7, 2.5e7, 1e7],
}
FLAP = {"flap_stiffness": [150.0, 90.0, 20.0]}
HUB: dict[str, Any] = {"hub_radius": 0.1, "rotation_rpm": 200.0}
TABLE = "0\t1.2\t300\t3e7\t150\n0.4\t1\t200\t2.5e7\t90\n1\t0.5\t50\t1e7\t20"


def rows(guest: Visitor, name: str = "stations") -> list[list[str]]:
    """The cells of a table as the page shows them, of stations without the twist."""
    lines = guest.values[f"blade.{name}"].split("\n")
    return [line.split("\t")[:5] for line in lines]


def type_in(guest: Visitor, row: int, column: int, text: str, name: str = "stations") -> None:
    """Type into a cell, as the page sends it: with all other cells."""
    table = rows(guest, name)
    table[row][column] = text
    guest.do(f"blade.{name}", "\n".join("\t".join(one) for one in table))


def shown(guest: Visitor, name: str) -> None:
    """Show a preset, with its table."""
    guest.do("blade.preset", name)
    guest.shows(PRESETS[name].beam)
    guest.wait(lambda _: "blade.stations" in guest.values)


# Text to values


@pytest.mark.parametrize(
    ("text", "cells"),
    [
        (TABLE, TABLE),
        (TABLE.replace("\t", ","), TABLE),
        (TABLE.replace("\t", "  "), TABLE),
        (TABLE.replace("\t", ";").replace(".", ","), TABLE),
        ("x [mm]\tEI [kN m^2]\tm\n0\t2\t1\n1000\t2\t1", "0\t1\t2000\n1\t1\t2000"),
        (
            "x;m;EI;twist\nft;t/m;Nm2;rad\n0;1;2;0\n10;1;2;0,1",
            "0\t1000\t2\t\t\t0\n3.048\t1000\t2\t\t\t5.72958",
        ),
        ("# a comment\n\n" + TABLE + "\r\n\n", TABLE),
        (
            "EI [N m^2]\tposition [m]\tEA (N)\tmass [kg/m]\n300\t0\t3e7\t1.2\n50\t1\t1e7\t.5",
            "0\t1.2\t300\t3e7\t\n1\t.5\t50\t1e7\t",
        ),
        (
            "r (m)\tm (kg/m)\tEI (Nm2)\tEA (N)\n0\t1\t2\t3\n1\t1\t2\t3",
            "0\t1\t2\t3\t\n1\t1\t2\t3\t",
        ),
        (
            "Radius;BMassDen;FlpStff;EdgStff;EAStff\n0;1;4;2;3\n1;1;4;2;3",
            "0\t1\t2\t3\t4\n1\t1\t2\t3\t4",
        ),
        (
            "station,mass_per_length,bending_stiffness,axial_stiffness\n0,1,2,3\n1,1,2,3",
            "0\t1\t2\t3\t\n1\t1\t2\t3\t",
        ),
    ],
)
def test_a_table_is_taken_as_people_have_it(text, cells):
    """By tabs, commas, semicolons or blanks; with comments; with names in another order."""
    rows = ["\t".join(row).rstrip() for row in parse_table(text, STATIONS)]
    assert rows == [row.rstrip() for row in cells.split("\n")]


@pytest.mark.parametrize("kind", ["elastodyn", "bmodes", "hawc2", "flex"])
def test_a_file_of_the_field_is_taken_as_a_table(kind):
    """Its fractions are those of the length of the beam shown; the twist is in its column."""
    pasted = parse_stations([Text("a", getattr(blade_texts, kind)())], blade_texts.BLADE.length)
    for k, expected in (
        (0, blade_texts.BLADE.stations),
        (1, blade_texts.BLADE.mass),
        (2, blade_texts.BLADE.edge),
        (4, blade_texts.BLADE.flap),
        (5, blade_texts.BLADE.twist),
    ):
        assert [float(row[k]) for row in pasted.rows] == pytest.approx(expected, rel=1e-5)
    assert "torsion" in pasted.left_out
    assert wrong_entries(Draft(pasted.rows)) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the table is empty"),
        ("9" * 900, r"has one column; it needs position \[m\], mass"),
        ("EI\tEA", "has a line of names only"),
        (
            "x\tcolour\n0\t1",
            r"column 'colour': must be one of position \[m\], mass \[kg/m\].*leave out",
        ),
        ("x\tEI [MPa]\n0\t1", r"EI \[MPa\]: unit 'MPa': must be one of N m\^2, kN m\^2"),
        ("0\t1\t2\t3\t4\t5\t6", r"row 1 has 7 cells, more than 6"),
    ],
)
def test_what_is_no_table_is_refused_with_the_remedy(text, words):
    with pytest.raises(InvalidInput, match=words):
        parse_table(text, STATIONS)


@pytest.mark.parametrize(
    ("cell", "text", "words"),
    [
        ((1, 1), "many", r"station 2, mass \[kg/m\] = many: must be a number, as 320"),
        ((1, 1), "", r"station 2, mass \[kg/m\] = nothing: must be a number"),
        ((2, 2), "0", r"station 3, EI \[N m²\] = 0: must be above 0"),
        ((0, 3), "-3e7", r"station 1, EA \[N\] = -3e7: must be above 0"),
        ((1, 3), "2,500", r"station 2, EA \[N\] = 2,500: write 2500, or 2\.500"),
        ((1, 3), "2,500,000", r"station 2, EA \[N\] = 2,500,000: write 2500000$"),
        ((1, 3), "inf", r"must be a number"),
        (
            (1, 4),
            "",
            r"station 2, flap EI \[N m²\] = nothing: give it at every station, or at none",
        ),
        ((0, 0), "0.1", r"station 1, position \[m\] = 0\.1: must be 0, at the root"),
    ],
)
def test_a_wrong_cell_is_told_with_its_value_unit_and_remedy(cell, text, words):
    """And only that cell."""
    table = [list(row) for row in parse_table(TABLE, STATIONS)]
    assert wrong_entries(Draft(tuple(map(tuple, table)))) == []
    table[cell[0]][cell[1]] = text
    (wrong,) = wrong_entries(Draft(tuple(map(tuple, table))))
    assert re.search(words, wrong.reason)
    assert (wrong.table, wrong.row, wrong.column) == ("stations", *cell)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("700\t1e3\t1e9", r"speed \[rpm\] = 12\.1: must lie in 0 \.\. 0\.\d+: .*too soft"),
        ("700\t1e12\t1e9", r"L √\(EA / EI\) at the root = 1\.897: must lie in 10"),
        ("700\t1e9\t1e19", r"L √\(EA / EI\) at the root = 6e\+06: must lie"),
        ("1e-9\t1e9\t1e10", r"mass \[kg/m\] of station 2 at 60 m over that at the root"),
    ],
)
def test_tables_that_describe_no_beam_are_told_in_words(row, words):
    """In the names and units of the page: without the names of Python's keywords and numbers."""
    before = PRESETS["nrel-5mw-blade"].beam.physical
    table = parse_table(f"0\t{row}\n60\t50\t1e9\t1e10", STATIONS)
    with pytest.raises(InvalidInput, match=words) as raised:
        beam_of(draft_of(before)._replace(stations=table), before)
    assert not re.search(r"\w_\w|gamma|\bmu\b|\*", str(raised.value))


@pytest.mark.parametrize("beam", [NREL, STEEL, Beam.from_si(**SI, **FLAP, **HUB)])
def test_the_tables_of_a_beam_are_that_beam(beam):
    """With all digits, though the tables show six; numbers with a point or an exponent."""
    before = beam.physical
    again = beam_of(draft_of(before), before)
    for name in ("mass", "bending", "axial", "flap"):
        pair = (getattr(one.blade, name) for one in (again, beam))
        assert next(pair) == pytest.approx(next(pair), rel=1e-14), name
    assert again.numbers == pytest.approx(beam.numbers, rel=1e-14)
    assert again.blade.degree == beam.blade.degree


@pytest.mark.parametrize("text", ["", "blade", "a text", "blade\nroot\t\ns\t0\t1", "blade\nx\ty"])
def test_a_link_with_other_tables_is_refused(text):
    """A draft is read as it was written, and nothing else is one."""
    draft = draft_of(
        Beam.from_si(**SI, **FLAP, **HUB, masses=[{"mass": 1, "position": 1}]).physical
    )
    assert draft_of_text(text_of_draft(draft)) == draft
    assert draft_of_text(text) is None


# The page


def test_a_preset_shows_its_source_its_table_and_its_properties(guest):
    """What the model leaves out is said while the stations are those of the preset."""
    shown(guest, "nrel-5mw-blade")
    assert len(rows(guest)) == 49
    assert rows(guest)[1] == [
        *("0.2", "709.731"),
        *("1.81136 × 10¹⁰", "9.72948 × 10⁹", "1.811 × 10¹⁰"),  # powers as elsewhere on the page
    ]
    assert "NREL/TP-500-38060" in guest.texts["blade"]
    assert "leaves out the twist" in guest.texts["blade"]
    chart = guest.charts["blade-chart"]
    assert [line["label"] for line in chart["lines"]] == ["m", "EI", "flap", "EA"]
    stiffness = dict(zip(chart["lines"][1]["at"], chart["lines"][1]["y"], strict=True))
    assert stiffness[61.5] == pytest.approx(5.01e6 / 18113.6e6, rel=1e-4)
    for above in ('data-set="blade.preset"', 'data-do="dimensionless"'):  # however many stations
        assert guest.texts["blade"].index(above) < guest.texts["blade"].index("<table")
    guest.do("blade.stations.remove", 3, until=lambda _: len(rows(guest)) == 48)
    guest.wait(lambda _: "leaves out the twist" not in guest.texts["blade"])
    shown(guest, "tapered-steel-blade")
    assert guest.says("polynomials of degree 4")


def test_cells_are_edited_and_a_wrong_one_is_kept_as_typed(guest, session, url):
    """The beam changes with each valid table, in the cell that was typed only. A wrong cell is told
    and marked, the scene keeps the beam; a reload keeps what is typed; corrected, it counts."""
    guest.do("link", "")
    shown(guest, "nrel-5mw-blade")
    physical = NREL.physical
    type_in(guest, 20, 1, "900")
    masses = list(physical.mass_per_length)
    masses[20] = 900.0
    heavier = Beam.of_physical(replace(physical, mass_per_length=tuple(masses)))
    guest.shows(heavier)
    found = session.visitor.state.case.beam.physical
    assert found.mass_per_length == pytest.approx(masses, rel=1e-13)
    assert found.bending_stiffness == pytest.approx(physical.bending_stiffness, rel=1e-13)
    assert found.rotation_speed == pytest.approx(physical.rotation_speed)
    type_in(guest, 4, 2, "stiff")
    assert guest.says("station 5, EI [N m²] = stiff: must be a number, as 320 or 1.8e10")
    guest.wait(lambda _: rows(guest)[4][2] == "stiff")
    assert guest.texts["blade"].count('aria-invalid="true"') == 1
    assert session.visitor.state.case.beam.physical == found
    guest.wait(lambda _: "draft=" in guest.parts["address"])
    with visitor(url) as new:
        new.do("link", f"?{guest.parts['address']}", until="EI [N m²] = stiff")
        new.wait(lambda _: rows(new)[4][2] == "stiff")
    type_in(guest, 4, 2, "1.9e10")
    guest.wait(lambda _: "= stiff" not in guest.texts["blade-reasons"])
    guest.wait(lambda _: "draft=" not in guest.parts["address"])
    stiffness = [*physical.bending_stiffness[:4], 1.9e10, *physical.bending_stiffness[5:]]
    now = session.visitor.state.case.beam.physical
    assert now.bending_stiffness == pytest.approx(stiffness, rel=1e-13)
    guest.do("undo")
    guest.wait(lambda _: rows(guest)[4][2] == "stiff")
    guest.do("undo")
    guest.do("undo")
    guest.shows(NREL)


def test_a_pasted_table_becomes_the_blade(guest):
    """From a spreadsheet, or a file. What is no table stays in the field, with the reason; a table
    with a wrong cell becomes the table, with that cell. Hub, speed and mass are kept."""
    start = FIRST.beam.physical
    guest.do("real.section", real_beam.ALONG, until="Paste a table")
    guest.do("blade.paste", "no table at all, as words", until="must be one of position [m]")
    guest.wait(lambda _: guest.values["blade.paste"] == "no table at all, as words")
    guest.do("blade.paste", TABLE)
    kept = {"hub_radius": start.hub_radius, "rotation_speed": start.rotation_speed}
    guest.shows(Beam.from_si(**SI, **FLAP, **kept))
    guest.wait(lambda _: guest.values["blade.paste"] == "")
    guest.do("blade.file", "mine.csv\n" + TABLE.replace("2.5e7", "a lot").replace("\t", ";"))
    assert guest.says("station 2, EA [N] = a lot: must be a number")
    assert rows(guest)[1][3] == "a lot"
    without_flap = "\n".join(line.rpartition("\t")[0] for line in TABLE.split("\n"))
    guest.do("blade.file", "mine.csv\n" + without_flap.replace("\t", ","))
    guest.wait(lambda _: [row[4] for row in rows(guest)] == ["", "", ""])
    guest.shows(Beam.from_si(**SI, **kept))
    guest.do("blade.paste", TABLE.replace("0.4", "9e9"))
    assert guest.says("must lie in")  # a beam too slender; and the table is kept
    guest.wait(lambda _: "9 × 10⁹" in guest.values["blade.stations"])


def told(guest: Visitor, words: str) -> None:
    """Wait until a note over the page has these words."""
    guest.wait(lambda _: any(words in one["text"] for one in guest.said))


def test_files_are_opened_also_on_a_page_without_a_size():
    """A main file and the file that it names, at once, say all; alone its fractions are those of
    the beam before, which is said, and a file that is no blade changes nothing."""
    blade, main = blade_texts.elastodyn(), blade_texts.elastodyn_main("../sub/blade.dat")
    expected = Beam.from_si(**blade_texts.KEYWORDS, hub_radius=1.5, rotation_rpm=12.1, pitch=1)
    with local(Scene()) as guest:
        state = guest.session.visitor
        guest.do("blade.file", "notes.dat\nnothing\nto see")
        told(guest, "looked for columns BlFract")
        guest.do("blade.file", f"main.dat\n{main}")
        told(guest, "the stations are in blade.dat")
        assert state.state.case.units is None
        guest.do("blade.file", f"main.dat\n{main}\x1cblade.dat\n{blade}")
        told(guest, "4 stations read")
        numbers = state.state.case.beam.numbers
        assert numbers == pytest.approx(expected.numbers, rel=1e-5)
        guest.do("blade.preset", "nrel-5mw-blade")
        guest.do("blade.file", f"blade.dat\n{blade}")
        told(guest, "here of the beam before, 61.5 m")


def test_a_station_that_is_added_to_a_uniform_blade_stays():
    """As many as are added, where the scene and its link keep them; each gets the focus, ready to
    be typed. A value makes a blade of it, and the values before a beam that is uniform again."""
    si = {"length": 1.0, "mass_per_length": 1.2, "bending_stiffness": 60.0, "axial_stiffness": 3e7}
    beam = Beam.from_si(**si)

    def cells(desk: Desk) -> list[list[str]]:
        desk.guest.visitor.receive()
        return rows(desk.guest.visitor)

    with offline():
        desk = Desk(Scene(beam).changed(playing=False))
        page = desk.guest.visitor
        for places, focus in ((["0", "0.5", "1"], 1), (["0", "0.25", "0.5", "1"], 1)):
            desk.do("blade.stations.add")
            desk.frame(2)
            assert [row[0] for row in cells(desk)] == places
            assert {tuple(row[1:]) for row in cells(desk)} == {("1.2", "60", "3 × 10⁷", "")}
            assert page.parts["focus"] == f"stations-{focus}-0"
            assert f'id="{page.parts["focus"]}"' in page.texts["blade"]
            assert page.texts["blade-reasons"] == ""
            assert desk.state.case.beam == beam
        other = Desk(Scene().changed(playing=False))
        other.do("link", f"?{desk.address}")
        other.frame(2)
        assert cells(other) == cells(desk)
        typed = cells(desk)
        typed[1][1] = "2.4"
        desk.do("blade.stations", "\n".join("\t".join(row) for row in typed))
        desk.frame(2)
        physical = desk.state.case.beam.physical
        assert physical.stations == (0.0, 0.25, 0.5, 1.0)
        assert physical.mass_per_length == pytest.approx((1.2, 2.4, 1.2, 1.2))
        assert cells(desk)[1][:2] == ["0.25", "2.4"]
        typed[1][1] = "1.2"
        desk.do("blade.stations", "\n".join("\t".join(row) for row in typed))
        desk.frame(2)
        assert [row[0] for row in cells(desk)] == ["0", "0.25", "0.5", "1"]
        assert desk.state.case.beam.is_uniform
        for k, left in ((1, ["0", "0.5", "1"]), (1, ["0", "1"])):
            desk.do("blade.stations.remove", k)
            desk.frame(2)
            assert [row[0] for row in cells(desk)] == left
        desk.do("blade.masses.add")
        desk.frame(2)
        assert len(desk.state.case.masses) == 1
        assert cells(desk) == [["0", "1.2", "60", "3 × 10⁷", ""], ["1", "1.2", "60", "3 × 10⁷", ""]]
        assert page.parts["focus"] == "masses-0-0"


def test_a_uniform_table_that_is_pasted_keeps_its_rows():
    """And what is below it, as a table with one wrong position has no order to be sorted by."""
    table = "0\t2\t70\t4e7\n0.3\t2\t70\t4e7\n1\t2\t70\t4e7"
    with offline():
        desk = Desk(Scene(STEEL).changed(playing=False))
        for text in (table, table.replace("0.3", "3")):
            desk.do("blade.paste", text)
            desk.frame(2)
            desk.guest.visitor.receive()
            assert len(rows(desk.guest.visitor)) == 3
        assert desk.state.case.beam.physical.length == pytest.approx(3.0)
        typed = rows(desk.guest.visitor)
        typed[0][0], typed[1][0], typed[2][0] = "0", "2", "1"
        for first, offers in (("0", True), ("root", False)):
            typed[0][0] = first
            desk.do("blade.stations", "\n".join("\t".join(row) for row in typed))
            desk.frame(2)
            desk.guest.visitor.receive()
            reasons = desk.guest.visitor.texts["blade-reasons"]
            assert "below that of station 2" in reasons
            assert ("blade.stations.sort" in reasons) is offers


def test_stations_masses_and_the_root_are_added_and_removed(guest):
    """A station in the middle of the longest interval, on the line between its neighbours, changes
    nothing; a mass and a spring do. Two stations stay."""
    guest.do("blade.begin", until="Paste a table")
    guest.do("blade.paste", TABLE)
    start = FIRST.beam.physical
    kept = {"hub_radius": start.hub_radius, "rotation_speed": start.rotation_speed}
    guest.shows(blade := Beam.from_si(**SI, **FLAP, **kept))
    guest.do("blade.stations.add")
    guest.wait(lambda _: rows(guest)[2] == ["0.7", "0.75", "125", "1.75 × 10⁷", "55"])
    guest.shows(blade)
    guest.do("blade.masses.add", until="remove mass 1")
    whole = (1.2 + 1.0) / 2 * 0.4 + (1.0 + 0.5) / 2 * 0.6
    assert rows(guest, "masses") == [[f"{whole / 10:.2g}", "1", "0", "0", "0"]]
    for column, text in enumerate(("0.3", "0.5", "0", "0.01", "0.02")):
        type_in(guest, 0, column, text, "masses")
        guest.wait(lambda _, k=column, t=text: rows(guest, "masses")[0][k] == t)
    body = {"mass": 0.3, "position": 0.5, "inertia": (0.0, 0.01, 0.02)}
    guest.shows(Beam.from_si(**SI, **FLAP, **kept, masses=[body]))
    guest.do("blade.root", "spring", until="stiffness [N m/rad]")
    guest.do("blade.spring", 500)
    guest.shows(Beam.from_si(**SI, **FLAP, **kept, masses=[body], root_stiffness=500))
    guest.do("blade.spring", -1, until="stiffness of the root [N m/rad] = −1: must be 0 or more")
    guest.do("blade.root", "hinged")
    guest.shows(Beam.from_si(**SI, **FLAP, **kept, masses=[body], root_stiffness=0))
    type_in(guest, 0, 1, "2", "masses")
    assert guest.says("position = 2: must lie in 0 .. 1")
    guest.do("blade.masses.remove", 0)
    guest.do("blade.root", "clamped")
    guest.shows(blade)
    for count in (3, 2):
        guest.do("blade.stations.remove", 1, until=lambda _, n=count: len(rows(guest)) == n)
    guest.do("blade.stations.remove", 1, until="a blade has at least two stations")
    assert len(rows(guest)) == 2


def test_a_mistyped_position_stays_in_its_row(guest, session):
    """Of a station or a body, where it is told, with a button that sorts the stations; corrected,
    the beam is that of before."""
    guest.do("blade.begin", until="Paste a table")
    guest.do("blade.paste", "\n".join(TABLE.split("\n")[::-1]))  # sorted as it is taken
    guest.wait(lambda _: [row[0] for row in rows(guest)] == ["0", "0.4", "1"])
    for _ in range(2):
        guest.do("blade.masses.add")
    guest.wait(lambda _: len(rows(guest, "masses")) == 2)
    type_in(guest, 0, 1, "0.5", "masses")
    guest.wait(lambda _: [row[1] for row in rows(guest, "masses")] == ["0.5", "1"])
    type_in(guest, 1, 1, "0.2", "masses")
    guest.wait(lambda _: [row[1] for row in rows(guest, "masses")] == ["0.5", "0.2"])
    physical = session.visitor.state.case.beam.physical
    type_in(guest, 1, 0, "4")
    told = "station 3, position [m] = 1: below that of station 2, 4: correct it, or sort"
    assert guest.says(told)
    guest.wait(lambda _: [row[0] for row in rows(guest)] == ["0", "4", "1"])
    assert session.visitor.state.case.beam.physical == physical
    type_in(guest, 1, 0, "0.4")
    guest.wait(lambda _: told not in guest.texts["blade-reasons"])
    assert session.visitor.state.case.beam.physical == physical
    type_in(guest, 1, 0, "4")
    guest.wait(lambda _: "blade.stations.sort" in guest.texts["blade-reasons"])
    guest.do("blade.stations.sort")
    guest.wait(
        lambda _: [row[:2] for row in rows(guest)] == [["0", "1.2"], ["1", "0.5"], ["4", "1"]]
    )
    guest.wait(lambda _: guest.texts["blade-reasons"] == "")


def test_a_blade_becomes_uniform_and_returns(guest):
    """By one button the beam is the uniform clamped one with the section at the root, which has the
    panel of a uniform beam; undo restores the blade, and so does its link."""
    shown(guest, "nrel-5mw-blade")
    guest.do("blade.masses.add", until="remove mass 1")
    guest.do("link", "", until=lambda _: "masses=" in guest.parts.get("address", ""))
    address = guest.parts["address"]
    assert len(address) < MAX_LINK
    guest.do("blade.uniform")
    at_root = {"mass_per_length": 678.935 * 1.04536, "bending_stiffness": 18113.6e6}
    si = {**at_root, "axial_stiffness": 9729.48e6, "length": 61.5, "hub_radius": 1.5}
    uniform = Beam.from_si(**si, flap_stiffness=18110e6, rotation_rpm=12.1)
    guest.shows(uniform)
    guest.choose("plane", "flapwise")
    guest.shows(uniform, plane="flapwise")
    guest.choose("plane", "chordwise")
    guest.wait(lambda _: guest.texts["blade"] == "" and "real.area" in guest.values)
    E, A = 1e9 * guest.values["real.youngs_modulus"], guest.values["real.area"]
    assert pytest.approx(9729.48e6, rel=1e-6) == E * A
    assert guest.values["real.density"] * A == pytest.approx(at_root["mass_per_length"], rel=1e-5)
    for _ in range(3):
        guest.do("undo")
    guest.wait(lambda _: "remove mass 1" in guest.texts["blade"])
    physical = NREL.physical
    mass = float(rows(guest, "masses")[0][0])
    body = {"mass": mass, "position": 61.5}
    loaded = Beam.from_si(**NREL.si, masses=[body])
    guest.shows(loaded)
    guest.do("dimensionless", until=lambda _: guest.texts["blade"] == "")
    guest.do("link", f"?{address}", until="remove mass 1")
    guest.shows(loaded)
    assert physical.masses == ()


def test_a_doubtful_value_gets_a_note(guest):
    """EI in kN m² is possible, and said to be unusual."""
    guest.do("blade.begin", until="Paste a table")
    thin = "\n".join(f"{x}\t1.2\t0.0003\t3e7" for x in (0, 1))
    guest.do("blade.paste", thin)
    assert guest.says("this blade is too soft")
    guest.do("blade.paste", thin.replace("0.0003", "0.31"))
    guest.forgets("this blade is too soft")
    assert guest.says("the bending stiffness in kN m²?")


def test_a_beam_of_another_size_is_not_lost_by_an_impossible_table(guest, session):
    """A number that is out of range, as the mass of a slider, keeps the panel as it is."""
    shown(guest, "nrel-5mw-blade")
    guest.do("alpha", 1e9, until="must lie in")
    guest.do("blade.stations.add")
    guest.do("alpha", 0)
    catch_up(guest)
    guest.shows(NREL)
    assert len(rows(guest)) == 49
    assert session.visitor.state.case.blade == NREL.blade


# In a browser


@pytest.fixture(scope="module")
def opened(url) -> Iterator[Page]:
    """A page of the explorer of this file, which its tests use in turn."""
    with page(url, 1440, 900) as opened:
        opened.wait(f"{READY} && {says('1st bending')}")
        yield opened


CELLS = (
    "[...document.querySelectorAll('#blade table')[0]"
    ".querySelectorAll('td:not(.hidden) > input.cell')]"
)
PASTE = """(text => {{ const data = new DataTransfer(); data.setData('text', text);
  const cell = {cell}; cell.focus(); cell.dispatchEvent(new ClipboardEvent('paste',
  {{clipboardData: data, bubbles: true, cancelable: true}})) }})({text})"""

DRAG = """(() => {{ const data = new DataTransfer(); data.items.add(new File([{text}], 'a.CSV'));
  document.body.dispatchEvent(new DragEvent('{kind}', {{dataTransfer: data, bubbles: true,
  cancelable: true}})); return document.getElementById('drop').hidden }})()"""


def test_cells_are_typed_pasted_and_read_from_a_file_in_the_page(opened, tmp_path):
    """By keyboard, letters of which are no shortcuts; several cells by paste; a CSV file. Another
    cell keeps what is typed in it, and a reload all of it."""
    opened.send("reset")
    opened.send("blade.begin")
    opened.wait(f"!!document.querySelector('#blade table') && {CELLS}[0].value === '0'")
    opened.evaluate(PASTE.format(cell=f"{CELLS}[3]", text=json.dumps(TABLE)))
    opened.wait(f"{CELLS}.length === 15 && {CELLS}[7].value === '200'")
    opened.evaluate(f"{CELLS}[7].focus(); {CELLS}[7].select()")
    choices = "document.documentElement.dataset.theme + document.getElementById('play').ariaPressed"
    before = opened.evaluate(choices)
    for letter in "pd":
        opened.key(letter)
    opened.call("Input.insertText", text="stiff")
    opened.key("Tab", until=says("station 2, EI [N m²] = "))
    assert opened.evaluate("document.activeElement === " + f"{CELLS}[8]")
    opened.wait("location.search.includes('draft=')")
    typed = opened.evaluate(f"{CELLS}[7].value")
    assert typed.endswith("stiff")
    assert opened.evaluate(choices) == before
    opened.reload()
    opened.wait(f"!!document.querySelector('#blade table') && {CELLS}.length === 15")
    opened.wait(f"{CELLS}[7].value === {json.dumps(typed)}")
    file = tmp_path / "blade.csv"
    file.write_text(TABLE.replace("\t", ",").replace("200", "250"))
    node = opened.call("DOM.getDocument")["root"]["nodeId"]
    box = opened.call("DOM.querySelector", nodeId=node, selector="#blade-file")["nodeId"]
    opened.call("DOM.setFileInputFiles", nodeId=box, files=[str(file)])
    opened.wait(f"{CELLS}[7].value === '250' && !location.search.includes('draft=')")
    assert not opened.evaluate(f"!!{by_id('blade-reasons')}.innerText")
    for kind, hidden in (("dragover", "false"), ("dragleave", "true"), ("drop", "true")):
        drag = DRAG.format(kind=kind, text=json.dumps(file.read_text().replace("250", "260")))
        opened.wait(f"({drag}) === {hidden}")
    opened.wait(f"{CELLS}[7].value === '260'")
    assert opened.problems == []


@pytest.mark.slow
def test_a_blade_of_many_stations_outlives_a_reload(url):
    """By its address."""
    with page(url, 1440, 900) as opened:
        opened.wait(f"{READY} && {says('1st bending')}")
        shown = f"!!document.querySelector('#blade table') && {CELLS}.length === 5 * 49"
        opened.send("blade.preset", "nrel-5mw-blade", until=shown)
        opened.wait("location.search.includes('61.5') && location.search.length > 2000")
        opened.reload()
        opened.wait(shown)
        assert opened.problems == []


@pytest.fixture
def blade_page(opened) -> Page:
    """That page with a blade that spins up, a body and a spring at the root."""
    for action, value in (
        ("reset", None),
        ("blade.preset", "tapered-steel-blade"),
        ("blade.masses.add", None),
        ("blade.root", "spring"),
        ("spin_up", 20.0),
    ):
        opened.send(action, value)
    opened.catch_up()
    opened.wait(f"!!{by_id('blade-spring')}")
    return opened


def test_the_panel_of_a_blade_makes_the_page_no_longer(blade_page):
    """Though it has a hidden field in it."""
    blade_page.resize(1440, 620)
    assert blade_page.evaluate("document.documentElement.scrollHeight <= innerHeight")


def test_axe_finds_nothing_serious_in_the_panel_and_the_tab_loads(blade_page):
    """On a phone, with a wrong cell; letters of 14 px, targets of 44 px; nothing is wider than the
    phone."""
    load_axe(blade_page)
    blade_page.resize(390, 844)
    blade_page.send("dark", True)
    blade_page.wait("document.documentElement.dataset.theme === 'dark'")
    blade_page.evaluate(
        "document.querySelectorAll('#controls details').forEach(e => e.open = true)"
    )
    cell = f"{CELLS}[1]"
    blade_page.evaluate(
        f"{cell}.value = 'x'; {cell}.dispatchEvent(new Event('change', {{bubbles: true}}))"
    )
    blade_page.wait(f"{cell}.ariaInvalid === 'true' && !!{by_id('blade-reasons')}.innerText")
    blade_page.open_tab("loads")
    blade_page.wait(f"!{by_id('loads-moment')}.hidden")
    for part in ("#blade", "#tab-loads"):
        assert violations(blade_page, part) == []
        seen = f"[...document.querySelectorAll('{part} *')].filter(e => e.checkVisibility())"
        small = "parseFloat(getComputedStyle(e).fontSize) < 13.99 && e.innerText"
        assert blade_page.evaluate(f"{seen}.filter(e => {small}).map(e => e.outerHTML)") == []
        box = "(r => Math.min(r.width, r.height))(e.getBoundingClientRect())"
        narrow = f"e.matches('button, select, input, textarea, summary') && {box} < 43.5"
        wanted = f"{seen}.filter(e => !e.matches('.hidden') && {narrow}).map(e => e.outerHTML)"
        assert blade_page.evaluate(wanted) == []
    assert blade_page.evaluate("document.documentElement.scrollWidth") <= 390
    blade_page.send("undo")
    blade_page.wait(f"{cell}.value !== 'x'")


@pytest.mark.slow
def test_cells_that_are_typed_before_a_slow_server_has_answered_stay(blade_page):
    """The answer to one is without the next one, which goes with the one after that; it takes the
    words on the preset away, which stood above the table."""
    blade_page.send("blade.preset", "nrel-5mw-blade", until="!!document.querySelector('#blade p')")
    blade_page.catch_up()
    cells = [f"{CELLS}[{k}]" for k in (1, 2, 3)]
    texts = ["3.5", "12000", "90000"]
    with blade_page.slow_line():
        for cell, text in zip(cells, texts, strict=True):
            blade_page.evaluate(f"{cell}.focus(); {cell}.select()")
            blade_page.call("Input.insertText", text=text)
            blade_page.key("Tab")
            blade_page.evaluate("new Promise(done => setTimeout(done, 350))")
    blade_page.catch_up()
    assert blade_page.evaluate(f"document.activeElement === {CELLS}[4]")
    assert [blade_page.evaluate(f"{cell}.value") for cell in cells] == texts


def test_a_blade_without_units_becomes_uniform(guest):
    """By a button in the panel that is there then, which says that it is a blade."""
    shown(guest, "nrel-5mw-blade")
    guest.do("dimensionless", until=lambda _: guest.texts["blade"] == "")
    guest.wait(lambda _: "a blade of 49 stations" in guest.texts["real-beam"])
    assert 'data-do="blade.uniform"' in guest.texts["real-beam"]
    guest.do("blade.uniform")
    guest.shows(NREL.replace(units=None, blade=None))
    guest.wait(lambda _: "blade.uniform" not in guest.texts["real-beam"])


@pytest.mark.parametrize("name", ["nrel-5mw-blade", *slow("tapered-steel-blade")])
def test_every_column_of_a_blade_can_be_read(opened, name):
    """All of them are in view at once, where the panel is narrow in several lines; with every tab
    on a desktop. No number is cut: without the end of its power it would be another one."""
    opened.resize(1440, 900)
    opened.send("reset")
    opened.send("blade.preset", name, until=f"!!document.querySelector('#blade table') && {CELLS}")
    opened.send("blade.masses.add", until="document.querySelectorAll('.cells').length === 2")
    opened.send("plane", "both", until="!document.querySelector('#blade th.hidden')")
    opened.catch_up()
    tables = "[...document.querySelectorAll('#blade .cells')]"
    wide = f"{tables}.filter(e => e.scrollWidth > e.clientWidth).length"
    cut = "[...document.querySelectorAll('.cell')].filter(e => e.scrollWidth > e.clientWidth)"
    tabs = "document.querySelector('[role=tablist]')"
    assert opened.evaluate(f"{tabs}.scrollWidth <= {tabs}.clientWidth")
    for width in (1440, 1250, 1000, 390):
        opened.resize(width, 900)
        assert opened.evaluate(f"[{wide}, {cut}.length]") == [0, 0]
    opened.resize(1440, 900)


@pytest.mark.parametrize("name", PRESETS)
def test_each_blade_can_be_made_uniform(name):
    beam = made_uniform(PRESETS[name].beam)
    assert beam.is_prismatic
    assert beam.blade is None or beam.blade.twist is None
