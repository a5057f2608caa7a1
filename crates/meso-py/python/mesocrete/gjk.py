"""Do two convex bodies share a point, and how far apart are they: every answer is certified.

A body is the convex hull of an (n, 3) array of points in any dimension: a solid, a flat polygon, a segment or a
point. Bodies are closed sets, so touching counts as intersecting. Coordinates are any finite numbers, in any unit.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mesocrete
from ._mesocrete import Aggregate, Bodies, Polyhedron, closest_points, distance, intersects, intersects_many

__all__ = [
    "Bodies",
    "Impact",
    "Penetration",
    "closest_points",
    "distance",
    "intersects",
    "intersects_many",
    "penetration",
    "time_of_impact",
]


class Penetration(NamedTuple):
    """How deep two bodies overlap, in the unit of their points."""

    depth: float
    """Moved by this along `direction`, b shares at most points of its surface with a."""
    at_least: float
    """No shorter move separates them."""
    direction: NDArray[np.float64]
    """Of unit length, from a to b: shape (3,)."""


class Impact(NamedTuple):
    """When a moving body meets another, as shares of its motion."""

    not_before: float
    """Before this the bodies are apart, for certain."""
    by: float | None
    """At this share of the motion b shares a point with a, for certain: the exact time is not later.
    None where rounding hides whether they touch."""
    direction: NDArray[np.float64]
    """Of unit length, from a to b: what separates them until then. 0 where they share a point at the start."""


def penetration(a: ArrayLike | Aggregate | Polyhedron, b: ArrayLike | Aggregate | Polyhedron) -> Penetration | None:
    """Return the shortest move that separates two convex hulls, or None where they share no point.

    Parameters
    ----------
    a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron

    Returns
    -------
    Penetration or None
        The true depth lies from `at_least` to `depth`, which differ by some 1e-14 of the bodies' size.

    Raises
    ------
    ValueError, TypeError
        For arrays that are no (n, 3) array of finite numbers.
    """
    found = _mesocrete.penetration(a, b)
    return None if found is None else Penetration(*found)


def time_of_impact(
    a: ArrayLike | Aggregate | Polyhedron, b: ArrayLike | Aggregate | Polyhedron, motion: ArrayLike
) -> Impact | None:
    """Return when b, which moves by `motion` without turning, first meets a; None where it never does, for certain.

    Parameters
    ----------
    a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron
    motion : array_like, shape (3,)
        What is added to the points of b from time 0 to time 1.

    Returns
    -------
    Impact or None
        The exact time lies from `not_before` to `by`, both included.

    Raises
    ------
    ValueError, TypeError
        For arrays that are no (n, 3) array of finite numbers, and a motion that is not three of them.
    """
    found = _mesocrete.time_of_impact(a, b, motion)
    return None if found is None else Impact(*found)
