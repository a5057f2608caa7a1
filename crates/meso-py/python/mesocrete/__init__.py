"""Mesoscale concrete: convex aggregates packed without overlap, exact collision, meshes and Abaqus decks.

>>> import mesocrete as mc
>>> packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 50}}, fraction=0.3)
>>> packing.write("model.vtu")

Units are mm, mm3, N, MPa, tonne and s; fractions go from 0 to 1 by volume of the specimen.
"""

from collections.abc import Sequence

from . import gjk
from ._mesocrete import (
    Aggregate,
    Aggregates,
    Frame,
    Mesh,
    Packing,
    Polyhedron,
    Response,
    Spec,
    __version__,
    convex_hull,
    load,
    pack,
    recipes,
)
from ._options import Grading, Specimen
from ._study import Study, study

Sequence.register(Aggregates)

__all__ = [
    "Aggregate",
    "Aggregates",
    "Frame",
    "Grading",
    "Mesh",
    "Packing",
    "Polyhedron",
    "Response",
    "Spec",
    "Specimen",
    "Study",
    "__version__",
    "convex_hull",
    "gjk",
    "load",
    "pack",
    "recipes",
    "study",
]
