"""A scene as data: the beam, its model, the view options and the camera; as TOML and as a link."""

import json
import math
import re
import tomllib
from collections import ChainMap
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self
from urllib.parse import parse_qsl, urlencode

from beamviz.beam import NUMBERS, Beam, from_record
from beamviz.chart_ranges import CHART_AXES
from beamviz.checks import check_choice, check_float, check_floats, check_int, check_positive
from beamviz.errors import InvalidInput
from beamviz.input_files import check_keys, errors_of_file, parse_toml, read_small
from beamviz.measured import COLUMNS, measured_columns
from beamviz.si import FILE_KEYS, SI_KEYS, VALUE_UNITS, PhysicalBeam, check_si_table
from beamviz.solver.problem import OPTIONS, parse_keywords
from beamviz.units import Units

MODES = 5  # solved for a scene, and more where its view shows more
MAX_DISTANCE = 1000.0  # of the camera, in beam lengths
COLOURINGS = ("displacement", "axial strain")
PER_REV = (1, 2, 3, 4, 5, 6)  # multiples of the speed in a chart
MAX_AMPLITUDE = 0.4
MAX_PACE = 4.0
UPPER_LIMITS = {"pace": MAX_PACE, "amplitude": MAX_AMPLITUDE}
MAX_SHARES = 20
MAX_LINK = 7000  # characters: common servers and proxies accept addresses of 8000
MAX_TITLE = 100  # characters
# Second beams: one that is given, or one made of the first in the explorer.
GIVEN = "earlier"
SECOND_BEAMS = (GIVEN, "ancf", "coriolis", "mass", "effects")
LINK_DIGITS = 15  # significant, of values in SI
BARE_KEY = re.compile("[A-Za-z0-9_-]+")  # of TOML; others are quoted
TOML_HEADER = """\
# A scene of beamviz: `beamviz serve FILE`, `beamviz screenshot OUT.png --scene FILE`.
# Every key is optional. shares: the contribution of mode 1, 2 ... to the motion, each 0 .. 1.
"""


@dataclass(frozen=True)
class Camera:
    """Position and target of the camera [beam lengths] from the middle of the scene, each within
    1000: x along the beam, z along the axis of rotation. Raises InvalidInput."""

    position: tuple[float, float, float]
    look_at: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, point in asdict(self).items():
            if not isinstance(point, list | tuple) or len(point) != 3:
                raise InvalidInput(f"{name} = {point!r}: must be three numbers")
            checked = check_floats(name, point, -MAX_DISTANCE, MAX_DISTANCE)
            object.__setattr__(self, name, checked)
        if self.position == self.look_at:
            raise InvalidInput(f"position = {list(self.position)}: must differ from look_at")


@dataclass(frozen=True)
class Second:
    """A second beam that is drawn with that of a scene. Raises InvalidInput."""

    beam: Beam | None = None  # None for that of the scene
    options: dict[str, Any] = field(default_factory=dict)  # of the model, unlike in the scene
    title: str = "before"  # the text beside it
    stacked: bool = False  # whether it is above the first beam, not overlaid
    # How the explorer makes it of the first beam; GIVEN: it stays as it is when that changes.
    choice: str = GIVEN

    def __post_init__(self) -> None:
        check_keys(self.options, LINKED["model"], "the model of the second beam")
        check_bool("stacked", self.stacked)
        check_choice("choice", self.choice, SECOND_BEAMS)
        title: Any = self.title
        if not isinstance(title, str) or len(title) > MAX_TITLE:
            raise InvalidInput(f"title = {title!r}: must be a text, {MAX_TITLE} characters at most")

    @property
    def table(self) -> dict[str, Any]:
        """It as a table of a scene file."""
        table: dict[str, Any] = {key: getattr(self, key) for key in ("choice", "title", "stacked")}
        if self.beam:
            table |= {"beam": self.beam.record, "units": without_none(self.beam.units)}
        return table | {"model": {k: v for k, v in self.options.items() if v is not None}}

    @classmethod
    def of_table(cls, table: Mapping[str, Any], folder: Path | None) -> Self:
        """The second beam of a table of a scene file. Raises InvalidInput."""
        values = {key: table[key] for key in ("choice", "title", "stacked") if key in table}
        inner = {key: table[key] for key in ("beam", "units", "si", "model") if key in table}
        for name, entries in inner.items():
            if not isinstance(entries, dict):
                raise InvalidInput(f"second.{name} = {entries!r}: must be a table")
            check_keys(entries, TABLES[name], f"[second.{name}]")
        beam = None
        if inner.keys() - {"model"}:
            first = beam_with_units(inner, folder)
            beam = first.replace(**from_record(inner.get("beam", {})))
        return cls(beam, inner.get("model", {}), **values)


