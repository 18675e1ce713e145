"""How charts look: colours, words and symbols they share."""

from typing import Any

COLOURS = {"bending": "#0072B2", "stretching": "#D55E00"}  # Okabe & Ito, safe for the colour-blind
INK, FAINT = "#222222", "#8A8A8A"
DPI = 200
LINE = 12  # [pt] between words
STYLE: Any = {
    "font.family": "DejaVu Sans",  # which matplotlib brings: the same picture on every machine
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "svg.hashsalt": "beamviz",  # the same picture is the same file
}
OMEGAS = ("ω₁", "ω₂", "ω₃", "ω₄", "ω₅")
RING: dict[str, Any] = {"marker": "o", "ls": "", "ms": 5.5, "mfc": "white", "mec": INK, "mew": 1.1}
