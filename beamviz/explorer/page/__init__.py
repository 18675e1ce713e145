"""The page of one visitor: updates to it, actions from it, and the HTML of its controls and tables.

The page is HTML of our own around viser's scene (page.html, page.css, page.js). The server sends
scripts `beamviz.apply({...})` with the changes, and the page sends actions through one hidden text
control of viser, the bridge; both are declared in messages.py.
"""

import json
import math
import re
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

import msgspec
import numpy as np
from viser import ClientHandle, GuiEvent, ViserServer

from beamviz.beam import PARAMETERS
from beamviz.drawing import colours
from beamviz.drawing.text import Measure, strength_text
from beamviz.explorer.declarations import Tab
from beamviz.explorer.page.messages import decode_action, encode_update
from beamviz.files import package_text
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.server.log import RateLimitedLog
from beamviz.server.viser_private import private_control, run_script
from beamviz.solver.solution import GreatestStress
from beamviz.units import Units

ROOT = '<div id="root"></div>'  # of viser's page
STYLES = (
    "server/viser.css",
    "drawing/captions.css",
    "drawing/plain_scene.css",
    *(f"explorer/page/{name}.css" for name in ("page", "chart", "first_picture")),
)
SCRIPTS = (
    "server/webgl.js",
    "server/viser.js",
    "drawing/plain_scene.js",
    "drawing/captions.js",
    *(f"explorer/page/{name}.js" for name in ("page", "figure", "chart", "map", "sound")),
)
MAX_TEXT = 1000  # characters of a value
DIGITS = 6  # significant, of the numbers of a chart

# Outside tags: before a number; powers and roots as messages of the command line have them. A
# pattern that begins with what is looked for, not with what may not be before it, takes a
# twentieth of the time.
HYPHEN = re.compile(r"-(?<![\w.-]-)(?=\.?\d)(?![^<>]*>)")
POWER = re.compile(r"\^([234])(?!\d)(?![^<>]*>)")
SQRT = re.compile(r"sqrt(?<!\wsqrt)(?=\()(?![^<>]*>)")
RAISED = {"2": "²", "3": "³", "4": "⁴"}
SIGNS = {"point": "", "here": "◎", "measured": "◇"}  # of marks that are no events

REFUSED = "The server does not know this action: {}. It may be another version: reload the page."

Handler = Callable[[Any], None]
Data = dict[str, Any]  # of a chart, as chart.js takes it
Axes = tuple[Measure, Measure]
Choices = Iterable[str] | Mapping[Any, str]  # the values of a select element, or labels by value
Cells = Iterable[str]  # HTML
Path = tuple[str, ...]  # of a part of the page: its keys in an update
Content = dict[Path, Any]  # of the page, by path

log = RateLimitedLog(__name__)


class Action(NamedTuple):
    """What happens for an action of the page: see `Page.on`."""

    handler: Handler
    takes: Any
    max_text: int


def insert_page(
    viser_page: str,
    tabs: Mapping[str, Tab],
    styles: Iterable[str] = (),
    first_picture: str = "",
) -> str:
    """viser's page with our elements around its scene, our style and our scripts. tabs: by key, in
    their order; styles: names of the CSS files of features; first_picture: HTML in place of the
    scene until that has come."""
    of_features = (f"explorer/features/{name}" for name in styles)
    style, script = package_text(*STYLES, *of_features), package_text(*SCRIPTS)
    heads = views = panels = help_rows = ""
    for k, (key, tab) in enumerate(tabs.items()):
        help_rows += f"<tr><td>{tab.name}</td><td>{escape(tab.help)}</td></tr>"
        shown = {"id": f"tab-{key}", "aria_labelledby": f"to-{key}", "hidden": k > 0}
        panels += f'<div role="tabpanel" tabindex="0"{attributes(**shown)}>{tab.content}</div>'
        if not tab.beside:
            group = [tab, *(other for other in tabs.values() if other.beside == tab.name)]
            heads += head_of(tab, group, is_open=k == 0)
            views += views_of(group, is_open=k == 0) if len(group) > 1 else ""
    symbols = "".join(
        f"<tr><td>{parameter.symbol}</td><td>{parameter.label}</td><td>{parameter.formula}</td></tr>"
        for parameter in PARAMETERS.values()
    )
    parts = {"tabs": heads, "views": views, "panels": panels, "symbols": symbols, "help": help_rows}
    parts["first_picture"] = first_picture
    markup = package_text("explorer/page/page.html").format(**parts)
    elements = f"<style>{style}</style>{markup}<script>{script}</script>"
    return viser_page.replace(ROOT, elements).replace("<title>Viser<", "<title>beamviz<")


