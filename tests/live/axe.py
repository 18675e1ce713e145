"""axe-core, which finds what is hard to see or to reach, in a page of the tests."""

from importlib.resources import files

from live.browser import Page

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8") + ";1"
RUN_AXE = """axe.run('%s', {resultTypes: ['violations']}).then(found =>
  found.violations.filter(v => ['serious', 'critical'].includes(v.impact)).map(v =>
    `${v.id}: ${v.nodes.map(n => n.html.slice(0, 99) + ' ' + n.failureSummary).join(' | ')}`))"""


# Charts that are late are pale, on purpose, at any moment: axe sees them as they are at rest.
NOT_PALE = """(() => { const style = new CSSStyleSheet();
  style.replaceSync('[data-outdated] > * { opacity: 1 !important; transition: none !important; }');
  document.adoptedStyleSheets.push(style); })()"""


def load_axe(page: Page) -> None:
    """Load axe-core into a page, in which nothing is pale from now on."""
    page.evaluate(AXE)
    page.evaluate(NOT_PALE)


def violations(page: Page, part: str = "html") -> list[str]:
    """What is serious in a part of a page, given as a CSS selector."""
    return page.evaluate(RUN_AXE % part)
