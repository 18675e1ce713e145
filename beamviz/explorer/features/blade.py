"""The panel of a blade: tables of its stations and bodies, its root, and its properties as a
chart."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from html import escape
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.blade import Blade
from beamviz.blade_files import Text, format_of
from beamviz.drawing.text import RAISED, Measure, si_text
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.blade_table import (
    MASSES,
    STATIONS,
    Column,
    Draft,
    Pasted,
    Rows,
    Wrong,
    beam_of,
    draft_of,
    draft_of_text,
    has_only_numbers,
    parse_stations,
    sorted_rows,
    text_of,
    text_of_draft,
    with_mass,
    with_station,
    without,
    wrong_entries,
    wrong_order,
)
from beamviz.explorer.declarations import Key, choice
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.real_beam import (
    ALONG,
    AS_AT_ROOT,
    BUTTONS,
    MATERIALS,
    OPEN_FILE,
    STEEL_BEAM,
    RealBeamState,
    in_tables,
    load,
    with_sizes,
)
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, Refused, Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.input_files import MAX_TOML_BYTES
from beamviz.presets import PRESETS, Preset
from beamviz.si import BY_SECTION, INEXTENSIBLE, PhysicalBeam
from beamviz.tables import plural

TABLES = {"stations": STATIONS, "masses": MASSES}
PASTE, FILE = "blade.paste", "blade.file"
BETWEEN_FILES = "\x1c"  # a separator of files, as page.js sends several
ROOTS = {"clamped": "clamped", "hinged": "hinged", "spring": "spring"}
MOST = 3  # reasons shown
EXPONENT = re.compile(r"(-?\d+(?:\.\d+)?)e(-?\d+)")
POWER = re.compile(f" × 10([{''.join(map(chr, RAISED.values()))}]+)")
LOWERED = {raised: digit for digit, raised in RAISED.items()}
POINTS = 17  # of a line in a segment of the blade


def read_draft(text: Any) -> Draft:
    """The tables of a blade as typed, of a link. Raises InvalidInput."""
    draft = draft_of_text(text) if isinstance(text, str) else None
    if draft is None:
        raise InvalidInput("draft: must be the tables of a blade, as a page of beamviz writes them")
    return draft


@dataclass(frozen=True)
class BladeState(Slice):
    """What is typed in the panel."""

    # The tables, while they describe no beam, or one that has not all of their rows. They have no
    # room beside those of a long blade.
    draft: Draft | None = field(
        default=None,
        metadata=choice(
            key=Key("draft", read_draft, text_of_draft, is_long=True), until=("scene",)
        ),
    )


class BladePanel(Feature):
    """The panel, in place of that of a uniform beam, where properties vary, there are more bodies,
    or the root is not clamped; or where the kind of section is ALONG."""

    style = "blade.css"
    state = BladeState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.added = ""  # the id of the cell that is to have the focus once it is on the page
        on = partial(self.page.on, max_text=2 * MAX_TOML_BYTES)
        for name in TABLES:
            on(f"blade.{name}", partial(self.type, name), str)
            on(f"blade.{name}.remove", partial(self.remove, name), int)
            on(f"blade.{name}.add", partial(self.add, name))
        on(
            "blade.stations.sort",
            lambda _: self.edit(
                lambda draft, _: draft._replace(stations=sorted_rows(draft.stations))
            ),
        )
        on("blade.root", self.choose_root, str)
        on(
            "blade.spring",
            lambda value: self.edit(lambda draft, _: draft._replace(root=str(value))),
            float,
        )
        on(PASTE, self.paste, str)
        on(FILE, self.open, str)
        on("blade.preset", self.choose, str)
        on("blade.begin", self.begin)
        on("blade.uniform", lambda _: load(visitor, "", uniform, then=with_sizes("")))

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        if not is_shown(state):
            return hidden_content()
        case = state.case
        return (
            tables_content(case, state.slice(BladeState).draft)
            | numbers_content(case.nearest_beam())
            | reasons_content(case, state.slice(BladeState).draft, state.refused)
            | chart_content(case)
        )

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Give a row that was added the focus, in the message that has it."""
        if self.added:
            self.page.focus(self.added)
            self.added = ""

    # Edits

    def edit(
        self,
        change: Callable[[Draft, PhysicalBeam], Draft],
        others: Mapping[str, Any] = MappingProxyType({}),
        start: Beam | None = None,
    ) -> None:
        """Show the beam of changed tables; or keep them as they are typed, with the reasons.
        others: SI values of the beam beside the tables; start: the beam whose tables are changed,
        in place of one without a size."""
        visitor = self.visitor
        with visitor.lock:
            state = visitor.state
            physical = physical_of(state) or (start.physical if start else None)
            if physical is None:
                return
            physical = with_values(physical, others)
            try:
                draft = change(state.slice(BladeState).draft or draft_of(physical), physical)
            except InvalidInput as error:
                refused = Refused("blade", "", str(error))
                visitor.change(lambda state: replace(state, refused=refused))
                return
            try:
                beam = None if wrong_entries(draft) else beam_of(draft, physical)
            except InvalidInput:
                beam = None
            if beam is None:
                shown = partial(with_draft, draft=draft)
                load(visitor, "", lambda beam: beam if beam.physical else start or beam, then=shown)
                return
            kept = None if has_rows(beam, draft) else draft
            load(visitor, "", lambda _: beam, then=partial(with_draft, draft=kept))

    def type(self, name: str, text: Any) -> None:
        """Take a table as the page sends it: the texts of its cells, the last ones of which may be
        left out."""
        columns, rows = len(TABLES[name]), rows_sent(str(text))
        if all(len(row) <= columns for row in rows):
            padded = tuple((*row, *[""] * (columns - len(row))) for row in rows)
            self.edit(lambda draft, _: with_rows(draft, name, padded))

    def add(self, name: str, _: Any) -> None:
        """Add a station or a body, whose first cell gets the focus."""

        def change(draft: Draft, beam: PhysicalBeam) -> Draft:
            if name == "stations":
                rows, k = with_station(draft.stations)
            else:
                rows, k = with_mass(draft.masses, beam), len(draft.masses)
            self.added = cell_id(name, k, 0)
            return with_rows(draft, name, rows)

        self.edit(change)

    def remove(self, name: str, k: Any) -> None:
        self.edit(lambda draft, _: with_rows(draft, name, removed(name, getattr(draft, name), k)))

    def choose_root(self, kind: Any) -> None:
        """Clamp or hinge the root, or hold it by a spring, at first as stiff as E I / L."""

        def change(draft: Draft, beam: PhysicalBeam) -> Draft:
            if kind == root_kind(draft.root) or kind not in ROOTS:
                return draft
            spring = text_of(beam.bending_stiffness[0] / beam.length)
            return draft._replace(root={"clamped": "", "hinged": "0", "spring": spring}[kind])

        self.edit(change)

    def paste(self, text: Any) -> None:
        """Take a table from elsewhere; where it is none, say why, and keep its text."""
        try:
            self.take([Text("the file", without_powers(str(text)))])
        except InvalidInput as error:
            refused = Refused(PASTE, str(text), str(error))
            self.visitor.change(lambda state: replace(state, refused=refused))

    def open(self, files: Any) -> None:
        """Take files that are given at once, each with its name and its contents from line 2 on,
        also while another panel is shown; where one is no blade, say why."""
        parts = (file.partition("\n") for file in str(files).split(BETWEEN_FILES))
        texts = [Text(name, content) for name, _, content in parts]
        with self.visitor.reporting("The file was not opened"):
            for file in texts:
                if len(file.text) > MAX_TOML_BYTES:
                    raise InvalidInput(f"{file.name}: larger than {MAX_TOML_BYTES} bytes")
                if not has_only_numbers(file):
                    format_of(file)  # raises for none
            self.take(texts)

    def take(self, texts: list[Text]) -> None:
        """Show the blade of texts from elsewhere. Raises InvalidInput where they are none."""
        physical = physical_of(self.visitor.state)
        pasted = parse_stations(texts, physical.length if physical else STEEL_BEAM.values["length"])

        def change(draft: Draft, beam: PhysicalBeam) -> Draft:
            draft = draft._replace(stations=sorted_rows(pasted.rows))
            return draft._replace(masses=pasted.masses) if pasted.others else draft

        self.edit(change, pasted.others, start=STEEL_BEAM.beam)
        self.page.say(said_of(pasted), error=bool(pasted.stretched))

    def choose(self, name: Any) -> None:
        """Show a preset; an unknown one changes nothing."""
        if name in tuple(PRESETS):
            load(self.visitor, "", lambda _: PRESETS[name].beam, then=with_sizes(ALONG))

    def begin(self, _: Any) -> None:
        """Show the table of the beam, of the steel beam where its size is not known."""
        beam = STEEL_BEAM.beam
        load(self.visitor, "", lambda old: old if old.physical else beam, then=with_sizes(ALONG))


