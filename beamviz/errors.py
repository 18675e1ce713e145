"""What can go wrong, told apart: the input, the physics, the numerics, the surroundings."""


class BeamvizError(Exception):
    """Base of every error this package raises on purpose."""

    kind = "error"


class InvalidInput(BeamvizError, ValueError):
    """The input is wrong; the message names it, the value given and what is allowed."""

    kind = "invalid-input"


class NoEquilibrium(BeamvizError):
    """The physics has no answer: no equilibrium beyond `limit`, the largest gamma with one."""

    kind = "no-equilibrium"

    def __init__(self, message: str, limit: float):
        super().__init__(message)
        self.limit = limit


class NotConverged(BeamvizError):
    """The numerics gave up; the message says what was tried."""

    kind = "not-converged"


class Unavailable(BeamvizError):
    """Something outside is missing or in the way (a port, a browser, a path)."""

    kind = "unavailable"
