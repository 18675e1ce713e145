"""The mechanics of the beam, written once: the energy of its section, the inertia of its mass, and
from both the equation of motion with its tangents. An equilibrium is a motion at rest, and modes
are solutions of its tangent."""