def with_values(physical: PhysicalBeam, others: Mapping[str, Any]) -> PhysicalBeam:
    """The beam with the hub, speed, pitch and mass at the tip of a file that says all of these."""
    if not others:
        return physical
    given = PhysicalBeam.of({**BY_SECTION, **others})
    names = ("hub_radius", "rotation_speed", "pitch", "mass")
    values = {name: getattr(given, name) for name in names}
    return replace(physical, **values, mass_position=physical.length)


def said_of(pasted: Pasted) -> str:
    """What is said of stations that were read."""
    text = f"{plural(len(pasted.rows), 'station')} read"
    if pasted.left_out:
        text += f"; the model leaves out {', '.join(pasted.left_out)}"
    if pasted.stretched:
        text += (
            f"; they are fractions of the length, here of the beam before,"
            f" {si_text(pasted.stretched, 'm', 4)}: with the main file opened at once, length, hub"
            " and speed are those of the blade"
        )
    return text


def with_draft(state: State, draft: Draft | None) -> State:
    """With these tables as typed, None for those of the beam, in the panel."""
    return with_sizes(ALONG)(state.with_values(BladeState, draft=draft))


def has_rows(beam: Beam, draft: Draft) -> bool:
    """Whether the tables of a beam have the rows of a draft: a uniform one has two stations."""
    physical = beam.physical
    return physical is not None and len(physical.stations) == len(draft.stations)


