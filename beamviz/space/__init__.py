"""The space of trial functions of a beam: spans, elements, Gauss points, first mesh, refinement.

Straight and deflected beams are assembled in the same space.
"""