def head_of(tab: Tab, group: Iterable[Tab], *, is_open: bool) -> str:
    """The head (HTML) of a tab and its other views."""
    return button(
        tab.name,
        id=f"to-{tab.key}",
        role="tab",
        aria_selected=is_open,
        aria_controls=f"tab-{tab.key}",
        data_panels=" ".join(f"tab-{view.key}" for view in group),
        tabindex=None if is_open else -1,
        hidden=tab.is_aside and not is_open,
        data_aside="" if tab.is_aside else None,
    )


def views_of(group: Sequence[Tab], *, is_open: bool) -> str:
    """The buttons (HTML) that choose one of the views of a tab, the first one its own."""
    first, *_ = group
    buttons = "".join(
        button(
            view.view,
            id=None if view is first else f"to-{view.key}",
            class_="quiet",
            data_panel=f"tab-{view.key}",
            aria_pressed=view is first,
        )
        for view in group
    )
    shown = attributes(aria_label=f"Views of {first.name}", data_of=f"to-{first.key}")
    hidden = "" if is_open else " hidden"
    return f'<div class="views" role="group"{shown}{hidden}>{buttons}</div>'


def choose_theme(side: ClientHandle | ViserServer, *, dark: bool) -> None:
    """Set viser's dark or light theme, without its own buttons."""
    side.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)


# Contents of the page


def html(id: str, content: str) -> Content:
    """HTML of the element with this id, as it is printed. Text in it must be escaped."""
    return {("html", id): typeset(content)}


def typeset(text: str) -> str:
    """A text, or HTML, as it is printed: with a minus sign before each negative number, not a
    hyphen, raised powers, as in kg/m³, and √ for sqrt; attributes, the values of fields among them,
    and names with digits stay."""
    text = POWER.sub(lambda match: RAISED[match[1]], HYPHEN.sub("\u2212", text))
    return SQRT.sub("√", text)


def value(key: str, shown: Any) -> Content:
    """A value shown by all controls with data-set="key"."""
    return {("values", key): shown}


def props(key: str, **changes: Any) -> Content:
    """Attributes (aria_label= for aria-label) of the elements with data-set="key" and of the
    element with the id `key`; False or None removes an attribute."""
    named = {name.strip("_").replace("_", "-"): change for name, change in changes.items()}
    return {("props", key, name): change for name, change in named.items()}


def faded(words: str, *ids: str) -> Content:
    """Mark elements, by their ids, that show an earlier result, which the words say; "" for none
    that does."""
    marks = (props(id, data_outdated=words or None) for id in ids)
    return {path: change for mark in marks for path, change in mark.items()}


def chart(id: str, data: Data) -> Content:
    """A chart or a map in the element with this id (chart.js, map.js)."""
    return {("charts", id, name): part for name, part in data.items()}


def names(content: Content) -> set[str]:
    """The ids and keys of the elements and controls that contents are of."""
    return {path[1] if len(path) > 1 else path[0] for path in content}