def with_rows(draft: Draft, name: str, rows: Rows) -> Draft:
    """With other rows in the table "stations" or "masses"."""
    return draft._replace(stations=rows) if name == "stations" else draft._replace(masses=rows)


def removed(name: str, rows: Rows, k: Any) -> Rows:
    """Without row k; a blade keeps two stations."""
    if name == "stations" and len(rows) <= 2:
        raise InvalidInput("a blade has at least two stations, at its root and its tip")
    return without(rows, k)


def uniform(beam: Beam) -> Beam:
    """The clamped beam with the section at the root throughout and at most one concentrated mass;
    without a size, as stiff in both planes. In SI units its material is that of the nearest speed
    of sound, which its stiffnesses do not tell."""
    physical = beam.physical
    if physical is None:
        return beam.replace(blade=None, masses=(), root=math.inf)
    m, EI, EA = (
        row[0]
        for row in (physical.mass_per_length, physical.bending_stiffness, physical.axial_stiffness)
    )

    def distance(material: dict[str, float]) -> float:
        return abs(math.log(material["youngs_modulus"] / material["density"] / (EA / m)))

    E = min(MATERIALS.values(), key=distance)["youngs_modulus"]
    ends, flap = (0.0, physical.length), physical.flap_stiffness
    return Beam.of_physical(
        replace(
            physical,
            stations=ends,
            mass_per_length=(m, m),
            bending_stiffness=(EI, EI),
            axial_stiffness=(EA, EA),
            flap_stiffness=flap and (flap[0], flap[0]),
            twists=None,
            degree=1,
            density=m * E / EA,
            youngs_modulus=E,
            masses=(),
            root_stiffness=math.inf,
        )
    )


