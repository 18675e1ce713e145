"""What travels between server and page is one declared set of messages, on both sides."""

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import msgspec
import pytest
from helpers import load_script
from live.coarse import coarse_charts
from live.server import wait_until
from live.visitor import PAGE, catch_up

from beamviz.explorer import links, page
from beamviz.explorer.feature import tabs
from beamviz.explorer.page import SCRIPTS, messages
from beamviz.files import package_text
from beamviz.lessons import NAMES

TYPES = load_script("message_types")


def test_the_types_of_the_page_are_those_of_the_server():
    """messages.d.ts is written from messages.py, offline.d.ts from offline_data.py."""
    assert TYPES.PATH.read_text() == TYPES.declarations()
    assert TYPES.OFFLINE.read_text() == TYPES.offline_declarations()


def test_an_update_has_the_declared_types():
    """A part that is not declared, or not in this form, is refused, before it is sent."""
    assert json.loads(messages.encode_update({"html": {"work": ""}})) == {"html": {"work": ""}}
    for wrong in (
        {"html": {"work": 1}},
        {"charts": {"loci-chart": {"cursor": {"action": "gamma", "x": "5"}}}},
        {"charts": {"loci-chart": {"marks": [{"key": "a"}]}}},
        {"captions": [{"name": "/scene", "text": "B1"}]},
        {"charts": {"loci-chart": {"legend": []}}},
        {"charts": {"loci-chart": {"keys": [{"style": "line", "text": "tip", "mark": ""}]}}},
        {"widgets": {}},
    ):
        with pytest.raises(msgspec.ValidationError):
            messages.encode_update(wrong)


def test_what_several_threads_say_at_once_is_all_said(guest, session):
    """As the thread of a file that is written, and the event loop."""
    texts = [[f"{k} {i}" for i in range(400)] for k in range(4)]

    def say(some: list[str]) -> None:
        for text in some:
            session.visitor.page.say(text)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(len(texts)) as pool:
            list(pool.map(say, texts))
    finally:
        sys.setswitchinterval(before)
    catch_up(guest)
    assert {one["text"] for one in guest.said} >= {text for some in texts for text in some}


@pytest.mark.parametrize("text", ["", "[1]", '[1, "a", []]', '["1", "a", 1]', '[1, "a", NaN]'])
def test_an_action_has_the_declared_types(text):
    """A number, a name and a plain value."""
    assert messages.decode_action('[1, "gamma", 5.5]') == (1, "gamma", 5.5)
    assert messages.decode_action(f'[1, "gamma", {10**40}]')[2] == 1e40
    with pytest.raises(msgspec.MsgspecError):
        messages.decode_action(text)


def test_negative_numbers_have_a_minus_sign_and_what_is_typed_and_named_a_hyphen():
    """In HTML outside tags; an exponent and a range of whole numbers stay."""
    html = '<a data-value="-1">-1.5</a> TP-500-38, 1e-06, 4-5, (-.2), δ = -1 .. 2'
    expected = '<a data-value="-1">−1.5</a> TP-500-38, 1e-06, 4-5, (−.2), δ = −1 .. 2'
    assert page.html("id", html) == {("html", "id"): expected}


def test_no_note_of_the_page_has_signs_of_a_keyboard_or_keywords(guest):
    """A density in g/cm³ and an impossible choice of the model, which the command line tells in
    ASCII and in keywords of Python."""
    steel = "length=0.5&density=7.85&area=1e-4&second_moment=1e-10&youngs_modulus=2.1e11"
    guest.do("link", f"?{steel}", until="a density in g/cm³ or t/m³, not kg/m³?")
    guest.says("√(EA / (mass per length))")
    guest.set(coriolis=True, method="chebyshev")
    guest.says("Coriolis on: method chebyshev takes no Coriolis forces")
    guest.set(coriolis=False, state="bent")
    guest.says("state bent: method chebyshev has no bent states; use method auto")
    shown = re.sub("<[^>]*>", " ", guest.text)
    assert not re.search(r"\^|sqrt|\w = '|= (True|False)", shown)


# What a visitor does, one after the other, so that all kinds of controls and charts are shown.
VISIT = [
    *[("tab", key) for key in tabs(links.PAGE)],
    *[("gamma", 5.0), ("keep", None), ("over", "alpha"), ("comparison", "coriolis")],
    *[("real.preset", "steel beam"), ("real.section", "tube"), ("real.section", "own")],
    *[("blade.begin", None), ("blade.masses.add", None), ("blade.root", "spring")],
    *[("own.keep", None), ("own.ask", "?"), *[(f"own.answer.{k}", str(k)) for k in (1, 2, 3, 4)]],
    *[("own.keep", None), ("own.edit", 0), ("own.go", 0), ("own.keep", None), ("own.remove", None)],
    *[("dimensionless", None), ("lesson", NAMES[0]), ("lesson_turn", 1), ("lesson", "")],
    *[("spin_up", 0.5), ("tab", "motion"), ("spin_up", 0.0), ("delta", -1.0), ("gamma", 30.0)],
]
# While a job is slow, after it was cancelled, for a table whose rows are not in order, for a force
# that would fold a blade.
ON_OCCASION = {"cancel_jobs", "retry_jobs", "blade.stations.sort", "motion.less", "motion.leave"}
ON_OCCASION |= {"own.show_answer"}  # to a presenter
ON_OCCASION |= {"own.bring_back"}  # after another lesson
ON_OCCASION |= {"adjust.match"}
OF_SCRIPTS = set(re.findall(r'send\("(\w+)"', package_text(*SCRIPTS)))


@pytest.fixture(scope="module")
def coarse() -> Iterator[None]:
    """Coarse charts: what is looked at is what they have, not what they show."""
    with coarse_charts():
        yield


@pytest.mark.usefixtures("coarse")
def test_no_two_elements_have_the_same_id(guest, session):
    """A label, an explanation or an update would be that of the first one."""
    for key in tabs(links.PAGE):
        guest.do("tab", key)
        catch_up(guest)
    wait_until(lambda: not (session.is_busy or session.postponed))
    catch_up(guest)
    html = "".join([guest.text, *(tab.content for tab in tabs(links.PAGE).values())])
    ids = Counter(re.findall(r' id="([^"]+)"', html))
    assert ids.total() > 100
    assert [id for id, count in ids.items() if count > 1] == []


@pytest.mark.usefixtures("coarse")
def test_each_control_has_a_handler_and_each_handler_a_control(guest, session):
    """In the HTML, in the charts and in the scripts: an action that nothing takes does nothing, a
    handler that nothing calls is dead."""
    used, html = ON_OCCASION | OF_SCRIPTS, set(PAGE.read_text().split(">"))
    html |= {tag for tab in tabs(links.PAGE).values() for tag in tab.content.split(">")}
    for action, value in VISIT:
        guest.do(action, value)
        catch_up(guest)
        if action in ("tab", "gamma", "lesson_turn"):
            wait_until(lambda: not (session.is_busy or session.postponed))  # with its charts
            catch_up(guest)
        html |= {tag for text in guest.texts.values() for tag in text.split(">")}
        for chart in guest.charts.values():
            used |= {one["action"] for one in chart.get("marks", ()) if "action" in one}
            used |= {chart["cursor"]["action"]} if chart.get("cursor") else set()
    for tag in html:
        used |= set(re.findall(r' data-(?:do|set|paste)="([^"]+)"', tag))
    known = set(session.visitor.page.actions)
    assert used - known == set()
    assert sorted(known - used) == []