@dataclass(frozen=True)
class ViewOptions:
    """Options of the drawing of a beam and its motion. Raises InvalidInput, which names the option,
    its value and the values allowed."""

    shares: tuple[float, ...] = (0.0, 1.0)  # contributions of mode 1, 2 ..., each 0 .. 1
    amplitude: float = 0.15  # largest displacement drawn [beam lengths], 0 .. 0.4
    playing: bool = True
    pace: float = 1.0  # playback speed, 0 .. 4 times the default
    rotating_frame: bool = True  # whether the camera rotates with the hub
    colouring: str = COLOURINGS[0]  # "displacement" or "axial strain"
    ghosts: bool = True  # whether the undeformed beam and its equilibrium are drawn
    nodes: bool = True  # whether vibration nodes are marked
    tip_path: bool = False  # whether the curve that the free end runs through is drawn
    forces: bool = False  # whether tension and forces of inertia are drawn
    thicken: bool = False  # whether a slender beam is drawn thicker
    all_modes: bool = False  # whether each mode has its row
    dark: bool = False  # whether the colours are dark

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = check_option(entry.name, entry.default, getattr(self, entry.name))
            object.__setattr__(self, entry.name, value)

    def changed(self, name: str, value: Any) -> Self:
        """With one option set by a browser: numbers are clamped, an invalid value is ignored."""
        old = getattr(self, name)
        if name in UPPER_LIMITS:
            value = clip(value, UPPER_LIMITS[name], old)
        changes: dict[str, Any] = {name: bool(value) if isinstance(old, bool) else value}
        try:
            return replace(self, **changes)
        except InvalidInput:
            return self

    def share(self, mode: int, value: Any) -> Self:
        """With the share of one mode (0-based) changed."""
        shares = list(self.shares) + [0.0] * (mode + 1 - len(self.shares))
        shares[mode] = clip(value, 1.0, shares[mode])
        return replace(self, shares=tuple(shares))

    def only(self, mode: int) -> Self:
        """With one mode (0-based) shown alone."""
        return replace(self, shares=(0.0,) * mode + (1.0,), all_modes=False)


def check_option(name: str, default: Any, value: Any) -> Any:
    """`value` as the view option `name`, of the type of its default. Raises InvalidInput."""
    if isinstance(default, bool):
        return check_bool(name, value)
    if isinstance(default, float):
        return check_float(name, value, 0.0, UPPER_LIMITS[name])
    if isinstance(default, str):
        return check_choice(name, value, COLOURINGS)
    if not isinstance(value, list | tuple) or len(value) > MAX_SHARES:
        raise InvalidInput(f"{name} = {value!r}: must be a list of at most {MAX_SHARES} numbers")
    return check_floats(name, value, 0.0, 1.0)


