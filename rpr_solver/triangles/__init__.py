"""Triangles given exactly, by rational numbers and roots: the geometry of a manipulator, its exact
coordinates over one quadratic field, the user's frame, and special shapes nearby."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
