"""The mechanics of beams: equilibrium, stiffness and mass."""