def check_bool(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise InvalidInput(f"{name} = {value!r}: must be true or false")
    return value


def check_per_rev(value: Any) -> tuple[int, ...]:
    """Multiples of the speed in ascending order, all of PER_REV for true. Raises InvalidInput."""
    if isinstance(value, bool):
        return PER_REV if value else ()
    if not isinstance(value, list | tuple) or any(multiple not in PER_REV for multiple in value):
        listed = ", ".join(map(str, PER_REV))
        raise InvalidInput(f"per_rev = {value!r}: must be true, false or a list of {listed}")
    return tuple(sorted({int(multiple) for multiple in value}))


def clip(value: Any, upper: float, old: float) -> float:
    """`value` clamped to 0 .. upper; `old` if it is not a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return old
    return min(max(float(value), 0.0), upper)


STRUCTURE = ("blade", "masses", "root")  # of a beam that is not uniform, as in `Beam.record`
UNIFORM: dict[str, Any] = {"blade": {}, "masses": [], "root": math.inf}  # as a link has it
# The tables of a file and their keys. The keys of LINKED are unique, so that a link and `Scene.of`
# need no tables; [si] replaces both [beam] and [units].
LINKED = {
    "beam": (*NUMBERS, *STRUCTURE),
    "model": tuple(name for name in OPTIONS if name != "modes"),
    "view": (*ViewOptions.__dataclass_fields__, "mode"),
    "camera": tuple(Camera.__dataclass_fields__),
    "chart": ("over", "per_rev"),
}
TABLES = {
    **LINKED,
    "units": tuple(Units.__dataclass_fields__),
    "si": tuple(FILE_KEYS),
    "second": ("choice", "title", "stacked", "beam", "units", "si", "model"),
    "measured": COLUMNS,
}
KEYS = tuple(key for keys in LINKED.values() for key in keys)


@dataclass(frozen=True)
class Scene:
    """All data of a picture or film of the explorer. Raises InvalidInput for a value out of range
    and for an unknown option."""

    beam: Beam = field(default_factory=Beam)
    options: dict[str, Any] = field(default_factory=dict)  # keywords of `solve`: the model
    view: ViewOptions = field(default_factory=ViewOptions)
    camera: Camera | None = None  # None fits the beam into the picture
    over: str = "gamma"  # the abscissa of the loci chart
    per_rev: tuple[int, ...] = ()  # multiples of the speed in it; True for all of PER_REV
    second: Second | None = None  # a beam drawn with it
    # Measured frequencies of the beam: columns by name, as for `adjust`; {} without any.
    measured: dict[str, list[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_keys(self.options, LINKED["model"], "the model")
        options = {key: self.options.get(key, OPTIONS[key].default) for key in LINKED["model"]}
        parse_keywords(**options)  # checks them
        if self.second:
            parse_keywords(**options | self.second.options)
        object.__setattr__(self, "options", options)
        check_choice("over", self.over, CHART_AXES)
        object.__setattr__(self, "per_rev", check_per_rev(self.per_rev))
        if self.measured:
            object.__setattr__(self, "measured", measured_columns(self.beam, self.measured))

    @classmethod
    def of(cls, beam: Beam | None = None, **values: Any) -> Self:
        """A scene by its keys, as in of(gamma=10, coriolis=True, mode=3). Raises InvalidInput."""
        return cls(beam or Beam()).changed(**values)

    def changed(self, **values: Any) -> Self:
        """With other values of some keys; `mode` (1-based) shows that mode alone."""
        check_keys(values, KEYS, "a scene")
        by_table = {
            table: {k: values[k] for k in keys if k in values} for table, keys in LINKED.items()
        }
        return replace(
            self,
            beam=self.beam.replace(**from_record(by_table["beam"])),
            options={**self.options, **by_table["model"]},
            view=change_view(self.view, **by_table["view"]),
            camera=change_camera(self.camera, by_table["camera"]),
            **by_table["chart"],
        )

    @property
    def solver_options(self) -> dict[str, Any]:
        """Keywords of `solve` for this scene: its model and the number of modes."""
        return {**self.options, "modes": max(MODES, len(self.view.shares))}

    @property
    def second_scene(self) -> Self:
        """The scene of the second beam alone, of which nothing is measured; its own where there is
        none."""
        if self.second is None:
            return self
        beam, options = self.second.beam or self.beam, self.options | self.second.options
        return replace(self, beam=beam, options=options, second=None, measured={})

    @property
    def tables(self) -> dict[str, dict[str, Any]]:
        """All keys with their values, by table."""
        return {
            "beam": self.beam.record,
            "units": without_none(self.beam.units),
            "model": {key: value for key, value in self.options.items() if value is not None},
            "view": asdict(self.view),
            "camera": without_none(self.camera),
            "chart": {"over": self.over, "per_rev": self.per_rev},
            "second": self.second.table if self.second else {},
            "measured": self.measured,
        }

    def to_toml(self) -> str:
        """The scene as the text of a TOML file."""
        tables = (toml_table(f"[{name}]", values) for name, values in self.tables.items())
        return "".join([TOML_HEADER, *tables])

    def to_query(self, base: Self | None = None, without: Collection[str] = ()) -> str:
        """The query of a link to the scene, which `Scene.from_query` reads: the keys, except those
        of `without`, whose values differ from those of `base`; in SI for a real beam. Raises
        InvalidInput for a blade of too many stations."""
        base, beam = base or type(self)(), self.beam
        tables, others = self.tables, base.tables
        spinless = {"spin_up": 0.0}  # which a table does not list
        values = spinless | {k: v for name in LINKED for k, v in tables[name].items()}
        usual = spinless | {k: v for name in LINKED for k, v in others[name].items()}
        if beam != base.beam and (si := rounded(beam.si)):
            values = {key: value for key, value in values.items() if key not in LINKED["beam"]}
            values = si | values
            usual |= dict.fromkeys(si.keys() - {"root_stiffness"}, 0.0)
            usual["mass_position"] = si["length"]
        else:
            values |= {key: UNIFORM[key] for key in UNIFORM if key in usual and key not in values}
        shares = self.view.shares
        if shares != base.view.shares and self.view.only(len(shares) - 1).shares == shares:
            values["mode"] = len(shares)
            del values["shares"]
        changed = {k: v for k, v in values.items() if v != usual.get(k) and k not in without}
        texts = {k: v if isinstance(v, str) else inline_toml(v) for k, v in changed.items()}
        query = urlencode(texts, safe="[],{}=")
        if len(query) > MAX_LINK:
            raise InvalidInput(
                f"a link to this beam has {len(query)} characters, more than the {MAX_LINK} that"
                " every server takes; save it as a scene file"
            )
        return query

    @classmethod
    def from_query(cls, query: dict[str, Any], base: Self | None = None) -> Self:
        """`base` with the values of a link's query (see `parse_query`). Raises InvalidInput."""
        base = base or cls()
        in_si = any(key in SI_KEYS and key not in LINKED["beam"] for key in query)
        si = {key: value for key, value in query.items() if in_si and key in SI_KEYS}
        if si:
            physical = PhysicalBeam.of(check_si_table(si, "the link"))
            base = replace(base, beam=Beam.of_physical(physical))
        return base.changed(**{key: value for key, value in query.items() if key not in si})

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """The scene in a TOML file. Raises InvalidInput, which names the file and the mistake, and
        warns as `Beam.from_si`."""
        scene = cls.from_bytes(read_small(path), str(path), Path(path).parent)
        scene.beam.warn_of_doubts(stacklevel=3)
        return scene

    @classmethod
    def from_bytes(cls, text: bytes, name: str, folder: Path | None = None) -> Self:
        """The scene in the contents of a TOML file with a name. folder: of its file of stations,
        which it may not name where none is given. Raises InvalidInput."""
        return cls.from_tables(parse_toml(text, name), name, folder)

    @classmethod
    def from_tables(cls, tables: dict[str, Any], name: str, folder: Path | None = None) -> Self:
        """The scene of tables as a scene file has them; name: of the file, in errors. Raises
        InvalidInput."""
        check_keys(tables, TABLES, name)
        for table, values in tables.items():
            if not isinstance(values, dict):
                raise InvalidInput(f"{name}: {table} = {values!r}: must be a table [{table}]")
            if table not in ("si", "measured"):  # whose keys are checked with their units
                check_keys(values, TABLES[table], f"{name} [{table}]")
        values = ChainMap(*(tables[table] for table in tables.keys() & LINKED.keys()))
        with errors_of_file(name, VALUE_UNITS):
            beam = beam_with_units(tables, folder)
        with errors_of_file(name):
            second = Second.of_table(tables["second"], folder) if "second" in tables else None
            measured = tables.get("measured", {})
            return replace(cls.of(beam, **values), second=second, measured=measured)


def toml_table(heading: str, values: dict[str, Any]) -> str:
    """A table as the text of TOML, a key on each line, followed by the tables in it; "" if it is
    empty."""
    name, lines, inner = heading.strip("[]"), [f"\n{heading}\n"], []
    for key, value in values.items():
        if isinstance(value, dict):
            inner.append(toml_table(f"[{name}.{key}]", value))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            inner += [toml_table(f"[[{name}.{key}]]", entry) for entry in value]
        else:
            bare = key if BARE_KEY.fullmatch(key) else json.dumps(key)
            lines.append(f"{bare} = {toml_value(value)}\n")
    return "".join([*lines, *inner]) if values else ""


def toml_value(value: Any) -> str:
    """A text, number, truth or list as TOML: as JSON, but for what that escapes otherwise."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def inline_toml(value: Any) -> str:
    """A value in TOML on one line, without spaces."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}={inline_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(inline_toml, value)) + "]"
    is_number = not isinstance(value, float) or math.isfinite(value)
    return json.dumps(value) if is_number else str(value)


