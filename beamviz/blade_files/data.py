"""What a file of a blade says."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple


class BladeData(NamedTuple):
    """The values of a file, by the keywords of `Beam.from_si`."""

    values: Mapping[str, Any]
    has_fractions: bool = False  # whether its stations are fractions of the length
    left_out: tuple[str, ...] = ()  # what it has, or its program computes, and this model does not
    blade_file: Path | None = None  # the file that has the stations, relative to this one
    factors: Mapping[str, float] = {}  # by which those of that file are multiplied
