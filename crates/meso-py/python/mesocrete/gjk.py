"""Do two convex bodies share a point, and how far apart are they: every answer is certified.

A body is the convex hull of an (n, 3) array of points in any dimension: a solid, a flat polygon, a segment or a
point. Bodies are closed sets, so touching counts as intersecting.
"""

from ._mesocrete import distance, intersects, intersects_many

__all__ = ["distance", "intersects", "intersects_many"]