def rounded(value: Any) -> Any:
    """A value with its numbers rounded to LINK_DIGITS: those calculated from dimensionless ones
    become the short ones that they were made of."""
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [rounded(entry) for entry in value]
    return float(f"{value:.{LINK_DIGITS}g}") if isinstance(value, float) else value


def parse_query(query: str) -> dict[str, Any]:
    """The keys and values of a query like "alpha=1&mode=3": each value as in TOML, or else the text
    itself. Raises InvalidInput if it has more keys than a scene."""
    try:
        most = 2 * (len(KEYS) + len(SI_KEYS))
        pairs = parse_qsl(query, keep_blank_values=True, max_num_fields=most)
    except ValueError:
        raise InvalidInput(f"a scene has no more than {most} keys") from None
    return {key: parse_value(text) for key, text in pairs}


def parse_value(text: str) -> Any:
    """The value of a text in TOML, or else the text itself."""
    try:
        values = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError):
        return text
    return values["value"] if len(values) == 1 else text


def change_view(view: ViewOptions, mode: Any = None, **values: Any) -> ViewOptions:
    """`view` with other values of some keys; mode (1-based): shown alone, replaces shares."""
    if mode is not None:
        if "shares" in values:
            raise InvalidInput("mode and shares exclude each other")
        view = view.only(check_int("mode", mode, 1, MAX_SHARES) - 1)
    return replace(view, **values)


