"""The switch of sound in Playback: the modes that swing in the scene, as tones at the frequencies
of the real beam where they can be heard, else all faster or slower by one factor. It is off
whenever a page opens; the page plays the tones (sound.js)."""

import math
from typing import NamedTuple

import numpy as np

from beamviz.explorer import page
from beamviz.explorer.feature import Feature
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.units import Units

PLACE = "sound-row"  # id of its place in Playback, which `controls.py` has
HEARD = 40.0, 8000.0  # [Hz] that small loudspeakers play
MIDDLE = 440.0  # [Hz] near which tones are brought that are not heard
HINT = (
    "The modes that swing, as tones as loud as their amounts: two of close frequencies beat. A"
    " motion has none"
)
SWITCH = (
    '<div class="row">'
    + page.button("Sound", id="sound", class_="switch", aria_pressed=False, title=HINT)
    + '<span id="sound-text" class="soft"></span></div>'
)


class Tones(NamedTuple):
    """Frequencies [Hz] that are played, (k,); their shares of the loudness, (k,), with sum 1; how
    many times faster than the beam that is, for a beam without a size T* per second."""

    hertz: np.ndarray
    shares: np.ndarray
    factor: float


class Sound(Feature):
    """Nothing sounds while the scene stands still."""

    def content(self, snapshot: Snapshot) -> Content:
        units = snapshot.picture.modes.beam.units
        drawn, shown = snapshot.picture.drawn, snapshot.picture.shown
        amounts = np.array([1.0 if drawn.in_rows else drawn.amplitudes[k] for k in shown])
        played = tones(drawn.shapes.frequencies[shown], amounts, units)
        text = scale_text(played, units) if len(played.hertz) else "no mode to hear"
        data = played if snapshot.is_moving else played._replace(hertz=np.zeros(0))
        return (
            page.html(PLACE, SWITCH)
            | page.html("sound-text", text)
            | page.props("sound", data_tones=tones_text(data))
        )


def tones(frequencies: np.ndarray, amounts: np.ndarray, units: Units | None) -> Tones:
    """The tones of modes: frequencies (m,) [1/T*], nan for a mode that does not vibrate; amounts
    (m,). A power of ten brings those of a real beam to where they are heard, unless they are."""
    vibrates = np.isfinite(frequencies) & (frequencies > 0) & (amounts != 0)
    frequencies, amounts = frequencies[vibrates], abs(amounts[vibrates])
    hertz = units.hertz(frequencies) if units else frequencies / (2 * math.pi)
    if not len(hertz):
        return Tones(hertz, amounts, 1.0)
    factor = 1.0
    if units is None or hertz.min() < HEARD[0] or hertz.max() > HEARD[1]:
        middle = float(np.exp(np.log(hertz).mean()))
        factor = 10.0 ** round(math.log10(MIDDLE / middle))
    return Tones(factor * hertz, amounts / amounts.sum(), factor)


def scale_text(played: Tones, units: Units | None) -> str:
    """How the tones differ from the vibration of the beam."""
    factor = played.factor
    if units is None:
        return f"1 T* of the beam lasts {1000 / factor:g} ms"
    if factor == 1:
        return "as the real beam sounds"
    return f"{factor:g} times faster" if factor > 1 else f"{1 / factor:g} times slower"


def tones_text(played: Tones) -> str:
    """The tones for the page: pairs of hertz and share, as "440:0.5 443:0.5"."""
    pairs = zip(played.hertz, played.shares, strict=False)
    return " ".join(f"{hertz:.6g}:{share:.3g}" for hertz, share in pairs)
