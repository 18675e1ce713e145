"""Labels of the charts: none is lost, and none covers another, at any size of the page."""

import json
import math

import pytest
from live.browser import READY, are_apart, by_id

pytestmark = pytest.mark.slow

SIZES = [(1440, 900), (390, 844)]
CHARTS = {  # of a link: its chart, and the labels of its lines
    "the motion of B1 and B2, whose frequencies are close": (
        "?alpha=1&beta=0.5&gamma=5&tab=motion",
        "motion-spectrum",
        ["B1", "B2", "B3", "B4", "S1"],
    ),
    "modes and multiples of the speed": (
        "?alpha=1&beta=0.5&gamma=5&per_rev=true",
        "loci-chart",
        ["1 ×", "2 ×", "3 ×", "4 ×", "5 ×", "6 ×", "B1", "B2", "B3", "B4", "S1"],
    ),
    "more modes than one column of labels has room for": (
        "?alpha=1&beta=0.5&gamma=5&mode=20",
        "loci-chart",
        [f"B{k}" for k in range(1, 14)] + [f"S{k}" for k in range(1, 8)],
    ),
}
ERRORS = {  # of methods, as they are for one beam
    "assumed-modes": 1e-2,
    "ancf": 1e-5,
    "linear": 8e-6,
    "auto": 1e-9,
    "foac": 1e-10,
    "zoac": 1e-11,
    "chebyshev": 1e-12,
}
BOXES = """[...document.querySelectorAll('#{chart} text.label:not(.at-beam)')].map(e => {{
  const {{left, top, right, bottom}} = e.getBoundingClientRect();
  return {{text: e.textContent, left, right, top: top + 3, bottom: bottom - 3}}; }})"""


@pytest.mark.parametrize("case", CHARTS)
def test_each_line_of_a_chart_has_a_label_of_its_own(shown, url, case):
    """Beside or above it; letters are less high than their line by three pixels on each side."""
    query, chart, labels = CHARTS[case]
    shown.call("Page.navigate", url=f"{url}/{query}")
    for size in SIZES:
        shown.resize(*size)
        shown.wait(f"{READY} && {by_id(chart)}?.querySelectorAll('text.label').length")
        boxes = f"{BOXES.format(chart=chart)}"
        shown.wait(f"{boxes}.length >= {len(labels)}")
        found = shown.evaluate(boxes)
        assert sorted(one["text"] for one in found) == sorted(labels)
        assert are_apart(found)
        left, width = shown.evaluate(
            f"[{by_id(chart)}.getBoundingClientRect()].map(r => [r.left, r.width])[0]"
        )
        assert all(left <= one["left"] and one["right"] <= left + width for one in found)


@pytest.mark.parametrize("size", [(1280, 720), (390, 844)], ids=str)
def test_long_labels_leave_the_chart_its_room(shown, url, size):
    """Those of the methods, in the order of their errors, on low and on narrow pages."""
    shown.call("Page.navigate", url=f"{url}/?tab=methods&methods=true")
    shown.resize(*size)
    shown.wait(f"{READY} && {by_id('timing-chart')}?.querySelectorAll('text.label').length")
    shown.wait("!document.querySelector('#tab-methods .wait').innerText")
    lines = [
        {"label": name, "at": [1, 10], "y": [0.1, error], "runs": [[0, 1, f"method-{k}", name]]}
        for k, (name, error) in enumerate(ERRORS.items())
    ]
    data = {"timing-chart": {"lines": [{**one, "dots": True} for one in lines]}}
    shown.evaluate(f"beamviz.apply({{charts: {json.dumps(data)}}})")
    found = shown.wait(
        f"(found => found.length === {len(ERRORS)} && found)({BOXES.format(chart='timing-chart')})"
    )
    assert sorted(one["text"] for one in found) == sorted(ERRORS)
    assert are_apart(found)
    left, right, frame = shown.evaluate("""(chart => {
      const {left, right} = chart.getBoundingClientRect();
      return [left, right, chart.querySelector("clipPath rect").width.baseVal.value]; })
      (document.getElementById("timing-chart"))""")
    assert all(left <= one["left"] and one["right"] <= right for one in found)
    assert frame > 0.3 * shown.evaluate(f"{by_id('tab-methods')}.clientWidth")


def test_the_name_of_a_region_does_not_touch_the_frame_of_the_map(shown, url):
    """Also of a region at an end of the axis."""
    shown.call("Page.navigate", url=f"{url}/?tab=map")
    shown.wait(f"{READY} && document.querySelectorAll('text.region').length")
    for end in (0, 1):
        name = f"modes {10 + end}, 12"
        region = f"[{{x: {20000 * end}, y: 1, text: '{name}'}}]"
        shown.evaluate(f"beamviz.apply({{charts: {{'map-chart': {{regions: {region}}}}}}})")
        shown.wait(f"document.querySelector('text.region').textContent === '{name}'")
        (left, right), (first, last) = shown.evaluate(
            "[document.querySelector('text.region'), document.querySelector('.field-of-map')]"
            ".map(e => e.getBoundingClientRect()).map(r => [r.left, r.right])"
        )
        assert first + 4 < left
        assert right < last - 4


CANCEL = "<span>computing: frequencies … 35 %</span><button type=button>Cancel</button>"
TITLES = """[...document.querySelectorAll('#caption-layer > span, #work')].map(e => {
  const {left, top, right, bottom} = e.getBoundingClientRect();
  return {text: e.textContent, left, top, right, bottom}; })"""


