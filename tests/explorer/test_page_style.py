"""The page on a phone held upright and in the dark: looked at in a browser without a window."""

from collections.abc import Iterator

import pytest
from live.browser import Page, field, page
from live.server import wait_until

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.explorer.page.style import SHEET
from beamviz.scene import Scene

pytestmark = pytest.mark.browser

WIDTH, HEIGHT = 390, 844
BEAM = Beam(alpha=1, beta=0.5, mu=123.4567)
RESULTS = "document.querySelector('[role=button][aria-label*=\"panel\"]')"
CANVAS = "document.querySelector('canvas[data-engine]')"


@pytest.fixture(scope="module")
def phone() -> Iterator[Page]:
    """A phone with the explorer."""
    with explorer(Scene(BEAM)) as url, page(url, WIDTH, HEIGHT) as opened:
        opened.call(
            "Emulation.setDeviceMetricsOverride",
            width=WIDTH,
            height=HEIGHT,
            deviceScaleFactor=1,
            mobile=True,
        )
        opened.wait("document.body?.innerText.includes('dark page')")
        yield opened


def place(phone: Page, element: str) -> list[float]:
    """Left, top, width and height of an element."""
    return phone.wait(
        f"(r => r && [r.x, r.y, r.width, r.height])({element}?.getBoundingClientRect())"
    )


def test_on_a_phone_the_controls_stand_below_the_scene(phone):
    """The scene has at least 40 % of the screen, and nothing lies over it."""

    def below() -> bool:
        _, top, width, height = place(phone, f"document.querySelector('{SHEET}')")
        scene = place(phone, CANVAS) == pytest.approx([0, 0, WIDTH, top], abs=1)
        bottom = top + height == pytest.approx(HEIGHT, abs=1)
        return scene and bottom and width == WIDTH and top > 0.4 * HEIGHT

    wait_until(below)


def test_on_a_phone_results_come_before_the_controls(phone):
    """The tab Modes is above the first slider."""
    slider = "document.querySelector('.mantine-Slider-root')"
    wait_until(lambda: place(phone, RESULTS)[1] < place(phone, slider)[1])


def test_on_a_phone_a_chart_is_no_wider_than_the_screen(phone):
    """The chart of loci fills the width, and nothing has to be scrolled sideways."""
    chart = "document.querySelector('#loci-chart')"
    phone.wait(f"!!{chart}?.querySelector('.mark, .ring')")

    def fits() -> bool:
        left, _, width, _ = place(phone, chart)
        return 0.9 * WIDTH < left + width <= WIDTH

    wait_until(fits)
    assert phone.evaluate("document.documentElement.scrollWidth") <= WIDTH


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_labels_have_contrast(phone, scheme):
    """At least 7 : 1 on either page (WCAG AAA)."""
    phone.evaluate(
        f"document.documentElement.setAttribute('data-mantine-color-scheme', '{scheme}')"
    )
    text, page = (
        luminance(phone.evaluate(f"getComputedStyle({element}).{what}"))
        for element, what in (
            ("document.querySelector('p:has(> label)')", "color"),
            (f"document.querySelector('{SHEET}')", "backgroundColor"),
        )
    )
    assert (max(text, page) + 0.05) / (min(text, page) + 0.05) > 7


def luminance(colour: str) -> float:
    """Relative luminance of a colour like rgb(74, 81, 88)."""
    parts = [int(part) / 255 for part in colour[colour.index("(") + 1 : -1].split(",")[:3]]
    light = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return sum(weight * p for weight, p in zip((0.2126, 0.7152, 0.0722), light, strict=True))


def test_all_digits_of_a_number_are_seen(phone):
    """In the field beside its slider."""
    box = field("slenderness μ")
    assert phone.evaluate(f"{box}.value") == "123.4567"
    assert phone.evaluate(f"{box}.scrollWidth <= {box}.clientWidth")


def test_the_page_has_a_name(phone):
    """That of the program, on its tab in the browser."""
    phone.wait("document.title === 'beamviz'")
