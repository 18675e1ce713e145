"""Random beams for hypothesis."""

from hypothesis import strategies as st

from beamviz.beam import Beam

EVERYDAY = {
    "alpha": (0.0, 5.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 60.0),
    "delta": (0.0, 3.0),
    "mu": (20.0, 500.0),
}


def beams(**ranges: tuple[float, float]) -> st.SearchStrategy[Beam]:
    """Beams within an everyday range of each number, or another one."""
    return st.builds(Beam, **{name: st.floats(*ends) for name, ends in (EVERYDAY | ranges).items()})
