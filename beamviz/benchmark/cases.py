"""The beams that methods are measured on, from gentle to harsh."""

from beamviz.beam import Beam

MODES = 5
SCENES = {
    "slow": Beam(gamma=2),
    "tip mass": Beam(alpha=1, gamma=5),
    "inner mass": Beam(alpha=1, beta=0.5, gamma=10),
    "fast": Beam(gamma=50, delta=1),
    "fast, inner mass": Beam(alpha=1, beta=0.3, gamma=50, delta=1),
    "fastest": Beam(gamma=200),
}
