"""What the page and the server send each other (page.py)."""

import gzip

from live.server import http_get
from live.visitor import PAPER, frequency_text, pause

from beamviz.explorer.page import page


def test_the_page_has_our_elements_around_the_scene(url):
    """Once each, compressed or not; its title is the name of the program."""
    _, _, plain = http_get(url)
    for part in (b'id="root"', b'id="scene"', b"const beamviz =", b"<title>beamviz<"):
        assert plain.count(part) == 1
    _, headers, packed = http_get(url, **{"Accept-Encoding": "gzip"})
    assert headers["Content-Encoding"] == "gzip"
    assert gzip.decompress(packed) == plain


def test_invalid_actions_are_ignored(guest, caplog):
    """With one line in the log; the next action is handled."""
    texts = ["", "1", "[1]", "[1, 2, 3, 4]", "{}", "[1, {}, 2]", '[1, "nothing", 1]', "[" * 900]
    guest.do("gamma", 11)
    for k, text in enumerate([*texts, "NaN"]):
        page.log.reported.clear()
        caplog.clear()
        update = {"value": text}
        guest.send(type="GuiUpdateMessage", uuid=guest.parts["bridge"], updates=update)
        guest.do("gamma", 12 + k)
        guest.says(frequency_text(PAPER.replace(gamma=12 + k)))
        assert caplog.text.count("unknown action") == 1, text


def test_a_long_text_is_ignored(guest, caplog):
    """More than 1000 characters, except for a scene file."""
    page.log.reported.clear()
    guest.do("gamma", "9" * 1001)
    guest.do("gamma", 12)
    guest.says(frequency_text(PAPER.replace(gamma=12)))
    assert "an unknown action was ignored: gamma with 999" in caplog.text


def test_only_changes_are_sent_and_an_invalid_value_is_corrected(guest):
    """No text for an unchanged number; the control of an invalid choice is reset."""
    guest.wait(lambda _: "loci-chart" in guest.charts)
    pause(guest)
    guest.values.clear()
    guest.do("playing", "no")
    guest.wait(lambda _: "playing" in guest.values)
    assert guest.values == {"playing": True}


def test_the_preferences_of_the_system_are_applied(guest):
    """Dark and paused; anything else is ignored."""
    guest.do("preferences", 3)
    guest.do("preferences", "dark still")
    guest.wait(lambda _: guest.parts["dark"] is True)
    assert guest.values["playing"] is False