class Page:
    """Sends changes to the page, those between two messages at once, and handles its actions.

    wake: tells the frame loop that an action was handled; sent: the content of the page, by path;
    waiting: what the next message will change; touched: paths of what the visitor has set in the
    page, which may not be what the state has; handled: the number of the last action.
    """

    def __init__(self, client: ClientHandle, wake: Callable[[], None]):
        self.client, self.wake, self.lock = client, wake, threading.Lock()
        self.actions: dict[str, Action] = {}
        self.sent: Content = {}
        self.waiting: Content = {}
        self.touched: set[Path] = set()
        self.handled = 0
        self.bridge = client.gui.add_text("bridge", "", visible=False)
        self.bridge.on_update(self.received)
        self.send(private_control(self.bridge), "bridge")

    # To the page

    def show(self, content: Content) -> None:
        """Show contents: send those that differ from what was sent."""
        for path, part in content.items():
            if self.sent.get(path, self) != part:
                self.sent[path] = part
                if path == ("dark",):
                    choose_theme(self.client, dark=part)
                self.send(part, *path)

    def show_again(self) -> None:
        """Send what the visitor has set once more, so that an invalid choice is corrected."""
        if self.touched:
            self.send(self.handled, "handled")
        for path in self.touched & self.sent.keys():
            self.send(self.sent[path], *path)
        self.touched.clear()

    def point(self, *keys: str) -> None:
        """Highlight controls, by their keys or ids, and open the sections that contain them."""
        self.send(keys, "point")

    def focus(self, id: str) -> None:
        """Give the element with this id, a field, the focus, and select its text."""
        self.send(id, "focus")

    def say(self, text: str, error: bool = False) -> None:
        """Announce a text to screen readers; an error is also shown for some seconds."""
        announced = {"text": typeset(text), "error": error}
        self.queue(lambda said: said if announced in said else [*said, announced], [], "say")

    def send(self, content: Any, *path: str) -> None:
        """Queue a part of the page, by its keys in the argument of `beamviz.apply` (page.js)."""
        self.queue(lambda _: content, None, *path)

    def queue(self, change: Callable[[Any], Any], usual: Any, *path: str) -> None:
        """Queue `change` of what is queued for a part of the page, `usual` where nothing is; from
        any thread."""
        with self.lock:
            queued = bool(self.waiting)
            self.waiting[path] = change(self.waiting.get(path, usual))
        if not queued:
            run_script(self.client, self.script)

    def script(self) -> str:
        """The script with all queued changes."""
        with self.lock:
            waiting, self.waiting = self.waiting, {}
        update: dict[str, Any] = {}
        for (*parents, name), content in waiting.items():
            inside = update
            for key in parents:
                inside = inside.setdefault(key, {})
            inside[name] = content
        try:
            return f"beamviz.apply({encode_update(update)})"
        except msgspec.ValidationError as error:
            log.error("message", list(waiting), error)
            raise

    # From the page

    def on(
        self, action: str, handler: Handler, takes: Any = None, *, max_text: int = MAX_TEXT
    ) -> None:
        """Declare an action of the page: `handler` is called with the value of each, in order, on
        the event loop, so it must be quick. takes: the type of the value, None without one;
        max_text: its most characters. What is not declared is refused."""
        self.actions[action] = Action(handler, takes, max_text)

    async def received(self, event: GuiEvent) -> None:
        """Call the handler of an action; refuse one that is not declared, or has another value."""
        action = ""
        try:
            self.handled, action, chosen = decode_action(self.bridge.value)
            handler, takes, max_text = self.actions[action]
            msgspec.convert(chosen, takes)
            if len(str(chosen)) > max_text:
                raise ValueError(f"{action} with {str(chosen)[:40]}")
        except (ValueError, KeyError, msgspec.MsgspecError) as error:
            visitor = f"visitor {event.client_id}"
            log.warn(visitor, "action", f"an unknown action was ignored: {str(error)[:80]}")
            self.say(REFUSED.format(action[:40]), error=True)
            self.send(self.handled, "handled")
            if (shown := ("values", action)) in self.sent:
                self.send(self.sent[shown], *shown)
            return
        self.touched.add(("open",) if action == "tab" else ("values", action))
        handler(chosen)
        self.wake()  # also where the state stays, and the control is to show that again


# Data of charts


def sent(values: np.ndarray) -> list[float | None]:
    """Numbers (n,) for JSON: rounded, None for nan and infinity."""
    return [float(f"{x:.{DIGITS}g}") if math.isfinite(x) else None for x in values.tolist()]


