"""How charts look: colours, words and symbols they share."""

from typing import Any

COLOURS = {"bending": "#0072B2", "stretching": "#D55E00"}  # Okabe & Ito, safe for the colour-blind
INK, FAINT = "#222222", "#8A8A8A"
DPI = 200
LINE = 12  # [pt] between words
STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "svg.hashsalt": "beamviz",  # the same picture is the same file
}
SYMBOLS = {"alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "mu": "μ"}
OMEGAS = ("ω₁", "ω₂", "ω₃", "ω₄", "ω₅")
AXES = {
    "alpha": "mass ratio α = m / (ρ A L)",
    "beta": "mass location β = d / L",
    "gamma": "rotation speed γ = Ω T*",
    "delta": "hub radius δ = a / L",
    "mu": "slenderness μ = √(A L² / I)",
}
RING: dict[str, Any] = {"marker": "o", "ls": "", "ms": 5.5, "mfc": "white", "mec": INK, "mew": 1.1}