# Readings


def physical_of(state: State) -> PhysicalBeam | None:
    """The beam in SI; None where a number is out of range or its size is not known."""
    try:
        return state.case.beam.physical
    except InvalidInput:
        return None


def is_shown(state: State) -> bool:
    """Whether the panel is that of a blade."""
    case = state.case
    has_size = bool(case.units and case.units.mass)
    return has_size and in_tables(case.nearest_beam(), state.slice(RealBeamState).section)


# The panel


def hidden_content() -> Content:
    """Nothing, in place of the panel."""
    texts = page.html("blade", "") | page.html("blade-numbers", "") | page.html("blade-reasons", "")
    return texts | page.value(PASTE, "") | page.props("blade-chart", hidden=True)


def tables_content(case: Case, draft: Draft | None) -> Content:
    """The tables: as they are typed, where the beam has no such tables. They do not depend on the
    speed, which a slider moves."""
    mu = case.nearest_beam().mu
    physical = Beam(mu=mu, **case.structure).physical
    assert physical
    tables = draft or draft_of(physical)
    wrong = wrong_entries(tables) if draft else []
    in_space = case.options["plane"] == "both"
    content = page.html("blade", panel(physical, tables, wrong, in_space))
    for name in TABLES:
        content |= page.value(f"blade.{name}", sent_text(getattr(tables, name)))
    content |= page.value("blade.root", root_kind(tables.root))
    return content | page.value("blade.spring", tables.root)


def sent_text(rows: Rows) -> str:
    """The cells of a table as the page takes and sends them."""
    return "\n".join("\t".join(map(with_power, row)) for row in rows)


def rows_sent(text: str) -> Rows:
    """The cells of a table that the page sends: the inverse of `sent_text`."""
    return tuple(tuple(line.split("\t")) for line in without_powers(text).split("\n"))


def with_power(cell: str) -> str:
    """A number as the page writes it: "1.8 × 10⁹" for "1.8e9"; another text as it is."""
    number = EXPONENT.fullmatch(cell)
    return f"{number[1]} × 10{number[2].translate(RAISED)}" if number else cell


def without_powers(text: str) -> str:
    """A text with its numbers as they are before `with_power`."""
    return POWER.sub(lambda number: f"e{number[1].translate(LOWERED)}", text)


def root_kind(root: str) -> str:
    """The key in ROOTS of a root."""
    if not root:
        return "clamped"
    return "hinged" if root == "0" else "spring"


def panel(physical: PhysicalBeam, tables: Draft, wrong: list[Wrong], in_space: bool) -> str:
    """The tables, the root, and buttons."""
    preset = next((one for one in PRESETS.values() if is_made_from(one, physical)), None)
    about = [text for text in (preset.source, preset.left_out) if text] if preset else []
    between = "Linear between stations; a station named twice is a jump."
    if physical.degree > 1:
        between = f"Between stations: polynomials of degree {physical.degree}."
    whole = np.trapezoid(physical.mass_per_length, physical.stations)
    spring = ""
    if root_kind(tables.root) == "spring":
        box = page.number_box("blade-spring", "blade.spring")
        label = '<label for="blade-spring">stiffness [N m/rad]</label>'
        spring = f'<div class="field">{label}{box}</div>'
    plane = page.button("in plane", data_set="plane", data_value="chordwise")
    plane += page.button("out of plane", data_set="plane", data_value="flapwise")
    masses = table("masses", tables.masses, wrong, in_space) if tables.masses else ""
    return (
        '<details class="real" open><summary>Blade</summary>'
        f'<div class="choices">{BUTTONS}'
        f"{AS_AT_ROOT}"
        f"{page.button('dimensionless', data_do='dimensionless')}</div>"
        f"{''.join(f'<p>{escape(text)}</p>' for text in about)}"
        '<div id="blade-chart" class="chart" data-chart></div>'
        f"{table('stations', tables.stations, wrong, in_space)}"
        '<div id="blade-reasons" role="status"></div>'
        f"<p>{between} Mass of the blade: {si_text(float(whole), 'kg', 4)}.</p>"
        f'<div class="choices">{page.button("add a station", data_do="blade.stations.add")}'
        f"{OPEN_FILE}</div>{PASTE_BOX}{masses}"
        f'<div class="choices">{page.button("add a mass", data_do="blade.masses.add")}</div>'
        f"{page.select('blade.root', 'root', ROOTS)}{spring}"
        f"{page.group('Vibration', '<span>Vibration</span>', plane)}"
        '<div id="blade-numbers"></div></details>'
    )


