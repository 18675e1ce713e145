"""axe-core, which finds what is hard to see or to reach, in a page of the tests."""

from importlib.resources import files

from live.browser import Page

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8") + ";1"
RUN_AXE = """axe.run('%s', {resultTypes: ['violations']}).then(found =>
  found.violations.filter(v => ['serious', 'critical'].includes(v.impact)).map(v =>
    `${v.id}: ${v.nodes.map(n => n.html.slice(0, 99) + ' ' + n.failureSummary).join(' | ')}`))"""


def load_axe(page: Page) -> None:
    """Load axe-core into a page."""
    page.evaluate(AXE)


def violations(page: Page, part: str) -> list[str]:
    """What is serious in a part of a page, given as a CSS selector."""
    return page.evaluate(RUN_AXE % part)