@pytest.mark.parametrize("choice", ["stacked=true&compare=mass", "all_modes=true"])
def test_on_a_phone_no_title_of_a_beam_is_under_the_button_that_cancels(shown, url, choice):
    """Beams above each other begin below the status, in each frame."""
    shown.call("Page.navigate", url=f"{url}/?alpha=1&beta=0.5&gamma=5&rotating_frame=true&{choice}")
    shown.resize(390, 844)
    shown.wait(f"{READY} && {by_id('caption-layer')}.childElementCount >= 2")
    shown.evaluate(f"beamviz.apply({{html: {{work: '{CANCEL}'}}}})")
    shown.wait(f"{by_id('work')}.innerText.includes('Cancel')")
    assert are_apart(shown.evaluate(TITLES))


FREE_TICKS = """(() => {
  const chart = document.getElementById('loci-chart');
  const flag = chart.querySelector('.flag').getBoundingClientRect();
  return [...chart.querySelectorAll('text.tick:not(.y)')].map(e => e.getBoundingClientRect())
    .every(tick => tick.right < flag.left || tick.left > flag.right); })()"""


def test_the_flag_of_the_beam_covers_no_number_of_the_axis(shown, url):
    """However long its number and those of the axis: a beam of 3 mm turns at 650000 rpm."""
    size = "density=2330&area=2.5e-8&second_moment=5.2e-18&youngs_modulus=1.69e11"
    shown.call("Page.navigate", url=f"{url}/?length=0.003&{size}&rotation_rpm=123456")
    shown.resize(1440, 900)
    shown.wait(f"{by_id('loci-chart')}?.querySelector('.flag')?.innerText.endsWith('rpm')")
    shown.wait(f"{by_id('loci-chart')}.querySelectorAll('text.tick').length > 4")
    assert shown.evaluate(FREE_TICKS)


OF_Y_AXIS = """[
  ...document.querySelectorAll('#loci-chart text.title, #loci-chart text.tick.y')
].map(e => {
  const {left, top, right, bottom} = e.getBoundingClientRect();
  return {text: e.textContent, left, right, top: top + 3, bottom: bottom - 3}; })"""


def test_the_title_of_the_y_axis_covers_none_of_its_numbers(shown, url):
    """However long they are: a beam of 0.3 mm vibrates at up to 20000 kHz."""
    size = "density=2330&area=2.5e-8&second_moment=5.2e-18&youngs_modulus=1.69e11"
    shown.call("Page.navigate", url=f"{url}/?length=0.0003&{size}")
    shown.resize(1440, 900)
    shown.wait(f"{OF_Y_AXIS}.some(one => one.text.length >= 5 && Number(one.text))")
    found = shown.evaluate(OF_Y_AXIS)
    assert are_apart(found), found
    edge = shown.evaluate(f"{by_id('loci-chart')}.getBoundingClientRect().left")
    assert all(edge <= one["left"] for one in found)


LABEL_AND_SIGNS = """(() => {
  const chart = document.getElementById('loci-chart');
  const boxOf = (e) => { const r = e.getBoundingClientRect();
    return {left: r.left, right: r.right, top: r.top + 3, bottom: r.bottom - 3}; };
  const ended = [...chart.querySelectorAll('text.label')].find(e => e.textContent === 'B4');
  const signs = [...chart.querySelectorAll('.events > .mark')].map(e => {
    const r = e.getBoundingClientRect(), x = (r.left + r.right) / 2, y = (r.top + r.bottom) / 2;
    return {left: x - 8, right: x + 8, top: y - 8, bottom: y + 8}; });
  return ended && [boxOf(ended), ...signs, boxOf(chart.querySelector('.operating'))]; })()"""


@pytest.mark.parametrize("gamma", [46.0, 49.0])
def test_a_label_within_the_chart_covers_no_mark_and_no_line_of_the_beam(shown, url, gamma):
    """That of a mode which is none of the first five at higher speeds, close to where it ends."""
    shown.call("Page.navigate", url=f"{url}/?alpha=1&beta=0.5&gamma={gamma}")
    range_ends = "beamviz.drawn['loci-chart'].x.range[1]"  # of a chart before the link: earlier
    for size in ((1440, 900), (390, 844)):
        shown.resize(*size)
        shown.wait(f"{READY} && {range_ends} > {gamma} && ({LABEL_AND_SIGNS})?.length > 2")
        label, *signs = shown.evaluate(LABEL_AND_SIGNS)
        assert all(are_apart([label, sign]) for sign in signs)


OF_CROSSING = """(() => {
  const middle = (e) => { const r = e.getBoundingClientRect();
    return [(r.left + r.right) / 2, (r.top + r.bottom) / 2]; };
  const chart = document.getElementById('loci-chart');
  const mark = chart.querySelector('.events > .mark[aria-label*="S1 and B3"]');
  return mark && [middle(mark), [...chart.querySelectorAll('.ring')].map(middle)]; })()"""


def test_the_mark_of_a_crossing_is_where_its_lines_cross(shown, url):
    """At the rings of a beam there: also on a phone, where marks have more room for a finger."""
    crossing = 9.3733
    shown.call("Page.navigate", url=f"{url}/?alpha=1&beta=0.5&gamma={crossing}")
    for size in SIZES:
        shown.resize(*size)
        shown.wait(f"{READY} && {OF_CROSSING}?.[1].length > 3")
        mark, rings = shown.evaluate(OF_CROSSING)
        assert min(math.dist(mark, ring) for ring in rings) < 1.5  # [px]