def is_made_from(preset: Preset, physical: PhysicalBeam) -> bool:
    """Whether the stations of a beam are those of a preset, to the digits shown."""
    of_preset = preset.beam.physical
    return of_preset is not None and draft_of(of_preset).stations == draft_of(physical).stations


def numbers_content(beam: Beam) -> Content:
    """The dimensionless numbers, and values that are likely in another unit."""
    assert beam.units
    text = (
        f"<p>γ = {beam.gamma:.4g}, μ = {beam.mu:.4g}, T* = {si_text(beam.units.time, 's', 4)}</p>"
    )
    if properties := beam.mass_properties:
        mass, centre = si_text(properties.mass, "kg", 4), si_text(properties.centre, "m", 4)
        inertia = si_text(properties.second_moment_about_axis, "kg m²", 4)
        text += (
            f"<p>mass {mass}, centre of mass {centre} from the root, moment of inertia about the"
            f" axis of rotation {inertia}</p>"
        )
    return page.html("blade-numbers", "".join(map(page.note, beam.doubts)) + text)


def reasons_content(case: Case, draft: Draft | None, refused: Refused | None) -> Content:
    """Why the tables describe no beam, and why the last entry was refused."""
    wrong = reasons_of(draft, case) if draft else []
    reasons, entry = [*wrong], ""
    if refused and refused.key.startswith("blade"):
        reasons.append(refused.reason)
        entry = refused.entry
    more = len(reasons) - MOST
    reasons = [*reasons[:MOST], *([f"and {more} more"] if more > 0 else [])]
    text = "".join(map(page.note, reasons))
    if draft and wrong_order(draft.stations) and sorted_rows(draft.stations) != draft.stations:
        text += page.button("sort the stations", data_do="blade.stations.sort")
    text += "<p>Until then the scene shows the beam before.</p>" if wrong else ""
    return page.html("blade-reasons", text) | page.value(PASTE, entry)


def reasons_of(draft: Draft, case: Case) -> list[str]:
    """What is wrong in each cell, or with the beam as a whole."""
    reasons = [one.reason for one in wrong_entries(draft)]
    try:
        physical = case.beam.physical
        if physical and not reasons:
            beam_of(draft, physical)
    except InvalidInput as error:
        reasons = [str(error)]
    return reasons


HEADS = ", ".join(column.head for column in STATIONS)
PASTE_BOX = (
    "<details><summary>Paste a table</summary>"
    f'<label for="blade-paste">Columns: {HEADS}; EA, flap EI and twist may be left out. With a'
    " line of names, as EI or mass_per_length, in any order and unit. Or the whole text of a blade"
    " file of ElastoDyn, BModes, HAWC2 or FLEX.</label>"
    f'<textarea id="blade-paste" data-set="{PASTE}" rows="4" spellcheck="false"></textarea>'
    "</details>"
)


