"""Theme and style sheet of the page."""

from html import escape

from viser import ClientHandle, GuiApi, ViserServer

BRAND = (32, 96, 150)
SHEET = '.mantine-Paper-root[style*="max-height: 60%"]'  # the controls on a phone
SECTION = '.mantine-Tabs-root[style*="border-top"]'  # results or lessons in it

# viser styles its elements in place, so these rules need !important. Grey text gets a contrast of
# more than 7 : 1 on either page. On a phone the sheet of controls stands below the scene rather
# than over it, as wide as the screen (what is in it is no table, which a chart would widen again
# and again), and results and lessons come before the controls. Six tabs fit in one row, and all
# digits in the field beside a slider. Until somebody moves the bar between them, results get more
# of the column than lessons, whose pages are short.
STYLE = f"""<style>
:root[data-mantine-color-scheme] {{ --mantine-color-dimmed: #4a5158; }}
:root[data-mantine-color-scheme="dark"] {{ --mantine-color-dimmed: #b9c0c7; }}
[data-mantine-color-scheme="dark"] [role="tab"][aria-selected="true"] {{
  color: var(--mantine-primary-color-4) !important;
}}
[role="tab"] {{ padding-inline: 6px !important; font-size: 13px !important; }}
p:has(> label) {{ letter-spacing: -.2px !important; }}
.mantine-Slider-root + .mantine-NumberInput-root,
.mantine-Slider-root + .mantine-NumberInput-root input {{ width: 4.5rem !important; }}
.mantine-Slider-markLabel {{ font-size: .7rem !important; transform: translateY(3px); }}
[style*="flex: 0.5 1 0px"]:first-child {{ flex-grow: .58 !important; }}
[style*="flex: 0.5 1 0px"]:last-child {{ flex-grow: .42 !important; }}
@media (max-width: 36em) {{
  div:has(> {SHEET}) {{ flex-direction: column; }}
  div:has(> {SHEET}) > div[style*="flex-grow"] {{ height: 0 !important; min-height: 0; }}
  {SHEET} {{
    position: relative !important;
    flex: none;
    width: 100% !important;
    max-height: 56% !important;
  }}
  {SHEET} div[style*="width: 20em"] {{ width: 100% !important; }}
  {SHEET} .mantine-ScrollArea-content {{ display: block !important; min-width: 0 !important; }}
  div:has(> div > {SECTION}) {{ display: flex; flex-direction: column; }}
  div:has(> {SECTION}) {{ order: -1; }}
}}
</style>"""


def add_style(gui: GuiApi) -> None:
    """Add the style sheet and the title to a page."""
    gui.add_html(STYLE + script_element("document.title = 'beamviz'"))


def theme(side: ClientHandle | ViserServer, *, dark: bool) -> None:
    """Set a dark or a light theme, without viser's own buttons."""
    side.gui.configure_theme(
        dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BRAND
    )


def script_element(script: str) -> str:
    """An element that runs `script` when it is added: an image that cannot be loaded does, a
    script element in HTML that comes later does not."""
    return f'<img alt="" src="data:," style="display:none" onerror="{escape(script)}">'
