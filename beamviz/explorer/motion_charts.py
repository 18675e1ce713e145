"""The charts of a computed motion, the deflection of its tip over time and the spectrum, and what
they show in words."""

import numpy as np

from beamviz.drawing.motion import UNSTIFFENED
from beamviz.drawing.text import (
    frequencies,
    length_text,
    lengths,
    times,
)
from beamviz.explorer import page
from beamviz.explorer.computed_motion import Computed
from beamviz.explorer.film import time_text
from beamviz.explorer.page import Data

WIDER = 1.1  # than to the highest frequency of a mode
DECADES = 4  # of amplitude in the spectrum


def strip_data(computed: Computed) -> Data:
    """The deflection of the tip over time."""
    along, tip = times(computed.units), computed.motion.tip[:, 1]
    across = lengths("deflection of the tip", "y", computed.units)
    low, high = min(float(tip.min()), 0.0), max(float(tip.max()), 0.0)
    low, high = (low, high) if high > low else (-1e-3, 1e-3)
    margin = (0.6 if not isinstance(computed.second, str) else 0.08) * (high - low)
    lines: list[Data] = [
        {
            "label": "tip",
            "y": page.sent(across.factor * tip),
            "runs": [[0, len(tip) - 1, "bending", "tip"]],
        }
    ]
    gaps = []
    if not isinstance(computed.second, str):
        other = computed.second.tip[:, 1]
        lines.append(
            {
                "label": "",
                "second": True,
                "at": page.sent(along.factor * computed.second.t),
                "y": page.sent(across.factor * other),
                "runs": [[0, len(other) - 1, "stretching", UNSTIFFENED]],
            }
        )
        if computed.film.diverged is not None:
            ends = along.factor * computed.film.diverged, along.factor * computed.film.until
            gaps.append([*map(float, ends), f"{UNSTIFFENED}: diverged"])
    return {
        "name": "Deflection of the tip over time",
        "x": page.axis_data(along, (0.0, computed.film.until)),
        "y": page.axis_data(across, (low - margin, high + margin)),
        "at": page.sent(along.factor * computed.motion.t),
        "lines": lines,
        "gaps": gaps,
        "keys": [
            {"style": "line bending", "text": "tip"},
            *([{"style": "line second", "text": UNSTIFFENED}] if len(lines) > 1 else []),
        ],
    }


def spectrum_data(computed: Computed) -> Data:
    """The spectrum of the deflection of the tip, with the frequencies of the modes as lines."""
    along, across = frequencies(computed.units), lengths("amplitude", "a", computed.units)
    frequency, amplitude = computed.spectrum
    highest = max((omega for _, _, omega in computed.modes), default=float(frequency[-1]))
    inside = (frequency > 0) & (frequency <= WIDER * highest)
    frequency, amplitude = frequency[inside], amplitude[inside]
    top = float(amplitude.max(initial=0.0)) or 1.0
    ends = top / 10**DECADES, 3 * top
    lines = [
        {
            "label": label,
            "at": page.sent(along.factor * np.array([omega, omega * (1 + 1e-9)])),
            "y": page.sent(across.factor * np.array([ends[0], 10 * ends[1]])),
            "runs": [[0, 1, f"{family} dashed", label]],
        }
        for label, family, omega in computed.modes
    ]
    amplitude = np.maximum(amplitude, 0.1 * ends[0])
    lines.append(
        {
            "label": "",
            "y": page.sent(across.factor * amplitude),
            "runs": [[0, len(amplitude) - 1, "resonance", "tip"]],
        }
    )
    return {
        "name": "Spectrum of the motion of the tip",
        "x": page.frequency_axis(along, (0.0, WIDER * highest)),
        "y": page.axis_data(across, ends, log=True),
        "at": page.sent(along.factor * frequency),
        "lines": lines,
        "keys": [
            {"style": "line resonance", "text": "spectrum"},
            {"style": "line dashed", "text": "modes"},
        ],
    }


def notes(computed: Computed, before: bool) -> str:
    """What the charts show, in words; before: the motion is that before the last change."""
    units = computed.units
    distance, error = float(abs(computed.motion.tip[:, 1]).max()), computed.motion.error
    known = length_text(error, units, 1)
    far = f"at most {length_text(distance, units, 4)} aside, known to {known}"
    if distance < error:
        far = f"less than {known} aside"
    tip = "Before the last change the tip was" if before else "The tip is"
    text = f"<p>{tip} {far}.</p>" + page.strength(computed.greatest_stress, units)
    if isinstance(computed.second, str):
        text += page.note(computed.second)
    elif computed.film.diverged is not None:
        text += page.note(
            f"The theory without stiffening diverges: at {time_text(computed.film.diverged, units)}"
            " its tip is displaced by the length of the beam. The beam itself goes on."
        )
    else:
        text += "<p>The theory without stiffening does not diverge in this time.</p>"
    experiment = computed.experiment
    if computed.since:
        text += f"<p>The spectrum is that of the motion after {time_text(computed.since, units)}"
        text += ", with the frequencies that the beam has then.</p>"
    elif experiment.hub == "torque" and experiment.event:
        text += "<p>The frequencies are those at the speed that is reached in the end.</p>"
    elif experiment.event:
        text += "<p>The frequencies are those at the end; make the motion longer to see them.</p>"
    return text
