"""Kinds of events: each is complete, and its events are what charts and files take them for."""

import importlib
import json
import math
import pkgutil
import re
import unicodedata
from pathlib import Path

import numpy as np
import pytest
from helpers import slow
from matplotlib.markers import MarkerStyle
from matplotlib.text import Text

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.exports.chart_files import SceneLoci
from beamviz.exports.html_page import chart as exported_chart
from beamviz.frequency_loci import Loci, events, loci
from beamviz.frequency_loci.events import EVENT_COLUMNS, EVENT_KINDS, KINDS
from beamviz.frequency_loci.events.record import EventKind
from beamviz.output.loci import events_csv, loci_json, loci_table
from beamviz.plotting.loci import draw_chart
from beamviz.scene import Scene

REFERENCE = (Path(__file__).parents[2] / "assets" / "reference.md").read_text()
TIP = Beam(alpha=1, beta=1)
FOLDING = Beam(4.656, 1, 5.341, -0.09663, 194.4)
BENT = {"state": "stable", "modes": 2, "strain": "biot", "curvature": "material"}
CHARTS = {  # by kind, a chart with an event of it: beam, parameter, first and last value, options
    "crossing": (TIP, "gamma", 0, 10, {}),
    "veering": (TIP, "gamma", 0, 8, {"coriolis": True}),
    "close approach": (
        *(Beam(alpha=0.5, gamma=6, delta=0.5, mu=40), "beta", 0.37, 0.47),
        {"coriolis": True, "modes": 9},
    ),
    "coalescence": (Beam(alpha=1, mu=1000), "spin_up", 0, 150, {"state": "stable", "modes": 2}),
    "buckling": (Beam(delta=-1), "gamma", 0, 5, {"state": "stable"}),
    "limit point": (FOLDING, "spin_up", 0, 0.3, BENT),
    "second state": (FOLDING, "spin_up", 0, 0.3, BENT),
    "resonance": (TIP, "gamma", 0, 8, {"per_rev": 3}),
}
each_kind = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
LONG = ("coalescence", "limit point", "second state")  # also in test_growth and test_limits
each_chart = pytest.mark.parametrize(
    "kind",
    [kind for kind in KINDS if kind.name not in LONG]
    + slow(*(kind for kind in KINDS if kind.name in LONG)),
    ids=lambda kind: kind.name,
)


COMPUTED: list[tuple[tuple, Loci]] = []  # what is asked for in CHARTS, and the chart


def chart(name: str) -> Loci:
    """The chart with an event of a kind; kinds with the same one share it."""
    assert name in CHARTS, f"{name}: CHARTS has no chart with such an event"
    for asked, computed in COMPUTED:
        if asked == CHARTS[name]:
            return computed
    beam, over, start, stop, options = CHARTS[name]
    COMPUTED.append((CHARTS[name], loci(beam, over, np.linspace(start, stop, 21), **options)))
    return COMPUTED[-1][1]


def test_every_module_of_a_kind_is_listed():
    """A kind that KINDS does not list is not looked for."""
    for module in pkgutil.iter_modules(events.__path__, f"{events.__name__}."):
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, EventKind):
                assert value in KINDS, f"{module.name}: add {name} to KINDS"


def test_names_and_signs_are_different():
    for mark in ("name", "sign"):
        marks = [getattr(kind, mark) for kind in KINDS]
        assert len({*marks}) == len(marks), f"two kinds have one {mark}: {marks}"


@each_kind
def test_the_reference_has_every_kind_with_its_fields(kind):
    """In the table of kinds, and among the keys of an event."""
    assert f"| `{kind.name}` | {kind.meaning} |" in REFERENCE, (
        f"assets/reference.md: the table of kinds lacks the row of {kind.name!r}"
    )
    (keys,) = re.findall(r"^\| `events` .*$", REFERENCE, re.MULTILINE)
    for field in kind.fields:
        assert f"`{field.name}`" in keys, f"assets/reference.md: `events` lacks {field.name!r}"


