"""Triangles given exactly, by rational numbers and roots: the geometry of a manipulator, its exact
coordinates over one quadratic field, the user's frame, and special shapes nearby."""

from .frames import CommonFrame, Corner
from .geometry import Canonical, Geometry, hash_of_canonical, note_problems, read_geometry
from .near import Effect, SpecialShape, near_shapes, own_shapes
from .surds import ExactRoot, Surd, parse_surd
from .triangle import CCW, CW, Triangle, read_triangle
from .user_frame import UserFrame

__all__ = [
    "CCW",
    "CW",
    "Canonical",
    "CommonFrame",
    "Corner",
    "Effect",
    "ExactRoot",
    "Geometry",
    "SpecialShape",
    "Surd",
    "Triangle",
    "UserFrame",
    "hash_of_canonical",
    "near_shapes",
    "note_problems",
    "own_shapes",
    "parse_surd",
    "read_geometry",
    "read_triangle",
]