def change_camera(camera: Camera | None, values: dict[str, Any]) -> Camera | None:
    if not values:
        return camera
    if camera is None and "position" not in values:
        raise InvalidInput("the camera has a look_at but no position")
    return Camera(**{**without_none(camera), **values})


def beam_with_units(tables: dict[str, Any], folder: Path | None) -> Beam:
    """The beam of the table [si], or the default beam with the units of the table [units]."""
    if "si" in tables:
        if other := {"beam", "units"} & set(tables):
            raise InvalidInput(f"[si] and [{min(other)}] exclude each other")
        physical = PhysicalBeam.of(check_si_table(tables["si"], "[si]", folder))
        return Beam.of_physical(physical)
    units = tables.get("units", {})
    if not units:
        return Beam()
    for key in ("length", "time"):
        if key not in units:
            raise InvalidInput(f"[units]: missing key {key!r}")
    return Beam(units=Units(**{key: check_positive(key, value) for key, value in units.items()}))


def without_none(entry: Any) -> dict[str, Any]:
    """The fields of a dataclass that have a value; {} for None."""
    return {k: v for k, v in asdict(entry).items() if v is not None} if entry else {}


# The scene of the explorer if no other one is given.
START = Scene.of(
    alpha=1.0,
    beta=0.5,
    gamma=5.0,
    shares=[1.0, 1.0],
    rotating_frame=False,
    pace=0.5,  # a turn in 5 s: the mass that is to be dragged can be taken as it passes
)