def axis_data(measure: Measure, ends: tuple[float, float], *, log: bool = False) -> Data:
    names = {"label": measure.label, "symbol": measure.symbol, "unit": measure.unit}
    return {**names, "range": [float(measure.factor * end) for end in ends], "log": log}


def frequency_axis(measure: Measure, ends: tuple[float, float]) -> Data:
    label = f"frequency [{measure.unit}]" if measure.unit else f"frequency {measure.label}"
    return axis_data(measure._replace(label=label), ends)


def mark(key: str, kind: str, axes: Axes, at: tuple[float, float], text: str, **to: Any) -> Data:
    """A mark of a chart at a point; action=, value=: what a click on it sends. The sign of a kind
    is the same in charts, keys and lists."""
    x, y = (float(measure.factor * place) for measure, place in zip(axes, at, strict=True))
    shown = {
        "kind": kind,
        "style": mark_style(kind),
        "sign": sign(kind),
        "text": typeset(text),
    }
    return {"key": key, **shown, "x": x, "y": y, **to}


def mark_style(kind: str) -> str:
    """The CSS classes of a mark. Those of "limit point" and "second state" are one word, lest they
    get the styles of the marks "point" and of lines "second"."""
    return f"mark {kind.replace(' ', '-')}"


def keys(lines: Iterable[Data], marks: Iterable[Data] = ()) -> list[Data]:
    """The key of a chart: the styles of its lines, by their first word, and the kinds of marks."""
    labelled = [line for line in lines if line["label"] and not line.get("second")]
    styles = dict.fromkeys(run[2].split()[0] for line in labelled for run in line["runs"])
    styled = [(f"line {style}", style) for style in styles]
    if any(line.get("second") for line in lines):
        styled.append(("line second", "compared with"))
    kinds = dict.fromkeys(mark["kind"] for mark in marks)
    return [
        *({"style": style, "text": text} for style, text in styled),
        *({"style": mark_style(kind), "text": kind, "sign": sign(kind)} for kind in kinds),
    ]


def sign(kind: str) -> str:
    """The sign of a kind of event; of a kind without one a neutral one."""
    return EVENT_KINDS[kind].sign if kind in EVENT_KINDS else SIGNS.get(kind, "•")


# HTML of controls


def attributes(**values: Any) -> str:
    """Attributes as HTML: aria_label= becomes aria-label, disabled=True has no value, None and
    False are left out, data_value= and values other than strings become JSON."""
    text = ""
    for name, value in values.items():
        name = name.strip("_").replace("_", "-")
        if isinstance(value, bool) and not name.startswith(("aria-", "data-")):
            text += f" {name}" if value else ""
        elif value is not None:
            plain = isinstance(value, str) and name != "data-value"
            text += f' {name}="{escape(value if plain else json.dumps(value))}"'
    return text


def button(label: str, **values: Any) -> str:
    """A button: data_do= names its action or data_set= the value that it sets, to data_value=."""
    return f'<button type="button"{attributes(**values)}>{escape(label)}</button>'


def hint(name: str, text: str, key: str = "") -> str:
    """A question mark that opens an explanation of `name`; "" without one. key: of the control,
    where others may have the same name."""
    if not text:
        return ""
    id = "hint-" + "".join(c if c.isalnum() else "-" for c in key or name)
    mark = button("?", class_="hint", popovertarget=id, aria_label=f"About {name}")
    return f'{mark}<span popover id="{id}">{escape(text)}</span>'


def number_box(id: str, key: str, **values: Any) -> str:
    """A field for a number, with a decimal point or comma (page.js)."""
    usual = {"class_": "number", "inputmode": "decimal", "autocomplete": "off"}
    return f'<input type="text"{attributes(id=id, data_set=key, **usual, **values)}>'