def table(name: str, rows: Rows, wrong: list[Wrong], in_space: bool) -> str:
    """A table of fields; the page fills them, and sends all of them when one changes. The twist is
    shown where there is one, or the beam bends in both planes."""
    columns = TABLES[name]
    at = {(one.row, one.column) for one in wrong if one.table == name}
    hidden = {
        k
        for k, column in enumerate(columns)
        if column.key == "twist" and not (in_space or any(row[k].strip() for row in rows))
    }

    def hiding(k: int) -> str:
        return ' class="hidden"' if k in hidden else ""

    heads = "".join(
        f'<th scope="col"{hiding(k)}>{head_html(column)}</th>' for k, column in enumerate(columns)
    )
    body = "".join(
        f"<tr><td>{remove_button(name, i)}</td>"
        + "".join(
            f"<td{hiding(k)}>{cell(name, i, k, (i, k) in at)}</td>" for k in range(len(columns))
        )
        + "</tr>"
        for i in range(len(rows))
    )
    own = page.attributes(aria_label=name, data_set=f"blade.{name}", data_paste=PASTE)
    return (
        f'<div class="cells"><table{own}><thead><tr><td></td>{heads}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def head_html(column: Column) -> str:
    return f"{escape(column.label)} <br>[{column.unit}]"


def cell_id(name: str, row: int, k: int) -> str:
    return f"{name}-{row}-{k}"


def cell(name: str, row: int, k: int, is_wrong: bool) -> str:
    column, title = TABLES[name][k], "station" if name == "stations" else "mass"
    own = page.attributes(
        id=cell_id(name, row, k),
        type="text",
        class_="cell",
        inputmode="decimal",
        autocomplete="off",
        aria_label=f"{column.head} of {title} {row + 1}",
        aria_invalid=True if is_wrong else None,
        aria_describedby="blade-reasons" if is_wrong else None,
    )
    return f"<input{own}>"


def remove_button(name: str, row: int) -> str:
    title = "station" if name == "stations" else "mass"
    own = {"data_do": f"blade.{name}.remove", "data_value": row, "class_": "quiet"}
    return page.button("×", aria_label=f"remove {title} {row + 1}", **own)


# The chart


class Line(NamedTuple):
    """The label, style and name of a property."""

    label: str
    style: str
    name: str


LINES = {
    "mass": Line("m", "mixed", "mass"),
    "bending": Line("EI", "bending", "EI"),
    "flap": Line("flap", "method-4", "flap EI"),
    "axial": Line("EA", "stretching", "EA"),
}
UNIFORM = Blade((0.0, 1.0), (1.0, 1.0), (1.0, 1.0), (1.0, 1.0))


def chart_content(case: Case) -> Content:
    """The properties along the span, each over its value at the root."""
    assert case.units
    stretches = case.numbers["mu"] != INEXTENSIBLE
    data = properties_data(case.blade or UNIFORM, case.units.length, stretches)
    return page.props("blade-chart", hidden=False) | page.chart("blade-chart", data)


def properties_data(blade: Blade, length: float, stretches: bool = True) -> page.Data:
    """The chart of the properties along a span of some length [m]; the axial stiffness only of a
    beam that stretches."""
    place = np.linspace(0, 1, 2 if blade.degree == 1 else POINTS)
    x = np.concatenate([part.start + (part.stop - part.start) * place for part in blade.segments])
    at, lines, top = page.sent(length * x), [], 1.0
    is_given = {"flap": blade.flap is not None, "axial": stretches}
    names = [name for name in LINES if is_given.get(name, True)]
    for name in names:
        y = np.concatenate([part.polynomials[name](place) for part in blade.segments])
        y = y / y[0]
        top = max(top, float(y.max()))
        run = [0, len(x) - 1, LINES[name].style, ""]
        lines.append({"label": LINES[name].label, "at": at, "y": page.sent(y), "runs": [run]})
    return {
        "name": "Properties along the span, over those at the root",
        "x": page.axis_data(Measure("position [m]", "x", "m"), (0.0, length)),
        "y": page.axis_data(Measure("relative to the root", ""), (0.0, 1.08 * top)),
        "at": at,
        "lines": lines,
        "marks": [],
        "keys": [{"style": f"line {LINES[n].style}", "text": LINES[n].name} for n in names],
    }