@each_kind
def test_the_sign_of_an_event_is_its_marker(kind):
    """The character on the page and the marker of matplotlib are the same mark: both name their
    shapes, as BLACK DIAMOND and (filled) diamond."""
    shape, _, direction = MarkerStyle.markers[kind.marker].partition("_")
    name = unicodedata.name(kind.sign)
    assert {"x": "MULTIPLICATION"}.get(shape, shape.upper()) in name
    assert direction.upper() in name
    assert kind.filled == ("BLACK" in name)


@each_chart
def test_every_kind_is_located_and_written(kind):
    """In its chart, with the numbers of its fields; in JSON, CSV, the table and the picture."""
    computed = chart(kind.name)
    located = [event for event in computed.events if event.kind == kind.name]
    assert located, f"CHARTS[{kind.name!r}] has no such event"
    for event in located:
        assert len(event.branches) == len(event.frequencies) == len(event.modes)
        assert all(math.isfinite(getattr(event, field.name)) for field in kind.fields)
    records = [r for r in json.loads(loci_json(computed))["events"] if r["kind"] == kind.name]
    assert [r["at"] for r in records] == [event.at for event in located]
    assert all(tuple(r)[: len(EVENT_COLUMNS)] == EVENT_COLUMNS for r in records)
    assert events_csv(computed).count(f"\n{kind.name},") == len(located)
    assert loci_table(computed).count(kind.name) >= len(located)
    figure = draw_chart(computed, range(1, computed.tracked.per_rev + 1))
    words = " ".join(text.get_text() for text in figure.findobj(match=Text))
    assert kind.name in words


@each_chart
def test_lines_are_drawn_through_the_events(kind):
    """A frequency of a branch at an event is that of a point near it, without a spike."""
    computed = chart(kind.name)
    for event in (event for event in computed.events if event.kind == kind.name):
        for label, frequency in zip(event.branches, event.frequencies, strict=True):
            if frequency is None or label not in {b.label for b in computed.branches}:
                continue
            y = computed[label].frequency
            k = int(np.clip(np.searchsorted(computed.values, event.at), 1, len(y) - 1))
            beside = y[max(k - 2, 0) : k + 2]
            steps = np.ptp(beside[np.isfinite(beside)])
            away = np.nanmin(abs(beside - frequency))
            assert away <= 1.5 * steps + 1e-9, (event, beside)


def test_kinds_are_chosen_by_name():
    """By default all but those on request; an unknown one is refused with the names."""
    values = np.linspace(0, 8, 11)
    assert loci(TIP, "gamma", values).kinds == tuple(k.name for k in KINDS if not k.on_request)
    chosen = loci(TIP, "gamma", values, per_rev=1, kinds=["veering"], coriolis=True)
    assert chosen.kinds == ("veering", "resonance")
    assert {event.kind for event in chosen.events} == {"veering", "resonance"}
    without = loci(TIP, "gamma", values, kinds=["veering"])
    assert "crossing" not in loci_table(without)
    with pytest.raises(InvalidInput, match=r"crosing': must be one of crossing, .*'crossing'"):
        loci(TIP, "gamma", values, kinds=["crosing"])
    with pytest.raises(InvalidInput, match="resonance: needs per_rev"):
        loci(TIP, "gamma", values, kinds=["resonance"])


def test_the_exported_page_explains_its_signs():
    """Those of the events in its chart."""
    scene = Scene(TIP.replace(gamma=5), {"coriolis": True})
    html, kinds = exported_chart(scene), {event.kind for event in SceneLoci.of(scene).first.events}
    assert "veering" in kinds
    for kind in EVENT_KINDS.values():
        explained = f'title="{kind.meaning}">{kind.sign} {kind.name}<' in html
        assert explained == (kind.name in kinds), kind.name
