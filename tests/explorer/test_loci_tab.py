"""The tabs Loci and Veering in a running explorer, and on the real page."""

import math

import pytest
from charts import TIP, chart_of
from live.browser import Page, control, element, field, page, tab
from live.server import wait_until
from live.visitor import frequency_text, pause, visitor

from beamviz.explorer.features import loci_chart as charts
from beamviz.scene import Scene

FIRST = Scene(TIP)


def test_the_chart_follows_the_sliders(url):
    """Another mass moves the crossing; the mark of the beam follows the speed."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("alpha", 2.0)
        guest.says(f"{chart_of(TIP.replace(alpha=2)).events[0].at:.4f}")
        guest.choose("gamma", 7.25)
        guest.says("this beam, γ = 7.25")


def test_moving_along_the_axis_computes_no_chart(url, monkeypatch):
    """Only the mark moves."""
    with visitor(url) as guest:
        guest.says("4.4641")
        pause(guest, 0.7)
        monkeypatch.setattr(charts, "loci", None)  # a call would end in words
        guest.choose("gamma", 6.5)
        guest.says("this beam, γ = 6.5")
        pause(guest, 0.7)
        assert "unexpected" not in guest.text


def test_choosing_a_crossing_moves_the_beam_there(url):
    """The number is set, the beam solved again, and the tab Veering magnifies it."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("go to", "1")
        at = chart_of(TIP).events[0].at
        guest.says(frequency_text(TIP.replace(gamma=at)))
        guest.says("smallest frequency gap 0.241 at γ 4.650")
        guest.choose("horizontal axis", "mass α")
        guest.says("at α")


def test_nonsense_about_the_chart_changes_nothing(url):
    """Unknown axes and numbers are ignored, and the session goes on."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("horizontal axis", "temperature")
        guest.choose("go to", "99")
        guest.choose("go to", 7)
        guest.choose("per-rev lines", "maybe")
        guest.choose("gamma", 8.0)
        guest.says("this beam, γ = 8")
        guest.choose("alpha", math.nan)
        guest.says("alpha = nan")
        guest.choose("alpha", 1.5)
        guest.says(f"{chart_of(TIP.replace(alpha=1.5, gamma=8)).events[0].at:.4f}")


# The real page


CHART = "Object.values(window.__viserTestpoints?.uplots || {})[0]?.chart"


PICK = "Array.from(document.querySelectorAll('button')).filter(e => e.innerText === '1').pop()"


def pick(shown: Page, axis: str) -> None:
    """Choose another axis."""
    shown.click(control("horizontal axis"))
    option = element("[role=option]", axis)
    shown.wait(f"{option}?.offsetHeight")
    shown.evaluate(f"{option}.click()")  # wherever it is while the list unfolds


def mark_of(shown: Page) -> float:
    """Where the upright line of the chart is."""
    return shown.evaluate(
        f"(() => {{ const {{ data, series }} = {CHART};"
        " const k = series.findIndex(one => String(one.dash) === '2,3');"
        " return data[0][data[k].findIndex(y => !Number.isNaN(y))]; })()"
    )


def reaches(shown: Page, value: float) -> None:
    """Wait until the mark of the beam is at a value."""
    wait_until(lambda: abs(mark_of(shown) - value) < 1e-6)


@pytest.mark.slow
@pytest.mark.browser
def test_the_chart_on_the_page(url):
    """It is drawn with names on its lines; the mark follows the slider; a chosen crossing moves
    the beam; the tab Veering draws both cases; no console errors."""
    with page(url, 1280, 860) as shown:
        shown.wait("document.body?.innerText.includes('stretching')")
        shown.click(tab("Loci"))
        shown.wait(f"{CHART} && {CHART}.scales.y.max === 250")
        frame, names = shown.wait(
            f"""(() => {{
              const names = document.querySelector('[data-labels] > div');
              if (!names || !{CHART}.over.clientWidth) return null;
              return [{CHART}.over, names].map(e => {{
                const r = e.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; }});
            }})()"""
        )
        assert names == pytest.approx(frame, abs=2)  # names stand where their lines end
        reaches(shown, 3.0)
        shown.drag(control("speed γ"), 0.06, 0.2)
        speed = f"{field('speed γ')}.value"
        moved = float(shown.wait(f"{speed} !== '3' && {speed}"))
        assert moved > 4
        reaches(shown, float(shown.evaluate(speed)))
        shown.click(PICK)
        reaches(shown, chart_of(TIP).events[0].at)
        shown.wait(f"{speed} === '4.4641'")
        pick(shown, "position β")
        shown.wait(f"{CHART}.scales.x.min === 0 && {CHART}.scales.x.max === 1")
        pick(shown, "speed γ")
        shown.wait(f"{CHART}.scales.x.max === 20")
        shown.click(PICK)
        shown.click(tab("Veering"))
        shown.wait("document.body.innerText.includes('smallest frequency gap 0.241 at γ 4.650')")
        shown.wait("document.querySelectorAll('table[aria-label^=shapes] svg').length === 12")
        assert shown.problems == []