def slider(key: str, label: str, help: str = "", **values: Any) -> str:
    """A slider with its label and a number field; values: min=, max=, step= of the slider."""
    box = number_box(f"{key}-field", key, aria_label=label)
    bar = attributes(id=f"{key}-slider", data_set=key, **values)
    name = f'<label for="{key}-slider" id="{key}-label">{escape(label)}</label>'
    name += hint(label, help, key)
    inputs = f'{box}<input type="range"{bar}>'
    return f'<div class="field" id="{key}-row"><span class="name">{name}</span>{inputs}</div>'


def checkbox(key: str, label: str, help: str = "") -> str:
    box = f'<input type="checkbox"{attributes(data_set=key)}>'
    name = f'<label class="check">{box}{escape(label)}</label>'
    return f'<div class="row">{name}{hint(label, help, key)}</div>'


def options(choices: Choices) -> str:
    """The options of a select element."""
    labels = choices if isinstance(choices, Mapping) else {name: name for name in choices}
    parts = (f"<option{attributes(value=key)}>{escape(labels[key])}</option>" for key in labels)
    return "".join(parts)


def select(key: str, label: str, choices: Choices, help: str = "", id: str = "") -> str:
    """A select element with its label."""
    id = id or f"{key}-select"
    name = f'<label for="{id}">{escape(label)}</label>{hint(label, help, key)}'
    box = f'<select id="{id}" data-set="{key}">{options(choices)}</select>'
    return f'<div class="field"><span class="name">{name}</span>{box}</div>'


def group(name: str, *parts: str, **values: str) -> str:
    """A row of controls (HTML) with the accessible name `name`."""
    named = attributes(aria_label=name, **{"class_": "row", **values})
    return f'<div role="group"{named}>{"".join(parts)}</div>'


# HTML of texts


def note(text: str) -> str:
    """A paragraph about a missing or incomplete result; "" for no text."""
    return f'<p class="note">{escape(text)}</p>' if text else ""


def strength(found: GreatestStress | None, units: Units | None) -> str:
    """A paragraph about the greatest stress, a warning beyond the yield stress; "" where it is not
    known, or nothing is loaded."""
    if found is None or not found.pascals:
        return ""
    own = attributes(class_="yields" if found.yields else None)
    return f"<p{own}>{escape(strength_text(found, units))}</p>"


def chart_tab(tools: str, chart: str, *lists: str, hidden: bool = True, over: str = "") -> str:
    """The skeleton of a tab: its controls (HTML), and by their ids its chart and its lists, below
    the chart or, on wide pages, below the controls beside it; over: what lies over the chart, HTML.
    """
    parts = "".join(f'<div id="{id}"></div>' for id in lists)
    beside = f'<div class="tools">{tools}</div><div class="lists">{parts}</div>'
    figure = f'<div id="{chart}" class="chart" data-chart{" hidden" if hidden else ""}></div>'
    wait = waiting_place(f"{chart}-wait")
    return f'<div class="chart-tab"><div class="beside">{beside}</div>{wait}{figure}{over}</div>'


def waiting_place(id: str) -> str:
    """The place for what is said of a first result that is being computed."""
    return f'<div id="{id}" class="wait"></div>'


def table(name: str, heads: Cells, rows: Iterable[Cells], caption: str = "", **values: str) -> str:
    """A table of cells with the accessible name `name` and a caption (HTML)."""
    title = f"<caption>{caption}</caption>" if caption else ""
    head = "".join(f'<th scope="col">{heading}</th>' for heading in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    named = attributes(aria_label=name, **values)
    return f"<table{named}>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def polyline(x: np.ndarray, y: np.ndarray, kind: str, **values: Any) -> str:
    """A line (SVG) of a CSS class through points [px]."""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return f"<polyline{attributes(class_=kind, points=points, **values)}/>"


def colour_scale(title: str, anchors: tuple[colours.RGB, ...], *ends: str) -> str:
    """A colour map with its title and the values at its ends."""
    values = "".join(f"<span>{end}</span>" for end in ends)
    stops = ", ".join(f"rgb{colour}" for colour in anchors)
    bar = f'<div class="colours" style="background:linear-gradient(90deg, {stops})"></div>'
    return f'<span>{escape(title)}</span>{bar}<div class="ends">{values}</div>'
