"""A scene as data: a beam, its model, what to see of it and from where; as TOML."""

import json
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self

from beamviz.beam import (
    LIMITS,
    SI_KEYS,
    Beam,
    Units,
    checked,
    known,
    parsed_toml,
    read_toml,
    si_keywords,
    whole,
)
from beamviz.errors import InvalidInput
from beamviz.solver import OPTIONS, Problem, solve_many
from beamviz.view_options import MAX_SHARES, Look

FAR = 1000.0  # beam lengths; no camera is further away
HEADING = """\
# A scene of beamviz: `beamviz serve FILE`, `beamviz screenshot OUT.png --scene FILE`.
# Every key may be left out. shares: how much of mode 1, 2 ... is shown.
"""


@dataclass(frozen=True)
class Camera:
    """Where one looks from and at, in beam lengths from the middle of the scene: x along the
    beam, z along the axis of rotation."""

    position: tuple[float, float, float]
    look_at: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, point in asdict(self).items():
            if not isinstance(point, list | tuple) or len(point) != 3:
                raise InvalidInput(f"{name} = {point!r}: must be three numbers")
            object.__setattr__(self, name, tuple(checked(name, x, -FAR, FAR) for x in point))
        if self.position == self.look_at:
            raise InvalidInput(f"position = {list(self.position)}: must differ from look_at")


def names(kind: type) -> tuple[str, ...]:
    """The fields of a dataclass."""
    return tuple(entry.name for entry in fields(kind))


# The tables of a file and their keys. No key is in two of [beam], [model], [look], [camera] and
# [chart], so that a link and `SavedScene.of` need no tables; [si] stands for [beam] and [units].
TABLES = {
    "beam": tuple(LIMITS),
    "model": tuple(name for name in OPTIONS if name != "modes"),
    "look": (*names(Look), "mode"),
    "camera": names(Camera),
    "chart": ("over", "per_rev"),
    "units": names(Units),
    "si": tuple(SI_KEYS),
}
OWN = ("units", "si")  # not among the keys of a scene
KEYS = tuple(key for table, keys in TABLES.items() if table not in OWN for key in keys)


@dataclass(frozen=True)
class SavedScene:
    """Everything that makes a scene of the explorer, and a picture or film of it.

    options: keywords of `solve` that describe the model; camera: None fits the beam into the
    picture; over, per_rev: axis of the loci chart, and whether it has per-rev lines.
    Raises InvalidInput for whatever makes no sense.
    """

    beam: Beam = field(default_factory=Beam)
    options: dict[str, Any] = field(default_factory=dict)
    look: Look = field(default_factory=Look)
    camera: Camera | None = None
    over: str = "gamma"
    per_rev: bool = False

    def __post_init__(self) -> None:
        known(self.options, TABLES["model"], "the model")
        options = {key: self.options.get(key, getattr(Problem, key)) for key in TABLES["model"]}
        solve_many([], **options)  # which checks them
        object.__setattr__(self, "options", options)
        if self.over not in LIMITS:
            raise InvalidInput(f"over = {self.over!r}: must be one of {', '.join(LIMITS)}")
        if not isinstance(self.per_rev, bool):
            raise InvalidInput(f"per_rev = {self.per_rev!r}: must be true or false")

    @classmethod
    def of(cls, beam: Beam | None = None, **values: Any) -> Self:
        """A scene by its keys: of(alpha=1, gamma=10, coriolis=True, mode=3, dark=True)."""
        return cls(beam or Beam()).changed(**values)

    def changed(self, **values: Any) -> Self:
        """With other values of some keys; `mode` (from 1) shows that mode alone."""
        known(values, KEYS, "a scene")
        own = {
            table: {key: values[key] for key in keys if key in values}
            for table, keys in TABLES.items()
        }
        return replace(
            self,
            beam=self.beam.replace(**own["beam"]),
            options={**self.options, **own["model"]},
            look=seen(self.look, own["look"]),
            camera=placed(self.camera, own["camera"]),
            **own["chart"],
        )

    @property
    def tables(self) -> dict[str, dict[str, Any]]:
        """Every key with its value, by table."""
        return {
            "beam": self.beam.numbers,
            "units": filled(self.beam.units),
            "model": {key: value for key, value in self.options.items() if value is not None},
            "look": asdict(self.look),
            "camera": filled(self.camera),
            "chart": {"over": self.over, "per_rev": self.per_rev},
        }

    def to_toml(self) -> str:
        """The scene as the text of a TOML file."""
        return HEADING + "".join(
            f"\n[{table}]\n"
            + "".join(f"{key} = {json.dumps(value)}\n" for key, value in it.items())
            for table, it in self.tables.items()
            if it
        )

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """The scene in a TOML file; InvalidInput names the file and what is wrong in it."""
        return cls.from_tables(read_toml(Path(path)), str(path))

    @classmethod
    def from_bytes(cls, text: bytes, name: str) -> Self:
        """The scene in what a file called `name` holds."""
        return cls.from_tables(parsed_toml(text, name), name)

    @classmethod
    def from_tables(cls, tables: dict[str, Any], name: str) -> Self:
        """The scene in the tables of a file called `name`."""
        known(tables, TABLES, name)
        for table, values in tables.items():
            if not isinstance(values, dict):
                raise InvalidInput(f"{name}: {table} = {values!r}: must be a table [{table}]")
            known(values, TABLES[table], f"{name} [{table}]")
        values = {k: v for table in tables if table not in OWN for k, v in tables[table].items()}
        try:
            return cls.of(measured(tables), **values)
        except InvalidInput as error:
            raise InvalidInput(f"{name}: {error}") from None


def seen(look: Look, values: dict[str, Any]) -> Look:
    """`look` with other values of some keys, of which `mode` stands for shares."""
    if "mode" in values:
        if "shares" in values:
            raise InvalidInput("mode and shares exclude each other")
        mode = whole("mode", values.pop("mode"), 1, MAX_SHARES)
        look = look.only(mode - 1)
    return replace(look, **values)


def placed(camera: Camera | None, values: dict[str, Any]) -> Camera | None:
    """`camera` with other values of some keys."""
    if not values:
        return camera
    if camera is None and "position" not in values:
        raise InvalidInput("the camera has a look_at but no position")
    return Camera(**{**filled(camera), **values})


def measured(tables: dict[str, Any]) -> Beam:
    """The beam of SI units in the tables of a file, or the usual one, with its units."""
    if "si" in tables:
        if other := {"beam", "units"} & set(tables):
            raise InvalidInput(f"[si] and [{min(other)}] exclude each other")
        return Beam.from_si(**si_keywords(tables["si"], "[si]"))
    units = tables.get("units", {})
    if not units:
        return Beam()
    for key in ("length", "time"):
        if key not in units:
            raise InvalidInput(f"[units] misses {key}")
    for key, value in units.items():
        if checked(key, value, 0.0, float("inf")) == 0:
            raise InvalidInput(f"{key} = 0: must be above 0")
    return Beam(units=Units(**units))


def filled(entry: Any) -> dict[str, Any]:
    """The fields of a dataclass that have a value."""
    return {k: v for k, v in asdict(entry).items() if v is not None} if entry else {}
