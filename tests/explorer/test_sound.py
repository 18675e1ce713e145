"""The switch of sound: what is played of a scene, and that the browser plays it."""

import numpy as np
import pytest
from live.browser import page
from live.server import wait_until

from beamviz import Beam, Scene
from beamviz.explorer import explorer
from beamviz.explorer.features.sound import scale_text, tones
from beamviz.units import Units

VOICES = "beamvizSound.voices.map((v) => v.oscillator.frequency.value)"


def heard(guest) -> dict[float, float]:
    """Shares of the tones by their hertz."""
    pairs = (tone.split(":") for tone in guest.props["sound"]["data-tones"].split())
    return {float(hertz): float(share) for hertz, share in pairs}


def test_two_close_modes_beat_at_their_difference_times_the_scale(guest):
    """As loud as their amounts; silent while the scene stands still."""
    guest.edit(alpha=1.0, beta=1.0, coriolis=True)
    guest.do("tab", "loci")
    guest.wait(lambda _: "B3 S1 1" in guest.texts["loci-events"])
    guest.do("go_to_event", "B3 S1 1")
    guest.do("playing", value=True)
    guest.wait(lambda _: len(heard(guest)) == 2 and max(heard(guest)) < 1.01 * min(heard(guest)))
    low, high = sorted(tones := heard(guest))
    assert high / low == pytest.approx(61.418 / 61.177, rel=1e-4)
    assert 139 < low < 1392
    assert list(tones.values()) == [0.5, 0.5]
    assert "1 T* of the beam lasts" in guest.texts["sound-text"]
    guest.do("playing", value=False)
    guest.wait(lambda _: not heard(guest))


def test_a_real_beam_sounds_at_its_own_frequency_or_says_how_much_faster():
    """A beam whose first frequency is 3.516 / 2 pi Hz, and one a thousand times faster."""
    for time, text in ((1.0, "1000 times faster"), (1e-3, "as the real beam sounds")):
        units = Units(length=1.0, time=time, mass=1.0)
        played = tones(np.array([3.516]), np.array([1.0]), units)
        assert scale_text(played, units) == text
        assert played.hertz == pytest.approx([559.6], rel=1e-3)


@pytest.mark.slow
def test_the_browser_plays_the_tones_when_asked():
    with explorer(Scene.of(Beam(alpha=1, gamma=5), mode=2)) as url, page(url, 1280, 900) as live:
        live.wait("document.getElementById('sound')?.dataset.tones")
        assert live.evaluate(VOICES) == []
        live.evaluate("document.getElementById('sound').scrollIntoView()")
        live.click("document.getElementById('sound')", f"{VOICES}.length === 1")
        hertz = float(live.evaluate("document.getElementById('sound').dataset.tones.split(':')[0]"))
        wait_until(lambda: live.evaluate(VOICES)[0] == pytest.approx(hertz, rel=1e-3))
        live.send("playing", value=False, until=f"{VOICES}.length === 0")
        live.send("playing", value=True, until=f"{VOICES}.length === 1")
        live.click("document.getElementById('sound')", f"{VOICES}.length === 0")
        assert live.problems == []
